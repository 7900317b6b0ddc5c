"""Random sleeves on the ground and on a carrier, of all laws, for the tests of all elements."""

from typing import Any

import numpy as np

from building import Document, Floats, sleeve_at
from gearplay.model.pack import Packed
from gearplay.parts.registry import SLEEVE
from gearplay.parts.sleeve.law import DELTA

LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "gonthier")


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a planet in a sleeve on a carrier that is in a sleeve itself."""

    def sleeve() -> dict[str, Any]:
        return {
            "radial_clearance": float(rng.uniform(2e-5, 1e-4)),
            "law": str(rng.choice(LAWS)),
            "stiffness": float(10.0 ** rng.uniform(8.0, 10.0)),
            "restitution": float(rng.uniform(0.5, 0.95)) if damped else 1.0,
            "friction_coefficient": float(rng.choice([0.0, 0.1])) if damped else 0.0,
            "friction_speed": 0.3,
            "shaft_radius": 0.01,
            "rotor_side": str(rng.choice(["journal", "bush"])),
        }

    damping = float(rng.choice([0.0, 20.0])) if damped else 0.0
    return {
        "gravity": [0.0, 0.0] if plain else [float(rng.uniform(-9.0, 9.0)), -9.81],
        "rotors": {
            "carrier": {"mass": 1.0, "inertia": 2e-3, "position": [0.0, 0.0]},
            "planet": {"mass": 0.4, "inertia": 1e-4, "position": [0.05, 0.02], "radial_damping": damping},
        },
        "sleeves": {"carrier": sleeve(), "planet": {**sleeve(), "on": "carrier"}},
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of all sleeves."""
    total = 0.0
    for k, sleeve in enumerate(packed.system.records[SLEEVE]):
        depth = max(float(sleeve_at(packed, k, y)[DELTA]), 0.0)
        total += sleeve.stiffness / (sleeve.exponent + 1.0) * depth ** (sleeve.exponent + 1.0)
    return total
