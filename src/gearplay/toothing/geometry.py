"""Involute geometry of drawn gears and of pairs, external and internal, in the transverse section.

Drawings give the basic rack: normal module, normal pressure angle, helix angle, profile shift. Every other angle is derived here:
the transverse pressure angle alpha_t at the reference circle, with tan alpha_t = tan alpha_n / cos beta, and the working one
alpha_w at the actual centres, with cos alpha_w = c0 / a. Lengths in m, angles in rad.

The tooth of an external gear and the space of a ring have the same shape: half angle sigma - inv(alpha_y) at radius r_y. A
positive profile shift moves material away from the gear's own axis, of a ring too: its tip circle grows.

ISO 21771-1:2014; J. R. Colbourne, The Geometry of Involute Gears, Springer 1987.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

ADDENDUM: Final = 1.0
"""In modules: full-depth teeth, ISO 53."""
DEDENDUM: Final = 1.25
TIP_RADIUS: Final = 0.38
"""Radius of the rack's tips in modules, ISO 53."""


def inv(alpha: float) -> float:
    """Return the involute function tan(alpha) - alpha [rad]."""
    return math.tan(alpha) - alpha


def inverse_involute(value: float) -> float:
    """Return the angle [rad] of an involute function, by Newton's method for its tangent; NaN below 0.

    >>> math.degrees(inverse_involute(inv(math.radians(20.0))))
    20.0
    """
    if not value > 0.0:
        return 0.0 if value == 0.0 else math.nan
    tangent = math.cbrt(3.0 * value) + value
    for _ in range(30):
        step = (tangent - math.atan(tangent) - value) * (1.0 + tangent**-2)
        tangent -= step
        if abs(step) <= 1e-15 * tangent:
            break
    return math.atan(tangent)


@dataclass(frozen=True, kw_only=True)
class DrawnGear:
    """A gear as its drawing defines it.

    Parameters
    ----------
    teeth, module, pressure_angle, helix_angle, internal
        Number of teeth; module [m], pressure angle and helix angle [rad] of the rack, in the normal section.
    profile_shift, addendum, dedendum, tip_radius
        In modules; the tip radius is that of the rack's teeth, at most the largest that they have room for.
    tip_diameter
        d_a [m]; by the addendum if None.
    thickness_change
        Change of the normal tooth thickness at the reference circle [m], negative for thinner teeth.
    facewidth, bore
        [m]; None if not given.

    """

    teeth: int
    module: float
    pressure_angle: float = math.radians(20.0)
    helix_angle: float = 0.0
    internal: bool = False
    profile_shift: float = 0.0
    addendum: float = ADDENDUM
    dedendum: float = DEDENDUM
    tip_radius: float = TIP_RADIUS
    tip_diameter: float | None = None
    thickness_change: float = 0.0
    facewidth: float | None = None
    bore: float | None = None

    @property
    def sign(self) -> float:
        """+1 of an external gear, -1 of a ring."""
        return -1.0 if self.internal else 1.0

    @cached_property
    def transverse_module(self) -> float:
        """m_t = m_n / cos beta [m]."""
        return self.module / math.cos(self.helix_angle)

    @cached_property
    def transverse_angle(self) -> float:
        """Transverse pressure angle alpha_t at the reference circle [rad]."""
        if self.helix_angle == 0.0:
            return self.pressure_angle
        return math.atan(math.tan(self.pressure_angle) / math.cos(self.helix_angle))

    @cached_property
    def base_helix(self) -> float:
        """Helix angle beta_b at the base cylinder [rad], sin beta_b = sin beta cos alpha_n."""
        return math.asin(math.sin(abs(self.helix_angle)) * math.cos(self.pressure_angle))

    @cached_property
    def reference_radius(self) -> float:
        """r = m_t z / 2 [m]."""
        return 0.5 * self.transverse_module * self.teeth

    @cached_property
    def base_radius(self) -> float:
        """r_b = r cos alpha_t [m]."""
        return self.reference_radius * math.cos(self.transverse_angle)

    @cached_property
    def base_pitch(self) -> float:
        """Transverse base pitch 2 pi r_b / z [m]."""
        return 2.0 * math.pi * self.base_radius / self.teeth

    @cached_property
    def tip(self) -> float:
        """Radius r_a of the tip circle [m]."""
        if self.tip_diameter is not None:
            return 0.5 * self.tip_diameter
        return self.reference_radius + (self.sign * self.addendum + self.profile_shift) * self.module

    @cached_property
    def root(self) -> float:
        """Radius r_f of the root circle [m]."""
        return self.reference_radius + (self.profile_shift - self.sign * self.dedendum) * self.module

    @cached_property
    def rack_tip_radius(self) -> float:
        """Radius of the rack's tips in modules, at most that of a full round."""
        return max(0.0, min(self.tip_radius, full_tip_radius(self.pressure_angle, self.dedendum)))

    @cached_property
    def half_angle(self) -> float:
        """Half angle sigma at the base circle [rad] of the tooth of an external gear, of the space of a ring."""
        shift = 2.0 * self.profile_shift * math.tan(self.pressure_angle) / self.teeth
        thinner = 0.5 * self.thickness_change / (self.reference_radius * math.cos(self.helix_angle))
        return 0.5 * math.pi / self.teeth + shift + inv(self.transverse_angle) + self.sign * thinner

    def half_angle_at(self, radius: float) -> float:
        """Return sigma - inv(alpha_y) [rad] at a radius [m], within the base circle that at it."""
        return self.half_angle - inv(math.acos(min(1.0, self.base_radius / max(radius, self.base_radius))))

    @property
    def normal_thickness(self) -> float:
        """Normal tooth thickness at the reference circle [m]."""
        half_pitch = 0.5 * math.pi * self.module
        shift = 2.0 * self.profile_shift * self.module * math.tan(self.pressure_angle)
        return half_pitch + self.sign * shift + self.thickness_change

    @property
    def tip_thickness(self) -> float:
        """Transverse thickness at the tip circle [m], a ring's within its base circle that at it; negative for pointed teeth."""
        at = max(self.tip, self.base_radius)
        half = self.half_angle_at(self.tip)
        return 2.0 * at * (math.pi / self.teeth - half if self.internal else half)

    @cached_property
    def straight_flank(self) -> float:
        """Depth in modules to which the rack's flank is straight."""
        return self.dedendum - self.rack_tip_radius * (1.0 - math.sin(self.pressure_angle))

    @property
    def undercut(self) -> float:
        """By how many modules the rack's straight flank reaches beyond the base tangent point, negative without undercut."""
        depth = self.reference_radius * math.sin(self.transverse_angle) ** 2 / self.module
        return self.straight_flank - self.profile_shift - depth

    @property
    def length_to_tip(self) -> float:
        """Way along the base tangent from its tangent point to the tip circle [m], 0 for a ring's tip within its base circle."""
        return math.sqrt(max(self.tip**2 - self.base_radius**2, 0.0))


def full_tip_radius(pressure_angle: float, dedendum: float) -> float:
    """Return the largest radius of a rack's tips in modules: two quarter rounds without a flat between them."""
    flat = 0.25 * math.pi - dedendum * math.tan(pressure_angle)
    return flat * math.cos(pressure_angle) / (1.0 - math.sin(pressure_angle))


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
        return PathOfContact(
            line - self.second.length_to_tip, self.first.length_to_tip + 0.0 * line, line
        )

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
        """Way by which the contact shifts along the path over the facewidth [m], b tan beta_b; 0 of spur gears."""
        return (self.facewidth or 0.0) * math.tan(self.first.base_helix)

    @property
    def overlap_ratio(self) -> float:
        """eps_beta: that way over the base pitch."""
        return self.overlap / self.first.base_pitch

    @property
    def pitch_place(self) -> float:
        """Place of the pitch point on the line of action, from the tangent point of the first gear [m]."""
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

    def sliding(self, place: float) -> float:
        """Return the sliding speed of the flanks per speed of the first gear [m] at a place on the path [m]."""
        ratio = self.second.sign * self.first.teeth / self.second.teeth
        return (place - self.pitch_place) * (1.0 + ratio)

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
