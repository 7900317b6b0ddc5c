"""Position servos: against closed forms and a control by hand, and random ones for the tests of all elements."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured, case_of, simulate_one
from gearplay.model.pack import pack
from gearplay.parts.registry import POSITIONER
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import InputError

INERTIA = 2e-3  # kg m^2


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc on a servo, continuous, at its limit or below it; it wants 0 where its mechanism is to be mirrored."""
    return disc(
        angle=0.0 if plain else float(rng.uniform(-0.1, 0.1)),
        proportional_gain=float(rng.uniform(1.0, 20.0)),
        derivative_gain=float(rng.uniform(0.0, 0.1)),
        integral_gain=float(rng.uniform(0.0, 50.0)),
        torque_limit=float(rng.choice([0.005, 50.0])),
        current_time=float(rng.choice([0.0, 2e-3])),
    )


def disc(**drive: Any) -> Document:
    """Return a disc on a position servo."""
    given = {"kind": "position", "angle": 0.1, "proportional_gain": 8.0, "torque_limit": 100.0, **drive}
    return {
        "rotors": {
            "disc": {
                "mass": 1.0,
                "inertia": INERTIA,
                "position": [0.01, 0.02],
                "drive": given,
                "initial": {"theta": 0.0, "omega": 0.0},
            }
        },
        "run": {"duration": 0.2, "sampling": 1e4, "tolerance": 1e-12},
    }


def test_a_position_loop_is_a_damped_oscillator(measured: Measured) -> None:
    """J theta'' = kp (angle - theta) - kd theta'."""
    run = simulate_one(disc(derivative_gain=0.05))
    decay = 0.05 / (2.0 * INERTIA)
    w = math.sqrt(8.0 / INERTIA - decay**2)
    swing = np.exp(-decay * run.time) * (np.cos(w * run.time) + decay / w * np.sin(w * run.time))
    worst = float(np.max(np.abs(run.signal("theta", "disc") - 0.1 * (1.0 - swing))))
    measured("position loop: angle [rad]", worst, "1e-10")
    assert worst < 1e-10
    assert np.allclose(run.signal("position_error", "disc"), 0.1 * swing, atol=1e-9)


@pytest.mark.parametrize("limit", [100.0, 0.2])
def test_sampled_control__equals_its_recursion(limit: float, measured: Measured) -> None:
    """Between samples the torque is constant: theta and omega by hand, limited and with back-calculation."""
    period, kp, kd, ki = 1.3e-3, 8.0, 0.06, 40.0
    run = simulate_one(
        disc(derivative_gain=kd, integral_gain=ki, torque_limit=limit, sample_time=period)
        | {"run": {"duration": 0.0650, "sampling": 1e5, "tolerance": 1e-12}}
    )
    theta, omega, z, exact = 0.0, 0.0, 0.0, np.empty(run.time.size)
    for k in range(51):
        wanted = kp * (0.1 - theta) + ki * z - kd * omega
        torque = min(max(wanted, -limit), limit)
        z += period * ((0.1 - theta) + (torque - wanted) / kp)
        tau = run.time - k * period
        inside = (tau >= -1e-12) & (tau < period)
        exact[inside] = theta + omega * tau[inside] + 0.5 * torque / INERTIA * tau[inside] ** 2
        theta += omega * period + 0.5 * torque / INERTIA * period**2
        omega += torque / INERTIA * period
    worst = float(np.max(np.abs(run.signal("theta", "disc") - exact)))
    measured(f"sampled position loop, limit {limit:g} N m: angle [rad]", worst, "1e-10")
    assert worst < 1e-10
    torque_steps = np.unique(np.round(run.signal("position_torque", "disc"), 12))
    assert len(torque_steps) <= 51
    assert np.max(np.abs(torque_steps)) <= limit


@pytest.mark.parametrize("limit", [100.0, 0.2])
def test_the_tangent_passes_samples(limit: float, measured: Measured) -> None:
    """Against differences of the flow over several samples, with and without the limit."""
    document = disc(derivative_gain=0.06, integral_gain=40.0, torque_limit=limit, sample_time=1e-3)
    flow = Flow(case_of(document))
    start, span = flow.start(), 5.5e-3
    exact = flow.go(start, span, changes=np.eye(flow.size)).changes
    worst = 0.0
    for c in flow.free:
        h = 1e-5 * flow.natural[c]
        plus, minus = (flow.go(start + s * h * np.eye(flow.size)[c], span).state for s in (1.0, -1.0))
        difference = (plus - minus) / (2.0 * h) / flow.natural
        scale = 1e-12 + np.max(np.abs(exact[c] / flow.natural))
        worst = max(worst, float(np.max(np.abs(difference - exact[c] / flow.natural)) / scale))
    measured(f"tangent through samples, limit {limit:g} N m, relative", worst, "1e-6")
    assert worst < 1e-6


def geared(**drive: Any) -> Document:
    """Return a pinion on a position servo that drives a wheel with a spring of its own sense."""
    stiffness = {"kind": "harmonic", "mean": "1e8 N/m"}
    document = disc(**drive)
    document["rotors"] = {
        "motor": {**document["rotors"]["disc"], "teeth": 20, "initial": {}, "position": [0.0, 0.0]},
        "output": {"mass": 1.0, "inertia": 4e-3, "teeth": 40, "load": {"drag": 0.02}},
    }
    document["meshes"] = [
        {
            "driver": "motor",
            "driven": "output",
            "module": "2 mm",
            "pressure_angle": "20 deg",
            "backlash": "50 um",
            "stiffness": stiffness,
            "damping": {"ratio": 0.3},
        }
    ]
    document["run"] = {"duration": 1.5, "sampling": 1e3, "tolerance": 1e-7}
    return document


@pytest.mark.compiled
@pytest.mark.parametrize("sample_time", [0.0, 1e-3])
def test_load_side_sensor__the_output_reaches_the_commanded_angle(sample_time: float) -> None:
    """The output turns against the motor: the torque's sign follows from the train; the error stays within the backlash."""
    document = geared(
        angle="5 deg", sensor="output", proportional_gain=2.0, derivative_gain=0.15, sample_time=sample_time
    )
    run = simulate_one(document)
    end = run.signal("theta", "output")[-200:]
    assert np.max(np.abs(end - math.radians(5.0))) < 50e-6 / 0.035
    assert run.signal("theta", "motor")[-1] == pytest.approx(-2.0 * math.radians(5.0), abs=4e-3)


def test_a_sensor_that_does_not_turn_with_the_drive_is_refused() -> None:
    document = disc(sensor="other")
    document["rotors"]["other"] = {"mass": 1.0, "inertia": 1e-3}
    with pytest.raises(InputError, match=r"drive\.sensor.*turns with disc"):
        gp.simulate(case_of(document))


def test_a_carrier_can_be_the_sensor_of_its_sun() -> None:
    """The ring of a planetary set is held by a spring: the carrier turns with the sun, the ring does not."""
    mesh = {"module": "2 mm", "backlash": "50 um", "stiffness": {"kind": "harmonic", "mean": 1e8}}
    light = {"mass": 0.2, "inertia": 1e-4}
    document: Document = {
        "rotors": {
            "sun": {
                **light,
                "teeth": 24,
                "drive": disc(angle=0.1, sensor="carrier")["rotors"]["disc"]["drive"],
            },
            "planet": {**light, "teeth": 18},
            "ring": {**light, "teeth": 60, "internal": True},
            "carrier": {**light, "position": [0.0, 0.0]},
        },
        "sleeves": {"planet": {"radial_clearance": 1e-5, "stiffness": "1e9 N/m^1.5", "on": "carrier"}},
        "supports": {"ring": {"torsional_stiffness": 1e5}},
        "meshes": [
            {"driver": "sun", "driven": "planet", **mesh},
            {"driver": "planet", "driven": "ring", **mesh},
        ],
        "run": {"duration": 0.01, "sampling": 1e4},
    }
    assert pack(case_of(document)).system.records[POSITIONER][0].sense == 1.0
    document["rotors"]["sun"]["drive"]["sensor"] = "ring"
    with pytest.raises(InputError, match=r"drive\.sensor.*turns with sun"):
        pack(case_of(document))
