"""A sleeve's forces to first order: what a small change of state, or of the latched impact speed, changes in them.

The exact derivative of `motion.add_sleeve` on a fixed mode (docs/theory, "Tangent of the motion").
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import BED_AS_PRINTED, BED_NONE, LOADED, System
from gearplay.kernels.sleeve import (
    BED_NODES,
    BED_WEIGHTS,
    bed_half_angle,
    bed_integrals,
    bed_penetration,
    signed_power,
    sleeve_force,
    sleeve_geometry,
    smooth_sign,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Columns of a sleeve's row of slopes: geometry, force and its derivatives by penetration, rate and latched speed; friction.
U_X, U_Y, INV_L, V_U, V_N, ARM_X, ARM_Y, SPIN = 0, 1, 2, 3, 4, 5, 6, 7
N, N_D, N_R, N_V, PULL, PULL_N, PULL_S, F_X, F_Y = 8, 9, 10, 11, 12, 13, 14, 15, 16
SLEEVE_SLOPES = 17


@compiled_inline
def smooth_sign_slope(u: float) -> float:
    """Return the slope of `sleeve.smooth_sign`.

    >>> smooth_sign_slope(0.0), smooth_sign_slope(1.0)
    (1.5, 0.0)
    """
    return 1.5 * (1.0 - u * u) if abs(u) < 1.0 else 0.0


@compiled
def bed_slopes(delta_m: float, c: float, R: float, k: float) -> tuple[float, float]:
    """Return the derivatives by delta_m of the two integrals of `sleeve.bed_integrals`.

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


@compiled
def sleeve_force_slopes(sleeve: Any, delta: float, rate: float, v_in: float) -> tuple[float, float, float]:
    """Return the derivatives of `sleeve.sleeve_force` by delta [N/m], rate and v_in [N s/m]."""
    margin, by_rate = 1.0 + sleeve.dissipation * rate / v_in, sleeve.dissipation / v_in
    by_latch = -by_rate * rate / v_in
    if sleeve.bed == BED_NONE:
        force = sleeve.stiffness * signed_power(delta, sleeve.exponent)
        steepness = sleeve.exponent * (
            math.sqrt(abs(delta)) if sleeve.exponent == 1.5 else abs(delta) ** (sleeve.exponent - 1.0)
        )
        return sleeve.stiffness * steepness * margin, force * by_rate, force * by_latch
    if delta <= 0.0:
        return 0.0, 0.0, 0.0
    c, R, k = sleeve.clearance, sleeve.shaft_radius, sleeve.bed_exponent
    elastic, opening = bed_integrals(delta, c, R, k)
    stiffer, wider = bed_slopes(delta, c, R, k)
    if sleeve.bed == BED_AS_PRINTED:
        damping = by_rate * sleeve.stiffness * delta**sleeve.exponent
        grown = sleeve.exponent * damping / delta
        return (
            sleeve.stiffness * stiffer + (grown * opening + damping * wider) * rate,
            damping * opening,
            -damping * rate * opening / v_in,
        )
    pressed = sleeve.bed_stiffness * elastic
    return sleeve.bed_stiffness * stiffer * margin, pressed * by_rate, pressed * by_latch


@compiled
def linearise_sleeve(
    system: System, k: int, t: float, y: Floats, modes: Ints, latch: Floats, row: Floats, out: Floats
) -> None:
    """Fill sleeve k's row of slopes at (t, y); ``out`` is scratch."""
    sleeve = system.sleeves[k]
    sleeve_geometry(sleeve, system, t, y, out)
    delta, rate, u_x, u_y = out[0], out[1], out[2], out[3]
    length = delta + sleeve.clearance
    row[U_X], row[U_Y], row[V_U], row[V_N] = u_x, u_y, rate, out[7]
    row[INV_L] = 1.0 / length if length > 0.0 else 0.0
    row[ARM_X], row[ARM_Y], row[SPIN] = out[5], out[6], 0.0
    if sleeve.bush >= 0:
        n = system.rotors.size
        row[SPIN] = system.rotors[sleeve.bush].nominal_speed + y[3 * (n + sleeve.bush) + 2]
    for c in range(N, SLEEVE_SLOPES):
        row[c] = 0.0
    if modes[k] != LOADED:
        return
    row[N], _ = sleeve_force(sleeve, delta, rate, latch[k])
    row[N_D], row[N_R], row[N_V] = sleeve_force_slopes(sleeve, delta, rate, latch[k])
    if sleeve.friction > 0.0:
        u = out[4] / sleeve.friction_speed
        row[PULL_N] = -sleeve.friction * smooth_sign(u)
        row[PULL] = row[PULL_N] * row[N]
        row[PULL_S] = -sleeve.friction * row[N] * smooth_sign_slope(u) / sleeve.friction_speed
    row[F_X] = -row[N] * u_x - row[PULL] * u_y
    row[F_Y] = -row[N] * u_y + row[PULL] * u_x


@compiled
def sleeve_changes(
    system: System, k: int, row: Floats, z: Floats
) -> tuple[float, float, float, float, float]:
    """Return what a change z of the state changes in sleeve k: e_x, e_y [m], delta [m], its rate, speed across u [m/s]."""
    sleeve, n = system.sleeves[k], system.rotors.size
    j = sleeve.journal
    e_x, e_y, v_x, v_y = z[3 * j], z[3 * j + 1], z[3 * (n + j)], z[3 * (n + j) + 1]
    if sleeve.bush >= 0:
        b = sleeve.bush
        turn, spin = z[3 * b + 2], z[3 * (n + b) + 2]
        arm_x, arm_y = row[ARM_X], row[ARM_Y]
        e_x -= z[3 * b] - arm_y * turn
        e_y -= z[3 * b + 1] + arm_x * turn
        v_x -= z[3 * (n + b)] - arm_y * spin - row[SPIN] * arm_x * turn
        v_y -= z[3 * (n + b) + 1] + arm_x * spin - row[SPIN] * arm_y * turn
    u_x, u_y = row[U_X], row[U_Y]
    swing = (-e_x * u_y + e_y * u_x) * row[INV_L]  # of the direction u [rad]
    delta = e_x * u_x + e_y * u_y
    rate = v_x * u_x + v_y * u_y + row[V_N] * swing
    across = -v_x * u_y + v_y * u_x - row[V_U] * swing
    return e_x, e_y, delta, rate, across


@compiled
def add_sleeve_change(system: System, k: int, row: Floats, z: Floats, latched: float, force: Floats) -> None:
    """Add to ``force`` [rotor, (N, N, N m)] what changes z of the state and ``latched`` [m/s] of the impact speed change."""
    sleeve, n = system.sleeves[k], system.rotors.size
    e_x, e_y, delta, rate, across = sleeve_changes(system, k, row, z)
    j, b, R = sleeve.journal, sleeve.bush, sleeve.shaft_radius
    u_x, u_y = row[U_X], row[U_Y]
    swing = (-e_x * u_y + e_y * u_x) * row[INV_L]
    normal = row[N_D] * delta + row[N_R] * rate + row[N_V] * latched
    pull = 0.0
    if sleeve.friction > 0.0:
        sliding = across + R * z[3 * (n + j) + 2]
        if b >= 0:
            sliding -= (R + sleeve.clearance) * z[3 * (n + b) + 2]
        pull = row[PULL_N] * normal + row[PULL_S] * sliding
    # f = -N u + T n with n across u; dn = -u dswing
    f_x = -normal * u_x - pull * u_y + (row[N] * u_y - row[PULL] * u_x) * swing
    f_y = -normal * u_y + pull * u_x - (row[N] * u_x + row[PULL] * u_y) * swing
    force[j, 0] += f_x
    force[j, 1] += f_y
    force[j, 2] += R * pull
    if b >= 0:
        turn = z[3 * b + 2]
        arm_x, arm_y = row[ARM_X], row[ARM_Y]
        force[b, 0] -= f_x
        force[b, 1] -= f_y
        force[b, 2] -= arm_x * f_y - arm_y * f_x - turn * (arm_y * row[F_Y] + arm_x * row[F_X])
        force[b, 2] -= (R + sleeve.clearance) * pull
