"""Tooth stiffness by ISO 6336-1:2019, method B: one pair of teeth, its factor of light loads, a parabola over the path.

In N/(mm um) of facewidth, as the standard has it, of steel with a modulus of 206 GPa.
"""

import math
from typing import Final

from gearplay.toothing.gear import DrawnGear

STEEL: Final = 206e9
"""Young's modulus [Pa] for which the standard gives its constants."""
LIGHT: Final = 1e5
"""Line load F_t/b [N/m] below which the stiffness falls with its fourth root."""
CORRECTION: Final = 0.8
"""C_M, measured over theoretical stiffness of solid discs."""


def flexibility(pinion: DrawnGear, wheel: DrawnGear) -> float:
    """Return q' [mm um/N] of a pair of teeth: a ring counts as a rack without shift.

    q' = 0.04723 + 0.15551/z_n1 + 0.25791/z_n2 - 0.00635 x_1 - 0.11654 x_1/z_n1 - 0.00193 x_2 - 0.24188 x_2/z_n2
    + 0.00529 x_1^2 + 0.00182 x_2^2.

    >>> gears = (DrawnGear(teeth=20, module=4e-3), DrawnGear(teeth=60, module=4e-3))
    >>> round(single_stiffness(*gears), 6)
    13.15257
    """
    helix = pinion.helix_angle
    virtual = math.cos(pinion.base_helix) ** 2 * math.cos(helix)
    one, other = pinion.teeth / virtual, math.inf if wheel.internal else wheel.teeth / virtual
    x, y = pinion.profile_shift, 0.0 if wheel.internal else wheel.profile_shift
    q = 0.04723 + 0.15551 / one + 0.25791 / other
    q += -0.00635 * x - 0.11654 * x / one - 0.00193 * y - 0.24188 * y / other
    return q + 0.00529 * x * x + 0.00182 * y * y


def single_stiffness(pinion: DrawnGear, wheel: DrawnGear) -> float:
    """Return c' = C_M C_B cos beta / q' [N/(mm um)], the maximum stiffness of one pair of teeth, for loads above 100 N/mm.

    C_B = (1 + 0.5 (1.2 - h_fP/m_n)) (1 - 0.02 (20 deg - alpha_n)), its first factor the mean of both gears.
    """
    depth = 0.5 * (pinion.dedendum + wheel.dedendum)
    rack = (1.0 + 0.5 * (1.2 - depth)) * (1.0 - 0.02 * (20.0 - math.degrees(pinion.pressure_angle)))
    return CORRECTION * rack * math.cos(pinion.helix_angle) / flexibility(pinion, wheel)


def light_load_factor(line_load: float) -> float:
    """Return the factor of a stiffness at a line load F_t/b [N/m]: its fourth root below 100 N/mm.

    >>> round(light_load_factor(1e3), 6)
    0.316228
    """
    return min(1.0, math.pow(line_load / LIGHT, 0.25))


def mean_factor(contact_ratio: float) -> float:
    """Return c_gamma / c' = 0.75 eps_alpha + 0.25."""
    return 0.75 * contact_ratio + 0.25


def parabola(contact_ratio: float) -> float:
    """Return kappa of k = c' b (1 - kappa u^2) over the path, u = -1 .. 1: peak c', mean of the sum c_gamma of the standard."""
    return 0.75 * (1.0 - 1.0 / contact_ratio)
