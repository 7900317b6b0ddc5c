"""Data collector: anti-alias filter, sampling, conversion to counts and back."""

from functools import reduce
from math import pi, tau
from operator import mul

import numpy as np
from numpy.typing import NDArray

from gearplay.rig.modes import Modes, sharpen
from gearplay.rig.plan import Collector

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

HALF_TAPS = 10
"""Half length of the filter that thins out the ideal acceleration [samples of the collector]."""


def butterworth(order: int, corner: float) -> Modes:
    """Return the modes of a Butterworth low-pass of 3 dB at ``corner`` [Hz]: poles evenly spaced on a half circle.

    Butterworth, On the theory of filter amplifiers, 1930: ``|H|^2 = 1 / (1 + (f / corner)^(2 order))``.

    >>> float(np.abs(butterworth(8, 100.0).response(np.array([100.0])))[0] ** 2).__round__(9)
    0.5
    """
    w = tau * corner
    poles = [w * complex(np.exp(1j * pi * (2 * k + order + 1) / (2 * order))) for k in range(order)]
    poles = [complex(p.real, 0.0) if abs(p.imag) < 1e-9 * w else p for p in poles]
    kept = [p for p in poles if p.imag >= 0.0]
    residues = [w * reduce(mul, (w / (p - q) for q in poles if q != p), 1.0 + 0j) for p in kept]
    return Modes(tuple(kept), tuple(residues))


def filter_response(collector: Collector, frequency: Floats) -> Complex:
    """Return the analytic response of the anti-alias filter at each frequency [Hz], shape [frequency]; 1 without a filter.

    >>> bool(np.allclose(filter_response(Collector(filter="none"), np.array([1.0, 1e6])), 1.0))
    True
    """
    if collector.filter == "none":
        return np.ones(np.shape(frequency), dtype=np.complex128)
    return butterworth(collector.filter_order, collector.corner).response(frequency)


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
