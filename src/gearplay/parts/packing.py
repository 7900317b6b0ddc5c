"""Packing of the elements of a train, kind after kind: parts that hold or connect rotors, then those of `OTHERS`."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from gearplay.parts.assembly import blank
from gearplay.parts.drive.excitation_packing import pack_excitations
from gearplay.parts.drive.packing import pack_ripples, pack_servos
from gearplay.parts.drive.position_packing import pack_position_loops
from gearplay.parts.housing import law as housing
from gearplay.parts.mesh.packing import add_pair_signals, pack_meshes
from gearplay.parts.protocol import Packing
from gearplay.parts.registry import EXCITATION, KINDS, MESH, PAIR, POSITIONER, SERVO

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def _pack_base(packing: Packing) -> None:
    """Add the element that shows the motion of the housing."""
    if packing.train.base is not None:
        packing.assembly.add(housing, "base", blank(housing.RECORD), [0])


OTHERS: Final[Mapping[int, Sequence[Callable[[Packing], None]]]] = MappingProxyType(
    {
        SERVO: (pack_servos,),
        MESH: (pack_meshes, pack_ripples),
        EXCITATION: (pack_excitations,),
        housing.KIND: (_pack_base,),
        POSITIONER: (pack_position_loops,),
        PAIR: (add_pair_signals,),
    }
)
"""Functions that add the elements of a kind, of which a train has no table or list of its own parts."""


def pack_elements(packing: Packing) -> None:
    """Add the elements of all parts; of a carried rotor the first that holds it takes the damping of the centre's motion."""
    train: Train = packing.train
    holders, joints = list(train.every_holder()), list(train.named_joints())
    for kind in range(len(KINDS)):
        for _, name, part in holders:
            if part.kind == kind:
                first = part.on is not None and part is train.holders(name)[0]
                part.pack(packing, name, train.rotors[name].radial_damping if first else 0.0)
        for _, name, joint in joints:
            if joint.kind == kind:
                joint.pack(packing, name)
        for add in OTHERS.get(kind, ()):
            add(packing)
    for place in packing.later:
        place()
