"""Outlines of teeth as the rack cuts them, fillets included, and of two gears in mesh."""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear, inv, inverse_involute
from gearplay.toothing.pair import GearPair
from gearplay.toothing.potential_energy import fillet

Floats = NDArray[np.float64]
POINTS: Final = 24
"""Points of a fillet and of a flank."""
SEARCHED: Final = 200
"""Angles of the rack's normal at which the end of a fillet is searched."""


def half_tooth(gear: DrawnGear, points: int = POINTS) -> tuple[Floats, Floats]:
    """Return radii [m] and half angles [rad] from the root circle to the tip: of a tooth; from tip to root of a ring's space.

    ``points`` of the fillet and of the flank. Undercut teeth change from the fillet to the involute where both cross; pointed
    ones end in their points. A ring has no fillet, and its flanks are radial within the base circle.
    """
    pointed = math.inf
    if gear.half_angle_at(gear.root if gear.internal else gear.tip) < 0.0:
        pointed = gear.base_radius / math.cos(inverse_involute(gear.half_angle))
    if gear.internal:
        high = min(gear.root, pointed)
        radii = np.linspace(max(gear.tip, gear.base_radius), high, points)
        if gear.tip < gear.base_radius:
            radii = np.concatenate([[gear.tip], radii])
        return radii, _half_angles(gear, radii)
    high = min(gear.tip, pointed)
    ends = _fillet_end(gear, high)
    x, y = fillet(gear, np.linspace(0.5 * math.pi, ends, points))
    begins = math.hypot(float(x[-1]), float(y[-1]))
    radii = np.linspace(begins, high, points)[1:] if begins < high else np.empty(0)
    half = np.concatenate([np.arctan2(x, y), _half_angles(gear, radii)])
    return np.concatenate([np.hypot(x, y), radii]), np.minimum(half, math.pi / gear.teeth)


def _half_angles(gear: DrawnGear, radii: Floats) -> Floats:
    return np.array([max(gear.half_angle_at(float(radius)), 0.0) for radius in radii])


def _fillet_end(gear: DrawnGear, high: float) -> float:
    """Return the angle of the rack's normal [rad] at which the fillet meets the involute, or the radius ``high`` [m] before."""

    def within(gamma: float) -> bool:
        x, y = fillet(gear, np.array([gamma]))
        radius = float(np.hypot(x, y)[0])
        cut = gear.undercut <= 0.0 or float(np.arctan2(x, y)[0]) < gear.half_angle_at(radius)
        return radius < high and cut

    alpha = gear.pressure_angle
    x, y = fillet(gear, np.array([alpha]))
    if gear.undercut <= 0.0 and float(np.hypot(x, y)[0]) <= high:
        return alpha
    start = alpha + (0.5 * math.pi - alpha) * np.linspace(0.0, 1.0, SEARCHED) ** 2
    inside = next((k for k, gamma in enumerate(start) if within(float(gamma))), 0)
    if inside == 0:  # undercut by less than rounding
        return alpha
    low, top = float(start[inside - 1]), float(start[inside])
    for _ in range(60):
        middle = 0.5 * (low + top)
        low, top = (low, middle) if within(middle) else (middle, top)
    return top


def teeth_at(gear: DrawnGear, middle: float, numbers: Iterable[int], points: int = POINTS) -> Floats:
    """Return the outline of teeth, of a ring of spaces, counter-clockwise, shape [point, 2] [m].

    Number 0 lies at ``middle`` [rad], ``numbers`` are consecutive; ``points`` as of `half_tooth`.
    """
    radii, half = half_tooth(gear, points)
    angles, places = [], []
    for k in numbers:
        at = middle + 2.0 * math.pi * k / gear.teeth
        angles += [at - half, at + half[::-1]]
        places += [radii, radii[::-1]]
    angle, radius = np.concatenate(angles), np.concatenate(places)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def closed_teeth(pair: GearPair, count: int) -> tuple[Floats, Floats]:
    """Return outlines of ``2 count + 1`` teeth of both gears, drive flanks in touch at the pitch point, shapes [point, 2].

    The first gear's centre is the origin, the second's at +x, of an internal pair at -x.
    """
    first, second, angle = pair.first, pair.second, pair.working_angle
    flank_1 = pair.pitch_place / first.base_radius - angle
    sign = second.sign
    flank_2 = (pair.least_distance * inv(angle) - sign * first.base_radius * flank_1) / second.base_radius
    numbers = range(-count, count + 1)
    one = teeth_at(first, flank_1 - first.half_angle, numbers)
    middle = flank_2 - second.half_angle
    if pair.internal:
        other = teeth_at(second, middle, numbers)
        return one, other - np.array([pair.distance, 0.0])
    other = teeth_at(second, math.pi + middle, numbers)
    return one, other + np.array([pair.distance, 0.0])
