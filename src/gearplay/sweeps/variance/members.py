"""Means over members of drawn points, scatter about them, and its share of the total variance."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def as_table(values: Floats) -> Floats:
    """Return values as a table, shape [sample, member]; whatever is not finite counts as failed and becomes NaN.

    >>> as_table(np.array([1.0, np.inf])).tolist()
    [[1.0], [nan]]
    """
    table = np.array(values, dtype=np.float64)
    if table.ndim not in (1, 2):
        raise ValueError(f"values must have shape [sample] or [sample, member], not {table.shape}")
    table = table.reshape(len(table), -1)
    table[~np.isfinite(table)] = np.nan
    return table


def member_means(table: Floats) -> Floats:
    """Return the mean of each point's finished members, shape [sample]; NaN where none finished."""
    known = np.isfinite(table)
    count = known.sum(axis=1)
    total = np.where(known, table, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def member_variance(table: Floats) -> float:
    """Return the variance of single cases about their point's mean; NaN where no point has two finished members."""
    known = np.isfinite(table)
    kept = known.sum(axis=1) > 1
    samples = int(kept.sum())
    if samples == 0:
        return math.nan
    part = table[kept]
    rest = part - member_means(part)[:, None]
    spare = float((known[kept].sum(axis=1) - 1).sum())
    return float(np.nansum(rest**2)) / spare


def noise_share(own: float, whole: float) -> float:
    """Return a variance among members over the whole, at most 1; NaN where either is unknown or nothing varies.

    >>> noise_share(1.0, 4.0), noise_share(float("nan"), 4.0)
    (0.25, nan)
    """
    return min(own / whole, 1.0) if whole > 0.0 else math.nan
