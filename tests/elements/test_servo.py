"""Speed servos: against a closed form, and random ones for the tests of all elements."""

import math

import numpy as np
import pytest

from building import Document, simulate_one

INERTIA = 1e-3  # kg m^2


def disc(**drive: float) -> Document:
    """Return a disc on a servo."""
    rotor = {
        "mass": 1.0,
        "inertia": INERTIA,
        "drive": {"kind": "servo", **drive},
        "position": [0.01, 0.02],
    }
    return {"rotors": {"disc": rotor}, "run": {"duration": 0.01, "sampling": 1e4}}


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc on a servo, at its limit or below it, or on a motor at a voltage."""
    if rng.random() < 0.3:
        document = disc(speed=0.0, proportional_gain=1.0, integral_gain=0.0, torque_limit=1.0)
        document["rotors"]["disc"]["drive"] = {
            "kind": "motor",
            "voltage": float(rng.uniform(-24.0, 24.0)),
            "resistance": float(rng.uniform(0.2, 2.0)),
            "inductance": float(rng.uniform(0.5e-3, 5e-3)),
            "torque_constant": float(rng.uniform(0.02, 0.2)),
        }
        return document
    return disc(
        speed=float(rng.uniform(1.0, 20.0)),
        proportional_gain=float(rng.uniform(0.1, 2.0)),
        integral_gain=float(rng.uniform(1.0, 20.0)),
        torque_limit=float(rng.choice([0.05, 50.0])),
    )


@pytest.mark.parametrize("speed", [10.0, -10.0])
def test_a_servo_leaves_its_limit_when_it_wants_less(speed: float) -> None:
    """From rest it gives its limit until k (speed - omega) is no more than that; from there J omega' = k (speed - omega)."""
    gain, limit = 0.2, 0.5
    document = disc(speed=speed, proportional_gain=gain, integral_gain=0.0, torque_limit=limit)
    document["rotors"]["disc"]["initial"] = {"omega": 0.0}
    run = simulate_one(document | {"run": {"duration": 0.04, "sampling": 1e4, "tolerance": 1e-12}})
    leaves = INERTIA * (abs(speed) / limit - 1.0 / gain)
    late = np.maximum(run.time - leaves, 0.0)
    limited = limit / INERTIA * run.time
    free = abs(speed) - limit / gain * np.exp(-gain / INERTIA * late)
    exact = math.copysign(1.0, speed) * np.where(run.time < leaves, limited, free)
    assert np.max(np.abs(run.signal("omega", "disc") - exact)) < 1e-9
