"""Parts of random trains: bodies, gears, meshes; the draws of a generator in a fixed order."""

import math
from typing import Any

import numpy as np

from cross.random_systems import _stiffness

KINDS = ("harmonic", "fourier", "square", "table")


def gear(rng: np.random.Generator, teeth: int, *, internal: bool = False) -> dict[str, Any]:
    """Return a gear of a shaft, some with runout."""
    made: dict[str, Any] = {"teeth": teeth}
    if internal:
        made["internal"] = True
    if rng.uniform() < 0.6:
        made["runout"] = {"amplitude": float(rng.uniform(3e-6, 12e-6)), "phase": float(rng.uniform(0.0, 6.0))}
    return made


def body(rng: np.random.Generator, radius: float) -> dict[str, float]:
    """Return mass and inertia of a rotor of about this radius [m]."""
    mass = float(rng.uniform(0.3, 1.2))
    return {"mass": mass, "inertia": mass * (float(rng.uniform(0.6, 0.9)) * radius) ** 2}


def mesh_of(rng: np.random.Generator, driver: str, driven: str, module: float, seed: int) -> dict[str, Any]:
    """Return a mesh at an angle, its kind of stiffness by the seed, some with a transmission error."""
    mesh: dict[str, Any] = {
        "driver": driver,
        "driven": driven,
        "module": module,
        "pressure_angle": math.radians(float(rng.choice([20.0, 22.5]))),
        "backlash": float(rng.uniform(80e-6, 160e-6)),
        "stiffness": _stiffness(rng, KINDS[seed % 4], float(10.0 ** rng.uniform(7.0, 8.0))),
        "damping": {"maximum": float(rng.uniform(20.0, 200.0)), "depth": float(rng.uniform(1e-6, 3e-6))},
        "angle": float(rng.uniform(-math.pi, math.pi)),
    }
    if rng.uniform() < 0.5:
        mesh["transmission_error"] = [{"order": 2, "amplitude": float(rng.uniform(1e-6, 3e-6)), "phase": 1.0}]
    return mesh
