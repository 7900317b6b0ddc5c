"""Models of the instruments: accelerometer with AC coupling and saturation; anti-alias filter, sampling, conversion to counts."""

import math
from functools import reduce
from operator import mul

import numpy as np
from numpy.typing import NDArray

from gearplay.rig.modes import Modes, sharpen
from gearplay.rig.plan import Accelerometer, Collector

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

HALF_TAPS = 10
"""Half length of the filter that thins out the ideal acceleration [samples of the collector]."""


def sensor_modes(sensor: Accelerometer) -> Modes:
    """Return the sensor's modes, its nominal sensitivity divided out.

    ``H(s) = s / (s + w_c) * w_n^2 / (s^2 + 2 zeta w_n s + w_n^2)`` with w_c, w_n the coupling's corner and the natural frequency
    in rad/s: seismic element of ISO 16063-1, first-order coupling. Residues: ``r_i = (s - p_i) H(s)`` at s = p_i.
    """
    w_c, w_n, zeta = (
        math.tau * sensor.coupling_corner,
        math.tau * sensor.natural_frequency,
        sensor.damping_ratio,
    )
    pole = w_n * complex(-zeta, math.sqrt(1.0 - zeta**2))
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
    s: Complex = np.asarray(1j * math.tau * np.asarray(frequency, dtype=np.float64), dtype=np.complex128)
    w_c, w_n, zeta = (
        math.tau * sensor.coupling_corner,
        math.tau * sensor.natural_frequency,
        sensor.damping_ratio,
    )
    response: Complex = s / (s + w_c) * w_n**2 / (s**2 + 2.0 * zeta * w_n * s + w_n**2)
    return response


def sensor_voltage(sensor: Accelerometer, means: Floats, sampling: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the saturated output [V] of the sensor and the mask of saturated samples, both of shape [time].

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
    deviation = sensor.sensitivity * sensor.density * math.sqrt(0.5 * sampling)
    return generator.normal(0.0, deviation, size) if deviation > 0.0 else np.zeros(size)


def butterworth(order: int, corner: float) -> Modes:
    """Return the modes of a Butterworth low-pass of 3 dB at ``corner`` [Hz]: poles evenly spaced on a half circle.

    Butterworth, On the theory of filter amplifiers, 1930: ``|H|^2 = 1 / (1 + (f / corner)^(2 order))``.

    >>> float(np.abs(butterworth(8, 100.0).response(np.array([100.0])))[0] ** 2).__round__(9)
    0.5
    """
    w = math.tau * corner
    poles = [w * complex(np.exp(1j * math.pi * (2 * k + order + 1) / (2 * order))) for k in range(order)]
    poles = [complex(p.real, 0.0) if abs(p.imag) < 1e-9 * w else p for p in poles]
    kept = [p for p in poles if p.imag >= 0.0]
    residues = [w * reduce(mul, (w / (p - q) for q in poles if q != p), 1.0 + 0j) for p in kept]
    return Modes(tuple(kept), tuple(residues))


def keep_back_aliases(collector: Collector, voltage: Floats, sampling: float) -> Floats:
    """Return the voltage behind the anti-alias filter, shape [time], at the same rate [Hz]."""
    if collector.filter == "none":
        return voltage
    return butterworth(collector.filter_order, collector.corner).join(sharpen(voltage), 1.0 / sampling)


def convert(collector: Collector, voltage: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return counts, whole numbers from -2^(bits - 1) to 2^(bits - 1) - 1, and which samples were beyond; shape [time].

    >>> counts, beyond = convert(Collector(range=1.0, bits=3), np.array([0.0, 0.26, -1.0, 0.99]))
    >>> counts.tolist(), beyond.tolist()
    ([0.0, 1.0, -4.0, 3.0], [False, False, False, True])
    """
    top = 2 ** (collector.bits - 1)
    steps = np.rint(voltage / collector.quantum)
    return np.clip(steps, -top, top - 1) + 0.0, (steps < -top) | (steps > top - 1)


def thin_out(means: Floats, factor: int) -> Floats:
    """Return the ideal acceleration [m/s^2] at every ``factor``-th interval's start, shape [time // factor].

    A symmetric low-pass of 20 collector samples (Kaiser window, beta 8) without delay: flat to 0.37 of the collector's
    rate, 80 dB down from 0.63. Beyond both ends the acceleration counts as zero.

    >>> bool(np.allclose(thin_out(np.ones(800), 8)[15:-15], 1.0, atol=2e-4))
    True
    """
    from scipy.signal import firwin, upfirdn

    half = HALF_TAPS * factor
    # An even number of taps: the means lie half an interval off the instants that are kept.
    taps = firwin(2 * half, 0.5, window=("kaiser", 8.0), fs=float(factor))
    ahead = (1 - half) % factor
    thinned = upfirdn(taps, np.concatenate((np.zeros(ahead), means, np.zeros(half))), 1, factor)
    first = (half - 1 + ahead) // factor
    result: Floats = thinned[first : first + means.size // factor]
    return result
