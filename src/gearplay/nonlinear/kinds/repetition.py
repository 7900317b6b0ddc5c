"""Repetition of a section: the smallest number of periods after which it repeats within the resolution.

Folded by an order k, samples n, n + k, n + 2 k ... stand together; of a cycle of order k only noise about their means is left.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.kinds.thresholds import REPEATS, SPREAD

Floats = NDArray[np.float64]

PEAK = 5.0 * SPREAD
"""Largest deviation of a single sample: five standard deviations [resolutions]."""


@dataclass(frozen=True)
class Misfit:
    """Deviation from repetition with ``order``, worst signal [resolutions]: standard deviation and largest value."""

    order: int
    spread: float
    peak: float

    @property
    def repeats(self) -> bool:
        """Whether the deviation is within the resolution."""
        return self.spread <= SPREAD and self.peak <= PEAK


def repeating_orders(samples: Floats, most: int, apart: float, *, first: int | None = None) -> Iterator[int]:
    """Yield the orders, up to ``most``, with which samples repeat to within ``apart``, the smallest first.

    ``samples`` has shape [period, signal]; with order k no sample differs from that k periods later by more than ``apart`` in
    any signal. Of long records only the ``first`` samples are compared.

    >>> list(repeating_orders(np.tile([[0.0], [5.0], [0.0], [8.0]], (4, 1)), 8, 0.1))
    [4, 8]
    """
    for order in range(1, most + 1):
        count = len(samples) - order
        some = count if first is None else min(first, count)
        if float(np.max(np.abs(samples[order : order + some] - samples[:some]))) <= apart:
            yield order


def unfolded(samples: Floats, order: int) -> Floats:
    """Return the samples, shape [period, signal], less the mean of their place in the cycle (of complete cycles).

    >>> unfolded(np.array([[1.0], [5.0], [3.0], [5.0]]), 2).ravel().tolist()
    [-1.0, 0.0, 1.0, 0.0]
    """
    complete = len(samples) // order * order
    means = samples[:complete].reshape(-1, order, samples.shape[1]).mean(axis=0)
    return np.asarray(samples - np.resize(means, samples.shape))


def misfit(samples: Floats, order: int) -> Misfit:
    """Return the deviation of samples [resolutions], shape [period, signal], from repetition with ``order``.

    >>> found = misfit(np.array([[1.0], [5.0], [3.0], [5.0]]), 2)
    >>> found.spread, found.peak  # two degrees of freedom are left of four
    (1.0, 1.0)
    """
    rest = unfolded(samples, order)
    spread = np.sqrt(np.sum(rest**2, axis=0) / (len(samples) - order))
    return Misfit(order, float(np.max(spread)), float(np.max(np.abs(rest))))


def find_order(samples: Floats, repeats: int = REPEATS) -> Misfit | None:
    """Return the misfit of the smallest order with which samples [resolutions] repeat at least ``repeats`` times, or nothing.

    The order is at most ``sqrt(N s) / 2`` with s the largest standard deviation [resolutions]: some order k brings any rotation
    back to within ``1 / (sqrt(5) k)`` of a turn (Hurwitz), so that from about ``sqrt(N s)`` on a torus repeats too.

    >>> find_order(np.tile([[0.0], [50.0], [0.0], [80.0]], (20, 1))).order
    4
    """
    most = min(len(samples) / repeats, 0.5 * math.sqrt(len(samples) * float(np.max(np.std(samples, axis=0)))))
    # Two samples within a peak of one mean differ by two peaks at most; 256 samples exclude most orders.
    candidates = repeating_orders(samples, max(int(most), 1), 2.0 * PEAK, first=256)
    return next((found for order in candidates if (found := misfit(samples, order)).repeats), None)


def nearest_order(samples: Floats) -> Misfit:
    """Return the misfit of the order up to 64 with the least spread."""
    orders = range(1, min(64, len(samples) // REPEATS) + 1)
    return min((misfit(samples, order) for order in orders), key=lambda found: found.spread)


def count_bands(states: Floats) -> int:
    """Return the number of bands (up to 32) visited in turn; 1 where folding removes less than a fifth of the variance.

    ``states`` has shape [period, signal], each signal of like size; a band is visited at least 20 times. The result is
    the smallest order whose remaining variance is at most a fifth above the least.
    """
    orders = range(1, max(1, min(32, len(states) // 20)) + 1)
    left = np.array([np.sum(unfolded(states, k) ** 2) / (len(states) - k) for k in orders])
    best = int(np.flatnonzero(left <= 1.2 * left.min())[0])
    return best + 1 if left[best] < 0.8 * left[0] else 1
