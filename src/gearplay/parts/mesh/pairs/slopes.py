"""Exact slopes of the forces of pairs of teeth and their directional changes (docs/theory, T23)."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    PENETRATION,
    Branch,
    Loads,
    System,
    omega_of,
    theta_of,
)
from gearplay.parts.mesh.flank import ON_RAMP, flank_damping, flank_slopes
from gearplay.parts.mesh.geometry import (
    COS_PSI,
    DISTANCE,
    DISTANCE_RATE,
    MESH,
    PHI_RATE,
    PULL_1,
    PULL_2,
    PULL_A,
    SIN_PSI,
    SIN_W,
    fill_psi,
)
from gearplay.parts.mesh.pairs.forces import fading, first_pair
from gearplay.parts.mesh.pairs.overlap import (
    AWAY,
    TIP_OF_1,
    TIP_OF_2,
    Pair,
    overlap_rate,
    pair_overlap,
    pair_stiffness,
    penetration_rate,
    sense,
    turn_rates,
)
from gearplay.parts.mesh.pairs.record import FLANKS, MOST
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
    SHARED,
)
from gearplay.parts.mesh.tooth_stiffness import harmonic_curvatures, harmonics

# Columns of a mesh's row of slopes behind those of `gearplay.parts.mesh.slope_columns`: distance of the centres, its rate, rate
# of the line of centres, d(alpha_w)/dA and its slope by A, slope and curvature of the error of the teeth by the phase;
S_A, S_A_RATE, S_PHI_RATE, LEAN, LEAN_SLOPE, E_1, E_2 = range(SHARED, SHARED + 7)
# sums over the pairs; rates of both gears against the line of centres in the drive flank's sense; deepest pair of each flank;
SUM_A, SUM_1, SUM_2, RATE_1, RATE_2, DEEPEST, DEEPEST_BACK = range(SHARED + 7, SHARED + 14)
# then for each pair: force, its slopes by overlap, rate and both places, and the fields of `overlap.Pair`.
PAIRS = SHARED + 14
(
    F, F_P, F_R, F_1, F_2, BY_A, BY_1, BY_2, AA, AZ, ZZ, TIP, DEV_1, DEV_2, BEND_1, BEND_2, EDGE, P_RATE
) = range(18)  # fmt: skip
COLUMNS = 18
PAIR_SLOPES = PAIRS + COLUMNS * FLANKS * MOST


@compiled_inline
def _store(row: Floats, at: int, pair: Pair) -> None:
    row[at + BY_A], row[at + BY_1], row[at + BY_2] = pair.by_a, pair.p_1, pair.p_2
    row[at + AA], row[at + AZ], row[at + ZZ] = pair.bend_aa, pair.bend_az, pair.bend_zz
    row[at + TIP] = 1.0 if pair.touching == TIP_OF_1 else 2.0 if pair.touching == TIP_OF_2 else 0.0
    row[at + DEV_1], row[at + DEV_2] = pair.by_1, pair.by_2
    row[at + BEND_1], row[at + BEND_2], row[at + EDGE] = pair.dev_1, pair.dev_2, pair.edge


@compiled_once
def linearise_pairs(system: System, n: int, branch: Branch, loads: Loads, row: Floats) -> None:
    """Fill what mesh n's row of slopes has of its pairs, their rows of the contact table and the sums filled."""
    mesh, out = system.records[MESH][n], loads.out
    A, sine = out[DISTANCE], out[SIN_W]
    row[S_A], row[S_A_RATE], row[S_PHI_RATE] = A, out[DISTANCE_RATE], out[PHI_RATE]
    row[LEAN] = mesh.c0 / (A * A * sine)
    row[LEAN_SLOPE] = -mesh.c0 * (2.0 * A * A - mesh.c0 * mesh.c0) / (A**5 * sine**3)
    row[E_1] = row[E_2] = 0.0
    if mesh.error_count > 0:
        fill_psi(mesh, branch.memory, out)
        cosine, sine_psi = out[COS_PSI], out[SIN_PSI]
        _, _, row[E_1] = harmonics(system.terms, mesh.error_start, mesh.error_count, cosine, sine_psi)
        _, row[E_2] = harmonic_curvatures(system.terms, mesh.error_start, mesh.error_count, cosine, sine_psi)
    row[SUM_A], row[SUM_1], row[SUM_2] = out[PULL_A], out[PULL_1], out[PULL_2]
    row[RATE_1], row[RATE_2], _ = turn_rates(mesh, out, 0)
    for flank in range(FLANKS):
        deepest = -math.inf
        for slot in range(mesh.pairs):
            k = first_pair(mesh, flank) + slot
            at = PAIRS + COLUMNS * (flank * mesh.pairs + slot)
            pair = pair_overlap(mesh, system, out, flank, slot)
            rate, _, rate_1, _ = overlap_rate(mesh, out, flank, pair)
            _store(row, at, pair)
            row[at + P_RATE] = penetration_rate(pair, rate, rate_1)
            row[at + F] = loads.contacts[k, FORCE]
            row[at + F_P] = row[at + F_R] = row[at + F_1] = row[at + F_2] = 0.0
            if row[at + F] != 0.0 and pair.touching != AWAY:
                stiffness, k_1, k_2 = pair_stiffness(mesh, system, flank, pair)
                share = fading(mesh, stiffness)
                row[at + F_P], by_rate = flank_slopes(mesh, stiffness, pair.p, share * rate, ON_RAMP, 0)
                row[at + F_R] = share * by_rate
                by_k = pair.p
                if mesh.fades == 1:
                    by_k += flank_damping(mesh, pair.p, ON_RAMP, 0) * rate / mesh.stiffest
                row[at + F_1], row[at + F_2] = k_1 * by_k, k_2 * by_k
            if loads.contacts[k, PENETRATION] > deepest:
                deepest = loads.contacts[k, PENETRATION]
                row[DEEPEST + flank] = slot


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
) -> tuple[float, float, float, float, float, float, float]:
    """Return what a motion changes in a pair: overlap and its rate, rho_1, its rate and rho_2, dp/dA and dp/dz."""
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
    return p, rate, moved_1, faster_1, moved_2, by_a, by_z


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
    at = PAIRS + COLUMNS * (flank * mesh.pairs + slot)
    p, rate, moved_1, faster_1, _, _, _ = _pair_change(mesh, row, at, flank, motion, psi, psi_rate)
    if row[at + EDGE] != 0.0:
        p, rate = row[at + EDGE] * moved_1, row[at + EDGE] * faster_1
    return p, rate, row[at + P_RATE]


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
        for slot in range(mesh.pairs):
            at = PAIRS + COLUMNS * (flank * mesh.pairs + slot)
            f = row[at + F]
            if f == 0.0:
                continue
            p, rate, moved_1, _, moved_2, by_a, by_z = _pair_change(
                mesh, row, at, flank, motion, psi, psi_rate
            )
            grown = (
                row[at + F_P] * p + row[at + F_R] * rate + row[at + F_1] * moved_1 + row[at + F_2] * moved_2
            )
            d_a += grown * row[at + BY_A] + f * by_a
            d_1 += m * (grown * row[at + BY_1] + (f * by_z if row[at + TIP] == 1.0 else 0.0))
            d_2 += m * (grown * row[at + BY_2] + (f * by_z if row[at + TIP] == 2.0 else 0.0))
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
