"""Deviations of one flank over its path of contact: tip relief, pitch and profile deviations, faults (docs/teeth)."""

import math

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import System

FAULT_EDGE = 0.02
"""Part of the path over which a spall, or a chip, begins and ends."""


@compiled_inline
def relief(
    amount: float, length: float, power: float, tip: float, toward: float, place: float
) -> tuple[float, float, float]:
    """Return tip relief [m] at a place [m] of a flank's path, its slope and curvature; ``toward`` 1 for a higher tip."""
    if amount == 0.0:
        return 0.0, 0.0, 0.0
    into = toward * (place - tip) / length + 1.0
    if into <= 0.0:
        return 0.0, 0.0, 0.0
    if into >= 1.0:
        return amount, 0.0, 0.0
    return rising_relief(amount, length, power, toward, into)


@compiled_inline
def rising_relief(
    amount: float, length: float, power: float, toward: float, into: float
) -> tuple[float, float, float]:
    """Return tip relief [m] at a share of its length from its start, continued beyond the tip, its slope and curvature."""
    if power == 1.0:
        return amount * into, toward * amount / length, 0.0
    return amount * into * into, toward * 2.0 * amount * into / length, 2.0 * amount / (length * length)


@compiled_inline
def rise(u: float) -> tuple[float, float, float]:
    """Return u^2 (3 - 2u) from 0 to 1 and its first two derivatives, constant beyond."""
    if u <= 0.0 or u >= 1.0:
        return (0.0 if u <= 0.0 else 1.0), 0.0, 0.0
    return u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u


@compiled_inline
def height_at(low: float, high: float, place: float) -> tuple[float, float]:
    """Return a place [m] on a flank's path from 0 at its root end to 1 at the tip, held beyond, and its slope [1/m]."""
    x = (place - low) / (high - low)
    if x <= 0.0 or x >= 1.0:
        return min(max(x, 0.0), 1.0), 0.0
    return x, 1.0 / (high - low)


@compiled_inline
def cubic_at(system: System, first: int, last: int, place: float) -> tuple[float, float, float]:
    """Return a piecewise cubic at a place, its slope and curvature; held beyond its ends.

    Rows ``first`` to ``last`` of `System.spline` are (start, c0, c1, c2, c3), the last only its end.
    """
    row = first
    while row < last - 1 and system.spline[row + 1, 0] <= place:
        row += 1
    x = place - system.spline[row, 0]
    longest = system.spline[row + 1, 0] - system.spline[row, 0]
    held = x < 0.0 or x > longest
    x = min(max(x, 0.0), longest)
    c = system.spline[row]
    slope = 0.0 if held else c[2] + x * (2.0 * c[3] + 3.0 * x * c[4])
    bend = 0.0 if held else 2.0 * c[3] + 6.0 * x * c[4]
    return c[1] + x * (c[2] + x * (c[3] + x * c[4])), slope, bend


@compiled_inline
def tooth_deviation(
    system: System, at: int, rows: int, low: float, high: float, place: float
) -> tuple[float, float, float]:
    """Return material missing on a flank [m] at a place [m] of its path, its slope and curvature; ``at`` of `flank_rows`.

    dev = pitch + slope (x - 1/2) + form sin(pi x) + bow (2 x - 1)^2 + spall + worn profile, x of `height_at`.
    """
    if at < 0:
        return 0.0, 0.0, 0.0
    row = system.terms[at]
    x, by = height_at(low, high, place)
    angle = math.pi * x
    form = row[2] * math.sin(angle)
    deviation = row[0] + row[1] * (x - 0.5) + form
    slope = by * (row[1] + math.pi * row[2] * math.cos(angle))
    bend = -math.pi * math.pi * by * by * form
    if rows > 1:
        bow, away = system.terms[at + 1, 0], 2.0 * x - 1.0
        deviation += bow * away * away
        slope += by * 4.0 * bow * away
        bend += by * by * 8.0 * bow
        depth = system.terms[at + 2, 0]
        if depth != 0.0:
            up, up_1, up_2 = rise((x - system.terms[at + 1, 1]) / FAULT_EDGE + 0.5)
            down, down_1, down_2 = rise((system.terms[at + 1, 2] - x) / FAULT_EDGE + 0.5)
            by_edge = by / FAULT_EDGE
            deviation += depth * up * down
            slope += depth * by_edge * (up_1 * down - up * down_1)
            bend += depth * by_edge * by_edge * (up_2 * down - 2.0 * up_1 * down_1 + up * down_2)
    if rows > 4 and system.terms[at + 4, 1] > 0.0:
        first = int(system.terms[at + 4, 0])
        worn, by_x, by_xx = cubic_at(system, first, first + int(system.terms[at + 4, 1]), x)
        deviation += worn
        slope += by * by_x
        bend += by * by * by_xx
    return deviation, slope, bend


@compiled_inline
def tooth_kept(
    system: System, at: int, rows: int, low: float, high: float, place: float
) -> tuple[float, float]:
    """Return the share of the stiffness that faults of a flank's tooth leave at a place [m] of its path, and its slope [1/m]."""
    if at < 0 or rows == 1:
        return 1.0, 0.0
    x, by = height_at(low, high, place)
    start, middle, end = system.terms[at + 3, 0], system.terms[at + 3, 1], system.terms[at + 3, 2]
    rising, bend = 4.0 * middle - 3.0 * start - end, 2.0 * (start + end) - 4.0 * middle
    whole, by_whole = 1.0 - start - x * (rising + bend * x), -by * (rising + 2.0 * bend * x)
    lost, by_lost, _ = rise((x - system.terms[at + 2, 1]) / FAULT_EDGE + 0.5)
    share = system.terms[at + 2, 2]
    left = 1.0 - share * lost
    return whole * left, by_whole * left - whole * share * by_lost * by / FAULT_EDGE


@compiled_inline
def least_deviation(system: System, at: int, low: float, high: float, place: float) -> float:
    """Return a bound of `tooth_deviation` [m] from below: pitch, slope and the least of form; all else takes material away."""
    if at < 0:
        return 0.0
    row = system.terms[at]
    return row[0] + row[1] * (height_at(low, high, place)[0] - 0.5) + min(row[2], 0.0)


@compiled_inline
def tilted_least(system: System, at: int) -> float:
    """Return a bound from below of what is missing along an oblique line of contact [m]: pitch, all of the profile slope."""
    return system.terms[at, 0] - abs(system.terms[at, 1]) if at >= 0 else 0.0
