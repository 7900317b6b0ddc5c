"""Set-points over time: a constant, pieces of second degree, a sine (docs/theory, section 4).

Pieces are rows of `System.record`: begin [s], value, rate, half of the second derivative. The first holds before its begin too,
the last without end. The sine is a row of `System.terms`.
"""

import math

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import System

FIELDS = [
    ("set_point", "i8"),  # first piece in System.record
    ("set_points", "i8"),  # number of pieces, 0 for a constant
    ("wave", "i8"),  # row of its sine in System.terms, -1 for none
    ("steepest", "f8"),  # bound of the magnitude of its rate
]
"""Fields of a record with a set-point."""


@compiled_inline
def piece_at(system: System, first: int, pieces: int, t: float) -> int:
    """Return the row in `System.record` of the piece at t [s] of a curve: the last that begins at t or before, else the first."""
    low, high = first, first + pieces - 1
    while low < high:
        middle = (low + high + 1) // 2
        if system.record[middle, 0] <= t:
            low = middle
        else:
            high = middle - 1
    return low


@compiled_inline
def set_point(
    system: System, constant: float, first: int, pieces: int, wave: int, t: float
) -> tuple[float, float]:
    """Return value and rate at t [s] of a set-point: ``constant``, or its pieces, and its sine."""
    value, rate = constant, 0.0
    if pieces > 0:
        piece = system.record[piece_at(system, first, pieces, t)]
        u = max(t - piece[0], 0.0)
        value, rate = piece[1] + u * (piece[2] + u * piece[3]), piece[2] + 2.0 * u * piece[3]
    if wave >= 0:
        w = system.terms[wave, 0]
        s, c = math.sin(w * t), math.cos(w * t)
        value += system.terms[wave, 1] * s + system.terms[wave, 2] * c
        rate += w * (system.terms[wave, 1] * c - system.terms[wave, 2] * s)
    return value, rate
