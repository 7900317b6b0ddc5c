"""Outlines of teeth as the rack cuts them, fillets included, and of two gears in mesh."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear, inv
from gearplay.toothing.pair import GearPair
from gearplay.toothing.potential_energy import fillet

Floats = NDArray[np.float64]
POINTS: Final = 24
"""Points of a fillet and of a flank."""


def half_tooth(gear: DrawnGear) -> tuple[Floats, Floats]:
    """Return radii [m] and half angles [rad] from the root circle to the tip: of a tooth, of a ring of its space.

    Of undercut teeth the fillet where it cuts away the involute; a ring has no fillet.
    """
    tip = gear.tip if not gear.internal else max(gear.tip, gear.base_radius)
    low, high = (tip, gear.root) if gear.internal else (gear.base_radius, tip)
    radii = np.linspace(low, high, POINTS)
    half = np.array([max(gear.half_angle_at(float(radius)), 0.0) for radius in radii])
    if gear.internal:
        return radii, half
    x, y = fillet(gear, np.linspace(0.5 * math.pi, gear.pressure_angle, POINTS))
    r_fillet, half_fillet = np.hypot(x, y), np.arctan2(x, y)
    begins = r_fillet[-1]
    kept = radii > begins
    radii, half = radii[kept], half[kept]
    if gear.undercut > 0.0:
        half = np.minimum(half, np.interp(radii, r_fillet, half_fillet, right=np.inf))
    return np.concatenate([r_fillet, radii]), np.concatenate([half_fillet, half])


def teeth_at(gear: DrawnGear, middle: float, count: int) -> Floats:
    """Return the outline of ``2 count + 1`` teeth or spaces of a ring, one at ``middle`` [rad], shape [point, 2]."""
    radii, half = half_tooth(gear)
    angles, places = [], []
    for k in range(-count, count + 1):
        at = middle + 2.0 * math.pi * k / gear.teeth
        angles += [at - half, at + half[::-1]]
        places += [radii, radii[::-1]]
    angle, radius = np.concatenate(angles), np.concatenate(places)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def closed_teeth(pair: GearPair, count: int) -> tuple[Floats, Floats]:
    """Return outlines of both gears' teeth about the mesh, drive flanks in touch at the pitch point, shapes [point, 2].

    The first gear's centre is the origin, the second's at +x, of an internal pair at -x.
    """
    first, second, angle = pair.first, pair.second, pair.working_angle
    flank_1 = pair.pitch_place / first.base_radius - angle
    sign = second.sign
    flank_2 = (pair.least_distance * inv(angle) - sign * first.base_radius * flank_1) / second.base_radius
    one = teeth_at(first, flank_1 - first.half_angle, count)
    middle = flank_2 - second.half_angle
    if pair.internal:
        other = teeth_at(second, middle, count)
        return one, other - np.array([pair.distance, 0.0])
    other = teeth_at(second, math.pi + middle, count)
    return one, other + np.array([pair.distance, 0.0])
