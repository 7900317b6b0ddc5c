"""Loss of stiffness of a pair of teeth by a straight crack at the root of one of them.

The crack starts where the tangent of the fillet makes 30 deg with the middle line of the tooth (ISO 6336-3) and runs inwards and
down. Sections above its tip keep on that side at most the half thickness at the tip; bending and shear go by the reduced section,
compression, foundation and contact stay: S. Wu, M. J. Zuo, A. Parey, J. Sound Vib. 317 (2008) 470.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair
from gearplay.toothing.potential_energy import SHEAR, fillet, involute_flank, pair_stiffness

Floats = NDArray[np.float64]
SECTIONS: Final = 4000
"""Sections of the fillet and of the involute."""
CRITICAL: Final = math.radians(30.0)
"""Angle between the tangent of the fillet and the middle line where a crack starts."""


@dataclass(frozen=True)
class Crack:
    """Depth [m] along the crack and its angle from the middle line of the tooth [rad]."""

    depth: float
    angle: float


def _outline(gear: DrawnGear) -> tuple[Floats, Floats, Floats]:
    """Return half thickness and height [m] of an external tooth from root to tip, and both of its fillet, shape [2, section]."""
    x, y = fillet(gear, np.linspace(0.5 * math.pi, gear.pressure_angle, SECTIONS))
    begins = math.sqrt(max((math.hypot(float(x[-1]), float(y[-1])) / gear.base_radius) ** 2 - 1.0, 0.0))
    ends = math.sqrt((gear.tip / gear.base_radius) ** 2 - 1.0)
    above = involute_flank(gear, np.linspace(begins, ends, SECTIONS)[1:])
    return np.concatenate([x, above[0]]), np.concatenate([y, above[1]]), np.array([x, y])


def crack_tip(gear: DrawnGear, crack: Crack) -> tuple[float, float]:
    """Return distance from the middle line and height [m] of the tip of a crack; the distance is negative beyond the middle."""
    _, _, (x, y) = _outline(gear)
    inclined = np.arctan2(-np.gradient(x), np.gradient(y))
    start = int(np.argmin(np.abs(inclined - CRITICAL)))
    return (
        float(x[start]) - crack.depth * math.sin(crack.angle),
        float(y[start]) - crack.depth * math.cos(crack.angle),
    )


def added_compliance(
    gear: DrawnGear, crack: Crack, tangent: float, facewidth: float, modulus: float, poisson: float
) -> float:
    """Return the added compliance [m/N] of a cracked external tooth; arguments as of `tooth_compliance`."""
    whole, height, _ = _outline(gear)
    (xs, ys) = involute_flank(gear, np.array([tangent]))
    x_c, y_c = float(xs[0]), float(ys[0])
    beta = math.atan(tangent) - math.atan2(x_c, y_c)
    kept, tip = crack_tip(gear, crack)
    below = height < y_c
    x, y = np.append(whole[below], x_c), np.append(height[below], y_c)
    reduced = np.where((y >= tip) & (x > kept), max(kept, 0.0), x)
    cosine, sine = math.cos(beta), math.sin(beta)
    lever = cosine * (y_c - y) - x_c * sine
    shear_modulus = modulus / (2.0 * (1.0 + poisson))

    def bent(width: Floats) -> Floats:
        moment, area = width**3 * facewidth / 12.0, width * facewidth
        return lever**2 / (modulus * moment) + SHEAR * cosine**2 / (shear_modulus * area)

    return float(np.trapezoid(bent(x + reduced) - bent(2.0 * x), y))


def crack_losses(
    pair: GearPair, gear: int, crack: Crack, places: Floats, modulus: float, poisson: float
) -> Floats:
    """Return the share of a pair's stiffness by potential energy that a crack of one tooth takes, shape [place].

    Parameters
    ----------
    pair
        Gears with facewidths; external ones with bores.
    gear
        0 for the first, 1 for the second, which must be external.
    crack
        At the root on the loaded side.
    places
        On the path of contact [m], shape [place].
    modulus, poisson
        E [Pa], nu.

    """
    width = pair.facewidth
    assert width is not None, "validated"
    cracked = (pair.first, pair.second)[gear]
    found = []
    for place in places.tolist():
        stiffness = pair_stiffness(pair, place, modulus, poisson)
        way = place if gear == 0 else pair.base_tangent - place
        more = added_compliance(cracked, crack, way / cracked.base_radius, width, modulus, poisson)
        found.append(1.0 - 1.0 / (1.0 + more * stiffness))
    return np.array(found)


def with_bore(gear: DrawnGear) -> DrawnGear:
    """Return a gear whose body stiffness is known: without a bore given, with one of half its root diameter."""
    return gear if gear.bore is not None or gear.internal else replace(gear, bore=gear.root)
