"""Periodic orbits, kinds of motion and exponents of what couplings, supports and torques with terms make."""

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, Measured, case_of

J_1, J_2, K, C, T_1, OMEGA = 2e-3, 3e-3, 40.0, 0.02, 0.5, 120.0


def shaken() -> Document:
    """Return two discs on a torsional spring, the second held by another; a torque T sin(omega t) on the first."""
    term = {"frequency": OMEGA / (2.0 * np.pi), "amplitude": T_1}
    return {
        "rotors": {
            "one": {"mass": 1.0, "inertia": J_1, "drive": {"kind": "torque", "torque": 0.0, "terms": [term]}},
            "two": {"mass": 1.0, "inertia": J_2},
        },
        "couplings": [{"between": ["one", "two"], "torsional_stiffness": K, "torsional_damping": C}],
        "supports": {"two": {"torsional_stiffness": 2.0 * K, "torsional_damping": C}},
        "run": {"duration": 1.0, "sampling": 1e3, "tolerance": 1e-10},
    }


def expected_section() -> Floats:
    """Return rotations [rad] and speeds [rad/s] where the torque's sine begins, by the linear equations."""
    spring, damping = K * np.array([[1, -1], [-1, 3]]), C * np.array([[1, -1], [-1, 2]])
    amplitudes = np.linalg.solve(
        spring - OMEGA**2 * np.diag([J_1, J_2]) + 1j * OMEGA * damping, np.array([T_1, 0.0])
    )
    return np.concatenate([amplitudes.imag, OMEGA * amplitudes.real])


def test_an_orbit_is_the_harmonic_response(measured: Measured) -> None:
    """The periodic orbit of two joined discs under a torque with one term is that of the linear equations; its multipliers are
    those of free vibrations over one period.
    """
    orbit = gp.periodic_orbit(case_of(shaken()))
    expected = expected_section()
    error = float(np.max(np.abs(orbit.states[0] / expected - 1.0)))
    measured("orbit of two joined discs against the harmonic response, relative", error, "1e-7")
    assert error < 1e-7
    spring, damping = K * np.array([[1, -1], [-1, 3]]), C * np.array([[1, -1], [-1, 2]])
    masses = np.diag([1.0 / J_1, 1.0 / J_2])
    rates = np.block([[np.zeros((2, 2)), np.eye(2)], [-masses @ spring, -masses @ damping]])
    multipliers = np.asarray(orbit.multipliers)
    for each in np.exp(np.linalg.eigvals(rates) * 2.0 * np.pi / OMEGA):
        assert np.min(np.abs(multipliers - each)) < 1e-6


@pytest.mark.slow
def test_exponents_of_joined_rotors_add_up_to_their_damping() -> None:
    """The sum of all exponents is the trace of the damping, and so is the divergence on the way."""
    found = gp.lyapunov(case_of(shaken()), count=4, duration=3.0)
    trace = -(C / J_1 + 2.0 * C / J_2)
    assert float(np.sum(found.values)) == pytest.approx(trace, rel=1e-6)
    assert found.divergence == pytest.approx(trace, rel=1e-9)


@pytest.mark.slow
def test_the_pulsating_pair_is_periodic() -> None:
    """The bundled pair under 300 + 100 sin(omega t) N m answers with the common period of its load and of its mesh."""
    found = gp.motion("pulsating-pair", periods=100, settle=100, compare=False)
    assert "periodic of order 1" in found.message
