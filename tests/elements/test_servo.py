"""Random servos for the tests of all elements, at their limit or below it."""

import numpy as np

from building import Document


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc on a servo."""
    drive = {
        "kind": "servo",
        "speed": float(rng.uniform(1.0, 20.0)),
        "proportional_gain": float(rng.uniform(0.1, 2.0)),
        "integral_gain": float(rng.uniform(1.0, 20.0)),
        "torque_limit": float(rng.choice([0.05, 50.0])),
    }
    rotor = {"mass": 1.0, "inertia": 1e-3, "drive": drive, "position": [0.01, 0.02]}
    return {"rotors": {"disc": rotor}, "run": {"duration": 0.01, "sampling": 1e4}}
