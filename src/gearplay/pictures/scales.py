"""Axis scales: edges of cells, logarithmic or linear, evenly spaced ticks."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DECADES = 5.0  # shown below the highest value; rounding would else fill the picture
FEW = 6  # values of an axis that are named one by one
WIDE = 1.5  # decades from which on a scale is logarithmic


def is_logarithmic(values: Floats) -> bool:
    """Return whether an axis's values, in order, are spaced more evenly in logarithms.

    >>> is_logarithmic(np.geomspace(1e-5, 1e-3, 7)), is_logarithmic(np.array([1.0, 2.0, 5.0, 10.0, 20.0, 50.0]))
    (True, True)
    >>> is_logarithmic(np.linspace(1e-5, 1e-3, 7)), is_logarithmic(np.array([1.0, 100.0]))
    (False, False)
    """
    if len(values) < 3 or not 0.0 < values[0] < values[-1]:
        return False
    steps, ratios = np.diff(values), np.diff(np.log(values))
    return bool(np.std(ratios) / np.mean(ratios) < 0.5 * np.std(steps) / np.mean(steps))


def edges_of(values: Floats, *, log: bool) -> Floats:
    """Return the edges of the cells around values in order, shape [value + 1]; none below 0 where no value is.

    >>> edges_of(np.array([1.0, 2.0, 4.0]), log=False).tolist(), edges_of(np.array([1.0, 100.0]), log=True).tolist()
    ([0.5, 1.5, 3.0, 5.0], [0.1, 10.0, 1000.0])
    """
    at = np.log10(values) if log else values
    middle = 0.5 * (at[1:] + at[:-1])
    found = np.concatenate([[at[0] - (middle[0] - at[0])], middle, [at[-1] + (at[-1] - middle[-1])]])
    if log:
        return np.asarray(10.0**found)
    return np.maximum(found, 0.0) if at[0] >= 0.0 else found


def stand_apart(values: Floats, *, log: bool) -> bool:
    """Return whether at most `FEW` values in order are so far apart that each can have its tick on an axis.

    >>> stand_apart(np.array([5.0, 20.0]), log=False), stand_apart(np.array([1.0, 2.0, 100.0]), log=False)
    (True, False)
    """
    at = np.log10(values) if log else values
    return 2 <= len(at) <= FEW and bool(np.diff(at).min() > 0.1 * (at[-1] - at[0]))


def spread_places(count: int, most: int) -> list[int]:
    """Return at most ``most`` of ``count`` positions, spread evenly, both ends included.

    >>> spread_places(15, 4), spread_places(2, 4)
    ([0, 5, 9, 14], [0, 1])
    """
    return sorted({round(x) for x in np.linspace(0, count - 1, min(count, most))})


def logarithmic_range(values: Floats) -> tuple[float, float] | None:
    """Return the ends of a logarithmic scale for values that span more than `WIDE` decades, None where it should be linear.

    Few values may be 0, and what is more than `DECADES` below the highest is at the lower end.

    >>> logarithmic_range(np.array([0.01, 1.0, np.nan])), logarithmic_range(np.array([-1.0, 100.0]))
    ((0.01, 1.0), None)
    """
    known = values[np.isfinite(values)]
    above = known[known > 0.0]
    if not above.size or (known < 0.0).any() or above.size < 0.9 * known.size:
        return None
    low, high = float(above.min()), float(above.max())
    if math.log10(high / low) <= WIDE:
        return None
    return max(low, high * 10.0**-DECADES), high
