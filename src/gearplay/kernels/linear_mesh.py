"""A mesh's forces to first order: what a small change of state changes in them.

The exact derivative of `motion.add_mesh` on fixed modes (docs/theory, "Tangent of the motion"). A flank's penetration p has
the gradient D on the coordinates q of both gears; its force F acts along -D. So dQ = -D dF - F dD, with dD from the second
derivatives of p.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import (
    FORCE,
    MESH_COUPLED,
    MESH_PRINTED_COUPLED,
    MESH_UNCOUPLED,
    RAMP_SMOOTH,
    STIFFNESS_FOURIER,
    STIFFNESS_SPLINE,
    System,
)
from gearplay.kernels.mesh import flank_damping, harmonics, mesh_stiffness, spline_piece
from gearplay.kernels.motion import press_mesh

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Columns of a mesh's row of slopes. Arms, direction of the line of centres, relative velocity of the toothing centres:
LA_X, LA_Y, LB_X, LB_Y, E_X, E_Y, DV_X, DV_Y, SPIN_A, SPIN_B, PSI_RATE = range(11)
# curvatures of the opening along and across, and of the roll; error by the phase; what a turn of the carrier does to g:
BEND_E, BEND_N, BEND_MIXED, WIDEN, WIDEN_RATE, ERROR_1, ERROR_2, CARRIED = range(11, 19)
# and for each flank: direction, force, and the force's derivatives by penetration, rate and phase.
FLANK = 19
NU_X, NU_Y, F, F_P, F_R, F_PSI = range(6)
PER_FLANK = 6
MESH_SLOPES = FLANK + 2 * PER_FLANK


@compiled
def stiffness_slope(mesh: Any, system: System, psi: float, cos_psi: float, sin_psi: float) -> float:
    """Return dK/dpsi [N/m] of `mesh.mesh_stiffness` between the edges of a square wave."""
    if mesh.stiffness_kind == STIFFNESS_FOURIER:
        slope, _ = harmonic_bends(system.terms, mesh.stiffness_start, mesh.stiffness_count, cos_psi, sin_psi)
        return slope
    if mesh.stiffness_kind != STIFFNESS_SPLINE:
        return 0.0
    row, x = spline_piece(mesh, system, psi)
    p = system.spline[row]
    return p[2] + x * (2.0 * p[3] + 3.0 * x * p[4])


@compiled_inline
def harmonic_bends(
    terms: Floats, start: int, count: int, cos_psi: float, sin_psi: float
) -> tuple[float, float]:
    """Return the slope of sum a cos(k psi + phase) and the second derivative of sum a sin(k psi + phase) by psi."""
    slope, bend = 0.0, 0.0
    c, s, order = 1.0, 0.0, 0.0
    for i in range(start, start + count):
        while order < terms[i, 0]:
            c, s = c * cos_psi - s * sin_psi, s * cos_psi + c * sin_psi
            order += 1.0
        sine = terms[i, 1] * s + terms[i, 2] * c
        slope -= order * sine
        bend -= order * order * sine
    return slope, bend


@compiled_inline
def flank_slopes(
    mesh: Any, stiffness: float, p: float, rate: float, past: int, back: int
) -> tuple[float, float]:
    """Return the derivatives of a flank's force K p + C(p) dp/dt by p [N/m] and by the rate [N s/m]."""
    damping = flank_damping(mesh, p, past, back)
    steepness = 0.0
    u = p * mesh.inv_depth
    if past == 0 and u > 0.0:
        steepness = 6.0 * mesh.C_m * mesh.inv_depth * u * (1.0 - u)
        if mesh.ramp != RAMP_SMOOTH:
            steepness = 0.0 if back == 1 else -steepness
    return stiffness + steepness * rate, damping


@compiled
def linearise_mesh(
    system: System, j: int, t: float, y: Floats, modes: Ints, contacts: Floats, row: Floats, out: Floats
) -> int:
    """Fill mesh j's row of slopes at (t, y); return 1 where it cannot mesh. ``contacts`` and ``out`` are filled on the way."""
    if press_mesh(system, j, y, t, modes, contacts, out) != 0:
        return 1
    mesh, n = system.meshes[j], system.rotors.size
    n_s, n_m = system.sleeves.size, system.meshes.size
    a, b = mesh.a, mesh.b
    spin_a = system.rotors[a].nominal_speed + y[3 * (n + a) + 2]
    spin_b = system.rotors[b].nominal_speed + y[3 * (n + b) + 2]
    row[LA_X], row[LA_Y], row[LB_X], row[LB_Y] = out[14], out[15], out[16], out[17]
    row[E_X], row[E_Y], row[SPIN_A], row[SPIN_B], row[PSI_RATE] = out[21], out[22], spin_a, spin_b, out[13]
    row[DV_X] = y[3 * (n + b)] - spin_b * out[17] - (y[3 * (n + a)] - spin_a * out[15])
    row[DV_Y] = y[3 * (n + b) + 1] + spin_b * out[16] - (y[3 * (n + a) + 1] + spin_a * out[14])
    cos_psi, sin_psi = out[19], out[20]
    _, _, row[ERROR_1] = harmonics(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    _, row[ERROR_2] = harmonic_bends(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    inv_A, sin_w, s = out[26], out[9], mesh.s
    row[BEND_E] = row[BEND_N] = row[BEND_MIXED] = row[WIDEN] = row[WIDEN_RATE] = row[CARRIED] = 0.0
    if mesh.kind == MESH_COUPLED:
        # Second derivatives of the opening along and across the line of centres, and of the roll's angle.
        row[BEND_E] = s * mesh.c0 * mesh.c0 * inv_A * inv_A * inv_A / sin_w
        row[BEND_N] = s * sin_w * inv_A
        row[BEND_MIXED] = -s * mesh.sigma * mesh.c0 * inv_A * inv_A
    elif mesh.kind == MESH_PRINTED_COUPLED:
        row[WIDEN] = 2.0 * sin_w
    if mesh.frame >= 0 and mesh.kind != MESH_COUPLED:
        row[CARRIED] = carried_rate(system, j, t, y, out)
    k_mesh = mesh_stiffness(mesh, system, out[12], cos_psi, sin_psi, modes[n_s + 4 * n_m + j])
    k_slope = stiffness_slope(mesh, system, out[12], cos_psi, sin_psi)
    printed = mesh.kind != MESH_COUPLED and mesh.kind != MESH_UNCOUPLED
    for flank in range(2):
        at, contact = FLANK + PER_FLANK * flank, n_s + 2 * j + flank
        row[at + NU_X], row[at + NU_Y] = out[4 + 2 * flank], out[5 + 2 * flank]
        row[at + F] = contacts[contact, FORCE]
        row[at + F_P] = row[at + F_R] = row[at + F_PSI] = 0.0
        if contacts[contact, FORCE] != 0.0:
            p = out[flank]
            rate = out[2 + flank] if not printed else (out[18] if flank == 0 else -out[18])
            past = modes[n_s + 2 * n_m + 2 * j + flank]
            row[at + F_P], row[at + F_R] = flank_slopes(mesh, k_mesh, p, rate, past, flank)
            row[at + F_PSI] = k_slope * p
    return 0


@compiled
def carried_rate(system: System, j: int, t: float, y: Floats, out: Floats) -> float:
    """Return dg/dtheta [m] of the carrier that turns mesh j's fixed line of action, `mesh.mesh_gaps` having filled ``out``."""
    mesh = system.meshes[j]
    turn = system.rotors[mesh.frame].nominal_speed * t + y[3 * mesh.frame + 2]
    c, sn = math.cos(turn), math.sin(turn)
    u_x, u_y = c * mesh.u0_x - sn * mesh.u0_y, sn * mesh.u0_x + c * mesh.u0_y
    dx = y[3 * mesh.b] + out[16] - (y[3 * mesh.a] + out[14]) + mesh.A0 * (mesh.u0_x - u_x)
    dy = y[3 * mesh.b + 1] + out[17] - (y[3 * mesh.a + 1] + out[15]) + mesh.A0 * (mesh.u0_y - u_y)
    nu_x, nu_y = out[4], out[5]
    return -nu_y * dx + nu_x * dy + mesh.A0 * (nu_x * u_y - nu_y * u_x)


@compiled_inline
def mesh_changes(
    system: System, j: int, row: Floats, z: Floats
) -> tuple[float, float, float, float, float, float]:
    """Return what a change z of the state changes in mesh j: the vector between the toothing centres (2) [m], its rate (2)
    [m/s], the phase [rad] and its rate [rad/s].
    """
    mesh, n = system.meshes[j], system.rotors.size
    a, b = mesh.a, mesh.b
    turn_a, turn_b, spin_a, spin_b = z[3 * a + 2], z[3 * b + 2], z[3 * (n + a) + 2], z[3 * (n + b) + 2]
    d_x = z[3 * b] - row[LB_Y] * turn_b - (z[3 * a] - row[LA_Y] * turn_a)
    d_y = z[3 * b + 1] + row[LB_X] * turn_b - (z[3 * a + 1] + row[LA_X] * turn_a)
    v_x = z[3 * (n + b)] - row[LB_Y] * spin_b - row[SPIN_B] * row[LB_X] * turn_b
    v_y = z[3 * (n + b) + 1] + row[LB_X] * spin_b - row[SPIN_B] * row[LB_Y] * turn_b
    v_x -= z[3 * (n + a)] - row[LA_Y] * spin_a - row[SPIN_A] * row[LA_X] * turn_a
    v_y -= z[3 * (n + a) + 1] + row[LA_X] * spin_a - row[SPIN_A] * row[LA_Y] * turn_a
    psi, psi_rate = z[3 * mesh.driver + 2], z[3 * (n + mesh.driver) + 2]
    if mesh.frame >= 0:
        psi -= z[3 * mesh.frame + 2]
        psi_rate -= z[3 * (n + mesh.frame) + 2]
    return d_x, d_y, v_x, v_y, mesh.z_driver * psi, mesh.z_driver * psi_rate


@compiled_inline
def bend_of(row: Floats, sign: float, d_x: float, d_y: float) -> tuple[float, float]:
    """Return how the direction of a flank of sense ``sign`` changes with the vector between the toothing centres."""
    e_x, e_y = row[E_X], row[E_Y]
    along, across = d_x * e_x + d_y * e_y, -d_x * e_y + d_y * e_x
    mixed = sign * row[BEND_MIXED]
    by_e, by_n = row[BEND_E] * along + mixed * across, mixed * along + row[BEND_N] * across
    return by_e * e_x - by_n * e_y, by_e * e_y + by_n * e_x


@compiled
def flank_change(
    system: System, j: int, flank: int, row: Floats, z: Floats
) -> tuple[float, float, float, float]:
    """Return what a change z changes in a flank of mesh j: penetration [m], its damping's rate [m/s], direction (2)."""
    mesh, n = system.meshes[j], system.rotors.size
    at, sign = FLANK + PER_FLANK * flank, 1.0 - 2.0 * flank
    a, b = mesh.a, mesh.b
    nu_x, nu_y = row[at + NU_X], row[at + NU_Y]
    d_x, d_y, v_x, v_y, psi, psi_rate = mesh_changes(system, j, row, z)
    bend_x, bend_y = bend_of(row, sign, d_x, d_y)
    turned = 0.0
    if mesh.frame >= 0 and mesh.kind != MESH_COUPLED:
        turned = z[3 * mesh.frame + 2]
        bend_x, bend_y = bend_x - nu_y * turned, bend_y + nu_x * turned
    roll = mesh.rho_a * z[3 * a + 2] + mesh.rho_b * z[3 * b + 2]
    roll_rate = mesh.rho_a * z[3 * (n + a) + 2] + mesh.rho_b * z[3 * (n + b) + 2]
    p = sign * (mesh.sigma * roll + row[ERROR_1] * psi + row[CARRIED] * turned) + nu_x * d_x + nu_y * d_y
    if flank == 1:
        p -= row[WIDEN] * (d_x * row[E_X] + d_y * row[E_Y])
    rate = sign * (mesh.sigma * roll_rate + row[ERROR_1] * psi_rate + row[ERROR_2] * row[PSI_RATE] * psi)
    rate += nu_x * v_x + nu_y * v_y + bend_x * row[DV_X] + bend_y * row[DV_Y]
    return p, rate, bend_x, bend_y


@compiled
def add_mesh_change(system: System, j: int, row: Floats, z: Floats, force: Floats) -> None:
    """Add to ``force`` [rotor, (N, N, N m)] what a change z of the state changes in mesh j's forces."""
    mesh = system.meshes[j]
    a, b = mesh.a, mesh.b
    turn_a, turn_b = z[3 * a + 2], z[3 * b + 2]
    psi = z[3 * mesh.driver + 2]
    if mesh.frame >= 0:
        psi -= z[3 * mesh.frame + 2]
    psi *= mesh.z_driver
    for flank in range(2):
        at, sign = FLANK + PER_FLANK * flank, 1.0 - 2.0 * flank
        f = row[at + F]
        if f == 0.0:
            continue
        p, rate, bend_x, bend_y = flank_change(system, j, flank, row, z)
        grown = row[at + F_P] * p + row[at + F_R] * rate + row[at + F_PSI] * psi
        nu_x, nu_y = row[at + NU_X], row[at + NU_Y]
        f_x, f_y = -grown * nu_x - f * bend_x, -grown * nu_y - f * bend_y
        twist = -mesh.sigma * sign * grown
        force[b, 0] += f_x
        force[b, 1] += f_y
        force[b, 2] += twist * mesh.rho_b + row[LB_X] * f_y - row[LB_Y] * f_x
        force[a, 0] -= f_x
        force[a, 1] -= f_y
        force[a, 2] += twist * mesh.rho_a - (row[LA_X] * f_y - row[LA_Y] * f_x)
        # The arms turn with their gears under the force -f nu.
        force[b, 2] += f * turn_b * (row[LB_X] * nu_x + row[LB_Y] * nu_y)
        force[a, 2] -= f * turn_a * (row[LA_X] * nu_x + row[LA_Y] * nu_y)
