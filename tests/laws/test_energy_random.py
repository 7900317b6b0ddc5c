"""Energy of a thousand random conservative systems: pairs and trains, sleeves and floating, gravity, torques, runout."""

import math
from itertools import pairwise

import numpy as np
import pytest

from building import ALPHA, Document, Floats, Instant, Measured, case_of, run_of
from depth import sized
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack

SYSTEMS = sized(1000)
TIMES = np.linspace(0.002, 0.02, 10)


def conservative_system(seed: int) -> Document:
    """Return a random train of 1 to 4 rotors in which nothing dissipates and nothing is prescribed."""
    rng = np.random.default_rng([91, seed])
    internal = bool(rng.random() < 0.5)
    count = 2 if internal else int(rng.integers(1, 5))
    names = [f"gear{i}" for i in range(count)]
    document: Document = {
        "rotors": {},
        "sleeves": {},
        "meshes": [],
        "gravity": [0.0, float(rng.choice([0.0, -9.81]))],
        "backlash_model": str(rng.choice(["coupled", "uncoupled"])),
        "run": {"duration": 0.02, "sampling": 1e3, "tolerance": 1e-10},
    }
    for i, name in enumerate(names):
        teeth = 60 if internal and i == 1 else int(rng.integers(17, 40))
        mass = float(10.0 ** rng.uniform(-1.0, 0.5))
        arm = 2e-3 * teeth
        angle, radius = 2.0 * math.pi * rng.random(), 4e-5 * math.sqrt(rng.random())
        v_x, v_y, spin = 0.04 * rng.standard_normal(3)
        rotor: Document = {
            "mass": mass,
            "inertia": 0.5 * mass * arm**2,
            "runout": {"amplitude": float(rng.choice([0.0, 1e-5])), "phase": float(i)},
            "initial": {"x": radius * math.cos(angle), "y": radius * math.sin(angle), "vx": v_x, "vy": v_y},
        }
        rotor["initial"]["omega"] = spin / arm + (3.0 if i == 0 else 0.0)
        if count > 1:
            rotor |= {"teeth": teeth, "internal": internal and i == 1}
        if rng.random() < 0.3:
            rotor["drive"] = {"kind": "torque", "torque": float(rng.uniform(-1.0, 1.0))}
        if rng.random() < 0.2:
            rotor["floating"] = True
        else:
            document["sleeves"][name] = {
                "radial_clearance": float(10.0 ** rng.uniform(-4.3, -3.7)),
                "law": "hunt-crossley",
                "stiffness": float(10.0 ** rng.uniform(9.0, 10.5)),
                "exponent": float(rng.choice([1.3, 1.5, 2.0])),
                "restitution": 1.0,
            }
        document["rotors"][name] = rotor
    for driver, driven in pairwise(names):
        document["meshes"].append(
            {
                "driver": driver,
                "driven": driven,
                "module": 4e-3,
                "pressure_angle": ALPHA,
                "backlash": float(10.0 ** rng.uniform(-4.3, -3.7)),
                "stiffness": {"kind": "harmonic", "mean": float(10.0 ** rng.uniform(7.0, 8.5))},
            }
        )
    return document


def total_energy(packed: Packed, instant: Instant, t: float, y: Floats) -> float:
    """Return kinetic, elastic and potential energy [J] of gravity and constant torques."""
    rotors, n = packed.system.rotors, packed.system.rotors.size
    q = y[: 3 * n].reshape(n, 3)
    theta = rotors.nominal_speed * t + q[:, 2]
    lifted = -float(np.sum(rotors.mass * (q[:, :2] @ packed.system.gravity)))
    return instant.energy(t, y) + lifted - float(np.sum(rotors.torque * theta))


@pytest.mark.slow
def test_a_thousand_random_systems_keep_their_energy(measured: Measured) -> None:
    """At tolerance 1e-10, over 20 ms of impacts, the residual is at most 1e-7 of the largest kinetic energy.

    A floating gear may drift out of mesh; such a system ends with that status and another takes its place.
    """
    residuals: list[float] = []
    events, left_mesh = 0, 0
    while len(residuals) < SYSTEMS:
        document = conservative_system(len(residuals) + left_mesh)
        case = case_of(document)
        packed, start = pack(case), initial_state(case, pack(case))
        motion, instant = run_of(case, packed), Instant(packed)
        energies, largest = [total_energy(packed, instant, 0.0, start)], instant.kinetic(start)
        for t in TIMES:
            motion.clock[kernel.T_END] = t
            status = stepper.advance(packed.system, motion, 10_000_000)
            if status != kernel.DONE:
                break
            energies.append(total_energy(packed, instant, t, motion.y))
            largest = max(largest, instant.kinetic(motion.y))
        if status == kernel.CANNOT_MESH:
            left_mesh += 1
            continue
        assert status == kernel.DONE
        residuals.append(float(np.ptp(energies)) / largest)
        events += int(motion.counts[kernel.EVENTS])
    measured(
        f"largest energy residual of {SYSTEMS} random systems over 20 ms, tolerance 1e-10",
        max(residuals),
        "1e-7",
    )
    measured("median of the same", float(np.median(residuals)), "1e-8")
    assert left_mesh < 0.1 * SYSTEMS
    assert events > 20 * SYSTEMS
    assert max(residuals) < 1e-7, int(np.argmax(residuals))
    assert np.median(residuals) < 1e-8
