"""Static form of a case: some rotors held, a torque on one, everything else unloaded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.time_invariant import Smooth
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.parts.drive.schema import SpeedDrive
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.rotor.schema import Initial, Load
from gearplay.parts.tables import HOLDERS
from gearplay.schema.fields import FrozenTable
from gearplay.solver.frames import CarrierFrames
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.suggestions import did_you_mean

Floats = NDArray[np.float64]

MOVES = 1e-9
"""Part of a rolling motion that is rounding."""


@dataclass(frozen=True)
class Held:
    """A case at its temperatures without drives and loads, the rotors ``hold`` and those of prescribed rotation held.

    ``ratios`` are the rotations by rolling per that of ``at`` while the input turns, shape [rotor]; ``friction`` the Coulomb
    torques of the rotors [N m], shape [rotor]. Errors, runouts and stiffness over the mesh phase remain; teeth and sleeves have
    no friction.
    """

    source: Case
    at: str
    hold: tuple[str, ...]
    ratios: Floats
    friction: Floats

    @property
    def place(self) -> int:
        """Place of ``at`` among the rotors."""
        return list(self.source.rotors).index(self.at)

    def smooth(self, turn: float = 0.0) -> Smooth:
        """Return the kernels' arrays of the system with its gears turned so that ``at`` has a rotation [rad]."""
        hot = self.source.operating
        still = _unloaded(hot, dict.fromkeys(self.hold, 0.0), self.at, turn * self.ratios)
        packed = pack(still, turning=hot, moves=False)
        centres, names = geometry.centres(hot), list(hot.rotors)
        carriers = tuple(
            names.index(on) if (on := geometry.carrier_of(hot, name)) is not None else -1 for name in names
        )
        frames = CarrierFrames(packed.system)
        return Smooth(still, packed, centres, np.zeros(len(names)), frozenset(), carriers, frames)


def held(case: Case, at: str, hold: str | Sequence[str]) -> Held:
    """Return a case with rotors held; `InputError` where there is no such rotor, or the held ones let ``at`` turn."""
    hot = case.operating
    names, holds = list(hot.rotors), (hold,) if isinstance(hold, str) else tuple(hold)
    for field, name in (("at", at), *(("hold", name) for name in holds)):
        if name not in names:
            raise InputError.of(
                field, name, "must be a rotor of the case", did_you_mean(name, names, "Rotors")
            )
    if at in holds or not holds:
        rule = "must name a rotor other than the one that the torque acts on"
        raise InputError.of("hold", hold, rule, "Hold the input, and load the output")
    turns = np.zeros(len(names))
    still = _unloaded(hot, dict.fromkeys(holds, 0.0), at, turns)
    free = np.abs(rolling.free_turns(still)[names.index(at)]).max(initial=0.0)
    if free > MOVES:
        rule = f"must keep {at} from turning, but the train still rolls"
        raise InputError.of("hold", ", ".join(holds), rule, "Hold further rotors as well")
    try:
        ratios = rolling.nominal_speeds(_unloaded(hot, {at: 1.0}, "", turns))
    except InputError:  # a torsional spring or another held rotor keeps it from turning
        ratios = np.zeros(len(names))
    friction = np.array([rotor.load.friction for rotor in hot.rotors.values()])
    return Held(case, at, holds, ratios, friction)


def _unloaded(hot: Case, speeds: dict[str, float], at: str, turns: Floats) -> Case:
    """Return a case without loads and drives but the given prescribed speeds, and those of 0 of rotors other than ``at``.

    ``turns`` are the rotations at which it stands [rad], shape [rotor].
    """
    rotors = {}
    for (name, rotor), turn in zip(hot.rotors.items(), turns.tolist(), strict=True):
        speed = speeds.get(name)
        fixed = isinstance(rotor.drive, SpeedDrive) and rotor.drive == SpeedDrive(speed=0.0) and name != at
        if speed is None and fixed:
            speed = 0.0
        changes = {
            "drive": None if speed is None else SpeedDrive(speed=speed),
            "load": Load(),
            "unbalance": None,
            "temperature": None,
            "initial": Initial(theta=turn),
        }
        rotors[name] = rotor.model_copy(update=changes)
    update: dict[str, object] = {
        "rotors": FrozenTable(rotors),
        "meshes": tuple(mesh.model_copy(update={"friction_coefficient": 0.0}) for mesh in hot.meshes),
        **{
            table: FrozenTable({name: part.time_invariant() for name, part in getattr(hot, table).items()})
            for table in HOLDERS
        },
        "base": None,
        "environment": None,
        "run": hot.run.model_copy(update={"transient": 0.0}),
    }
    still = hot.model_copy(update=update)
    return still
