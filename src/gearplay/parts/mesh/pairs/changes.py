"""Directional changes of the forces of pairs of teeth, of their overlaps and of the lead of an envelope (docs/theory, T23)."""

from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, omega_of, theta_of
from gearplay.parts.mesh.geometry import MESH
from gearplay.parts.mesh.pairs.friction import sliding_arms
from gearplay.parts.mesh.pairs.overlap import ON_FLANK, TIP_OF_1, TIP_OF_2, sense
from gearplay.parts.mesh.pairs.record import FLANKS
from gearplay.parts.mesh.pairs.slopes import (
    AA,
    AZ,
    BEND_1,
    BEND_2,
    BEND_12,
    BY_1,
    BY_2,
    BY_A,
    DEEPEST,
    DEV_1,
    DEV_2,
    E_1,
    E_2,
    EDGE,
    F_1,
    F_2,
    F_P,
    F_PSI,
    F_R,
    F_RATE_1,
    F_RATE_2,
    GRIP,
    GRIP_SLOPE,
    LEAN,
    LEAN_SLOPE,
    P_RATE,
    RATE_1,
    RATE_2,
    RHO,
    S_A,
    S_A_RATE,
    S_PHI_RATE,
    SUM_1,
    SUM_2,
    SUM_A,
    TIP,
    ZZ,
    F,
    column_of,
)
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
)


@compiled_inline
def _motion_change(
    system: System, mesh: Any, row: Floats, z: Floats, d_x: float, d_y: float, v_x: float, v_y: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return what a change z changes in A, phi, both gears' angles against the line of centres, and in their rates.

    The vector between the toothing centres changes by d, its rate by v.
    """
    e_x, e_y, dv_x, dv_y = row[S_E_X], row[S_E_Y], row[DV_X], row[DV_Y]
    along, across = d_x * e_x + d_y * e_y, -d_x * e_y + d_y * e_x
    phi = across / row[S_A]
    slide = -dv_x * e_y + dv_y * e_x
    distance_rate = v_x * e_x + v_y * e_y + slide * phi
    phi_rate = (-v_x * e_y + v_y * e_x - (dv_x * e_x + dv_y * e_y) * phi - row[S_PHI_RATE] * along) / row[S_A]
    first, second = (mesh.b, mesh.a) if mesh.s > 0.0 else (mesh.a, mesh.b)
    return (
        along,
        distance_rate,
        phi,
        phi_rate,
        z[theta_of(first)] - phi,
        z[theta_of(second)] - phi,
        z[omega_of(system, first)] - phi_rate,
        z[omega_of(system, second)] - phi_rate,
    )


@compiled_inline
def _pair_change(
    mesh: Any,
    row: Floats,
    at: int,
    flank: int,
    motion: tuple[float, float, float, float, float, float, float, float],
    psi: float,
    psi_rate: float,
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return what a motion changes in a pair: overlap and its rate, rho_1, its rate, rho_2, its rate, dp/dA and dp/dz."""
    m, error = sense(mesh, flank), 1.0 - 2.0 * flank
    A, A_rate, _, _, turn_1, turn_2, spin_1, spin_2 = motion
    turn_1, turn_2, spin_1, spin_2 = m * turn_1, m * turn_2, m * spin_1, m * spin_2
    swing = row[LEAN] * A
    swing_rate = row[LEAN] * A_rate + row[LEAN_SLOPE] * row[S_A_RATE] * A
    moved_1, moved_2 = mesh.base_1 * (turn_1 + swing), mesh.base_2 * (turn_2 + swing)
    faster_1, faster_2 = mesh.base_1 * (spin_1 + swing_rate), mesh.base_2 * (spin_2 + swing_rate)
    rate_1, rate_2 = error * row[RATE_1], error * row[RATE_2]  # the back flank's sense is the opposite one
    roll = row[LEAN] * row[S_A_RATE]
    p = row[at + BY_A] * A + row[at + BY_1] * turn_1 + row[at + BY_2] * turn_2 + error * row[E_1] * psi
    p -= row[at + DEV_1] * moved_1 + row[at + DEV_2] * moved_2
    z_turn, z_rate = (turn_1, rate_1) if row[at + TIP] == 1.0 else (turn_2, rate_2)
    by_a = row[at + AA] * A + row[at + AZ] * z_turn
    by_z = row[at + AZ] * A + row[at + ZZ] * z_turn
    rate = row[at + BY_A] * A_rate + row[at + BY_1] * spin_1 + row[at + BY_2] * spin_2
    rate += row[S_A_RATE] * by_a + z_rate * by_z
    rate += error * (row[E_1] * psi_rate + row[E_2] * row[S_PSI_RATE] * psi)
    rate -= row[at + DEV_1] * faster_1 + row[at + DEV_2] * faster_2
    rate -= row[at + BEND_1] * mesh.base_1 * (rate_1 + roll) * moved_1
    rate -= row[at + BEND_2] * mesh.base_2 * (rate_2 + roll) * moved_2
    cross = mesh.base_1 * (rate_1 + roll) * moved_2 + mesh.base_2 * (rate_2 + roll) * moved_1
    rate -= row[at + BEND_12] * cross
    return p, rate, moved_1, faster_1, moved_2, faster_2, by_a, by_z


@compiled_once
def pair_crossing(
    system: System,
    n: int,
    contact: int,
    row: Floats,
    z: Floats,
    d_x: float,
    d_y: float,
    v_x: float,
    v_y: float,
    psi: float,
    psi_rate: float,
) -> tuple[float, float, float]:
    """Return what a change z changes in the penetration of a contact of mesh n and in its rate, and that rate."""
    mesh = system.records[MESH][n]
    motion = _motion_change(system, mesh, row, z, d_x, d_y, v_x, v_y)
    if contact < FLANKS:
        flank, slot = contact, int(row[DEEPEST + contact])
    else:
        flank, slot = (contact - FLANKS) // mesh.pairs, (contact - FLANKS) % mesh.pairs
    at = column_of(mesh, flank, slot)
    p, rate = _penetration_change(mesh, row, at, flank, motion, psi, psi_rate)
    return p, rate, row[at + P_RATE]


@compiled_inline
def _penetration_change(
    mesh: Any,
    row: Floats,
    at: int,
    flank: int,
    motion: tuple[float, float, float, float, float, float, float, float],
    psi: float,
    psi_rate: float,
) -> tuple[float, float]:
    """Return what a motion changes in a pair's penetration and in its rate."""
    p, rate, moved_1, faster_1, _, _, _, _ = _pair_change(mesh, row, at, flank, motion, psi, psi_rate)
    if row[at + EDGE] != 0.0:
        return row[at + EDGE] * moved_1, row[at + EDGE] * faster_1
    return p, rate


@compiled_once
def lead_crossing(
    system: System,
    n: int,
    flank: int,
    row: Floats,
    z: Floats,
    d_x: float,
    d_y: float,
    v_x: float,
    v_y: float,
    psi: float,
    psi_rate: float,
) -> tuple[float, float, float]:
    """Return what a change z changes in the next pair's penetration over the lead's and in its rate, and that rate."""
    mesh = system.records[MESH][n]
    motion = _motion_change(system, mesh, row, z, d_x, d_y, v_x, v_y)
    lead, after = column_of(mesh, flank, 0), column_of(mesh, flank, 1)
    p_0, rate_0 = _penetration_change(mesh, row, lead, flank, motion, psi, psi_rate)
    p_1, rate_1 = _penetration_change(mesh, row, after, flank, motion, psi, psi_rate)
    return p_1 - p_0, rate_1 - rate_0, row[after + P_RATE] - row[lead + P_RATE]


@compiled_inline
def _friction_change(
    mesh: Any,
    row: Floats,
    at: int,
    flank: int,
    motion: tuple[float, float, float, float, float, float, float, float],
    direction: tuple[int, float, float, float, float, float],
    grown: float,
    moved_1: float,
) -> tuple[float, float, float]:
    """Return what a motion changes in the sums over A and both gears' angles by the friction of a pair.

    ``direction`` of its force has the part that touches, the slopes by A and both angles, what the motion changes in that by A
    and in that by the angle of the gear whose tip touches. Its normal force grows by ``grown``, its place by ``moved_1``.
    """
    m, s, A = sense(mesh, flank), mesh.s, row[S_A]
    touching, along, first, second, by_a, by_z = direction
    s_a, s_1, s_2 = sliding_arms(s, A, mesh.tip_1, mesh.tip_2, touching, along, first, second, row[at + RHO])
    ds_a = -along * by_a / s_a
    across = -motion[0] * along - A * by_a
    if touching == TIP_OF_2:
        ds_2 = -second * by_z / s_2
        ds_1 = across - ds_2
    else:
        ds_1 = -first * by_z / s_1 if touching == TIP_OF_1 else moved_1
        ds_2 = across - ds_1
    error = 1.0 - 2.0 * flank
    sliding = ds_a * row[S_A_RATE] + s_a * motion[1]
    sliding += error * (ds_1 * row[RATE_1] + ds_2 * row[RATE_2]) + m * (s_1 * motion[6] + s_2 * motion[7])
    grip = row[at + GRIP] * row[at + F]
    more = row[at + GRIP] * grown + row[at + GRIP_SLOPE] * row[at + F] * sliding
    return (
        more * s_a + grip * ds_a,
        m * (more * s_1 + grip * ds_1),
        m * (more * s_2 + grip * ds_2),
    )


@compiled_inline
def _direction(
    mesh: Any, row: Floats, at: int, distance: float, by_a: float, by_z: float
) -> tuple[int, float, float, float, float, float]:
    """Return the direction of a pair's force for `_friction_change`: that of its overlap, of an envelope that of the involutes.

    Its overlap's slopes change by ``by_a`` and ``by_z``, the distance of the centres by ``distance``.
    """
    if mesh.envelope == 1:
        s, A, c0 = mesh.s, row[S_A], mesh.c0
        sine = c0 / (A * A * row[LEAN])
        bend = s * c0 * c0 / (A * A * A * sine)
        return ON_FLANK, s * sine, mesh.base_1, -s * mesh.base_2, bend * distance, 0.0
    return int(row[at + TIP]), row[at + BY_A], row[at + BY_1], row[at + BY_2], by_a, by_z


@compiled_once
def add_pair_change(
    system: System,
    n: int,
    row: Floats,
    z: Floats,
    d_x: float,
    d_y: float,
    v_x: float,
    v_y: float,
    psi: float,
    psi_rate: float,
    force: Rows,
) -> None:
    """Add to ``force`` [rotor, (N, N, N m)] what a change z of the state changes in the forces of mesh n's pairs."""
    mesh = system.records[MESH][n]
    a, b = mesh.a, mesh.b
    motion = _motion_change(system, mesh, row, z, d_x, d_y, v_x, v_y)
    d_a, d_1, d_2 = 0.0, 0.0, 0.0
    for flank in range(FLANKS):
        m = sense(mesh, flank)
        for slot in range(1 if mesh.envelope == 1 else mesh.pairs):
            at = column_of(mesh, flank, slot)
            f = row[at + F]
            if f == 0.0:
                continue
            p, rate, moved_1, faster_1, moved_2, faster_2, by_a, by_z = _pair_change(
                mesh, row, at, flank, motion, psi, psi_rate
            )
            if mesh.envelope == 1 and row[at + EDGE] != 0.0:
                p, rate = row[at + EDGE] * moved_1, row[at + EDGE] * faster_1
            grown = (
                row[at + F_P] * p + row[at + F_R] * rate + row[at + F_1] * moved_1 + row[at + F_2] * moved_2
            )
            grown += row[at + F_PSI] * psi + row[at + F_RATE_1] * faster_1 + row[at + F_RATE_2] * faster_2
            direction = _direction(mesh, row, at, motion[0], by_a, by_z)
            touching, along, first, second, by_a, by_z = direction
            d_a += grown * along + f * by_a
            d_1 += m * (grown * first + (f * by_z if touching == TIP_OF_1 else 0.0))
            d_2 += m * (grown * second + (f * by_z if touching == TIP_OF_2 else 0.0))
            if row[at + GRIP] != 0.0 or row[at + GRIP_SLOPE] != 0.0:
                change = _friction_change(mesh, row, at, flank, motion, direction, grown, moved_1)
                d_a += change[0]
                d_1 += change[1]
                d_2 += change[2]
    e_x, e_y, A, phi = row[S_E_X], row[S_E_Y], row[S_A], motion[2]
    across = (row[SUM_1] + row[SUM_2]) / A
    d_along = -d_a - across * phi
    d_across = (d_1 + d_2) / A - across * motion[0] / A - row[SUM_A] * phi
    df_x, df_y = d_along * e_x - d_across * e_y, d_along * e_y + d_across * e_x
    f_x, f_y = -row[SUM_A] * e_x - across * e_y, -row[SUM_A] * e_y + across * e_x
    on_a, on_b = (-d_2, -d_1) if mesh.s > 0.0 else (-d_1, -d_2)
    la_x, la_y, lb_x, lb_y = row[LA_X], row[LA_Y], row[LB_X], row[LB_Y]
    force[b, 0] += df_x
    force[b, 1] += df_y
    force[b, 2] += on_b + lb_x * df_y - lb_y * df_x - z[theta_of(b)] * (lb_x * f_x + lb_y * f_y)
    force[a, 0] -= df_x
    force[a, 1] -= df_y
    force[a, 2] += on_a - (la_x * df_y - la_y * df_x) + z[theta_of(a)] * (la_x * f_x + la_y * f_y)
