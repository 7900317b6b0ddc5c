"""Modes solve their differential equations exactly between samples."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearplay.rig.instruments import butterworth, sensor_modes, sensor_response
from gearplay.rig.modes import Modes, grow
from gearplay.rig.plan import Accelerometer, load_rig

SENSOR = load_rig().accelerometers["sensor"]
FREQUENCIES = np.geomspace(0.01, 2e5, 400)


def sensor_of(**values: float) -> Accelerometer:
    return load_rig({"accelerometers": {"a": values}}).accelerometers["a"]


@pytest.mark.parametrize("size", [1e-12, 1e-6, 0.999e-3, 1.001e-3, 0.1, 5.0])
@pytest.mark.parametrize("turn", [0.5 * math.pi, 0.8 * math.pi, math.pi])
def test_growth_functions_by_their_series(size: float, turn: float) -> None:
    z = size * complex(math.cos(turn), math.sin(turn))
    one = sum(z**k / math.factorial(k + 1) for k in range(60))
    two = sum(z**k / math.factorial(k + 2) for k in range(60))
    found = grow(z)
    assert abs(found[0] - one) <= 1e-13
    assert abs(found[1] - two) <= 1e-12


@pytest.mark.parametrize("damping", [1e-3, 0.02, 0.5, 0.9])
def test_the_sum_of_modes_is_the_sensors_transfer_function(damping: float) -> None:
    sensor = (
        sensor_of(damping_ratio=damping, resonance=26e3)
        if damping < 0.3
        else sensor_of(damping_ratio=damping, resonance=60e3)
    )
    analytic = sensor_response(sensor, FREQUENCIES)
    assert np.allclose(sensor_modes(sensor).response(FREQUENCIES), analytic, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("order", range(1, 13))
def test_the_sum_of_modes_is_a_butterworth_filter(order: int) -> None:
    found = np.abs(butterworth(order, 4e4).response(FREQUENCIES)) ** 2
    assert np.allclose(found, 1.0 / (1.0 + (FREQUENCIES / 4e4) ** (2 * order)), rtol=1e-8, atol=1e-14)


def reference(modes: Modes, times: np.ndarray, held: bool, u: np.ndarray) -> np.ndarray:
    """Integrate the modes as ordinary differential equations, interval by interval."""
    interval = times[1]
    x = np.zeros(len(modes.poles), dtype=complex)
    poles = np.array(modes.poles)
    out = [0.0]
    weights = np.array(
        [r * (2.0 if p.imag > 0.0 else 1.0) for p, r in zip(poles, modes.residues, strict=True)]
    )
    for k in range(len(times) - 1):
        a, b = (u[k], u[k]) if held else (u[k], u[k + 1])
        solved = solve_ivp(
            lambda t, x, a=a, b=b: poles * x + a + (b - a) * t / interval,
            (0.0, interval), x, method="DOP853", rtol=1e-11, atol=1e-18,
        )  # fmt: skip
        x = solved.y[:, -1]
        out.append(float(np.sum((weights * x).real)))
    return np.array(out)


@pytest.mark.parametrize("held", [True, False])
def test_sampled_modes_are_exact_for_held_and_for_joined_input(held: bool) -> None:
    generator = np.random.default_rng(1)
    times = np.arange(60) / 2e5
    u = generator.normal(size=60)
    for modes in (sensor_modes(SENSOR), butterworth(5, 4e4)):
        if held:
            found = modes.hold(u, float(times[1]))
        else:
            u[0] = 0.0  # joined input starts from rest, at zero
            found = modes.join(u, float(times[1]))
        wanted = reference(modes, times, held, u)
        assert found[0] == pytest.approx(0.0, abs=1e-12)
        assert np.allclose(found, wanted, rtol=1e-8, atol=1e-9 * np.max(np.abs(wanted)))
