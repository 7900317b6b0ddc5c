"""Involute geometry of gears as drawn, external and internal, in the transverse section.

Drawings give the basic rack: normal module, normal pressure angle, helix angle, profile shift. Every other angle is derived here:
the transverse pressure angle alpha_t at the reference circle, with tan alpha_t = tan alpha_n / cos beta, and the working one
alpha_w at the actual centres, with cos alpha_w = c0 / a. Lengths in m, angles in rad.

The tooth of an external gear and the space of a ring have the same shape: half angle sigma - inv(alpha_y) at radius r_y. A
positive profile shift moves material away from the gear's own axis, of a ring too: its tip circle grows.

ISO 21771-1.
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

    >>> round(math.degrees(inverse_involute(inv(math.radians(20.0)))), 9)
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
        """R = m_t z / 2 [m]."""
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
        """Length of the base tangent from its tangent point to the tip circle [m], 0 for a ring's tip within its base circle."""
        return math.sqrt(max(self.tip**2 - self.base_radius**2, 0.0))


def full_tip_radius(pressure_angle: float, dedendum: float) -> float:
    """Return the largest radius of a rack's tips in modules: two quarter rounds without a flat between them."""
    flat = 0.25 * math.pi - dedendum * math.tan(pressure_angle)
    return flat * math.cos(pressure_angle) / (1.0 - math.sin(pressure_angle))
