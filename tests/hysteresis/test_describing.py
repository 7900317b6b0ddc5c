"""Describing functions: closed forms of the dead zone and of friction, published predictions, errors against limit cycles."""

import math

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.vocabulary.errors import InputError
from servo_loops import Axis

BASE = {"J1": 1e-3, "J2": 4e-3, "b": 2e-3, "d1": 1e-3}


def dead_zone(k: float, b: float, amplitude: np.ndarray) -> np.ndarray:
    """Return k (1 - 2/pi (asin x + x sqrt(1 - x^2))), x = b / amplitude (Gelb and Vander Velde 1968, table 2)."""
    x = b / amplitude
    return k * (1.0 - 2.0 / math.pi * (np.arcsin(x) + x * np.sqrt(1.0 - x**2)))


def test_describing_function__dead_zone(measured: Measured) -> None:
    axis = Axis(**BASE, k=10.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=2e-3)
    found = gp.describing_function(axis.case(1e-9), at="load", hold="motor", torque=0.2).ds
    exact = dead_zone(10.0, 2e-3, found["amplitude"].values)
    worst = float(np.max(np.abs(found["stiffness"].values / exact - 1.0)[5:]))
    measured("describing function of a dead zone, relative", worst, "1e-6")
    assert worst < 1e-6
    assert float(found["loss"].max()) == 0.0


def test_describing_function__friction_and_two_springs(measured: Measured) -> None:
    """Play and springs of two couplings in a row add up; Coulomb friction gives 4 T / (pi A)."""
    still = {"mass": 1.0, "inertia": 1e-3}
    part = {"torsional_stiffness": 60.0, "play": 2e-3}
    case = {
        "rotors": {"a": still, "b": {**still}, "c": {**still, "load": {"friction": 0.05}}},
        "couplings": [{"between": ["a", "b"], **part}, {"between": ["b", "c"], **part}],
        "run": {"duration": 1.0},
    }
    found = gp.describing_function(case, at="c", hold="a", torque=1.0).ds
    amplitude = found["amplitude"].values
    exact = dead_zone(30.0, 2e-3, amplitude)
    worst = float(np.max(np.abs(found["stiffness"].values / exact - 1.0)[5:]))
    measured("describing function of two couplings in a row, relative", worst, "1e-6")
    assert worst < 1e-6
    assert np.allclose(found["loss"].values, 0.2 / (math.pi * amplitude), rtol=1e-12)
    assert "growth_rate" not in found


@pytest.mark.parametrize(
    ("axis", "period", "amplitude"),
    [
        (Axis(**BASE, k=10.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=2e-3), 0.19861966343957, 3.8719661962139e-3),
        (Axis(**BASE, k=5.0, Kp=2.0, Kd=0.1, Ki=0.0, d2=0.01), 0.29944494841310, 3.3189878085231e-3),
        (Axis(**BASE, k=5.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=0.01), 0.19882540356781, 7.3682796525235e-3),
        (Axis(**BASE, k=10.0, Kp=4.0, Kd=0.1, Ki=10.0, d2=2e-3), 0.20200998059382, 4.6558170681179e-3),
    ],
)
def test_prediction__numbers_of_harmonic_balance(
    axis: Axis, period: float, amplitude: float, measured: Measured
) -> None:
    """1 + N(A) G(i omega) = 0 solved elsewhere."""
    found = gp.describing_function(axis.case(1e-9), at="load", hold="motor", torque=0.2).ds
    assert found.sizes["cycle"] == 1
    assert float(found["cycle_stable"][0]) == 1.0
    errors = (
        abs(float(found["cycle_period"][0]) / period - 1.0),
        abs(float(found["cycle_amplitude"][0]) / amplitude - 1.0),
    )
    measured("limit cycles predicted by a describing function, relative", max(errors), "1e-6")
    assert max(errors) < 1e-6


@pytest.mark.compiled
def test_prediction__its_error_against_the_limit_cycle() -> None:
    axis = Axis(**BASE, k=5.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=0.01)
    found = gp.describing_function(axis.case(1e-9), at="load", hold="motor", torque=0.2)
    orbit = gp.periodic_orbit(axis.case(1e-9), autonomous=True, settle=30)
    errors = found.errors(orbit)
    assert errors["period"] == pytest.approx(0.19882540356781 / 0.200513233655 - 1.0, abs=1e-6)
    assert errors["amplitude"] == pytest.approx(7.3682796525e-3 / 7.5104895031e-3 - 1.0, abs=1e-5)
    forced = gp.periodic_orbit(gp.torsional_pair(0.7, force=0.05), settle=300)
    with pytest.raises(InputError, match="must be a limit cycle"):
        found.errors(forced)


@pytest.mark.parametrize("ratio", [-2.0, 3.0])
def test_prediction__of_a_geared_axis_is_that_of_its_output(ratio: float) -> None:
    """A motor behind a gearing, its inertia, drag and gains divided as the ratio asks, is the direct axis at the output."""
    axis = Axis(**BASE, k=10.0, Kp=4.0, Kd=0.1, Ki=10.0, d2=2e-3)
    direct = gp.describing_function(axis.case(1e-9), at="load", hold="motor", torque=0.2).ds
    geared = gp.replace(
        axis.case(1e-9),
        {
            "couplings": [{"between": ["load", "motor"], "torsional_stiffness": 10.0, "play": 4e-3, "ratio": 1.0 / ratio}],
            "rotors.motor.inertia": axis.J1 / ratio**2,
            "rotors.motor.load.drag": axis.d1 / ratio**2,
            "rotors.motor.drive.proportional_gain": axis.Kp / abs(ratio),
            "rotors.motor.drive.integral_gain": axis.Ki / abs(ratio),
            "rotors.motor.drive.derivative_gain": axis.Kd / ratio**2,
        },
    )  # fmt: skip
    found = gp.describing_function(geared, at="load", hold="motor", torque=0.2).ds
    for name in ("cycle_period", "cycle_amplitude"):
        assert float(found[name][0]) == pytest.approx(float(direct[name][0]), rel=1e-9)


def test_describing_function__refusals() -> None:
    with pytest.raises(InputError, match="must be a rotor of the case"):
        gp.describing_function("external-pair", at="output", hold="nobody", torque=1.0)
