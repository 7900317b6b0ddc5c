"""Derivatives of a mesh: exact slopes of its forces and their directional changes (docs/theory, T23)."""

from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    Branch,
    Loads,
    System,
    omega_of,
    spin_of,
    theta_of,
    vx_of,
    vy_of,
    x_of,
    y_of,
)
from gearplay.kernels.smooth_sign import smooth_sign, smooth_sign_slope
from gearplay.parts.mesh.flank import flank_slopes
from gearplay.parts.mesh.geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    BY_FRAME,
    COS_PSI,
    DISTANCE,
    E_X,
    E_Y,
    INV_A,
    MESH_PRINTED_COUPLED,
    N_D_X,
    N_D_Y,
    P_D,
    P_D_RATE,
    PSI,
    PSI_RATE,
    SIN_PSI,
    SIN_W,
    is_coupled,
)
from gearplay.parts.mesh.law.forces import contact_kinematics, damping_rate
from gearplay.parts.mesh.law.friction import lever_arms
from gearplay.parts.mesh.law.record import BACK, EDGE, KIND, PER_CONTACT
from gearplay.parts.mesh.law.switches import next_pair_switch
from gearplay.parts.mesh.pairs.changes import add_pair_change, lead_crossing, pair_crossing
from gearplay.parts.mesh.pairs.friction import SLIDING
from gearplay.parts.mesh.pairs.record import PAIR, SEGMENT
from gearplay.parts.mesh.pairs.slopes import PAIRS, linearise_envelope, linearise_pairs
from gearplay.parts.mesh.slope_columns import (
    DV_X,
    DV_Y,
    LA_X,
    LA_Y,
    LB_X,
    LB_Y,
    S_E_X,
    S_E_Y,
    S_PSI_RATE,
    SPIN_A,
    SPIN_B,
)
from gearplay.parts.mesh.tooth_stiffness import (
    harmonic_curvatures,
    harmonics,
    mesh_stiffness,
    stiffness_slope,
)

# Columns of a mesh's row of slopes behind those of `gearplay.parts.mesh.slope_columns`: turns of the opening along and across,
# and of the roll; error by the phase;
BEND_E, BEND_N, BEND_MIXED, WIDEN, ERROR_1, ERROR_2 = range(11, 17)
# of a carrier that turns a fixed line of action: dg/dtheta, its spin, n.D with D the vector of centres;
S_BY_FRAME, SPIN_F, ALONG = range(17, 20)
# and for each flank: direction, rate, force, and the force's derivatives by penetration, rate and phase.
FLANK = 20
NU_X, NU_Y, P_RATE, F, F_P, F_R, F_PSI = range(7)
FLANK_SLOPES = 7
# Then for each flank friction over normal force, its slope by the sliding speed [s/m] and both lever arms [m]; and the length of
# the line of centres.
GRIP, GRIP_SLOPE, Q_A, Q_B = range(4)
COLUMNS = 4
RUBBING = FLANK + 2 * FLANK_SLOPES
S_LENGTH = RUBBING + 2 * COLUMNS
SLOPES = max(S_LENGTH + 1, PAIRS)


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill mesh n's row of slopes at (t, y), the derivative of `apply_forces` on fixed modes; return 1 where it cannot mesh.

    A flank's penetration p has the gradient D on the coordinates q of its rotors; its force F acts along -D. So
    dQ = -D dF - F dD, with dD from the second derivatives of p (docs/theory, T23).
    """
    if contact_kinematics(system, n, t, y, branch, loads) != 0:
        return 1
    out, modes = loads.out, branch.modes
    mesh = system.records[KIND][n]
    a, b = mesh.a, mesh.b
    spin_a, spin_b = spin_of(system, a, y), spin_of(system, b, y)
    row[LA_X], row[LA_Y], row[LB_X], row[LB_Y] = out[ARM_A_X], out[ARM_A_Y], out[ARM_B_X], out[ARM_B_Y]
    row[S_E_X], row[S_E_Y], row[SPIN_A], row[SPIN_B] = out[E_X], out[E_Y], spin_a, spin_b
    row[S_PSI_RATE] = out[PSI_RATE]
    row[DV_X] = y[vx_of(system, b)] - spin_b * out[ARM_B_Y] - (y[vx_of(system, a)] - spin_a * out[ARM_A_Y])
    row[DV_Y] = y[vy_of(system, b)] + spin_b * out[ARM_B_X] - (y[vy_of(system, a)] + spin_a * out[ARM_A_X])
    if mesh.pairs > 0:
        linearise_pairs(system, n, branch, loads, row)
        if mesh.envelope == 1:
            linearise_envelope(system, n, branch, loads, row)
        return 0
    cos_psi, sin_psi = out[COS_PSI], out[SIN_PSI]
    _, _, row[ERROR_1] = harmonics(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    _, row[ERROR_2] = harmonic_curvatures(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    inv_A, sin_w, s = out[INV_A], out[SIN_W], mesh.s
    row[BEND_E] = row[BEND_N] = row[BEND_MIXED] = row[WIDEN] = 0.0
    row[S_BY_FRAME], row[SPIN_F], row[ALONG] = out[BY_FRAME], 0.0, 0.0
    if is_coupled(mesh):
        # Second derivatives of the opening along and across the line of centres, and of the roll's angle.
        row[BEND_E] = s * mesh.c0 * mesh.c0 * inv_A * inv_A * inv_A / sin_w
        row[BEND_N] = s * sin_w * inv_A
        row[BEND_MIXED] = -s * mesh.sigma * mesh.c0 * inv_A * inv_A
    else:
        if mesh.kind == MESH_PRINTED_COUPLED:
            row[WIDEN] = 2.0 * sin_w
        if mesh.frame >= 0:
            row[SPIN_F] = spin_of(system, mesh.frame, y)
            row[ALONG] = out[DISTANCE] * (out[N_D_X] * out[E_X] + out[N_D_Y] * out[E_Y])
    segment = modes[mesh.mode + SEGMENT]
    k_mesh = mesh_stiffness(mesh, system, out[PSI], cos_psi, sin_psi, segment)
    k_slope = stiffness_slope(mesh, system, out[PSI], cos_psi, sin_psi)
    for flank in range(2):
        at, contact = FLANK + FLANK_SLOPES * flank, mesh.contact + flank
        row[at + NU_X], row[at + NU_Y] = out[N_D_X + 2 * flank], out[N_D_Y + 2 * flank]
        row[at + P_RATE] = out[P_D_RATE + flank]
        row[at + F] = loads.contacts[contact, FORCE]
        row[at + F_P] = row[at + F_R] = row[at + F_PSI] = 0.0
        if row[at + F] != 0.0:
            p, past = out[P_D + flank], modes[mesh.mode + flank]
            rate = damping_rate(mesh, flank, out)
            row[at + F_P], row[at + F_R] = flank_slopes(mesh, k_mesh, p, rate, past, flank)
            row[at + F_PSI] = k_slope * p
            if mesh.friction > 0.0:
                rubbing, u = RUBBING + COLUMNS * flank, loads.contacts[contact, SLIDING] / mesh.friction_speed
                row[rubbing + GRIP] = -mesh.friction * smooth_sign(u)
                row[rubbing + GRIP_SLOPE] = -mesh.friction * smooth_sign_slope(u) / mesh.friction_speed
                q_a, q_b = lever_arms(mesh, flank, modes[mesh.mode + PAIR], out)
                row[rubbing + Q_A], row[rubbing + Q_B] = q_a, q_b
    row[S_LENGTH] = out[DISTANCE]
    return 0


@compiled_inline
def _mesh_changes(
    system: System, mesh: Any, row: Floats, z: Floats
) -> tuple[float, float, float, float, float, float]:
    """Return what a change z of the state changes in a mesh: the vector between the toothing centres (2) [m], its rate (2)
    [m/s], the phase [rad] and its rate [rad/s].
    """
    a, b = mesh.a, mesh.b
    turn_a, turn_b = z[theta_of(a)], z[theta_of(b)]
    spin_a, spin_b = z[omega_of(system, a)], z[omega_of(system, b)]
    d_x = z[x_of(b)] - row[LB_Y] * turn_b - (z[x_of(a)] - row[LA_Y] * turn_a)
    d_y = z[y_of(b)] + row[LB_X] * turn_b - (z[y_of(a)] + row[LA_X] * turn_a)
    v_x = z[vx_of(system, b)] - row[LB_Y] * spin_b - row[SPIN_B] * row[LB_X] * turn_b
    v_y = z[vy_of(system, b)] + row[LB_X] * spin_b - row[SPIN_B] * row[LB_Y] * turn_b
    v_x -= z[vx_of(system, a)] - row[LA_Y] * spin_a - row[SPIN_A] * row[LA_X] * turn_a
    v_y -= z[vy_of(system, a)] + row[LA_X] * spin_a - row[SPIN_A] * row[LA_Y] * turn_a
    psi, psi_rate = z[theta_of(mesh.driver)], z[omega_of(system, mesh.driver)]
    if mesh.frame >= 0:
        psi -= z[theta_of(mesh.frame)]
        psi_rate -= z[omega_of(system, mesh.frame)]
    return d_x, d_y, v_x, v_y, mesh.z_driver * psi, mesh.z_driver * psi_rate


@compiled_inline
def _turn_of(row: Floats, sign: float, d_x: float, d_y: float) -> tuple[float, float]:
    """Return how the direction of a flank of sense ``sign`` changes with the vector between the toothing centres."""
    e_x, e_y = row[S_E_X], row[S_E_Y]
    along, across = d_x * e_x + d_y * e_y, -d_x * e_y + d_y * e_x
    mixed = sign * row[BEND_MIXED]
    by_e, by_n = row[BEND_E] * along + mixed * across, mixed * along + row[BEND_N] * across
    return by_e * e_x - by_n * e_y, by_e * e_y + by_n * e_x


@compiled
def _flank_change(
    system: System, mesh: Any, flank: int, row: Floats, z: Floats
) -> tuple[float, float, float, float, float]:
    """Return what a change z changes in a flank: penetration [m], its damping's rate [m/s], direction (2), dp/dtheta [m] of
    the carrier that turns it.
    """
    at, sign = FLANK + FLANK_SLOPES * flank, 1.0 - 2.0 * flank
    a, b = mesh.a, mesh.b
    nu_x, nu_y = row[at + NU_X], row[at + NU_Y]
    d_x, d_y, v_x, v_y, psi, psi_rate = _mesh_changes(system, mesh, row, z)
    turn_x, turn_y = _turn_of(row, sign, d_x, d_y)
    turned, spun, by_frame = 0.0, 0.0, 0.0
    if mesh.frame >= 0 and not is_coupled(mesh):
        turned, spun = z[theta_of(mesh.frame)], z[omega_of(system, mesh.frame)]
        turn_x, turn_y = turn_x - nu_y * turned, turn_y + nu_x * turned
        by_frame = nu_x * d_y - nu_y * d_x - sign * row[ALONG] * turned
    roll = mesh.rho_a * z[theta_of(a)] + mesh.rho_b * z[theta_of(b)]
    roll_rate = mesh.rho_a * z[omega_of(system, a)] + mesh.rho_b * z[omega_of(system, b)]
    p = sign * (mesh.sigma * roll + row[ERROR_1] * psi + row[S_BY_FRAME] * turned) + nu_x * d_x + nu_y * d_y
    if flank == BACK:
        p -= row[WIDEN] * (d_x * row[S_E_X] + d_y * row[S_E_Y])
    rate = sign * (mesh.sigma * roll_rate + row[ERROR_1] * psi_rate + row[ERROR_2] * row[S_PSI_RATE] * psi)
    rate += nu_x * v_x + nu_y * v_y + turn_x * row[DV_X] + turn_y * row[DV_Y]
    rate += sign * row[S_BY_FRAME] * spun + row[SPIN_F] * by_frame
    return p, rate, turn_x, turn_y, by_frame


@compiled_once
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return the derivatives along z of switch function s of mesh n and of its rate, and the rate."""
    mesh = system.records[KIND][n]
    if mesh.pairs > 0:
        d_x, d_y, v_x, v_y, psi, psi_rate = _mesh_changes(system, mesh, row, z)
        first = next_pair_switch(mesh)
        if mesh.envelope == 1 and s >= first:
            return lead_crossing(system, n, s - first, row, z, d_x, d_y, v_x, v_y, psi, psi_rate)
        if mesh.envelope == 1 and s >= EDGE:
            return psi, psi_rate, row[S_PSI_RATE]
        return pair_crossing(system, n, s // PER_CONTACT, row, z, d_x, d_y, v_x, v_y, psi, psi_rate)
    if s >= EDGE:
        _, _, _, _, psi, psi_rate = _mesh_changes(system, mesh, row, z)
        return psi, psi_rate, row[S_PSI_RATE]
    flank = s // PER_CONTACT
    p, rate, _, _, _ = _flank_change(system, mesh, flank, row, z)
    return p, rate, row[FLANK + FLANK_SLOPES * flank + P_RATE]


@compiled_inline
def _lever_changes(
    system: System, mesh: Any, flank: int, row: Floats, turn_x: float, turn_y: float, z: Floats
) -> tuple[float, float]:
    """Return the change of the lever arms [m] of friction about both toothing centres by a change z of the state.

    The flank's direction changes by ``turn``.
    """
    e_x, e_y, A = row[S_E_X], row[S_E_Y], row[S_LENGTH]
    at = FLANK + FLANK_SLOPES * flank
    nu_x, nu_y = row[at + NU_X], row[at + NU_Y]
    d_x, d_y, _, _, psi, _ = _mesh_changes(system, mesh, row, z)
    along, across = d_x * e_x + d_y * e_y, -d_x * e_y + d_y * e_x
    d_lever = (
        along * (nu_x * e_x + nu_y * e_y)
        + A * (turn_x * e_x + turn_y * e_y)
        + across * (-nu_x * e_y + nu_y * e_x)
    ) / (mesh.rho_a + mesh.rho_b)
    d_way = (1.0 - 2.0 * flank) * mesh.way * psi
    return d_way - d_lever * mesh.rho_a, d_way + d_lever * mesh.rho_b


@compiled
def _sliding_change(
    system: System, mesh: Any, flank: int, row: Floats, turn_x: float, turn_y: float, z: Floats
) -> float:
    """Return the change of a flank's sliding speed [m/s] by a change z of the state; its direction changes by ``turn``."""
    at, rubbing = FLANK + FLANK_SLOPES * flank, RUBBING + COLUMNS * flank
    _, _, v_x, v_y, _, _ = _mesh_changes(system, mesh, row, z)
    dq_a, dq_b = _lever_changes(system, mesh, flank, row, turn_x, turn_y, z)
    change = v_y * row[at + NU_X] - v_x * row[at + NU_Y] + row[DV_Y] * turn_x - row[DV_X] * turn_y
    change -= (
        z[omega_of(system, mesh.b)] * row[rubbing + Q_B] - z[omega_of(system, mesh.a)] * row[rubbing + Q_A]
    )
    return change - (row[SPIN_B] * dq_b - row[SPIN_A] * dq_a)


@compiled_once
def add_friction_change(
    system: System, n: int, flank: int, row: Floats, turn_x: float, turn_y: float, grown: float, z: Floats, force: Rows
) -> None:  # fmt: skip
    """Add the change of the friction of a flank of mesh n by a change z of the state to ``force``.

    The flank's direction changes by ``turn``, its normal force by ``grown`` [N].
    """
    mesh = system.records[KIND][n]
    a, b = mesh.a, mesh.b
    la_x, la_y, lb_x, lb_y = row[LA_X], row[LA_Y], row[LB_X], row[LB_Y]
    at, rubbing = FLANK + FLANK_SLOPES * flank, RUBBING + COLUMNS * flank
    nu_x, nu_y, normal = row[at + NU_X], row[at + NU_Y], row[at + F]
    sliding = _sliding_change(system, mesh, flank, row, turn_x, turn_y, z)
    dq_a, dq_b = _lever_changes(system, mesh, flank, row, turn_x, turn_y, z)
    g = row[rubbing + GRIP] * normal
    dg = row[rubbing + GRIP] * grown + row[rubbing + GRIP_SLOPE] * normal * sliding
    f_x, f_y = -g * nu_y, g * nu_x
    df_x, df_y = -dg * nu_y - g * turn_y, dg * nu_x + g * turn_x
    force[b, 0] += df_x
    force[b, 1] += df_y
    force[a, 0] -= df_x
    force[a, 1] -= df_y
    # The arms turn with their gears.
    force[b, 2] += lb_x * df_y - lb_y * df_x - z[theta_of(b)] * (lb_y * f_y + lb_x * f_x)
    force[a, 2] -= la_x * df_y - la_y * df_x - z[theta_of(a)] * (la_y * f_y + la_x * f_x)
    force[b, 2] -= dg * row[rubbing + Q_B] + g * dq_b
    force[a, 2] += dg * row[rubbing + Q_A] + g * dq_a


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of mesh n's forces by a change z of the state to ``force`` [rotor, (N, N, N m)]."""
    mesh = system.records[KIND][n]
    if mesh.pairs > 0:
        d_x, d_y, v_x, v_y, psi, psi_rate = _mesh_changes(system, mesh, row, z)
        add_pair_change(system, n, row, z, d_x, d_y, v_x, v_y, psi, psi_rate, force)
        return
    a, b = mesh.a, mesh.b
    turn_a, turn_b = z[theta_of(a)], z[theta_of(b)]
    psi = z[theta_of(mesh.driver)]
    if mesh.frame >= 0:
        psi -= z[theta_of(mesh.frame)]
    psi *= mesh.z_driver
    for flank in range(2):
        at, sign = FLANK + FLANK_SLOPES * flank, 1.0 - 2.0 * flank
        f = row[at + F]
        if f == 0.0:
            continue
        p, rate, turn_x, turn_y, by_frame = _flank_change(system, mesh, flank, row, z)
        grown = row[at + F_P] * p + row[at + F_R] * rate + row[at + F_PSI] * psi
        nu_x, nu_y = row[at + NU_X], row[at + NU_Y]
        f_x, f_y = -grown * nu_x - f * turn_x, -grown * nu_y - f * turn_y
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
        if mesh.friction > 0.0:
            add_friction_change(system, n, flank, row, turn_x, turn_y, grown, z, force)
        if mesh.frame >= 0:
            force[mesh.frame, 2] -= sign * grown * row[S_BY_FRAME] + f * by_frame
