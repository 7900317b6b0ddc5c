"""Whether a motion's statistics drift or jump within the record, judged against how blocks of the record differ anyway.

The record is cut into blocks; of each the mean of each signal, of its square, of its product with the next sample, and of the
logarithm of the distance of neighbouring states are taken. Two statistics compare the blocks with each other: Student's t of the
best step (two means, a common variance, the best place of the step) and t of a straight line. Chaos differs from block to block
by chance, as its correlations have it, and both stay small; of a regular motion that drifts they are very large.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLOCKS: Final = 16
"""Blocks: of 300 periods each holds 18, more than most correlations last, and t has 14 degrees of freedom."""

EDGE: Final = 3
"""A step has at least so many blocks on each side."""

LEAST: Final = 1e-18
"""Sums of squares of block means below this (of signals of size 1) are rounding."""


@dataclass(frozen=True)
class Drift:
    """How blocks of a record differ: t of the best step and of a straight line, the largest of all features."""

    step: float
    trend: float


def features(samples: Floats, distances: Floats, noise: float) -> Floats:
    """Return what is averaged over blocks, shape [state, feature]; ``distances`` of neighbours count from ``noise`` up."""
    count = min(len(distances), len(samples) - 1)
    now, later = samples[:count], samples[1 : count + 1]
    nearness = np.log(np.maximum(distances[:count], max(noise, 1e-12)))
    return np.hstack([now, now**2, now * later, nearness[:, None]])


def block_means(table: Floats, bands: int = 1) -> Floats:
    """Return the means of equal blocks, shape [block, feature]; what is left over at the end is left out.

    Blocks that hold two visits to each of ``bands`` bands or more hold whole numbers of visits.

    >>> block_means(np.repeat(np.arange(16.0), 3)[:, None])[:3].ravel().tolist()
    [0.0, 1.0, 2.0]
    """
    each = len(table) // BLOCKS
    each -= each % bands if 2 * bands <= each else 0
    return np.asarray(table[: BLOCKS * each].reshape(BLOCKS, each, -1).mean(axis=1))


def drift(means: Floats) -> Drift:
    """Return the drift of block means, shape [block, feature].

    A step explains the part ``b`` of the sum of squares about the mean, a line the part ``b'``: ``t^2 = b / (1 - b) (B - 2)``.

    >>> found = drift(np.array([0.0] * 8 + [1.0] * 7 + [2.0])[:, None])  # b of the step is 5.0625 / 5.9375
    >>> round(found.step, 6) == round((5.0625 / 0.875 * 14) ** 0.5, 6)
    True
    """
    count = len(means)
    rest = means - means.mean(axis=0)
    whole = np.sum(rest**2, axis=0)
    if not np.any(whole > LEAST):
        return Drift(0.0, 0.0)
    sums = np.cumsum(rest, axis=0)
    before = np.arange(EDGE, count - EDGE + 1)
    between = sums[before - 1] ** 2 * (count / (before * (count - before)))[:, None]
    place = np.arange(count) - 0.5 * (count - 1)
    straight = (place @ rest) ** 2 / np.sum(place**2)
    return Drift(_largest_t(between.max(axis=0), whole), _largest_t(straight, whole))


def _largest_t(explained: Floats, whole: Floats) -> float:
    kept = whole > LEAST
    left = np.maximum(whole[kept] - explained[kept], 1e-12 * whole[kept])
    return float(np.sqrt(np.max(explained[kept] / left) * (BLOCKS - 2)))


def slow_share(rest: Floats) -> float:
    """Return the share of the variance of a motion, shape [period, signal], that turns less than twice in the record.

    It is that of the cosine transform's terms of a half, one and one and a half turns.

    >>> n = np.arange(500.0)[:, None] + 0.5
    >>> [round(slow_share(np.cos(2.0 * np.pi * turns * n / 500.0)), 6) for turns in (0.5, 1.5, 2.0)]
    [1.0, 1.0, 0.0]
    """
    centred = rest - rest.mean(axis=0)
    place = (np.arange(len(rest)) + 0.5) / len(rest)
    slow = np.cos(np.pi * np.outer((1.0, 2.0, 3.0), place)) @ centred
    whole = float(np.sum(centred**2))
    return 2.0 / len(rest) * float(np.sum(slow**2)) / whole if whole > 0.0 else 0.0
