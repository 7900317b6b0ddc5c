"""Whether a section repeats after some periods: folding it by an order and looking at what is left.

Folded by order k, samples n, n + k, n + 2 k ... stand together; a cycle of order k leaves but noise about their means.
All sizes are in units of the resolution where a function takes it.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.orders import repeating_orders

Floats = NDArray[np.float64]

REPEATS: Final = 8
"""Fewest times a cycle must be seen: with 8 repeats its means take an eighth of the noise away, which is allowed for."""

FEW: Final = 3
"""Times a cycle must be seen to be suspected."""

SPREAD: Final = 1.5
"""Standard deviation of the rest that still counts as the resolution: noise of its size gives 1 +- 0.06 (300 periods), and
resolutions are stated roughly."""

PEAK: Final = 8.0
"""Largest deviation that still counts as the resolution: five standard deviations of noise at the limit `SPREAD`."""

FIRST: Final = 256
"""Samples that are compared with those one order later before all are: most orders fail there."""

MOST_BANDS, BAND_REPEATS = 32, 20
"""Bands of chaos are looked for up to so many, each seen at least so often: finer ones hold too few samples to be judged."""


@dataclass(frozen=True)
class Misfit:
    """How far a section is from repeating with ``order``, worst signal [resolutions]: standard deviation and largest."""

    order: int
    spread: float
    peak: float

    @property
    def repeats(self) -> bool:
        """Whether that is within the resolution."""
        return self.spread <= SPREAD and self.peak <= PEAK


def unfolded(samples: Floats, order: int) -> Floats:
    """Return the samples, shape [period, signal], less the mean of their place in the cycle (of whole repeats).

    >>> unfolded(np.array([[1.0], [5.0], [3.0], [5.0]]), 2).ravel().tolist()
    [-1.0, 0.0, 1.0, 0.0]
    """
    whole = len(samples) // order * order
    means = samples[:whole].reshape(-1, order, samples.shape[1]).mean(axis=0)
    return np.asarray(samples - np.resize(means, samples.shape))


def misfit(samples: Floats, order: int) -> Misfit:
    """Return how far samples [resolutions], shape [period, signal], are from repeating with ``order``.

    >>> found = misfit(np.array([[1.0], [5.0], [3.0], [5.0]]), 2)
    >>> found.spread, found.peak  # two degrees of freedom are left of four
    (1.0, 1.0)
    """
    rest = unfolded(samples, order)
    spread = np.sqrt(np.sum(rest**2, axis=0) / (len(samples) - order))
    return Misfit(order, float(np.max(spread)), float(np.max(np.abs(rest))))


def find_order(samples: Floats, least: int = 1, repeats: int = REPEATS) -> Misfit | None:
    """Return the misfit of the smallest order, from ``least`` up, with which samples [resolutions] repeat, or nothing.

    The record holds the cycle at least ``repeats`` times. The order is at most ``sqrt(N s) / 2`` with s the largest standard
    deviation [resolutions]: some order k brings any rotation back to within ``1 / (sqrt(5) k)`` of a turn (Hurwitz), so that
    from about ``sqrt(N s)`` on a torus repeats within the resolution too.

    >>> find_order(np.tile([[0.0], [50.0], [0.0], [80.0]], (20, 1))).order
    4
    """
    most = min(len(samples) / repeats, 0.5 * math.sqrt(len(samples) * float(np.max(np.std(samples, axis=0)))))
    # Two samples within a peak of one mean are no farther apart than two peaks.
    for order in repeating_orders(samples, max(int(most), 1), 2.0 * PEAK, least=least, first=FIRST):
        found = misfit(samples, order)
        if found.repeats:
            return found
    return None


def nearest_order(samples: Floats, most: int = 64) -> list[Misfit]:
    """Return the misfit of the best order up to ``most``, with those of the orders before and after it."""
    orders = range(1, min(most, len(samples) // REPEATS) + 1)
    found = [misfit(samples, order) for order in orders]
    best = min(range(len(found)), key=lambda i: found[i].spread)
    return [found[best], *(found[i] for i in (best - 1, best + 1) if 0 <= i < len(found))]


def count_bands(states: Floats) -> int:
    """Return the number of bands that the motion visits in turn, 1 where folding takes less than a fifth of its variance.

    ``states`` has shape [period, signal], each signal of like size. Of orders that leave about as little as any does (to a fifth)
    the smallest is taken.
    """
    orders = range(1, max(1, min(MOST_BANDS, len(states) // BAND_REPEATS)) + 1)
    left = np.array([np.sum(unfolded(states, k) ** 2) / (len(states) - k) for k in orders])
    best = int(np.flatnonzero(left <= 1.2 * left.min())[0])
    return best + 1 if left[best] < 0.8 * left[0] else 1
