"""One sleeve: a journal in a bush with radial clearance; point and conformal contact, friction."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import BED_AS_PRINTED, BED_NONE, System

Floats = NDArray[np.float64]

# Gauss-Legendre nodes on (0, 1): with the angle substituted by theta0 sin(phi) the bed's integrand is smooth,
# so that 16 nodes reach rounding error for exponents 1 to 3.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
BED_NODES = np.ascontiguousarray(0.5 * (_NODES + 1.0))
BED_WEIGHTS = np.ascontiguousarray(0.5 * _WEIGHTS)


@compiled
def bed_half_angle(delta_m: float, c: float, R: float) -> float:
    """Return the half contact angle theta0 [rad] at penetration delta_m [m], seen from the bush's centre.

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


@compiled_inline
def signed_power(x: float, n: float) -> float:
    """Return sign(x) |x|^n: a smooth continuation of x^n for stages that look behind a release."""
    if n == 1.5:
        return x * math.sqrt(abs(x))
    if n == 1.0:
        return x
    return math.copysign(abs(x) ** n, x)


@compiled_inline
def sleeve_force(sleeve: Any, delta: float, rate: float, v_in: float) -> tuple[float, float]:
    """Return the normal force [N] and its margin (positive while pressing) at penetration delta [m].

    F = K delta^n (1 + a ddelta/v_in), equations (7)-(11) with the damping of (10) written as the factor ``a``;
    the conformal bed (12)-(14) replaces K delta^n. ``rate`` is ddelta/dt [m/s], ``v_in`` the latched impact speed.
    As printed, the bed's damping C = a K delta_m^n / v_in is the same at every angle.
    """
    margin = 1.0 + sleeve.dissipation * rate / v_in
    if sleeve.bed == BED_NONE:
        return sleeve.stiffness * signed_power(delta, sleeve.exponent) * margin, margin
    if delta <= 0.0:
        return 0.0, margin
    elastic, opening = bed_integrals(delta, sleeve.clearance, sleeve.shaft_radius, sleeve.bed_exponent)
    if sleeve.bed == BED_AS_PRINTED:
        damping = sleeve.dissipation * sleeve.stiffness * delta**sleeve.exponent / v_in
        force = sleeve.stiffness * elastic + damping * rate * opening
        return force, force
    return sleeve.bed_stiffness * elastic * margin, margin


@compiled_inline
def smooth_sign(u: float) -> float:
    """Return the regularised sign: 1.5 u - 0.5 u^3 within |u| < 1, +-1 beyond; its slope is continuous.

    >>> smooth_sign(0.0), smooth_sign(2.0), smooth_sign(-1.0)
    (0.0, 1.0, -1.0)
    """
    if u >= 1.0:
        return 1.0
    if u <= -1.0:
        return -1.0
    return u * (1.5 - 0.5 * u * u)


@compiled_inline
def sleeve_geometry(sleeve: Any, system: System, t: float, y: Floats, out: Floats) -> None:
    """Fill ``out``: 0 delta [m], 1 ddelta/dt [m/s], 2-3 direction u, 4 sliding speed [m/s], 5-6 bush arm [m], 7 speed of the
    journal's centre across u [m/s].

    Equations (1), (2): e is the journal's displacement in the bush, delta = |e| - c. A bush on a carrier turns with it.
    """
    n = system.rotors.size
    j = sleeve.journal
    e_x, e_y, v_x, v_y = y[3 * j], y[3 * j + 1], y[3 * (n + j)], y[3 * (n + j) + 1]
    arm_x, arm_y, bush_spin = 0.0, 0.0, 0.0
    if sleeve.bush >= 0:
        i = sleeve.bush
        turn = system.rotors[i].nominal_speed * t + y[3 * i + 2]
        bush_spin = system.rotors[i].nominal_speed + y[3 * (n + i) + 2]
        # cos(turn) - 1 by the half angle: the journal's orbit must not cancel against 1
        cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
        c_1, sn = -2.0 * sine * sine, 2.0 * sine * cosine
        shift_x = c_1 * sleeve.offset_x - sn * sleeve.offset_y
        shift_y = sn * sleeve.offset_x + c_1 * sleeve.offset_y
        arm_x, arm_y = sleeve.offset_x + shift_x, sleeve.offset_y + shift_y
        e_x -= y[3 * i] + shift_x
        e_y -= y[3 * i + 1] + shift_y
        v_x -= y[3 * (n + i)] - bush_spin * arm_y
        v_y -= y[3 * (n + i) + 1] + bush_spin * arm_x
    length = math.sqrt(e_x * e_x + e_y * e_y)
    u_x, u_y = (e_x / length, e_y / length) if length > 0.0 else (1.0, 0.0)
    out[0] = length - sleeve.clearance
    out[1] = v_x * u_x + v_y * u_y
    out[2], out[3] = u_x, u_y
    spin = system.rotors[j].nominal_speed + y[3 * (n + j) + 2]
    out[4] = (
        -v_x * u_y
        + v_y * u_x
        + spin * sleeve.shaft_radius
        - bush_spin * (sleeve.shaft_radius + sleeve.clearance)
    )
    out[5], out[6] = arm_x, arm_y
    out[7] = -v_x * u_y + v_y * u_x
