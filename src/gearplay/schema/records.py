"""Records in the format of the kernels: equidistant ones as cubic pieces, their extremes, harmonic terms."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cubic_pieces(values: Floats, *, periodic: bool = False) -> Floats:
    """Return the pieces (c0, c1, c2, c3) of c0 + c1 u + c2 u^2 + c3 u^3, u from 0 to 1, of the cubic spline through ``values``.

    Shape [value - 1, 4]. A ``periodic`` record ends with its first value.

    >>> cubic_pieces(np.array([0.0, 1.0, 4.0, 9.0])).round(9)[1].tolist()
    [1.0, 2.0, 1.0, 0.0]
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(values.size), values, bc_type="periodic" if periodic else "not-a-knot")
    return np.ascontiguousarray(spline.c[::-1].T)


def extremes(pieces: Floats, widths: Floats | float = 1.0) -> tuple[float, float]:
    """Return the minimum and maximum of cubic pieces c0 + c1 u + c2 u^2 + c3 u^3, shape [piece, 4], u from 0 to ``widths``.

    A spline may pass beyond its points, so rules and peaks are those of the curve.

    >>> extremes(np.array([[0.0, 1.0, -1.0, 0.0]]))
    (0.0, 0.25)
    """
    c0, c1, c2, c3 = pieces.T
    ends = np.broadcast_to(widths, c0.shape)
    # Roots of the derivative in the form that keeps both where c3 is small: q / (3 c3) and c1 / q.
    q = -(c2 + np.copysign(np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0)), c2))
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.nan_to_num(np.stack([q / (3.0 * c3), c1 / q]))
    u = np.clip(np.concatenate([roots, np.zeros((1, c0.size)), ends[None]]), 0.0, ends)
    values = c0 + u * (c1 + u * (c2 + u * c3))
    return float(np.min(values)), float(np.max(values))


def edges(start: float, end: float) -> set[float]:
    """Return the breakpoints of a record that acts from ``start`` to ``end`` [s], which no step may pass.

    It may begin and end with a jump, so a step ends just before it, and one begins just after it: none sees both sides.

    >>> len(edges(0.0, 1.0)), len(edges(1.0, math.inf))
    (3, 2)
    """
    around = {math.nextafter(start, 0.0), start, end, math.nextafter(end, math.inf)}
    return {t for t in around if math.isfinite(t)}


def harmonic_rows(rows: Iterable[Sequence[float]]) -> list[list[float]]:
    """Return (order, amplitude, phase) rows as (order, a cos(phase), a sin(phase)), orders rising."""
    return [
        [k, a * math.cos(phase), a * math.sin(phase)] for k, a, phase in sorted(rows, key=lambda row: row[0])
    ]
