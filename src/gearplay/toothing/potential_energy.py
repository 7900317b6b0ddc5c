"""Stiffness of a pair of spur teeth by the potential energy of bent teeth, their foundations and the Hertzian contact.

Teeth are cantilevers of varying section on the root circle, with the outline that the rack cuts: the trochoid of its rounded tip,
then the involute. The load acts along the line of action, at the angle beta to the normal of the tooth's middle line:

    bending     integral of (cos beta (y_c - y) - x_c sin beta)^2 / (E I) dy
    shear       integral of 1.2 cos^2 beta / (G A) dy
    compression integral of sin^2 beta / (E A) dy
    foundation  P. Sainsot, P. Velex, O. Duverger, J. Mech. Des. 126 (2004) 748
    Hertz       4 (1 - nu^2) / (pi E b)

D. C. H. Yang, J. Y. Lin, J. Mech. Transm. Autom. Des. 109 (1987) 189. A ring's teeth have no fillet and a rigid rim here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair

Floats = NDArray[np.float64]
Curve = Callable[[DrawnGear, Floats], tuple[Floats, Floats]]
Sections = tuple[Floats, Floats, Floats]
NODES: Final = 48
"""Gauss-Legendre nodes over the fillet and over the involute."""
SHEAR: Final = 1.2
"""Shear factor of a rectangular section."""
SAINSOT: Final = np.array(
    [
        [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
        [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
        [-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236],
        [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
    ]
)
"""Factors of 1/theta^2, h^2, h/theta, 1/theta, h and 1 in L*, M*, P* and Q*."""


@dataclass(frozen=True)
class Compliance:
    """Compliance of one tooth along the line of action [m/N], by its parts."""

    bending: float
    shear: float
    compression: float
    foundation: float

    @property
    def total(self) -> float:
        """Sum of the parts [m/N]."""
        return self.bending + self.shear + self.compression + self.foundation


@lru_cache(maxsize=8)
def _nodes(count: int) -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.asarray(nodes), np.asarray(weights)


def fillet(gear: DrawnGear, gamma: Floats) -> tuple[Floats, Floats]:
    """Return the fillet of an external tooth [m] in the transverse section, its middle along +y.

    ``gamma`` is the angle of the rack's normal in the normal section [rad]: pi/2 at the root circle, the pressure angle where the
    involute begins. A point of the rack cuts where its normal passes through the pitch point; thinner teeth
    are cut on both sides.
    """
    module, alpha, radius = gear.module, gear.pressure_angle, gear.rack_tip_radius
    depth = (gear.dedendum - gear.profile_shift - radius + radius * np.sin(gamma)) * module
    offset = (
        0.25 * math.pi
        + (gear.dedendum - radius) * math.tan(alpha)
        + radius / math.cos(alpha)
        - radius * np.cos(gamma)
    ) * gear.transverse_module
    offset += 0.5 * gear.thickness_change / math.cos(gear.helix_angle)
    across = np.arctan2(np.sin(gamma), np.cos(gamma) * math.cos(gear.helix_angle))
    turned = (offset + depth / np.tan(across)) / gear.reference_radius
    reach = depth / np.sin(across)
    x = gear.reference_radius * np.sin(turned) - reach * np.cos(across - turned)
    y = gear.reference_radius * np.cos(turned) - reach * np.sin(across - turned)
    return x, y


def involute_flank(gear: DrawnGear, tangents: Floats) -> tuple[Floats, Floats]:
    """Return the involute flank [m] by the tangent of its pressure angle, the middle of the tooth along +y."""
    radius = gear.base_radius * np.sqrt(1.0 + tangents * tangents)
    half = gear.half_angle - (tangents - np.arctan(tangents))
    if gear.internal:
        half = math.pi / gear.teeth - half
    return radius * np.sin(half), radius * np.cos(half)


def _tangent_at(gear: DrawnGear, radius: float) -> float:
    return math.sqrt(max((radius / gear.base_radius) ** 2 - 1.0, 0.0))


def _piece(gear: DrawnGear, curve: Curve, low: float, high: float) -> Sections:
    """Return half thickness, height and weight of sections along a curve of the outline, shape [section]."""
    nodes, weights = _nodes(NODES)
    middle, half, step = 0.5 * (low + high), 0.5 * (high - low), 1e-5 * (high - low)
    at = middle + half * nodes
    x, y = curve(gear, at)
    slope = (curve(gear, at + step)[1] - curve(gear, at - step)[1]) / (2.0 * step)
    return x, y, np.abs(half * weights * slope)


@lru_cache(maxsize=64)
def _root(gear: DrawnGear) -> tuple[float, Sections, float]:
    """Return the tangent of the pressure angle where the involute begins, the fillet's sections, the angle of its end [rad]."""
    low, high = gear.pressure_angle, 0.5 * math.pi
    (x_0, x_1), (y_0, y_1) = fillet(gear, np.array([low, high]))
    begins = _tangent_at(gear, math.hypot(x_0, y_0))
    return begins, _piece(gear, fillet, low, high), math.atan2(x_1, y_1)


def _sections(gear: DrawnGear, tangent: float) -> Sections:
    """Return half thickness, height and weight of sections between the root and a contact, shape [section]."""
    if gear.internal:
        return _piece(gear, involute_flank, _tangent_at(gear, gear.root), tangent)
    begins, cut, _ = _root(gear)
    if tangent <= begins:  # the contact is within the fillet's height
        return _piece(gear, fillet, _fillet_angle(gear, tangent), 0.5 * math.pi)
    x, y, weight = (
        np.concatenate(each) for each in zip(cut, _piece(gear, involute_flank, begins, tangent), strict=True)
    )
    return x, y, weight


def _fillet_angle(gear: DrawnGear, tangent: float) -> float:
    """Return the rack's angle at which the fillet is as high as the involute at a tangent of the pressure angle."""
    height = float(involute_flank(gear, np.array([tangent]))[1][0])
    low, high = gear.pressure_angle, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        if float(fillet(gear, np.array([middle]))[1][0]) > height:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def tooth_compliance(
    gear: DrawnGear, tangent: float, facewidth: float, modulus: float, poisson: float
) -> Compliance:
    """Return the compliance of one tooth at a contact where the tangent of the pressure angle is ``tangent``.

    Parameters
    ----------
    gear
        An external gear with a bore, or a ring.
    tangent
        tan alpha_y, the way from the base tangent point over the base radius.
    facewidth, modulus, poisson
        b [m], E [Pa], nu.

    """
    (xs, ys) = involute_flank(gear, np.array([tangent]))
    x_c, y_c = float(xs[0]), float(ys[0])
    half = math.atan2(x_c, y_c)
    beta = math.atan(tangent) + (half if gear.internal else -half)
    x, y, weight = _sections(gear, tangent)
    cosine, sine = math.cos(beta), math.sin(beta)
    area, moment = 2.0 * x * facewidth, (2.0 * x) ** 3 * facewidth / 12.0
    lever = cosine * np.abs(y_c - y) - x_c * sine
    shear_modulus = modulus / (2.0 * (1.0 + poisson))
    return Compliance(
        bending=float(np.sum(weight * lever**2 / (modulus * moment))),
        shear=float(np.sum(weight * SHEAR * cosine**2 / (shear_modulus * area))),
        compression=float(np.sum(weight * sine**2 / (modulus * area))),
        foundation=0.0 if gear.internal else _foundation(gear, beta, x_c, y_c) / (modulus * facewidth),
    )


def _foundation(gear: DrawnGear, beta: float, x_c: float, y_c: float) -> float:
    """Return cos^2 beta (L* (u/S)^2 + M* u/S + P* (1 + Q* tan^2 beta)) of the body under a tooth."""
    assert gear.bore is not None, "validated"
    theta = _root(gear)[2]
    h = 2.0 * gear.root / gear.bore
    terms = np.array([1.0 / theta**2, h * h, h / theta, 1.0 / theta, h, 1.0])
    big_l, big_m, big_p, big_q = (SAINSOT @ terms).tolist()
    u = y_c - x_c * math.tan(beta) - gear.root
    ratio = u / (2.0 * theta * gear.root)
    inner = big_l * ratio**2 + big_m * ratio + big_p * (1.0 + big_q * math.tan(beta) ** 2)
    return math.cos(beta) ** 2 * float(inner)


def pair_stiffness(pair: GearPair, place: float, modulus: float, poisson: float) -> float:
    """Return the stiffness [N/m] of a pair of teeth that touch at a place on the path of contact [m]."""
    width = pair.facewidth
    assert width is not None, "validated"
    first, second = pair.first, pair.second
    other = pair.base_tangent + place if pair.internal else pair.base_tangent - place
    total = 4.0 * (1.0 - poisson**2) / (math.pi * modulus * width)
    total += tooth_compliance(first, place / first.base_radius, width, modulus, poisson).total
    total += tooth_compliance(second, other / second.base_radius, width, modulus, poisson).total
    return 1.0 / total
