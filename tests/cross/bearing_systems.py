"""Random mechanisms with rolling bearings: a geared shaft, a machine behind a shaft, a planet on an arm.

Twelve seeds; each selects the features, and the numbers too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

SEEDS = tuple(range(12))


def _bearing(rng: np.random.Generator, seed: int) -> dict[str, Any]:
    rollers = bool(rng.random() < 0.35)
    count = int(rng.integers(7, 15))
    found: dict[str, Any] = {
        "rolling_elements": count,
        "element_diameter": float(rng.uniform(4e-3, 7e-3)),
        "pitch_diameter": 0.04,
        "contact_angle": float(rng.choice([0.0, 0.3])),
        "internal_clearance": float(rng.choice([-4e-6, 0.0, 1e-5, 3e-5])),
        "exponent": 10.0 / 9.0 if rollers else 1.5,
        "stiffness": float(10.0 ** (rng.uniform(7.6, 8.3) if rollers else rng.uniform(9.0, 10.0))),
        "damping": {"value": float(rng.choice([0.0, 0.3, 1.0]))},
        "cage_phase": float(rng.uniform(-3.0, 3.0)),
        "cage_torque": bool(rng.random() < 0.7),
        "rotor_ring": "outer" if seed % 4 == 3 else "inner",
    }
    if rng.random() < 0.5:
        found["waviness"] = [
            {
                "order": int(rng.integers(2, 16)),
                "amplitude": float(rng.uniform(2e-7, 2e-6)),
                "phase": float(rng.uniform(-3.0, 3.0)),
                "ring": str(rng.choice(["inner", "outer"])),
            }
            for _ in range(2)
        ]
    if rng.random() < 0.3:
        found["offset"] = [float(v) for v in rng.uniform(-5e-6, 5e-6, 2)]
    return found


def _start(rng: np.random.Generator) -> dict[str, float]:
    angle, size = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(1e-6, 6e-6)
    v = rng.uniform(-0.01, 0.01, 2)
    return {"x": size * math.cos(angle), "y": size * math.sin(angle), "vx": float(v[0]), "vy": float(v[1])}


def bearing_case(seed: int) -> dict[str, Any]:
    """Return a mechanism as a document of a case."""
    rng = np.random.default_rng([49, seed])
    speed = float(rng.choice([60.0, 150.0, -300.0]))
    drive = {"kind": "speed", "speed": speed}
    case: dict[str, Any] = {
        "gravity": [float(rng.uniform(-20.0, 20.0)), float(rng.uniform(-80.0, -10.0))],
        "rotors": {},
        "bearings": {},
    }
    rotors, bearings = case["rotors"], case["bearings"]
    kind = seed % 3
    if kind == 0:  # a pair of gears, both in bearings
        for name, teeth in (("pinion", 20), ("wheel", 30)):
            rotors[name] = {
                "mass": float(rng.uniform(0.3, 2.0)),
                "inertia": 1e-3,
                "teeth": teeth,
                "initial": _start(rng),
            }
            bearings[name] = _bearing(rng, seed)
        rotors["pinion"]["drive"] = drive
        case["meshes"] = [
            {
                "driver": "pinion",
                "driven": "wheel",
                "module": 2e-3,
                "pressure_angle": math.radians(20.0),
                "backlash": 4e-5,
                "stiffness": {"kind": "harmonic", "mean": 1e8, "amplitude": 1e7, "phase": 0.3},
            }
        ]
        rotors["wheel"]["load"] = {"torque": 0.5}
    elif kind == 1:  # a shaft with an unbalance, and a free one behind a coupling, also on a support
        rotors["shaft"] = {"mass": 1.2, "inertia": 1e-3, "drive": drive, "initial": _start(rng)}
        rotors["machine"] = {"mass": 0.7, "inertia": 2e-3, "load": {"torque": 0.3}, "initial": _start(rng)}
        rotors["machine"]["unbalance"] = {"amount": float(rng.uniform(1e-6, 2e-5)), "phase": 0.4}
        bearings["shaft"], bearings["machine"] = _bearing(rng, seed), _bearing(rng, seed)
        case["couplings"] = [
            {
                "between": ["shaft", "machine"],
                "torsional_stiffness": 200.0,
                "torsional_damping": 0.05,
                "lateral_stiffness": 1e5,
            }
        ]
        if rng.random() < 0.5:
            case["supports"] = {"machine": {"stiffness": [1e6, 2e6], "damping": [10.0, 20.0]}}
    else:  # a planet in a bearing on an arm that turns, itself in a bearing
        rotors["arm"] = {
            "mass": 1.5,
            "inertia": 5e-3,
            "drive": {"kind": "speed", "speed": 0.2 * speed},
            "initial": _start(rng),
        }
        rotors["planet"] = {
            "mass": 0.5,
            "inertia": 2e-4,
            "position": [0.04, 0.03],
            "initial": {**_start(rng), "omega": float(rng.uniform(-200.0, 200.0))},
            "radial_damping": float(rng.choice([0.0, 15.0])),
        }
        rotors["arm"]["position"] = [0.0, 0.0]
        bearings["arm"], bearings["planet"] = _bearing(rng, seed), {**_bearing(rng, seed), "on": "arm"}
    return case
