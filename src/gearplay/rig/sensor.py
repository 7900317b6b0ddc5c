"""Accelerometer: seismic element, AC coupling, saturation."""

from math import sqrt, tau

import numpy as np
from numpy.typing import NDArray

from gearplay.rig.modes import Modes, sharpen
from gearplay.rig.plan import Accelerometer

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


def sensor_modes(sensor: Accelerometer) -> Modes:
    """Return the sensor's modes, its nominal sensitivity divided out.

    ``H(s) = s / (s + w_c) * w_n^2 / (s^2 + 2 zeta w_n s + w_n^2)`` with w_c, w_n the coupling's corner and the natural frequency
    in rad/s: seismic element of ISO 16063-1, first-order coupling. Residues: ``r_i = (s - p_i) H(s)`` at s = p_i.
    """
    w_c, w_n, zeta = tau * sensor.coupling_corner, tau * sensor.natural_frequency, sensor.damping_ratio
    pole = w_n * complex(-zeta, sqrt(1.0 - zeta**2))
    slow = -w_c * w_n**2 / (w_c**2 - 2.0 * zeta * w_n * w_c + w_n**2)
    fast = pole / (pole + w_c) * w_n**2 / (2j * pole.imag)
    return Modes((complex(-w_c), pole), (complex(slow), fast))


def sensor_response(sensor: Accelerometer, frequency: Floats) -> Complex:
    """Return the analytic response at each frequency [Hz]: voltage over nominal voltage, shape [frequency].

    >>> sensor = Accelerometer.model_validate({"kind": "356A02"})
    >>> [round(float(abs(h)), 4) for h in sensor_response(sensor, np.array([1.0, 100.0, 5000.0]))]
    [0.95, 1.0, 1.0416]

    At 5 kHz, a fifth of the resonance, 1 / (1 - 1 / 25) = 1.0417 without damping.
    """
    s: Complex = np.asarray(1j * tau * np.asarray(frequency, dtype=np.float64), dtype=np.complex128)
    w_c, w_n, zeta = tau * sensor.coupling_corner, tau * sensor.natural_frequency, sensor.damping_ratio
    response: Complex = s / (s + w_c) * w_n**2 / (s**2 + 2.0 * zeta * w_n * s + w_n**2)
    return response


def sensor_voltage(sensor: Accelerometer, means: Floats, sampling: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the sensor's output [V] at each sample, saturated, and which samples were, both of shape [time].

    ``means`` [m/s^2] is the acceleration along the axis averaged over each interval of ``sampling`` [Hz]. The output saturates at
    sensitivity times range; noise is not part of it (`noise_voltage`).
    """
    limit = sensor.sensitivity * sensor.range
    voltage = sensor.sensitivity * sensor_modes(sensor).hold(sharpen(means), 1.0 / sampling)
    beyond = np.abs(voltage) > limit
    return np.clip(voltage, -limit, limit), beyond


def noise_voltage(
    sensor: Accelerometer, size: int, sampling: float, generator: np.random.Generator
) -> Floats:
    """Return white noise [V], shape [time], of the sensor's one-sided density n: variance n^2 sampling / 2 in m/s^2."""
    deviation = sensor.sensitivity * sensor.density * sqrt(0.5 * sampling)
    return generator.normal(0.0, deviation, size) if deviation > 0.0 else np.zeros(size)
