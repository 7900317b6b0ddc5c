"""Random meshes for the tests of all elements: external and internal, all models, beside a carrier that turns."""

import math

import numpy as np

from building import Document, Floats, mesh_at, pair_case
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.geometry import P_B, P_D
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness, stiffness_slope
from gearplay.parts.registry import MESH


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a planet between a sun or ring and the carrier that bears it, or a pair on the ground."""
    internal, carried = bool(rng.integers(2)), bool(rng.integers(2))
    sleeve = {"radial_clearance": 1e-4, "stiffness": 1e9, "restitution": 0.9, "law": "hunt-crossley"}
    rotors = {
        "planet": {"teeth": 20, "mass": 0.4, "inertia": 2e-4},
        "other": {
            "teeth": 60,
            "internal": internal,
            "mass": 1.0,
            "inertia": 5e-3,
            "initial": {"omega": float(rng.uniform(1.0, 5.0))},  # which flank drives
        },
    }
    sleeves = {"planet": dict(sleeve), "other": dict(sleeve)}
    if carried:
        rotors["carrier"] = {"mass": 1.0, "inertia": 5e-3, "position": [0.0, 0.0]}
        sleeves["planet"]["on"] = "carrier"
        if rng.integers(2):
            rotors["carrier"]["drive"] = {"kind": "speed", "speed": float(rng.uniform(-30.0, 30.0))}
    stiffness = {"kind": "harmonic", "mean": 1e7}
    if not plain:
        rotors["planet"]["load"] = {"drag": float(rng.uniform(0.0, 0.1))}
        rotors["other"]["load"] = {"torque": float(rng.uniform(0.0, 5.0))}
        for name in ("planet", "other"):
            rotors[name]["runout"] = {"amplitude": 2e-5, "phase": float(rng.uniform(0.0, 6.0))}
        kind = str(rng.choice(["harmonic", "square"]))
        stiffness = {
            "harmonic": {"kind": "harmonic", "mean": 1e7, "amplitude": 3e6, "phase": 0.7},
            "square": {
                "kind": "square",
                "single": 0.7e7,
                "double": 1.3e7,
                "contact_ratio": 1.6,
                "phase": 1.0,
            },
        }[kind]
    return {
        "gravity": [0.0, 0.0] if plain else [0.0, -9.81],
        "backlash_model": str(rng.choice(["coupled", "uncoupled"])),
        "rotors": rotors,
        "sleeves": sleeves,
        "meshes": [
            {
                "driver": "planet",
                "driven": "other",
                "friction_coefficient": float(rng.choice([0.0, 0.3])) if damped else 0.0,
                "friction_speed": float(rng.choice([1e-3, 0.5])),
                "module": 4e-3,
                "pressure_angle": math.radians(float(rng.uniform(18.0, 26.0))),
                "backlash": float(rng.uniform(2e-5, 1e-4)),
                "stiffness": stiffness,
                "transmission_error": [] if plain else [{"order": 1, "amplitude": 5e-6, "phase": 0.4}],
                "damping": _damping(rng, 300.0 if damped else 0.0),
            }
        ],
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def _damping(rng: np.random.Generator, maximum: float) -> Document:
    """Return a damping of the ramp's law or of the constant one."""
    law: Document = {"law": "constant"} if rng.integers(2) else {"depth": 2e-5}
    return {"maximum": maximum, **law}


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of both flanks of all meshes."""
    total = 0.0
    for j, mesh in enumerate(packed.system.records[MESH]):
        out = mesh_at(packed, j, y)
        total += 0.5 * mesh.k_m * sum(max(float(out[p]), 0.0) ** 2 for p in (P_D, P_B))
    return total


def test_a_table_of_points_of_a_cosine_is_the_cosine() -> None:
    """At its points exactly, between 24 of them to 0.3 % of the amplitude, its slope to 6 %; its mean is the cosine's."""
    mean, swing, phases = 1e8, 3e7, 2.0 * math.pi * np.arange(24) / 24.0
    stiffness = {"kind": "table", "phase": list(phases), "stiffness": list(mean + swing * np.cos(phases))}
    packed = pack(pair_case(mesh={"stiffness": stiffness}))
    mesh = packed.system.records[MESH][0]
    assert abs(mesh.k_m - mean) < 1e-9 * mean

    def k(psi: float) -> float:
        return mesh_stiffness(mesh, packed.system, psi, math.cos(psi), math.sin(psi), 0)

    assert max(abs(k(psi) - mean - swing * math.cos(psi)) for psi in phases) < 1e-9 * mean
    between = np.linspace(-7.0, 7.0, 57)
    assert max(abs(k(psi) - mean - swing * math.cos(psi)) for psi in between) < 3e-3 * swing
    slopes = [stiffness_slope(mesh, packed.system, psi, math.cos(psi), math.sin(psi)) for psi in between]
    assert np.max(np.abs(slopes + swing * np.sin(between))) < 0.06 * swing
