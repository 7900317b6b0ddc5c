"""Time-invariant form of a case: mean stiffness, no errors, constant torques, nominal speeds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.model.perfect import perfect_rotor
from gearplay.parts.drive.schema import TorqueDrive
from gearplay.parts.mesh.faults import GearFault
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.mesh.stiffness import HarmonicStiffness
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.rotor.schema import Load, Rotor
from gearplay.parts.support.schema import Support
from gearplay.parts.tables import HOLDERS
from gearplay.schema.fields import FrozenTable
from gearplay.solver.frames import CarrierFrames
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Smooth:
    """A case without time-varying terms, in the layout of the kernels.

    ``speeds`` are the rotors' nominal speeds [rad/s], 0 unless a speed was given; ``controlled`` are the rotors whose servo
    became a spring, ``carriers`` the rotor that carries each, -1 for none, ``frames`` the carriers from which nothing varies.
    """

    case: Case
    packed: Packed
    centres: dict[str, tuple[float, float]]
    speeds: Floats
    controlled: frozenset[str]
    carriers: tuple[int, ...]
    frames: CarrierFrames

    def arms(self) -> Iterator[tuple[int, int, tuple[float, float]]]:
        """Yield every rotor on a carrier, the carrier, and the vector [m] from the carrier's centre to the rotor's."""
        names = list(self.case.rotors)
        for i, on in enumerate(self.carriers):
            if on >= 0:
                (x, y), (x_0, y_0) = self.centres[names[i]], self.centres[names[on]]
                yield i, on, (x - x_0, y - y_0)


def smooth(case: Case, *, load: str, speed: float | None) -> Smooth:
    """Return a case without time-varying terms.

    ``load`` is "operating", torques and drags at the nominal speeds, or "none"; ``speed`` [rad/s] is that of the leading rotor,
    None for a train that stands still under its operating load.

    Raises `InputError` where the train cannot turn as asked, or a turning carrier has more about it than a coaxial set.
    """
    hot = case.operating
    names = list(hot.rotors)
    nominal = rolling.nominal_speeds(hot)
    senses = rolling.senses(hot, nominal)
    centres = geometry.centres(hot)
    update: dict[str, object] = {
        "rotors": FrozenTable(
            {
                name: _rotor(rotor, float(nominal[i]), float(senses[i]), loaded=load == "operating")
                for i, (name, rotor) in enumerate(hot.rotors.items())
            }
        ),
        "meshes": tuple(_mesh(hot, j) for j in range(len(hot.meshes))),
        **{
            table: FrozenTable({name: part.time_invariant() for name, part in getattr(hot, table).items()})
            for table in HOLDERS
        },
        "supports": FrozenTable({**hot.supports, **_servo_springs(hot)}),
        "base": None,
        "environment": None,
        "faults": tuple(fault for fault in hot.faults if not isinstance(fault, GearFault)),
        "run": hot.run.model_copy(update={"transient": 0.0}),
    }
    if load == "none":
        update["gravity"] = (0.0, 0.0)
    still = hot.model_copy(update=update)
    packed = pack(still, turning=hot, moves=False)
    carriers = tuple(
        names.index(on) if (on := geometry.carrier_of(hot, name)) is not None else -1 for name in names
    )
    speeds = np.zeros(len(names))
    if speed is not None:
        speeds = rolling.rolling_ratios(hot)[1] * speed
        rotors: Any = packed.system.rotors
        rotors.nominal_speed[:] = speeds
        rotors.torque += rotors.drag * speeds  # the given load is kept at every speed
    frames = CarrierFrames(packed.system)
    for i, carrier in enumerate(carriers):
        if carrier >= 0 and frames.speeds[i] != speeds[carrier]:
            rule = f"must be left out, since {names[i]} goes round with {names[carrier]}, in no coaxial set alone"
            raise InputError.of("speed", speed, rule, "Ask for the modes at rest")
    servos = frozenset(n for n, r in hot.rotors.items() if r.drive and r.drive.speed_gains())
    return Smooth(still, packed, centres, speeds, servos, carriers, frames)


def _rotor(rotor: Rotor, speed: float, sense: float, *, loaded: bool) -> Rotor:
    """Return a rotor with constant torques only; loads as they are at its nominal speed."""
    drive, torque = rotor.drive, 0.0
    if loaded:
        load = rotor.load
        if load.torque > 0.0 or speed != 0.0:
            torque -= (sense or float(np.sign(speed))) * (load.torque + load.drag * abs(speed))
            torque -= float(np.sign(speed)) * load.friction
        torque += drive.constant_torque() if drive else 0.0
    new = (drive and drive.time_invariant()) or (TorqueDrive(torque=torque) if torque != 0.0 else None)
    changes = {
        "drive": new,
        "load": Load(drag=rotor.load.drag),
        "unbalance": None,
        "temperature": None,
    }
    start = rotor.initial.model_copy(update={"vx": 0.0, "vy": 0.0, "theta": None, "omega": None})
    return perfect_rotor(rotor).model_copy(update={**changes, "initial": start})


def _servo_springs(case: Case) -> dict[str, Support]:
    """Return supports with the springs that speed servos are to their rotors: gain on the speed, and on its integral."""
    found = {}
    for name, rotor in case.rotors.items():
        if rotor.drive is None or (gains := rotor.drive.speed_gains()) is None:
            continue
        before = case.supports.get(name)
        spring = before.torsional_stiffness if before is not None else 0.0
        damper = before.torsional_damping if before is not None else 0.0
        own = {
            "torsional_stiffness": spring + gains[1],
            "torsional_damping": damper + gains[0],
        }
        found[name] = before.model_copy(update=own) if before is not None else Support.model_validate(own)
    return found


def _mesh(case: Case, j: int) -> Mesh:
    """Return a mesh with its mean stiffness, damping as it is, without errors and friction."""
    changes: dict[str, object] = {
        "stiffness": HarmonicStiffness(mean=pack_stiffness(case, j).average),
        "transmission_error": (),
        "friction_coefficient": 0.0,
        "contact": "mesh",
    }
    return case.meshes[j].model_copy(update=changes)
