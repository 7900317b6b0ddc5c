"""Packing: from a validated case with full names to records with kernel symbols."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import housing_motion
from gearplay.kernels.layout import System
from gearplay.model.natural_sizes import natural_sizes
from gearplay.parts.assembly import Assembly
from gearplay.parts.mesh.involute import SERIES_TERMS
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.massless import refuse_massless
from gearplay.parts.packing import pack_elements
from gearplay.parts.planetary.paths import settable_paths
from gearplay.parts.protocol import Packing
from gearplay.parts.registry import KINDS
from gearplay.parts.rotor.packing import pack_rotor
from gearplay.schema.records import edges

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Packed:
    """A case in the layout of the kernels, with the solver's data that are not part of the equations."""

    system: System
    labels: Mapping[str, tuple[str, ...]]  # of rotors and elements, by dimension of a result
    contact_labels: tuple[str, ...]  # sleeves by name, flanks as ``mesh:drive``, ``mesh:back``
    angular: NDArray[np.bool_]  # per contact: whether it is one of angles and torques
    natural: Floats  # natural size per state: m, rad, m/s, rad/s
    restart_step: float  # s, first step after a switch
    stops: Floats  # s, times where the right-hand side jumps
    half_backlashes: Mapping[str, tuple[str, float]]
    """By a signal in half backlashes, ``mesh.x``: the penetration of the drive flank, and half the backlash [m]."""

    @property
    def rotor_names(self) -> tuple[str, ...]:
        """Names of the rotors."""
        return self.labels["rotor"]

    @property
    def state_size(self) -> int:
        """Number of states."""
        return int(self.natural.size)


def pack(
    case: "Case",
    *,
    span: float | None = None,
    member: int = 0,
    turning: "Case | None" = None,
    moves: bool = True,
) -> Packed:
    """Translate a case for the kernels: for one member's run of ``span`` [s], transient included, else of the case's own.

    Both matter only where the housing has a random record. ``turning`` is the case whose motion determines which flanks drive and
    how deep teeth are pressed, the case itself if not given. ``moves`` is whether the motion over time is computed; where it is
    not, free coordinates may be without mass: their inverse mass is 1, so that their rates are the forces on them.

    Raises `InputError` where drives contradict each other, given centres cannot mesh or a moving coordinate has no mass.
    """
    with settable_paths(case):
        return _pack(case.operating, turning, span=span, member=member, moves=moves)


def _pack(case: "Case", turning: "Case | None", *, span: float | None, member: int, moves: bool) -> Packed:
    if moves:
        refuse_massless(case)
    centres = geometry.centres(case)
    speeds = rolling.nominal_speeds(case)
    turning = case if turning is None else turning.operating
    moving = rolling.moving_speeds(turning, speeds if turning is case else rolling.nominal_speeds(turning))
    rotors = [
        pack_rotor(
            *each,
            speeds[i],
            np.sign(moving[i]),
            held=geometry.is_held(case, each[0]),
            carried=geometry.carrier_of(case, each[0]) is not None,
        )
        for i, each in enumerate(case.rotors.items())
    ]
    base, record = np.zeros(housing_motion.SLOTS), np.zeros((0, 4))
    if case.base is not None:
        from gearplay.parts.housing.schema import Member

        whole = case.run.transient + case.run.duration if span is None else span
        base, record = case.base.pack(whole, Member(case.run.seed, member))
    assembly = Assembly(len(rotors))
    packing = Packing(
        train=case,
        turning=turning,
        assembly=assembly,
        records=rotors,
        centres=centres,
        moving=moving,
        ratio=partial(rolling.ratio_between, case),
        member=(case.run.seed, member),
        record=record,
    )
    pack_elements(packing)
    alone = next(iter(packing.half_backlashes.values()), None)
    system = assembly.system(
        rotors,
        [kind.file.RECORD for kind in KINDS],
        terms=np.array(packing.terms, dtype=np.float64).reshape(-1, 3),
        involutes=np.array(packing.involutes, dtype=np.float64).reshape(-1, SERIES_TERMS),
        spline=np.array(packing.spline, dtype=np.float64).reshape(-1, 5),
        gravity=np.array(case.gravity, dtype=np.float64),
        base=base,
        record=packing.record,
    )
    stops = packing.stops | {float(r.ramp_time) for r in rotors}
    if case.base is not None:
        stops |= edges(float(base[housing_motion.START]), float(base[housing_motion.END]))
    return Packed(
        system=system,
        labels={"rotor": tuple(case.rotors)}
        | {KINDS[kind].name: tuple(found) for kind, found in assembly.labels.items()},
        contact_labels=tuple(assembly.contact_labels),
        angular=np.array(assembly.angular, dtype=bool),
        natural=natural_sizes(system, assembly.states),
        restart_step=0.1
        / max(1.0, *(r.ripple_rate for r in rotors), base[housing_motion.RATE], assembly.fastest),
        stops=np.array(sorted(stops - {0.0}), dtype=np.float64),
        half_backlashes=packing.half_backlashes
        | ({} if alone is None or case.torsional_pair is None else {"x": alone}),
    )
