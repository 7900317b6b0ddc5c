"""Geometry of rolling bearings: stiffness of an element by Hertz, pass frequencies, clearance classes, a catalogue."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

INCH: Final = 25.4e-3


class PassOrders(NamedTuple):
    """Orders per turn of the inner ring against the outer: of the cage, an element on the outer and the inner ring, its spin."""

    cage: float
    outer: float
    inner: float
    spin: float


def pass_orders(elements: int, ratio: float, contact_angle: float = 0.0) -> PassOrders:
    """Return the orders of pure rolling; ``ratio`` is D / d_m.

    T. A. Harris, Rolling Bearing Analysis, with g = D cos(contact angle) / d_m: FTF = (1 - g)/2, BPFO = Z (1 - g)/2,
    BPFI = Z (1 + g)/2, BSF = d_m/(2 D) (1 - g^2).

    >>> [round(order, 9) for order in pass_orders(8, 0.3125 / 1.319)]
    [0.381539045, 3.052312358, 4.947687642, 1.991939045]
    """
    g = ratio * math.cos(contact_angle)
    return PassOrders(
        cage=0.5 * (1.0 - g),
        outer=0.5 * elements * (1.0 - g),
        inner=0.5 * elements * (1.0 + g),
        spin=0.5 / ratio * (1.0 - g * g),
    )


def elliptic_integrals(m: float) -> tuple[float, float]:
    """Return the complete elliptic integrals K(m) and E(m), 0 <= m < 1, by the arithmetic-geometric mean.

    Abramowitz and Stegun 17.6.

    >>> [round(value, 12) for value in elliptic_integrals(0.5)]
    [1.854074677301, 1.350643881048]
    """
    a, b, c, total, power = 1.0, math.sqrt(1.0 - m), math.sqrt(m), 0.5 * m, 1.0
    for _ in range(12):  # quadratic: to rounding for m up to 1 - 1e-16
        a, b, c = 0.5 * (a + b), math.sqrt(a * b), 0.5 * (a - b)
        total += power * c * c
        power *= 2.0
    first = 0.5 * math.pi / a
    return first, first * (1.0 - total)


def _point_stiffness(curvatures: tuple[float, float, float, float], compliance: float) -> float:
    """Return K of Q = K delta^1.5 [N/m^1.5] of a Hertzian point contact.

    ``curvatures`` [1/m] are those of both bodies along and across the rolling, ``compliance`` is the sum of (1 - nu^2)/E [1/Pa].
    The axis ratio k of the contact ellipse is the root of the curvature difference, with exact elliptic integrals
    (T. A. Harris, Rolling Bearing Analysis).
    """
    along_1, along_2, across_1, across_2 = curvatures
    whole = along_1 + along_2 + across_1 + across_2
    difference = abs(along_1 + along_2 - across_1 - across_2) / whole

    def mismatch(k: float) -> float:
        first, second = elliptic_integrals(1.0 - 1.0 / (k * k))
        return ((k * k + 1.0) * second - 2.0 * first) / ((k * k - 1.0) * second) - difference

    low, high = 1.0 + 1e-9, 2.0
    while mismatch(high) < 0.0:
        high *= 2.0
    for _ in range(200):
        k = 0.5 * (low + high)
        if k in (low, high):
            break
        low, high = (k, high) if mismatch(k) < 0.0 else (low, k)
    first, second = elliptic_integrals(1.0 - 1.0 / (k * k))
    approach = 2.0 * first / math.pi * (0.5 * math.pi / (k * k * second)) ** (1.0 / 3.0)
    per_load = 0.5 * approach * whole * (1.5 * compliance / whole) ** (2.0 / 3.0)
    return float(per_load**-1.5)


def ball_stiffness(
    diameter: float, pitch_diameter: float, ratio: float, grooves: tuple[float, float], modulus: float, poisson: float
) -> float:  # fmt: skip
    """Return K [N/m^1.5] of one ball between both rings: two Hertzian contacts in series.

    ``diameter`` D and ``pitch_diameter`` [m], ``ratio`` D cos(contact angle) / d_m; ``grooves`` are the radii of the inner and
    the outer raceway over D; ``modulus`` [Pa] and ``poisson`` of balls and rings.

    >>> f"{ball_stiffness(7.94e-3, 39.04e-3, 7.94 / 39.04, (0.52, 0.52), 206e9, 0.3):.5e}"
    '9.21459e+09'
    """
    compliance = 2.0 * (1.0 - poisson * poisson) / modulus
    found = []
    for sign, groove in zip((1.0, -1.0), grooves, strict=True):
        along = sign * 2.0 / diameter * ratio / (1.0 - sign * ratio)
        curvatures = (2.0 / diameter, along, 2.0 / diameter, -1.0 / (groove * diameter))
        found.append(_point_stiffness(curvatures, compliance))
    return float(sum(each ** (-2.0 / 3.0) for each in found) ** -1.5)


class Geometry(NamedTuple):
    """Numbers of a bearing from its maker or from those who measured with it; lengths in m."""

    elements: int
    element_diameter: float
    pitch_diameter: float
    bore: float | None
    source: str


CATALOGUE: Final[Mapping[str, Geometry]] = MappingProxyType({
    "6205": Geometry(9, 0.3126 * INCH, 1.537 * INCH, 25e-3, "drive end, bearing data center of Case Western Reserve University"),
    "ER-10K": Geometry(8, 0.3125 * INCH, 1.319 * INCH, 0.625 * INCH, "Rexnord ER-10K, as SpectraQuest's simulators have it"),
    "NICE": Geometry(8, 0.235 * INCH, 1.245 * INCH, None, "MFPT fault data sets, E. Bechhoefer, 2013"),
    "UER204": Geometry(8, 7.92e-3, 34.55e-3, None, "LDK, XJTU-SY data sets: Wang, Lei et al., IEEE Trans. Reliab. 69 (2020) 401"),
})  # fmt: skip
"""Bearings by designation: only geometries with a source."""

CLASSES: Final = ("C2", "CN", "C3", "C4", "C5")
_RADIAL_CLEARANCES: Final = (
    (10e-3, ((0, 7), (2, 13), (8, 23), (14, 29), (20, 37))),
    (18e-3, ((0, 9), (3, 18), (11, 25), (18, 33), (25, 45))),
    (24e-3, ((0, 10), (5, 20), (13, 28), (20, 36), (28, 48))),
    (30e-3, ((1, 11), (5, 20), (13, 28), (23, 41), (30, 53))),
    (40e-3, ((1, 11), (6, 20), (15, 33), (28, 46), (40, 64))),
    (50e-3, ((1, 11), (6, 23), (18, 36), (30, 51), (45, 73))),
    (65e-3, ((1, 15), (8, 28), (23, 43), (38, 61), (55, 90))),
    (80e-3, ((1, 15), (10, 30), (25, 51), (46, 71), (65, 105))),
    (100e-3, ((1, 18), (12, 36), (30, 58), (53, 84), (75, 120))),
)
LEAST_BORE: Final = 2.5e-3
LARGEST_BORE: Final = _RADIAL_CLEARANCES[-1][0]


def clearance_range(grade: str, bore: float) -> tuple[float, float]:
    """Return least and largest radial internal clearance [m] of a class, for deep-groove ball bearings with cylindrical bore.

    ISO 5753-1, bores [m] over 2.5 to 100 mm; diametral: how far one ring moves across, unloaded, from end to end.

    >>> clearance_range("C3", 25e-3)
    (1.3e-05, 2.8e-05)
    """
    rows = next(rows for upper, rows in _RADIAL_CLEARANCES if bore <= upper)
    least, largest = rows[CLASSES.index(grade)]
    return 1e-6 * least, 1e-6 * largest


def ranges_at(bore: float | None) -> dict[str, tuple[float, float]]:
    """Return the ranges [m] of all classes at a bore; empty where none are known."""
    if bore is None or not LEAST_BORE < bore <= LARGEST_BORE:
        return {}
    return {grade: clearance_range(grade, bore) for grade in CLASSES}
