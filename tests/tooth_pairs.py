"""Spur pairs with a contact for each pair of teeth, and their pairs at given states, for tests."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson

import gearplay as gp
from building import Document, Floats, case_of, merged, mesh_at, simulate_one
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.geometry import P_D
from gearplay.parts.mesh.pairs.overlap import Pair, pair_overlap
from gearplay.parts.registry import MESH
from gearplay.solver.trajectory import Trajectory
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair

MODULE = 4e-3
TEETH: Document = {"kind": "teeth", "method": "iso6336"}


def with_pairs(first: Document, second: Document, **mesh: Any) -> gp.Case:
    """Return a spur pair 20/60 of module 4 mm with backlash 0.1 mm; changes of both gears and of the mesh."""
    gear = {"mass": 1.0, "inertia": 1e-3, "facewidth": 0.02}
    usual = {"driver": "one", "driven": "two", "module": MODULE, "backlash": 1e-4}
    usual |= {"contact": "pairs", "stiffness": TEETH, "damping": {"ratio": 0.05}}
    return gp.load_case(
        {
            "rotors": {
                "one": {**gear, "teeth": 20, "drive": {"kind": "speed", "speed": 60.0}, **first},
                "two": {**gear, "teeth": 60, "load": {"torque": 100.0}, **second},
            },
            "meshes": [usual | mesh],
            "run": {"duration": 0.02},
        }
    )


def document_of(
    module: float, teeth: tuple[int, int], shifts: tuple[float, float], ring: bool, backlash: float, width: float, **more: Any
) -> Document:  # fmt: skip
    """Return two gears in mesh with pairs of teeth, at the distance at which their shifts leave no backlash."""
    gears = [
        DrawnGear(teeth=z, module=module, profile_shift=x, internal=ring and k == 1)
        for k, (z, x) in enumerate(zip(teeth, shifts, strict=True))
    ]
    distance = GearPair(*gears, math.nan).shifted_distance
    rotors = {
        name: {
            "teeth": teeth[k],
            "profile_shift": shifts[k],
            "facewidth": width,
            "mass": 1.0,
            "inertia": 1e-3,
            "position": [distance if (k == 0) == ring else 0.0, 0.0],
        }
        for k, name in enumerate(("one", "two"))
    }
    rotors["two"]["internal"] = ring
    found: Document = {
        "gravity": [0.0, 0.0],
        "rotors": rotors,
        "meshes": [
            {
                "driver": "one",
                "driven": "two",
                "module": module,
                "center_distance": distance,
                "backlash": backlash,
                "contact": "pairs",
                "stiffness": {"kind": "teeth", "method": "iso6336", "line_load": 1e6},
            }
        ],
        "run": {"duration": 6e-3, "transient": 0.0, "sampling": 1e6, "tolerance": 1e-10},
    }
    return merged(found, more)


def placed(packed: Packed, place: float, overlap: float) -> Floats:
    """Return a state with the pair of slot 0 at a place on the driver's path [m] and an overlap of the involutes [m]."""
    (mesh,) = packed.system.records[MESH]
    y = np.zeros(packed.state_size)
    for _ in range(2):
        out = mesh_at(packed, 0, y)
        pair = pair_overlap(mesh, packed.system, out, 0, 0)
        y[2] += (place - pair.place) / mesh.base_1
        out = mesh_at(packed, 0, y)
        y[5] += (overlap - out[P_D]) / (-mesh.s * mesh.base_2)
    return y


def pairs_at(packed: Packed, y: Floats, flank: int = 0) -> list[Pair]:
    """Return the pairs of a flank at a state."""
    (mesh,) = packed.system.records[MESH]
    out = mesh_at(packed, 0, y)
    return [pair_overlap(mesh, packed.system, out, flank, slot) for slot in range(mesh.pairs)]


class Audit(NamedTuple):
    """Energy of a motion: the run, power into it [W] and energy without that of teeth [J] at all samples, gaps [J] at some."""

    run: Trajectory
    power: Floats
    stored: Floats
    gaps: Floats


def energy_audit(document: Document, sampling: float, elastic: Callable[[Packed, Floats], float]) -> Audit:
    """Return the audit of two gears on springs that begin as they roll freely, over 4 ms.

    ``elastic`` is the energy of the teeth [J] of the packed case with the geometry of the mesh in a scratch. A gap is kinetic and
    elastic energy less the integral of the power.
    """
    for name, omega in (("one", 150.0), ("two", -52.0)):
        document["rotors"][name]["tip_relief"] = {"amount": 1e-6, "length": 2e-3, "shape": "parabolic"}
        document["rotors"][name]["initial"] = {"omega": omega}
    document["supports"] = {name: {"stiffness": [1e8, 8e7]} for name in ("one", "two")}
    document["run"] |= {"sampling": sampling, "duration": 4e-3, "tolerance": 1e-11}
    run, case, packed = simulate_one(document), case_of(document), pack(case_of(document))
    stored = np.zeros(run.time.size)
    for name, rotor in case.rotors.items():
        v_x, v_y, omega = (run.signal(word, name) for word in ("vx", "vy", "omega"))
        stored += 0.5 * rotor.mass * (v_x**2 + v_y**2) + 0.5 * rotor.inertia * omega**2
        stored += 0.5 * 1e8 * run.signal("x", name) ** 2 + 0.5 * 8e7 * run.signal("y", name) ** 2
    power = run.signal("mesh_power_input", "one-two") - run.signal("mesh_power_loss", "one-two")
    brought = cumulative_simpson(power, dx=1.0 / run.sampling, initial=0.0)
    speeds, gaps = packed.system.rotors["nominal_speed"], []
    for at in np.linspace(0, run.time.size - 1, 200).astype(int):
        y, t = np.zeros(packed.state_size), float(run.time[at])
        for i, name in enumerate(("one", "two")):
            y[3 * i : 3 * i + 2] = [run.signal(word, name)[at] for word in ("x", "y")]
            y[3 * i + 2] = run.signal("theta", name)[at] - speeds[i] * t
        gaps.append(stored[at] + elastic(packed, mesh_at(packed, 0, y, t)) - brought[at])
    return Audit(run, power, stored, np.array(gaps))
