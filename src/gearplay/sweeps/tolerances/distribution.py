"""Distribution of a measure over drawn points and members: mean, scatter, quantiles with intervals."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.tolerances.exceedance import proportion
from gearplay.sweeps.variance.members import as_table, member_means, member_variance, noise_share

Floats = NDArray[np.float64]
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)


@dataclass(frozen=True)
class Quantile:
    """The value that a share ``level`` of all cases stays below; an end of its interval is infinite where points are too few."""

    level: float
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Distribution:
    """A measure over drawn points and members; numbers that do not exist are NaN.

    ``mean_error`` is the half-width of the mean's interval, ``effective`` the number of independent cases that the quantiles'
    intervals are made for. ``noise`` is the share of the variance of single cases that the members of one point show among
    themselves: no parameter explains it. It is NaN where there is but one member.
    """

    samples: int
    cases: int
    failed: int
    mean: float
    mean_error: float
    deviation: float
    least: float
    most: float
    noise: float
    effective: float
    confidence: float
    quantiles: tuple[Quantile, ...]


def distribution(values: Floats, confidence: float = 0.95, levels: Sequence[float] = LEVELS) -> Distribution:
    """Return mean, scatter and quantiles of a measure, from values of shape [sample] or [sample, member].

    Every point has the same weight, shared by its finished members; failed cases (not finite) are left out and counted.

    >>> found = distribution(np.arange(1.0, 100.0), levels=[0.5])
    >>> found.mean, found.quantiles[0]  # ranks 40 and 60 of 99
    (50.0, Quantile(level=0.5, value=50.0, low=40.0, high=60.0))
    """
    table = as_table(values)
    known = np.isfinite(table)
    failed = int((~known).sum())
    if not known.any():
        none = math.nan
        nothing = tuple(Quantile(level, none, -math.inf, math.inf) for level in levels)
        return Distribution(0, 0, failed, none, none, none, none, none, none, 0.0, confidence, nothing)
    means = member_means(table)
    means = means[np.isfinite(means)]
    count = len(means)
    order = np.argsort(table[known], kind="stable")
    pooled = table[known][order]
    weights = (known / np.maximum(known.sum(axis=1), 1)[:, None])[known][order] / count
    mean, deviation, error = float(np.mean(means)), math.nan, math.nan
    if count > 1:
        from scipy.special import stdtrit

        deviation = math.sqrt(float(np.sum(weights * (pooled - mean) ** 2)) * count / (count - 1.0))
        student = float(stdtrit(count - 1.0, 0.5 + 0.5 * confidence))
        error = student * float(np.std(means, ddof=1)) / math.sqrt(count)
    reached = np.cumsum(weights)
    values_at = [_at(pooled, reached, level) for level in levels]
    effective = _independent(table, [_at(pooled, reached, 0.5), *values_at], confidence)
    return Distribution(
        samples=count,
        cases=int(known.sum()),
        failed=failed,
        mean=mean,
        mean_error=error,
        deviation=deviation,
        least=float(pooled[0]),
        most=float(pooled[-1]),
        noise=noise_share(member_variance(table), deviation**2),
        effective=effective,
        confidence=confidence,
        quantiles=tuple(_quantile(pooled, reached, effective, confidence, level) for level in levels),
    )


def _at(ordered: Floats, reached: Floats, level: float) -> float:
    """Return the least value at which this share of all weight is reached."""
    return float(ordered[min(int(np.searchsorted(reached, level - 1e-9)), ordered.size - 1)])


def _independent(table: Floats, values: Sequence[float], confidence: float) -> float:
    """Return the fewest independent cases that the shares below any of some values scatter like.

    A tail alone holds too few cases for an estimate, so the median should be among the values.
    """
    failed = np.isnan(table)
    hits = (np.where(failed, np.nan, table <= value) for value in values)
    return min(proportion(each, confidence).effective for each in hits)


def _quantile(
    ordered: Floats, reached: Floats, effective: float, confidence: float, level: float
) -> Quantile:
    """Return a quantile with its interval between order statistics (David and Nagaraja, Order Statistics, 2003, section 7.1).

    With members the ranks are those of as many independent cases as the share below a quantile scatters like (Woodruff,
    J. Am. Stat. Assoc. 47 (1952) 635).
    """
    from scipy.stats import binom

    count, tail = max(1, math.floor(effective + 1e-9)), 0.5 * (1.0 - confidence)
    lower, upper = int(binom.ppf(tail, count, level)), int(binom.ppf(1.0 - tail, count, level)) + 1
    return Quantile(
        level,
        _at(ordered, reached, level),
        _at(ordered, reached, lower / count) if lower > 0 else -math.inf,
        _at(ordered, reached, upper / count) if upper <= count else math.inf,
    )
