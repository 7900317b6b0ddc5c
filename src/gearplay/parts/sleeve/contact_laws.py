"""Contact laws of sleeves: stiffness from geometry, damping factors, delivered restitution."""

import math
from collections.abc import Callable

from gearplay.parts.sleeve.conformal import bed_integrals


def hertz_stiffness(
    shaft_radius: float,
    radial_clearance: float,
    shaft: tuple[float, float],
    sleeve: tuple[float, float],
) -> float:
    """Return the contact stiffness K [N/m^1.5] of a journal in a bush, eq. (9).

    ``shaft_radius`` and ``radial_clearance`` (radius difference) in m; ``shaft`` and ``sleeve`` are pairs of
    Young's modulus [Pa] and Poisson's ratio. K = 4 / (3 pi (s_b + s_j)) sqrt(R_b R_j / (R_b - R_j)), s = (1 - nu^2) / (pi E).

    >>> f"{hertz_stiffness(0.01, 100e-6, (206e9, 0.3), (206e9, 0.3)):.3g}"
    '1.52e+11'
    """
    s = sum((1.0 - nu * nu) / (math.pi * modulus) for modulus, nu in (shaft, sleeve))
    bush_radius = shaft_radius + radial_clearance
    return 4.0 / (3.0 * math.pi * s) * math.sqrt(bush_radius * shaft_radius / radial_clearance)


def literal_dissipation(law: str, e: float) -> float:
    """Return the factor a of F = K delta^n (1 + a ddelta/v_in) as the law is published, for restitution e.

    Lankarani and Nikravesh 1990, eq. (10): 3 (1 - e^2) / 4 (also the conformal bed). Hunt and Crossley 1975: 3 (1 - e) / 2.
    Flores, Machado, Silva and Martins 2011: 8 (1 - e) / (5 e). Gonthier et al. 2004: (1 - e^2) / e.

    >>> round(literal_dissipation("lankarani-nikravesh", 0.9), 4)
    0.1425
    """
    if law == "hunt-crossley":
        return 1.5 * (1.0 - e)
    if law == "flores":
        return 1.6 * (1.0 - e) / e
    if law == "gonthier":
        return (1.0 - e * e) / e
    return 0.75 * (1.0 - e * e)


def _first_integral_mismatch(a: float, e: float) -> float:
    """Return a (1 + e) - ln(1 + a) + ln(1 - a e): zero where factor a delivers restitution e."""
    return a * (1.0 + e) - math.log1p(a) + math.log1p(-a * e)


def _bisect(low: float, high: float, function: Callable[[float], float]) -> float:
    """Return the zero of a function that is positive at ``low`` and negative at ``high``, to the last bit."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def delivered_restitution(a: float) -> float:
    """Return the restitution that factor ``a`` delivers, whatever stiffness, exponent and mass.

    Integrating the impact in the phase plane gives a - ln(1 + a) = -a e - ln(1 - a e) (docs/theory).

    >>> round(delivered_restitution(literal_dissipation("lankarani-nikravesh", 0.9)), 5)
    0.91318
    """
    if a <= 1e-12:
        return 1.0
    top = min(1.0, 1.0 / a)
    return _bisect(0.0, top * (1.0 - 1e-16), lambda e: _first_integral_mismatch(a, e))


def solved_dissipation(e: float) -> float:
    """Return the factor a that delivers restitution e exactly, 0 < e <= 1.

    >>> round(delivered_restitution(solved_dissipation(0.5)), 12)
    0.5
    """
    if e == 1.0:
        return 0.0
    return _bisect(1e-9, (1.0 - 1e-16) / e, lambda a: _first_integral_mismatch(a, e))


def bed_stiffness(
    point_stiffness: float,
    point_exponent: float,
    clearance: float,
    shaft_radius: float,
    bed_exponent: float,
    reference: float,
) -> float:
    """Return the bed's stiffness K' [N/m^k/rad] that meets the point law at penetration ``reference`` [m]."""
    elastic, _ = bed_integrals(reference, clearance, shaft_radius, bed_exponent)
    return float(point_stiffness * reference**point_exponent / elastic)
