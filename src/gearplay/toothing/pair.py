"""Involute geometry of a pair of drawn gears at any centre distance: working angle, backlash, path of contact, interference.

ISO 21771-1; J. R. Colbourne, The Geometry of Involute Gears, Springer 1987.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear, inv, inverse_involute

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PathOfContact:
    """Path of contact along the line of action, counted from the base tangent point of the first gear [m].

    ``tip_of_second`` and ``tip_of_first`` are where the tip circles cut the line, ``tangent_of_second`` the base tangent point of
    the second gear, at infinity for a ring. A tip beyond a tangent point is interference: there is no involute, and the path
    ends at the tangent point. NaN where the base circles are too near to mesh.
    """

    tip_of_second: float
    tip_of_first: float
    tangent_of_second: float

    @property
    def start(self) -> float:
        """A, cut at the tangent point of the first gear."""
        return max(self.tip_of_second, 0.0)

    @property
    def end(self) -> float:
        """E, cut at the tangent point of the second gear."""
        return min(self.tip_of_first, self.tangent_of_second)

    @property
    def length(self) -> float:
        """Length of the path, negative where tips do not overlap."""
        return self.end - self.start

    @property
    def uncut(self) -> float:
        """Distance of the tip circles on the line of action."""
        return self.tip_of_first - self.tip_of_second


@dataclass(frozen=True)
class GearPair:
    """Two drawn gears at a centre distance [m]: the first external, the second external or a ring."""

    first: DrawnGear
    second: DrawnGear
    distance: float

    @property
    def internal(self) -> bool:
        """Whether the second gear is a ring."""
        return self.second.internal

    @property
    def is_shifted(self) -> bool:
        """Whether a gear has profile shift."""
        return bool(self.first.profile_shift or self.second.profile_shift)

    @cached_property
    def least_distance(self) -> float:
        """c0 = r_b2 +- r_b1 [m], the distance at which the base circles touch; a cos alpha_w."""
        return self.second.base_radius + self.second.sign * self.first.base_radius

    @cached_property
    def reference_distance(self) -> float:
        """Distance [m] at which the reference circles roll on each other."""
        return self.second.reference_radius + self.second.sign * self.first.reference_radius

    @cached_property
    def working_angle(self) -> float:
        """Working pressure angle alpha_w [rad]; NaN where the base circles are too near."""
        if self.distance == self.reference_distance:
            return self.first.transverse_angle
        return (
            math.acos(self.least_distance / self.distance)
            if self.distance > self.least_distance
            else math.nan
        )

    def at(self, distance: float) -> "GearPair":
        """Return the pair at another centre distance [m]."""
        return GearPair(self.first, self.second, distance)

    @property
    def working_radii(self) -> tuple[float, float]:
        """Radii [m] of the circles that roll on each other."""
        ratio = self.distance / self.least_distance
        return self.first.base_radius * ratio, self.second.base_radius * ratio

    @cached_property
    def tight_involute(self) -> float:
        """inv(alpha_w) [rad] at which both flanks touch; negative where the teeth are too thick for any distance."""
        first, second = self.first, self.second
        change = (first.thickness_change + second.thickness_change) / math.cos(first.helix_angle)
        thicker = 0.5 * change * math.cos(first.transverse_angle) / self.least_distance
        return inv(first.transverse_angle) + self._shift + second.sign * thicker

    @property
    def _shift(self) -> float:
        """Rise of inv(alpha_w) [rad] by the profile shifts."""
        first, second = self.first, self.second
        shifts = second.profile_shift + second.sign * first.profile_shift
        return 2.0 * shifts * math.tan(first.pressure_angle) / (second.teeth + second.sign * first.teeth)

    @property
    def tight_distance(self) -> float:
        """Distance [m] of zero backlash with the given thicknesses; NaN where there is none."""
        return self.least_distance / math.cos(inverse_involute(self.tight_involute))

    @property
    def shifted_distance(self) -> float:
        """Distance [m] of zero backlash by the profile shifts alone; NaN where there is none."""
        if self._shift == 0.0:
            return self.reference_distance
        return self.least_distance / math.cos(
            inverse_involute(inv(self.first.transverse_angle) + self._shift)
        )

    @property
    def backlash(self) -> float:
        """Transverse backlash along the line of action [m], negative for flanks that overlap; NaN where they cannot mesh."""
        opened = inv(self.working_angle) - self.tight_involute
        return 2.0 * self.second.sign * self.least_distance * opened + 0.0

    @cached_property
    def base_tangent(self) -> float:
        """Length a sin alpha_w of the common tangent of the base circles [m]."""
        if self.distance == self.reference_distance:
            return self.distance * math.sin(self.first.transverse_angle)
        if self.distance <= self.least_distance:
            return math.nan
        return math.sqrt(self.distance**2 - self.least_distance**2)

    @cached_property
    def path(self) -> PathOfContact:
        """Path of contact between the tip circles."""
        line = self.base_tangent
        if self.internal:
            return PathOfContact(
                self.second.length_to_tip - line, self.first.length_to_tip + 0.0 * line, math.inf
            )
        return PathOfContact(line - self.second.length_to_tip, self.first.length_to_tip + 0.0 * line, line)

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio eps_alpha: length of the path of contact over the base pitch."""
        return self.path.length / self.first.base_pitch

    @property
    def facewidth(self) -> float | None:
        """Common facewidth [m], the smaller of the two; None where one is not given."""
        widths = (self.first.facewidth, self.second.facewidth)
        return None if None in widths else min(width for width in widths if width is not None)

    @property
    def overlap(self) -> float:
        """Shift of the contact along the path over the facewidth [m], b tan beta_b; 0 of spur gears."""
        return (self.facewidth or 0.0) * math.tan(self.first.base_helix)

    @property
    def overlap_ratio(self) -> float:
        """Overlap ratio eps_beta: `overlap` over the base pitch."""
        return self.overlap / self.first.base_pitch

    @property
    def pitch_place(self) -> float:
        """Position of the pitch point on the line of action, from the tangent point of the first gear [m]."""
        return self.first.base_radius * self.base_tangent / self.least_distance

    @property
    def range_of_distances(self) -> tuple[float, float]:
        """Distances [m] between which tips overlap and do not strike roots."""
        first, second = self.first, self.second
        if self.internal:
            strikes = min(second.root - first.tip, second.tip - first.root)
            return max(self.least_distance, second.tip - first.tip), strikes
        strikes = max(first.tip + second.root, first.root + second.tip)
        return max(self.least_distance, strikes), first.tip + second.tip

    @property
    def tip_clearances(self) -> tuple[float, float]:
        """Clearance [m] of each gear's tips from the root circle of the other, the first gear's first."""
        first, second = self.first, self.second
        if self.internal:
            return second.root - self.distance - first.tip, second.tip - self.distance - first.root
        return self.distance - first.tip - second.root, self.distance - second.tip - first.root

    @property
    def clean_tip_diameter(self) -> float:
        """Tip diameter [m] of the second gear whose tips just reach the tangent point of the first."""
        return 2.0 * math.hypot(self.base_tangent, self.second.base_radius)

    def sliding(self, place: Floats) -> Floats:
        """Return the sliding speed of the flanks per speed of the first gear [m] at places on the path [m]."""
        ratio = self.second.sign * self.first.teeth / self.second.teeth
        return (place - self.pitch_place) * (1.0 + ratio)

    def specific_sliding(self, place: Floats) -> tuple[Floats, Floats]:
        """Return |v1 - v2| / v1 and |v1 - v2| / v2 at places on the path [m], of the rolling speeds v1, v2 of both flanks.

        They are infinite at a base tangent point, where a flank does not roll.
        """
        sign = self.second.sign
        first = np.asarray(place, dtype=np.float64)
        second = self.base_tangent - first if sign > 0.0 else self.base_tangent + first
        second = second * (self.first.teeth / self.second.teeth)
        apart = np.abs(first - second)
        with np.errstate(divide="ignore"):
            return apart / first, apart / second

    @property
    def tips_foul(self) -> bool:
        """Whether the tips of an internal pair meet outside the line of action (Colbourne 1987)."""
        if not self.internal:
            return False
        first, second, distance = self.first, self.second, self.distance
        turn_1 = (second.tip**2 - first.tip**2 - distance**2) / (2.0 * distance * first.tip)
        turn_2 = (second.tip**2 - first.tip**2 + distance**2) / (2.0 * distance * second.tip)
        if abs(turn_1) >= 1.0 or abs(turn_2) >= 1.0:  # the tip circles do not cross
            return second.tip <= first.tip - distance
        at_tip_1 = inv(math.acos(first.base_radius / first.tip))
        at_tip_2 = inv(math.acos(min(1.0, second.base_radius / second.tip)))
        angle_1 = math.acos(turn_1) + at_tip_1 - inv(self.working_angle)
        turned = angle_1 * first.teeth / second.teeth + inv(self.working_angle)
        return turned - at_tip_2 < math.acos(turn_2)
