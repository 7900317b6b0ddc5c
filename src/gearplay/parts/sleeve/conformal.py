"""A conformal journal in its bush: a bed of radial springs over the angle of contact, equations (11)-(14), and its slopes."""

import math

import numpy as np

from gearplay.kernels.compiled import compiled

BED_NONE, BED_MATCHED, BED_AS_PRINTED = 0, 1, 2

# Gauss-Legendre nodes on (0, 1): with the angle substituted by theta0 sin(phi) the bed's integrand is smooth,
# so that 16 nodes reach rounding error for exponents 1 to 3.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
BED_NODES = np.ascontiguousarray(0.5 * (_NODES + 1.0))
BED_WEIGHTS = np.ascontiguousarray(0.5 * _WEIGHTS)


@compiled
def bed_half_angle(delta_m: float, c: float, R: float) -> float:
    """Return the half contact angle theta0 [rad] at penetration delta_m [m], about the bush's centre.

    cos theta0 = ((R+c)^2 + (c+delta_m)^2 - R^2) / (2 (R+c)(c+delta_m)): (13) measured where (12) is. R is the
    shaft radius [m], c the radial clearance [m].
    """
    e = c + delta_m
    cosine = ((R + c) ** 2 + e * e - R * R) / (2.0 * (R + c) * e)
    return math.acos(min(1.0, max(-1.0, cosine)))


@compiled
def bed_penetration(theta: float, delta_m: float, c: float, R: float) -> float:
    """Return the local penetration [m] at angle theta [rad] from the deepest point, eq. (12) with e_br = c.

    >>> round(1e6 * bed_penetration(0.0, 2e-6, 100e-6, 0.01), 9)
    2.0
    """
    e = c + delta_m
    # R - sqrt(R^2 - q) written without the difference of two large numbers
    q = R * R - ((R + c) ** 2 + e * e - 2.0 * (R + c) * e * math.cos(theta))
    return q / (R + math.sqrt(max(R * R - q, 0.0)))


@compiled
def bed_integrals(delta_m: float, c: float, R: float, k: float) -> tuple[float, float]:
    """Return 2 * integral of delta(theta)^k cos(theta) and 2 * integral of cos(theta) over 0..theta0, eq. (14)."""
    theta0 = bed_half_angle(delta_m, c, R)
    elastic = 0.0
    for i in range(BED_NODES.size):
        phi = 0.5 * math.pi * BED_NODES[i]
        theta = theta0 * math.sin(phi)
        local = bed_penetration(theta, delta_m, c, R)
        if local > 0.0:
            jacobian = theta0 * math.cos(phi) * 0.5 * math.pi
            elastic += BED_WEIGHTS[i] * local**k * math.cos(theta) * jacobian
    return 2.0 * elastic, 2.0 * math.sin(theta0)


@compiled
def bed_slopes(delta_m: float, c: float, R: float, k: float) -> tuple[float, float]:
    """Return the derivatives by delta_m of the two integrals of `bed_integrals`.

    The limit theta0 moves too, but the first integrand vanishes there.
    """
    theta0, e = bed_half_angle(delta_m, c, R), c + delta_m
    elastic = 0.0
    for i in range(BED_NODES.size):
        phi = 0.5 * math.pi * BED_NODES[i]
        theta = theta0 * math.sin(phi)
        local = bed_penetration(theta, delta_m, c, R)
        if local > 0.0:
            jacobian = theta0 * math.cos(phi) * 0.5 * math.pi
            deepening = ((R + c) * math.cos(theta) - e) / (R - local)
            elastic += BED_WEIGHTS[i] * k * local ** (k - 1.0) * deepening * math.cos(theta) * jacobian
    sine = math.sin(theta0)
    widening = 0.0
    if sine > 0.0:
        widening = -(e * e - (R + c) ** 2 + R * R) / (2.0 * (R + c) * e * e * sine)
    return 2.0 * elastic, 2.0 * math.cos(theta0) * widening
