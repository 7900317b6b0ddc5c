"""Thinning of curves and maps that preserves extremes."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def extreme_places(y: Floats, segments: int) -> NDArray[np.int64]:
    """Return the indices of the minimum and maximum of each of at most ``segments`` segments, in order.

    All indices for no more than two values a segment; a segment that holds a NaN has one of them, so that gaps stay.

    >>> extreme_places(np.array([0.0, 5.0, 1.0, 2.0, -3.0, 0.0, 9.0]), 3).tolist()
    [0, 1, 3, 4, 6]
    """
    size = -(-y.size // segments) if y.size else 0
    if size <= 2:
        return np.arange(y.size, dtype=np.int64)
    whole = y.size // size
    table = y[: whole * size].reshape(whole, size)
    places = np.stack([table.argmin(axis=1), table.argmax(axis=1)], axis=1) + size * np.arange(whole)[:, None]
    rest = y[whole * size :]
    ends = (
        whole * size + np.array([rest.argmin(), rest.argmax()]) if rest.size else np.zeros(0, dtype=np.int64)
    )
    return np.unique(np.concatenate([places.ravel(), ends]))


def extremes(x: Floats, y: Floats, segments: int) -> tuple[Floats, Floats]:
    """Return the minimum and maximum of each of at most ``segments`` segments of a curve, in their order.

    A curve of no more than two points per segment is returned unchanged.

    >>> extremes(np.arange(7.0), np.array([0.0, 5.0, 1.0, 2.0, -3.0, 0.0, 9.0]), 3)
    (array([0., 1., 3., 4., 6.]), array([ 0.,  5.,  2., -3.,  9.]))
    """
    at = extreme_places(y, segments)
    return x[at], y[at]


def thinned_path(x: Floats, y: Floats, most: int) -> tuple[Floats, Floats]:
    """Return at most about ``most`` points of a path in a plane, its extremes along both axes among them.

    >>> x, y = np.zeros(100), np.zeros(100)
    >>> x[40], y[70] = 9.0, -7.0
    >>> thin = thinned_path(x, y, 8)
    >>> float(max(thin[0])), float(min(thin[1])), len(thin[0]) < 10
    (9.0, -7.0, True)
    """
    if x.size <= most:
        return x, y
    at = np.union1d(extreme_places(x, most // 4), extreme_places(y, most // 4))
    return x[at], y[at]


def largest_of_cells(
    table: Floats, y: Floats, x: Floats, most: tuple[int, int], *, log: tuple[bool, bool] = (False, False)
) -> tuple[Floats, Floats, Floats]:
    """Return a map in cells no smaller than a pixel: the largest value of the cells within each.

    ``y`` and ``x`` are the rising edges of the cells, shape [row + 1] and [column + 1]; ``most`` is how many rows and columns
    there are at most, even on the axis as drawn, which is logarithmic where ``log`` says so. Returns the map and its edges.

    >>> cells = largest_of_cells(np.array([[0.0, 5.0, 1.0, np.nan]]), np.arange(2.0), np.arange(5.0), (1, 2))
    >>> [each.tolist() for each in cells]
    [[[5.0, 1.0]], [0.0, 1.0], [0.0, 2.0, 4.0]]
    """
    edges = []
    for axis, (ends, count, scaled) in enumerate(zip((y, x), most, log, strict=True)):
        starts = _starts(np.log(ends) if scaled else ends, count)
        table = np.fmax.reduceat(table, starts, axis=axis)
        edges.append(np.append(ends[starts], ends[-1]))
    return table, edges[0], edges[1]


def _starts(ends: Floats, count: int) -> NDArray[np.int64]:
    """Return the first cell of each of at most ``count`` strips of equal width, by the middles of the cells."""
    if ends.size - 1 <= count:
        return np.arange(ends.size - 1)
    middle = 0.5 * (ends[1:] + ends[:-1])
    strip = np.floor(count * (middle - ends[0]) / (ends[-1] - ends[0]))
    return np.flatnonzero(np.diff(strip, prepend=-1.0))
