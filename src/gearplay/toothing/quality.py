"""Flank tolerances of ISO 1328-1:2013 and deviations drawn within the class of a gear.

Pitch deviations are positions of flanks along the reference circle, positive counter-clockwise, of zero mean. Tooth i is at the
angle 2 pi i / z, counter-clockwise. The left flank of a tooth is that on the left of an observer who sees its tip up: the
counter-clockwise one of an external tooth, the clockwise one of a ring's tooth. Profile deviations count along the normal of the
flank, positive where material is missing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear

Floats = NDArray[np.float64]

FEWEST_TEETH: Final = 5
"""Least number of teeth of the standard."""
LEAST: Final = 0.5
"""Least drawn pitch deviation over its tolerance."""
TRIES: Final = 40
"""Draws of phase and white part before the deviations themselves are drawn anew."""


@dataclass(frozen=True)
class Tolerances:
    """Flank tolerances of a gear [m]: f_p, F_p, f_H_alpha, f_f_alpha, F_alpha, F_r.

    >>> found = tolerances(diameter=0.06, module=3e-3, quality=7)
    >>> round(1e6 * found.single_pitch, 6), round(1e6 * found.cumulative_pitch, 5)
    (12.52, 36.96056)
    """

    single_pitch: float
    cumulative_pitch: float
    profile_slope: float
    profile_form: float
    profile: float
    runout: float


@dataclass(frozen=True)
class FlankDeviations:
    """Deviations of the left or right flanks of a gear.

    Parameters
    ----------
    pitch
        Cumulative pitch deviation of each tooth [m], shape (teeth,).
    slope
        Profile slope deviation [m]: material missing at the tip end of the profile less that at its root end.
    form
        Amplitude [m] of a half wave over the profile.

    """

    pitch: Floats
    slope: float
    form: float

    def profile(self, place: Floats) -> Floats:
        """Return the missing material [m] at places along the profile, 0 at its root end, 1 at its tip end."""
        return self.slope * (place - 0.5) + self.form * np.sin(math.pi * place)


@dataclass(frozen=True)
class GearDeviations:
    """Deviations of both flanks of all teeth of a gear."""

    left: FlankDeviations
    right: FlankDeviations


def tolerances(*, diameter: float, module: float, quality: int) -> Tolerances:
    """Return the flank tolerances of a class (ISO 1328-1:2013, formulas 5 to 9; runout by its annex), not rounded.

    Parameters
    ----------
    diameter, module
        Reference diameter and normal module [m].
    quality
        Class, 1 to 11; neighbouring classes differ by sqrt(2).

    """
    d, m, scale = 1e3 * diameter, 1e3 * module, 1e-6 * math.sqrt(2.0) ** (quality - 5)
    cumulative = (0.002 * d + 0.55 * math.sqrt(d) + 0.7 * m + 12.0) * scale
    slope = (0.4 * m + 0.001 * d + 4.0) * scale
    form = (0.55 * m + 5.0) * scale
    return Tolerances(
        single_pitch=(0.001 * d + 0.4 * m + 5.0) * scale,
        cumulative_pitch=cumulative,
        profile_slope=slope,
        profile_form=form,
        profile=math.hypot(slope, form),
        runout=0.9 * cumulative,
    )


def gear_tolerances(gear: DrawnGear, quality: int) -> Tolerances:
    """Return the flank tolerances of a drawn gear."""
    return tolerances(diameter=2.0 * gear.reference_radius, module=gear.module, quality=quality)


def cumulative_deviation(pitch: Floats) -> float:
    """Return the total cumulative pitch deviation [m], largest less smallest position of a flank."""
    return float(np.ptp(pitch))


def single_deviation(pitch: Floats) -> float:
    """Return the largest single-pitch deviation [m], over all neighbours."""
    return float(np.abs(_single(pitch)).max())


def runout(gear: DrawnGear, left: Floats, right: Floats) -> float:
    """Return the runout [m] by pitch deviations: range of the radial positions of a ball between the flanks of each space.

    The flanks of a space stand pi / (2 z) aside from its middle, so that their normals are inclined to the tangent there by
    alpha_t + pi / (2 z), in a ring by alpha_t - pi / (2 z), or by alpha_t / 2 if that is more: a ball would fall into so wide a
    space.
    """
    side, angle = _side(gear), gear.transverse_angle
    inclined = max(angle + side * 0.5 * math.pi / gear.teeth, 0.5 * angle)
    narrower = (left - np.roll(right, -side)) * math.cos(angle)
    return float(np.ptp(narrower)) / (2.0 * math.sin(inclined))


def draw_deviations(gear: DrawnGear, quality: int, rng: np.random.Generator) -> GearDeviations:
    """Return deviations drawn for a gear of a class.

    Of each flank, total cumulative and single-pitch deviation are uniform between half and all of their tolerances. The
    positions are a sin(x + phase) + b w: an eccentricity of the gear, with x the angle of each flank, and a white error w of
    each space, the same of both its flanks. The amplitudes a and b are such that both drawn deviations come out exactly. The
    slope of the profile is uniform within its tolerance, its form a half wave of half its tolerance.

    A gear is drawn anew until its runout is within its class. Few teeth cannot have a small single-pitch with a large cumulative
    deviation; of these the ranges are shortened to those that both parts can meet.

    Parameters
    ----------
    gear
        The gear, of 5 teeth at least.
    quality
        Class, 1 to 11.
    rng
        Source of random numbers.

    Raises
    ------
    ValueError
        For a gear of fewer than 5 teeth, the least of the standard.

    """
    if gear.teeth < FEWEST_TEETH:
        raise ValueError(f"ISO 1328-1 begins at {FEWEST_TEETH} teeth, not {gear.teeth}.")
    allowed = gear_tolerances(gear, quality)
    left, right = _draw_pitches(gear, allowed, rng)
    slopes = allowed.profile_slope * rng.uniform(-1.0, 1.0, 2)
    form = 0.5 * allowed.profile_form
    return GearDeviations(
        FlankDeviations(left, float(slopes[0]), form), FlankDeviations(right, float(slopes[1]), form)
    )


def _draw_pitches(gear: DrawnGear, allowed: Tolerances, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return cumulative pitch deviations of left and right flanks [m]."""
    side, teeth = _side(gear), gear.teeth
    centres = 2.0 * math.pi * np.arange(teeth) / teeth
    from_centre = side * 0.5 * math.pi / teeth - gear.transverse_angle
    while True:
        shares = rng.uniform(0.0, 1.0, (2, 2))
        for _ in range(TRIES):
            turned = centres + rng.uniform(0.0, 2.0 * math.pi)
            white = rng.standard_normal(teeth)
            white -= white.mean()
            left = _mixed(np.sin(turned + from_centre), white, shares[0], allowed)
            right = _mixed(np.sin(turned - from_centre), np.roll(white, side), shares[1], allowed)
            if left is not None and right is not None and runout(gear, left, right) <= allowed.runout:
                return left, right


def _mixed(wave: Floats, white: Floats, shares: Floats, allowed: Tolerances) -> Floats | None:
    """Return a wave + b white whose two deviations are at shares of their ranges; None where these are empty.

    The ratio of single-pitch to cumulative deviation is continuous in the angle atan2(b, a) from 0 to pi/2. Both deviations are
    piecewise linear in a and b: Newton's method with the teeth at which they are reached, bisection where it leaves the bracket.
    """
    lowest, highest = (single_deviation(part) / cumulative_deviation(part) for part in (wave, white))
    most = min(allowed.cumulative_pitch, allowed.single_pitch / lowest)
    least = max(LEAST * allowed.cumulative_pitch, LEAST * allowed.single_pitch / highest)
    if not least <= most:
        return None
    cumulative = least + shares[0] * (most - least)
    smallest = max(LEAST * allowed.single_pitch, lowest * cumulative)
    largest = min(allowed.single_pitch, highest * cumulative)
    if not smallest <= largest:
        return None
    single = smallest + shares[1] * (largest - smallest)
    low, high, angle = 0.0, 0.5 * math.pi, 0.25 * math.pi
    for _ in range(60):
        mixed = math.cos(angle) * wave + math.sin(angle) * white
        steps = _single(mixed)
        top, bottom, steepest = int(mixed.argmax()), int(mixed.argmin()), int(np.abs(steps).argmax())
        surplus = abs(steps[steepest]) / (mixed[top] - mixed[bottom]) - single / cumulative
        if abs(surplus) <= 1e-15:
            break
        low, high = (angle, high) if surplus < 0.0 else (low, angle)
        next_tooth = (steepest + 1) % len(wave)
        of_wave, of_white = (
            math.copysign(1.0, steps[steepest]) * (part[next_tooth] - part[steepest]) * cumulative
            - (part[top] - part[bottom]) * single
            for part in (wave, white)
        )
        tangent = -of_wave / of_white if of_white else math.inf
        angle = math.atan(tangent) if math.tan(low) < tangent < math.tan(high) else 0.5 * (low + high)
    result: Floats = mixed * (cumulative / cumulative_deviation(mixed))
    return result


def _single(pitch: Floats) -> Floats:
    """Return single-pitch deviations, of each tooth to the next one counter-clockwise."""
    return np.roll(pitch, -1) - pitch


def _side(gear: DrawnGear) -> int:
    """+1 where the left flank is the counter-clockwise one of its tooth, -1 for a ring."""
    return -1 if gear.internal else 1
