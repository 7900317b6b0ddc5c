"""Limit cycles of sampled loops, locked to their samples, against matrix exponentials with a held torque."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import gearplay as gp
from gearplay.vocabulary.errors import InputError, SimulationError
from servo_loops import Axis

AXIS = Axis(J1=1e-3, J2=4e-3, k=10.0, b=2e-3, d1=1e-3, d2=0.01, Kp=4.0, Kd=0.05, Ki=0.0)
SAMPLE = 0.0211  # s: the loop hunts with ten of them


def sampled(sample_time: float = SAMPLE, **drive: Any) -> gp.Case:
    changes = {"sample_time": sample_time} | drive
    case = gp.replace(
        AXIS.case(1e-11), {f"rotors.motor.drive.{name}": each for name, each in changes.items()}
    )
    return gp.replace(case, {"run.duration": 4.0})


def generator(side: int) -> Any:
    """Return the matrix of the motion of (theta_1, omega_1, theta_2, omega_2, u, 1) on a flank, 0 for none, u held."""
    k, own, a = abs(side) * AXIS.k, side * AXIS.k * AXIS.b, AXIS
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            [-k / a.J1, -a.d1 / a.J1, k / a.J1, 0.0, 1.0 / a.J1, own / a.J1],
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            [k / a.J2, 0.0, -k / a.J2, -a.d2 / a.J2, 0.0, -own / a.J2],
            [0.0] * 6,
            [0.0] * 6,
        ]
    )


def beyond(state: Any, side: int) -> float:
    phi = state[0] - state[2]
    return float(abs(phi) - AXIS.b if side == 0 else AXIS.b - side * phi)


def after_samples(state: Any, count: int, gain: float = AXIS.Kp) -> Any:
    """Return (theta_1, omega_1, theta_2, omega_2) after some samples: contacts located by Brent's method."""
    y = np.array([*state, 0.0, 1.0])
    for _ in range(count):
        y[4] = -gain * y[2] - AXIS.Kd * y[1]
        left = SAMPLE
        while left > 0.0:
            phi = y[0] - y[2]
            side = 0 if abs(phi) < AXIS.b else int(np.sign(phi))
            if abs(abs(phi) - AXIS.b) < 1e-15:  # at a flank: the sense of the relative motion says which way
                side = int(np.sign(phi)) if np.sign(phi) * (y[1] - y[3]) > 0.0 else 0
            steps = np.linspace(0.0, left, 41)[1:]
            made, h = generator(side), left
            for low, high in zip([1e-12, *steps[:-1]], steps, strict=True):
                if beyond(expm(made * high) @ y, side) > 0.0:
                    h = brentq(
                        lambda t, m=made, b=y, s=side: beyond(expm(m * t) @ b, s), low, high, xtol=1e-17
                    )
                    break
            y, left = expm(made * h) @ y, left - h
            if left > 0.0:  # exactly at the flank
                phi = y[0] - y[2]
                y[0] += np.sign(phi) * AXIS.b - phi
    return y[:4]


@pytest.mark.slow
def test_sampled_cycle__is_that_of_exact_motion_with_its_multipliers() -> None:
    orbit = gp.periodic_orbit(sampled(), autonomous=True, settle=100)
    assert (orbit.order, orbit.stable) == (10, True)
    assert "limit cycle locked to 10 samples, period 0.211 s" in orbit.message
    names = ["motor.theta", "motor.omega", "load.theta", "load.omega"]
    motion = orbit.motion(names, samples=10)
    start = np.array([float(motion[name][0]) for name in names])
    assert np.max(np.abs(after_samples(start, 10) - start) / [1e-3, 1e-1, 1e-3, 1e-1]) < 1e-7
    for n in (3, 7):
        seen = np.array([float(motion[name][n]) for name in names])
        assert np.max(np.abs(after_samples(start, n) - seen) / [1e-3, 1e-1, 1e-3, 1e-1]) < 1e-7
    columns = [
        (after_samples(start + d, 10) - after_samples(start - d, 10)) / (2.0 * np.max(d))
        for d in np.diag([1e-8, 1e-6, 1e-8, 1e-6])
    ]
    exact = np.linalg.eigvals(np.array(columns).T)
    exact = exact[np.argsort(-np.abs(exact))]
    assert np.abs(orbit.multipliers[:4]) == pytest.approx(np.abs(exact), abs=1e-5)
    assert np.max(np.abs(orbit.multipliers[4:]), initial=0.0) < 1e-9  # the held torque is set anew


@pytest.mark.slow
def test_branch__of_sampled_cycles_is_that_of_exact_motion() -> None:
    path, names = (
        "rotors.motor.drive.proportional_gain",
        ["motor.theta", "motor.omega", "load.theta", "load.omega"],
    )
    found = gp.branch(sampled(), path, 3.0, 5.0, autonomous=True, settle=100, orbits=3, upwards=False)
    assert (found.order, len(found.orbits)) == (10, 3)
    assert np.all(np.diff(found.parameters) < 0.0)
    for gain, states in zip(found.parameters, found.levels(names)[0], strict=True):
        returned = after_samples(states[0], 10, float(gain))
        assert np.max(np.abs(returned - states[0]) / [1e-3, 1e-1, 1e-3, 1e-1]) < 1e-7
    last = gp.replace(sampled(), {path: float(found.parameters[-1])})
    exact = gp.periodic_orbit(last, autonomous=True, settle=100).amplitude("load.theta")
    assert found.amplitudes("load.theta")[0][-1] == pytest.approx(exact, rel=1e-6)


def test_sampled_cycle__not_locked_has_its_own_period() -> None:
    with pytest.raises(
        SimulationError,
        match=r"not locked to the samples: its own period is 0\.2\d+ s, 10\.\d+ samples.*quasi-periodic",
    ):
        gp.periodic_orbit(
            gp.replace(sampled(0.02), {"rotors.load.load.drag": 0.002}), autonomous=True, settle=60
        )


def test_sampled_cycle__at_rest() -> None:
    calm = gp.replace(sampled(1e-3), {"rotors.motor.drive.proportional_gain": 0.2, "run.duration": 0.2})
    with pytest.raises(SimulationError, match="comes to rest"):
        gp.periodic_orbit(calm, autonomous=True, settle=500)


@pytest.mark.parametrize(
    ("drive", "arguments", "said"),
    [
        ({}, {"section": "motor-load:forward:opens"}, "section.*must be left out for a sampled control"),
        ({"speed_resolution": 1e-3}, {}, "speed_resolution.*must be 0 for orbits of a sampled control"),
    ],
)
def test_sampled_cycle__refused(drive: dict[str, Any], arguments: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        gp.periodic_orbit(sampled(**drive), autonomous=True, **arguments)
