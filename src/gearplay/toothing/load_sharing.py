"""Load sharing at rest: gaps of tips outside the path of contact, deflection under a force, its division among pairs of teeth.

Where a tip lies outside the other flank's path of contact, its corner is the point that would touch. Involutes of one base circle
are parallel curves: the gap of a point (R, gamma) from an involute is r_b times the angle between the point and the flank at R.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import inv
from gearplay.toothing.pair import GearPair
from gearplay.toothing.path_stiffness import PathStiffness

Floats = NDArray[np.float64]


def _inv_at(base: float, radii: Floats) -> Floats:
    """Return inv(alpha) [rad] of an involute at radii [m], NaN within its base circle."""
    with np.errstate(invalid="ignore"):
        tangent = np.sqrt((radii / base) ** 2 - 1.0)
    return tangent - np.arctan(tangent)


def tip_gaps(pair: GearPair, places: Floats) -> Floats:
    """Return the gap [m] of a pair of teeth at places [m] along the line of action while the other pairs touch without load.

    0 on the path of contact, beyond it that of the corner of a tip from the other flank; NaN beyond the base tangent points and
    where the corner is within the other gear's base circle.
    """
    first, second, sign = pair.first, pair.second, pair.second.sign
    angle, distance = pair.working_angle, pair.distance
    flank_1 = places / first.base_radius - angle
    flank_2 = (pair.least_distance * inv(angle) - sign * first.base_radius * flank_1) / second.base_radius
    gaps = np.zeros(np.shape(places))
    for gear, other, own, facing, outside, turned in (
        (second, first, flank_2, flank_1, places < pair.path.tip_of_second, 1.0),
        (first, second, flank_1, flank_2, places > pair.path.tip_of_first, sign),
    ):
        at_tip = own - inv(math.acos(min(1.0, gear.base_radius / gear.tip)))
        x, y = gear.tip * np.cos(at_tip), gear.tip * np.sin(at_tip)  # about its own centre
        if pair.internal:
            x = x - distance if gear.internal else x + distance  # about the other centre
        else:
            x, y = distance - x, -y
        angles, radii = np.arctan2(y, x), np.hypot(x, y)
        found = other.base_radius * turned * (angles - facing + _inv_at(other.base_radius, radii))
        gaps = np.where(outside, found, gaps)
    return np.where((places < 0.0) | (places > pair.path.tangent_of_second), np.nan, gaps)


def static_sharing(
    stiffness: PathStiffness, force: float, phases: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return deflection [m], force of each pair [N] and numbers of the pairs under a transverse force along the line of action.

    Rigid bodies and perfect teeth: the pairs share one deflection, F = sum k_j max(0, deflection - gap_j). Corners beyond the
    path carry too, with the stiffness of its end; of helical gears they are left out.

    Parameters
    ----------
    stiffness
        Of the pair.
    force
        [N].
    phases
        In base pitches from where pair 0 passes the pitch point, shape [phase].

    Returns
    -------
    deflection, forces, numbers
        Shapes [phase], [phase, pair], [pair].

    """
    pair = stiffness.pair
    pitch, (low, high) = pair.first.base_pitch, stiffness.reach
    numbers = np.arange(
        math.floor((low - pair.pitch_place) / pitch) - 1, math.ceil((high - pair.pitch_place) / pitch) + 1
    )
    places = pair.pitch_place + (np.asarray(phases)[:, None] + numbers) * pitch
    if pair.overlap > 0.0:
        k, gaps = stiffness.single(places), np.where((places >= low) & (places <= high), 0.0, np.inf)
    else:
        k, gaps = stiffness.held(places), tip_gaps(pair, places)
    gaps = np.where(np.isnan(gaps), np.inf, gaps)
    order = np.argsort(gaps, axis=1)
    sorted_gaps, sorted_k = np.take_along_axis(gaps, order, 1), np.take_along_axis(k, order, 1)
    finite = np.where(np.isfinite(sorted_gaps), sorted_gaps, 0.0)
    touching = np.where(np.isfinite(sorted_gaps), sorted_k, 0.0)
    # With the n nearest pairs in touch: deflection = (F + sum k g) / sum k; the least over n is the right one.
    sums = np.cumsum(touching, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        candidates = np.where(sums > 0.0, (force + np.cumsum(touching * finite, axis=1)) / sums, np.inf)
    deflection = np.min(candidates, axis=1)
    forces = k * np.maximum(0.0, deflection[:, None] - gaps)
    return deflection, np.where(np.isfinite(gaps), forces, 0.0), numbers
