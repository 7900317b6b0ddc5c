"""Involute geometry of a pair at a changed centre distance."""

import math
from functools import lru_cache

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline

SERIES_TERMS = 14  # an even number


@compiled_inline
def involute(alpha: float) -> float:
    """Return inv(alpha) = tan(alpha) - alpha [rad], alpha [rad].

    >>> round(involute(math.radians(20.0)), 9)
    0.014904384
    """
    return math.tan(alpha) - alpha


@compiled_inline
def involute_from_distance(A: float, c0: float) -> float:
    """Return inv(alpha_w) [rad] at centre distance A [m], cos(alpha_w) = c0 / A, eq. (5); NaN for A < c0.

    The square-root form needs neither arccos nor tan and keeps full precision near the nominal angle.

    >>> c0 = 0.08 * math.cos(math.radians(20.0))
    >>> round(involute_from_distance(0.08, c0), 9)
    0.014904384
    """
    tangent = math.sqrt(A * A - c0 * c0) / c0
    return tangent - math.atan(tangent)


@compiled_inline
def involute_difference(
    A: float, c0: float, inv_alpha0: float, u: float, u_series: float, coefficients: Floats, row: int
) -> float:
    """Return inv(alpha_w) - inv(alpha0) [rad] at centre distance A [m], by a power series near the nominal distance.

    u = (A / A0)^2 - 1 with A0 the nominal distance; within |u| < ``u_series`` row ``row`` of ``coefficients``
    (`involute_series`) replaces the arctangent. Without the difference of two involutes nothing cancels.
    """
    if abs(u) < u_series:
        # Nearer by 8, eight terms leave the same rest.
        terms = 8 if 8.0 * abs(u) < u_series else SERIES_TERMS
        even, odd, square = 0.0, 0.0, u * u  # powers of their own each, so that neither waits for the other
        for k in range(terms - 2, -1, -2):
            even, odd = even * square + coefficients[row, k], odd * square + coefficients[row, k + 1]
        return (even + odd * u) * u
    return involute_from_distance(A, c0) - inv_alpha0


@lru_cache(maxsize=64)
def involute_series(alpha0: float, terms: int = SERIES_TERMS) -> tuple[Floats, float]:
    """Return the coefficients of (inv(alpha_w) - inv(alpha0)) / u in powers of u, and the largest |u| they serve.

    From d inv / du = sqrt(sin^2 alpha0 + u) / (2 cos alpha0 (1 + u)): the binomial series of the root times the
    geometric series, integrated term by term. Within a tenth of its radius of convergence, sin^2 alpha0, the rest is
    below 1e-14 of the value.

    >>> a, _ = involute_series(math.radians(20.0))
    >>> round(float(a[0]), 9) == round(math.tan(math.radians(20.0)) / 2.0, 9)
    True
    """
    q = math.sin(alpha0) ** 2
    root = np.empty(terms)  # sqrt(q + u) in powers of u
    root[0] = math.sqrt(q)
    for k in range(1, terms):
        root[k] = root[k - 1] * (1.5 - k) / (k * q)
    slope = np.empty(terms)  # times 1 / (1 + u)
    for k in range(terms):
        slope[k] = root[k] - (slope[k - 1] if k else 0.0)
    series = slope / (2.0 * math.cos(alpha0) * np.arange(1, terms + 1))
    series.flags.writeable = False  # it is kept
    return series, 0.1 * q
