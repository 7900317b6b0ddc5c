"""The reference's base motion, unbalance, torque terms and position servos, against closed forms."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import ellipk

from cross.discs import INERTIA, MASS, TIMES, disc, pair_of
from cross.reference import Reference

# ---------------------------------------------------------------------- base motion


@pytest.mark.slow
def test_a_shaken_oscillator() -> None:
    """Closed form of x'' + w^2 x = -a sin(W t + p) along a direction; gravity beside it."""
    shake = {"kind": "harmonic", "amplitude": 30.0, "frequency": 120.0, "phase": 0.4, "direction": 2.0}
    case = disc(support={"stiffness": [1e6, 1e6]}, base={"acceleration": shake}, gravity=[0.0, -9.81])
    found = Reference(case).trajectory(TIMES)
    w, W = math.sqrt(1e6 / MASS), 240.0 * math.pi
    size = -30.0 / (w**2 - W**2)
    free = -math.sin(0.4) * np.cos(w * TIMES) - W / w * math.cos(0.4) * np.sin(w * TIMES)
    swing = size * (np.sin(W * TIMES + 0.4) + free)
    sag = -9.81 / w**2 * (1.0 - np.cos(w * TIMES))
    np.testing.assert_allclose(found["x"][:, 0], math.cos(2.0) * swing, atol=1e-16)
    np.testing.assert_allclose(found["y"][:, 0], math.sin(2.0) * swing + sag, atol=1e-16)


@pytest.mark.parametrize("as_object", [False, True])
def test_a_half_sine_pulse(as_object: bool) -> None:
    """A free body gains -2 a T / pi; the pulse is a stop, so that its ends are exact."""
    pulse: Any = {"kind": "half-sine", "amplitude": 300.0, "duration": 4e-3, "start": 3e-3, "direction": -0.5}
    if as_object:
        way = math.cos(-0.5), math.sin(-0.5)

        def at(t: float) -> tuple[float, ...]:
            inside = 3e-3 <= t <= 7e-3
            size = 300.0 * math.sin(math.pi * (t - 3e-3) / 4e-3) if inside else 0.0
            return tuple(size * each for each in way)

        pulse = SimpleNamespace(kind="half-sine", start=3e-3, duration=4e-3, at=at)
    case: Any = disc(floating=True, base={"acceleration": pulse})
    found = Reference(SimpleNamespace(**case) if as_object else case).trajectory([3e-3, 7e-3, 0.01])
    gain = -2.0 * 300.0 * 4e-3 / math.pi
    np.testing.assert_allclose(
        found["vx"][:, 0], [0.0, gain * math.cos(-0.5), gain * math.cos(-0.5)], rtol=1e-12
    )
    along = gain * (2e-3 + 3e-3)
    np.testing.assert_allclose(found["y"][2, 0], along * math.sin(-0.5), rtol=1e-12)


# ---------------------------------------------------------------------- unbalance


@pytest.mark.slow
def test_an_unbalance_shakes_its_support() -> None:
    """Closed form of m x'' + k x = U W^2 cos(W t + p), and in y with the sine, both from rest."""
    W, w, phase = 150.0, math.sqrt(1e6 / MASS), 0.6
    case = disc(
        support={"stiffness": [1e6, 1e6]},
        drive={"kind": "speed", "speed": W},
        unbalance={"amount": 2e-3, "phase": phase},
    )
    found = Reference(case).trajectory(TIMES)
    size = 2e-3 * W**2 / MASS / (w**2 - W**2)
    c, s = np.cos(w * TIMES), np.sin(w * TIMES)
    x = np.cos(W * TIMES + phase) - math.cos(phase) * c + W / w * math.sin(phase) * s
    y = np.sin(W * TIMES + phase) - math.sin(phase) * c - W / w * math.cos(phase) * s
    np.testing.assert_allclose(found["x"][:, 0], size * x, atol=1e-16)
    np.testing.assert_allclose(found["y"][:, 0], size * y, atol=1e-16)


@pytest.mark.slow
def test_a_free_unbalanced_rotor_turns_about_its_centre_of_mass() -> None:
    amount, phase = 0.02, 0.3
    case = disc(floating=True, unbalance={"amount": amount, "phase": phase}, gravity=[1.0, -9.81])
    case["rotors"]["disc"]["initial"] = {"vx": 0.2, "omega": 90.0}
    case["base"] = {"acceleration": {"kind": "harmonic", "amplitude": 5.0, "frequency": 40.0}}
    reference = Reference(case)
    found = reference.trajectory(TIMES)
    np.testing.assert_allclose(found["theta"][:, 0], 90.0 * TIMES, atol=1e-12)
    arm = amount / MASS
    middle_x = found["x"][:, 0] + arm * (np.cos(90.0 * TIMES + phase) - math.cos(phase))
    middle_y = found["y"][:, 0] + arm * (np.sin(90.0 * TIMES + phase) - math.sin(phase))
    W = 80.0 * math.pi
    shaken = 0.5 * TIMES**2 - 5.0 / W * (TIMES - np.sin(W * TIMES) / W)
    np.testing.assert_allclose(middle_x, (0.2 - arm * 90.0 * math.sin(phase)) * TIMES + shaken, atol=1e-14)
    fall = arm * 90.0 * math.cos(phase) * TIMES - 0.5 * 9.81 * TIMES**2
    np.testing.assert_allclose(middle_y, fall, atol=1e-14)


@pytest.mark.slow
def test_a_torque_on_a_free_unbalanced_rotor_meets_the_inertia_about_its_centre_of_mass() -> None:
    case = disc(floating=True, unbalance={"amount": 0.02}, drive={"kind": "torque", "torque": 0.5})
    found = Reference(case).trajectory(TIMES)
    alpha = 0.5 / (INERTIA - 0.02**2 / MASS)
    np.testing.assert_allclose(found["theta"][:, 0], 0.5 * alpha * TIMES**2, atol=1e-13)


def test_the_equations_of_an_unbalanced_rotor_by_their_mass_matrix() -> None:
    """Newton and Euler about the axis, solved as three equations."""
    case = disc(
        support={"stiffness": [1e4, 3e4], "torsional_stiffness": 2.0},
        unbalance={"amount": 0.01, "phase": 0.9},
        gravity=[1.0, -9.0],
        initial={"x": 1e-3, "y": -2e-3, "theta": 0.4, "omega": 30.0},
    )
    found = Reference(case).trajectory([0.0])
    ux, uy = 0.01 * math.cos(1.3), 0.01 * math.sin(1.3)
    matrix = np.array([[MASS, 0.0, -uy], [0.0, MASS, ux], [-uy, ux, INERTIA]])
    right = np.array([-10.0 + MASS + 900.0 * ux, 60.0 - 9.0 * MASS + 900.0 * uy, -0.8 - 9.0 * ux - uy])
    got = [found[name][0, 0] for name in ("ax", "ay", "alpha")]
    np.testing.assert_allclose(got, np.linalg.solve(matrix, right), rtol=1e-12)


def test_gravity_swings_an_unbalance_about_a_held_axis() -> None:
    """A pendulum: its period by the complete elliptic integral."""
    case = disc(unbalance={"amount": 0.02, "phase": -0.5 * math.pi}, gravity=[0.0, -9.81])
    case["rotors"]["disc"]["initial"] = {"theta": 1.2}
    quarter = ellipk(math.sin(0.6) ** 2) / math.sqrt(0.02 * 9.81 / INERTIA)
    found = Reference(case, max_step=1e-3).trajectory([quarter, 2.0 * quarter])
    np.testing.assert_allclose(found["theta"][:, 0], [0.0, -1.2], atol=1e-11)


# ---------------------------------------------------------------------- torque terms


@pytest.mark.slow
def test_terms_in_time_and_in_rotation() -> None:
    terms = [{"frequency": 80.0, "amplitude": 0.4, "phase": 0.7}]
    case = disc(drive={"kind": "torque", "torque": 0.3, "terms": terms})
    found = Reference(case).trajectory(TIMES)
    W = 160.0 * math.pi
    swing = math.cos(0.7) * TIMES / W - (np.sin(W * TIMES + 0.7) - math.sin(0.7)) / W**2
    np.testing.assert_allclose(found["theta"][:, 0], (0.15 * TIMES**2 + 0.4 * swing) / INERTIA, atol=1e-13)
    terms = [{"order": 2.5, "amplitude": 0.4, "phase": 0.7}]
    case = disc(
        drive={"kind": "torque", "torque": 0.3, "terms": terms}, initial={"theta": 0.2, "omega": 40.0}
    )
    found = Reference(case).trajectory(TIMES)
    theta = found["theta"][:, 0]
    work = 0.3 * (theta - 0.2) - 0.16 * (np.cos(2.5 * theta + 0.7) - math.cos(2.5 * 0.2 + 0.7))
    np.testing.assert_allclose(0.5 * INERTIA * (found["omega"][:, 0] ** 2 - 1600.0), work, atol=1e-12)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_terms_of_a_load_act_against_the_nominal_sense_and_are_not_clipped(sense: float) -> None:
    load = {"torque": 0.2, "terms": [{"frequency": 100.0, "amplitude": 0.5, "phase": -0.5 * math.pi}]}
    drive = {"kind": "servo", "speed": 30.0 * sense, "proportional_gain": 1e-12, "integral_gain": 0.0}
    found = Reference(disc(load=load, drive=drive)).trajectory([0.0, 0.005])
    np.testing.assert_allclose(found["alpha"][:, 0], sense * np.array([0.3, -0.7]) / INERTIA, rtol=1e-9)


# ---------------------------------------------------------------------- position servo

GAINS = {"proportional_gain": 30.0, "derivative_gain": 0.2, "integral_gain": 900.0, "torque_limit": 0.5}


def test_a_sampled_servo_holds_its_torque() -> None:
    """Hand computation: parabolas from sample to sample, back-calculation while the torque is limited."""
    drive = {"kind": "position", "angle": 0.04, "sample_time": 1.5e-3, **GAINS}
    reference = Reference(disc(drive=drive, initial={"theta": 0.01, "omega": 1.0}))
    times = 1.5e-3 * np.arange(12)
    found = reference.trajectory(times)
    theta, omega, z = 0.01, 1.0, 0.0
    limited = 0
    for k in range(len(times)):
        np.testing.assert_allclose([found["theta"][k, 0], found["omega"][k, 0]], [theta, omega], rtol=1e-11)
        assert found["state"][k, 6] == pytest.approx(z, rel=1e-11, abs=1e-16)
        error = 0.04 - theta
        raw = 30.0 * error + 900.0 * z - 0.2 * omega
        torque = min(max(raw, -0.5), 0.5)
        limited += torque != raw
        assert found["alpha"][k, 0] == pytest.approx(torque / INERTIA, rel=1e-9)
        z += 1.5e-3 * (error + (torque - raw) / 30.0)
        theta += 1.5e-3 * omega + 0.5 * (1.5e-3) ** 2 * torque / INERTIA
        omega += 1.5e-3 * torque / INERTIA
    assert 0 < limited < len(times)


def test_a_continuous_servo_is_linear_within_its_limit() -> None:
    drive = {"kind": "position", "angle": 0.04, **GAINS, "torque_limit": 1e3}
    reference = Reference(disc(drive=drive, initial={"theta": 0.01, "omega": 1.0}))
    found = reference.trajectory([0.004, 0.02])
    matrix = np.array([[0.0, 1.0, 0.0], [-30.0 / INERTIA, -0.2 / INERTIA, -900.0 / INERTIA], [1.0, 0.0, 0.0]])
    for row, t in enumerate((0.004, 0.02)):  # of minus the error, the speed and minus the integral
        exact = expm(t * matrix) @ [-0.03, 1.0, 0.0]
        assert found["theta"][row, 0] == pytest.approx(0.04 + exact[0], rel=1e-12)
        assert found["state"][row, 6] == pytest.approx(-exact[2], rel=1e-10)


@pytest.mark.slow
def test_a_limited_servo_winds_back() -> None:
    """At its limit the torque is constant, and z' = e + (T - raw) / kp = (T - ki z + kd omega) / kp."""
    drive = {"kind": "position", "angle": 0.5, **GAINS}
    reference = Reference(disc(drive=drive))
    found = reference.trajectory([0.006])
    assert found["theta"][0, 0] == pytest.approx(0.25 / INERTIA * 0.006**2, rel=1e-12)
    a, b, c = 0.5 / 30.0, 0.2 * 0.5 / INERTIA / 30.0, 900.0 / 30.0
    exact = (a / c - b / c**2) * (1.0 - math.exp(-c * 0.006)) + b * 0.006 / c
    assert found["state"][0, 6] == pytest.approx(exact, rel=1e-10)
    reference.trajectory([0.09])
    assert any(key == ("servo", 0, "upper") and sign < 0.0 for _, key, sign in reference.events)


@pytest.mark.parametrize(("ratio", "sense"), [(2.0, 1.0), (-2.0, -1.0)])
def test_a_servo_reads_the_sensor_of_another_rotor(ratio: float, sense: float) -> None:
    drive = {"kind": "position", "angle": 0.02, "sensor": "two", **GAINS, "torque_limit": 1e3}
    coupling = {"between": ["one", "two"], "torsional_stiffness": 1.0, "ratio": ratio}
    start = {"initial": {"theta": 0.005, "omega": 0.7}}
    for sample_time in (0.0, 1e-3):
        one = {"drive": drive | {"sample_time": sample_time}, "initial": {"theta": ratio * 0.005}}
        reference = Reference(pair_of(one, start, couplings=[coupling]))
        found = reference.trajectory([0.0])
        raw = sense * (30.0 * 0.015 - 0.2 * 0.7)
        assert found["alpha"][0, 0] == pytest.approx(raw / INERTIA, rel=1e-12)
        assert [rotor.nominal_speed for rotor in reference.rotors] == [0.0, 0.0]
