"""Probability that a measure exceeds a limit, with its confidence interval.

Drawn points are the unit of independence: the members of an ensemble share the parameters of theirs. A probability is the
mean over the points of the share of members; its interval is that of Clopper and Pearson (Biometrika 26 (1934) 404) for as
many independent cases as would scatter like the shares do (Korn and Graubard, Survey Methodology 24 (1998) 193). With one
member it is the exact interval of a binomial; copies of one member change nothing.

Doubts: the interval is made for independent points (``monte-carlo``). Those of a Latin hypercube never scatter more than n - 1
independent ones (Owen, SIAM J. Numer. Anal. 34 (1997) 1884), those of ``sobol`` in practice far less: there the interval is
wider than need be.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.variance.members import as_table, member_means

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Proportion:
    """A probability with its interval; not a number, and 0 to 1, where no case finished.

    ``effective`` is the number of independent cases that the interval is made for.
    """

    value: float
    low: float
    high: float
    effective: float


@dataclass(frozen=True)
class Exceedance:
    """How often a measure exceeds ``limit``: the probability among finished cases, with its interval.

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
