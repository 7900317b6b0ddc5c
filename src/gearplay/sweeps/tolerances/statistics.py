"""Distribution of a measure over drawn points and members, and the probability that it exceeds a limit, with intervals.

Drawn points are the unit of independence: the members of an ensemble share the parameters of theirs. A probability is the
mean over the points of the share of members; its interval is that of Clopper and Pearson (Biometrika 26 (1934) 404) for as
many independent cases as would scatter like the shares do (Korn and Graubard, Survey Methodology 24 (1998) 193). With one
member it is the exact interval of a binomial; copies of one member change nothing.

Doubts: the interval is made for independent points (``monte-carlo``). Those of a Latin hypercube never scatter more than n - 1
independent ones (Owen, SIAM J. Numer. Anal. 34 (1997) 1884), those of ``sobol`` in practice far less: there the interval is
wider than need be.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.plans.design import Design
from gearplay.sweeps.variance import (
    Indices,
    as_table,
    independent_rows,
    indices_of,
    member_means,
    member_variance,
    noise_share,
)

Floats = NDArray[np.float64]
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
PART = 0.2
"""Share of the points that a cut leaves out."""
FEWEST = 20
"""Points that a cut needs at least."""


@dataclass(frozen=True)
class Proportion:
    """A probability with its interval; NaN, with the interval 0 to 1, where no case finished.

    ``effective`` is the number of independent cases that the interval is made for.
    """

    value: float
    low: float
    high: float
    effective: float


@dataclass(frozen=True)
class Exceedance:
    """Probability that a measure exceeds ``limit``, among finished cases, with its interval.

    ``bounds`` are the interval's ends had every failed case met the limit, and had every one exceeded it.
    """

    limit: float
    probability: float
    low: float
    high: float
    bounds: tuple[float, float]
    confidence: float
    samples: int
    cases: int
    failed: int
    effective: float


def proportion(hits: Floats, confidence: float = 0.95) -> Proportion:
    """Return the probability of a hit with its interval.

    ``hits`` has shape [sample, member] and holds 1 for a hit, 0 for none, NaN for a case that failed. Of n points with m
    members and shares f_i, mean p and variance s^2, the effective number of cases is ``n p (1 - p) / s^2``, between n and
    n m, times ``(t_(n m - 1) / t_(n - 1))^2`` of Student's t for what is not known of s, and never below n.

    >>> found = proportion(np.zeros((10, 1)))
    >>> found.value, found.low, round(found.high, 4)  # 1 - 0.025^(1 / 10)
    (0.0, 0.0, 0.3085)
    """
    shares = member_means(hits)
    shares = shares[np.isfinite(shares)]
    cases = int(np.isfinite(hits).sum())
    if shares.size == 0:
        return Proportion(math.nan, 0.0, 1.0, 0.0)
    value = float(np.mean(shares))
    count = _effective(shares, cases, value, confidence)
    low, high = interval_of(np.array(value), count, confidence)
    return Proportion(value, float(low), float(high), count)


def interval_of(value: Floats, count: float, confidence: float = 0.95) -> tuple[Floats, Floats]:
    """Return the ends of Clopper and Pearson's interval for shares ``value`` of ``count`` cases, which need not be whole.

    >>> [round(float(end), 4) for end in interval_of(np.array(0.1), 10.0)]
    [0.0025, 0.445]
    """
    from scipy.special import betaincinv

    tail, least = 0.5 * (1.0 - confidence), 1e-9
    inside = np.clip(value, 0.0, 1.0) * count
    rest = count - inside
    low = betaincinv(np.maximum(inside, least), rest + 1.0, tail)
    high = betaincinv(inside + 1.0, np.maximum(rest, least), 1.0 - tail)
    return np.where(inside > least, low, 0.0), np.where(rest > least, high, 1.0)


def _effective(shares: Floats, cases: int, value: float, confidence: float) -> float:
    from scipy.special import stdtrit

    tail, count = 0.5 * (1.0 - confidence), float(shares.size)
    if cases == shares.size or count < 2.0 or not 0.0 < value < 1.0:
        return count
    scatter = float(np.var(shares, ddof=1))
    most = value * (1.0 - value) / scatter * count if scatter > 0.0 else math.inf
    ratio = float(stdtrit(cases - 1.0, tail) / stdtrit(count - 1.0, tail))
    return max(count, min(most, float(cases)) * ratio**2)


def exceedance(values: Floats, limit: float, confidence: float = 0.95) -> Exceedance:
    """Return the probability that a measure exceeds ``limit``, from values of shape [sample] or [sample, member].

    Failed cases (not finite) are left out of the estimate and counted; ``bounds`` say what they could change.

    >>> found = exceedance(np.array([1.0, 2.0, 3.0, np.nan]), 2.5)
    >>> round(found.probability, 3), found.cases, found.failed
    (0.333, 3, 1)
    """
    table = as_table(values)
    failed = np.isnan(table)
    hits = np.where(failed, np.nan, table > limit)
    found = proportion(hits, confidence)
    return Exceedance(
        limit=limit,
        probability=found.value,
        low=found.low,
        high=found.high,
        bounds=(
            proportion(np.where(failed, 0.0, hits), confidence).low,
            proportion(np.where(failed, 1.0, hits), confidence).high,
        ),
        confidence=confidence,
        samples=int((~failed).any(axis=1).sum()),
        cases=int((~failed).sum()),
        failed=int(failed.sum()),
        effective=found.effective,
    )


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


@dataclass(frozen=True)
class Cut:
    """Effect of leaving out the lowest or highest fifth of a parameter's draws.

    ``bound`` is the value where the cut is, ``probability`` the exceedance of what is left, with its interval.
    """

    name: str
    end: str
    bound: float
    probability: float
    low: float
    high: float


@dataclass(frozen=True)
class Statistics:
    """Statistics of one measure and its limit."""

    distribution: Distribution
    exceedance: Exceedance
    indices: Indices
    cuts: tuple[Cut, ...]


def statistics_of(
    design: Design, drawn: Floats, values: Floats, limit: float, *, confidence: float = 0.95, seed: int = 0
) -> Statistics:
    """Return the statistics of a design's drawn points, shape [sample, parameter], and the measure there, shape [sample, ...].

    Of a saltelli design only the independent points are used for the distribution; all points are used for the indices.
    """
    rows, table = independent_rows(design), as_table(values)
    names = [p.name for p in design.parameters]
    return Statistics(
        distribution(table[rows], confidence),
        exceedance(table[rows], limit, confidence),
        indices_of(design, table, confidence=confidence, seed=seed),
        cuts_of(names, drawn[rows], table[rows], limit, confidence),
    )


def cuts_of(
    names: Sequence[str], drawn: Floats, values: Floats, limit: float, confidence: float = 0.95
) -> tuple[Cut, ...]:
    """Return the better of both cuts of each parameter, sorted by their gain; empty if no case exceeds the limit.

    The end is chosen by the same sample, so a small gain may be luck: compare the intervals.
    """
    table = as_table(values)
    if len(table) < FEWEST or not np.any(table > limit):
        return ()
    count = round(PART * len(table))
    found = []
    for at, name in enumerate(names):
        order = np.argsort(drawn[:, at], kind="stable")
        for end, left in (("low", order[count:]), ("high", order[:-count])):
            kept = exceedance(table[left], limit, confidence)
            bound = float(drawn[left[0 if end == "low" else -1], at])
            found.append(Cut(name, end, bound, kept.probability, kept.low, kept.high))
    known = [
        cut for cut in found if cut.probability == cut.probability
    ]  # not those whose rest failed throughout
    best: dict[str, Cut] = {}
    for cut in sorted(known, key=lambda cut: cut.probability):
        best.setdefault(cut.name, cut)
    return tuple(best.values())
