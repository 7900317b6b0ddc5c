"""Exact slopes of the forces of pairs of teeth (docs/theory, T23); `pairs.changes` has their directional changes."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    PENETRATION,
    Branch,
    Loads,
    System,
)
from gearplay.parts.mesh.flank import ON_RAMP, flank_damping, flank_slopes
from gearplay.parts.mesh.geometry import (
    COS_PSI,
    DISTANCE,
    DISTANCE_RATE,
    MESH,
    PHI_RATE,
    PSI,
    PULL_1,
    PULL_2,
    PULL_A,
    SIN_PSI,
    SIN_W,
    fill_psi,
)
from gearplay.parts.mesh.pairs.envelope import deepest_slot, lead_of
from gearplay.parts.mesh.pairs.forces import fading, first_pair, oblique_sums
from gearplay.parts.mesh.pairs.friction import SLIDING, grip_of
from gearplay.parts.mesh.pairs.overlap import (
    AWAY,
    TIP_OF_1,
    TIP_OF_2,
    Pair,
    overlap_rate,
    pair_overlap,
    pair_stiffness,
    penetration_rate,
    turn_rates,
)
from gearplay.parts.mesh.pairs.record import FLANKS, SEGMENT
from gearplay.parts.mesh.slope_columns import (
    SHARED,
)
from gearplay.parts.mesh.tooth_stiffness import (
    harmonic_curvatures,
    harmonics,
    mesh_stiffness,
    stiffness_slope,
)

# Columns of a mesh's row of slopes behind those of `gearplay.parts.mesh.slope_columns`: distance of the centres, its rate, rate
# of the line of centres, d(alpha_w)/dA and its slope by A, slope and curvature of the error of the teeth by the phase;
S_A, S_A_RATE, S_PHI_RATE, LEAN, LEAN_SLOPE, E_1, E_2 = range(SHARED, SHARED + 7)
# sums over the pairs; rates of both gears against the line of centres in the drive flank's sense; deepest pair of each flank;
SUM_A, SUM_1, SUM_2, RATE_1, RATE_2, DEEPEST, DEEPEST_BACK = range(SHARED + 7, SHARED + 14)
# then for each pair, with an envelope for the lead and the next of each flank: force, its slopes by overlap, rate, both places
# and the mesh phase, the fields of `overlap.Pair`, friction over normal force and its slope by the sliding speed [s/m]; of
# oblique lines of contact the force's slopes by the rates of both places.
PAIRS = SHARED + 14
(
    F, F_P, F_R, F_1, F_2, F_PSI, BY_A, BY_1, BY_2, AA, AZ, ZZ, TIP, DEV_1, DEV_2, BEND_1, BEND_2, EDGE, P_RATE, RHO, GRIP,
    GRIP_SLOPE, BEND_12, F_RATE_1, F_RATE_2,
) = range(25)  # fmt: skip
COLUMNS = 25
LEADING = 2
"""Pairs of each flank that an envelope stores."""


@compiled_inline
def column_of(mesh: Any, flank: int, at: int) -> int:
    """Return the first column of pair ``at`` of a flank: its slot, with an envelope 0 for the lead, 1 for the next."""
    stored = LEADING if mesh.envelope == 1 else mesh.pairs
    return int(PAIRS + COLUMNS * (flank * stored + at))


@compiled_inline
def _store(row: Floats, at: int, pair: Pair) -> None:
    row[at + BY_A], row[at + BY_1], row[at + BY_2] = pair.by_a, pair.p_1, pair.p_2
    row[at + AA], row[at + AZ], row[at + ZZ] = pair.bend_aa, pair.bend_az, pair.bend_zz
    row[at + TIP] = 1.0 if pair.touching == TIP_OF_1 else 2.0 if pair.touching == TIP_OF_2 else 0.0
    row[at + DEV_1], row[at + DEV_2] = pair.by_1, pair.by_2
    row[at + BEND_1], row[at + BEND_2], row[at + EDGE] = pair.dev_1, pair.dev_2, pair.edge
    row[at + RHO], row[at + BEND_12] = pair.rho_1, pair.dev_12
    for column in (F, F_P, F_R, F_1, F_2, F_PSI, GRIP, GRIP_SLOPE, F_RATE_1, F_RATE_2):
        row[at + column] = 0.0


@compiled_inline
def _store_oblique(
    mesh: Any,
    system: System,
    row: Floats,
    at: int,
    flank: int,
    pair: Pair,
    rates: tuple[float, float, float, float],
) -> None:
    """Fill the slopes of the force of an oblique line of contact, of its deepest point's penetration as everywhere.

    ``rates`` of `overlap_rate`. F = J + c M, c = C(p) / K_max, J and M integrals of `oblique.sums_over_line` by P = p + min d.
    """
    rate, worn, rate_1, rate_2 = rates
    sums = oblique_sums(mesh, system, flank, pair, rate, worn, rate_1, rate_2)
    steeper, damping = flank_slopes(mesh, 0.0, pair.p, sums.rate / mesh.stiffest, ON_RAMP, 0)
    c = damping / mesh.stiffest
    by_overlap, by_rate = sums.stiffness + c * sums.rate_p, c * sums.stiffness
    row[at + F_P], row[at + F_R] = by_overlap + steeper, by_rate
    row[at + F_1] = sums.force_1 + c * sums.rate_1 + by_overlap * pair.by_1
    row[at + F_1] += by_rate * (pair.dev_1 * rate_1 + pair.dev_12 * rate_2)
    row[at + F_2] = sums.force_2 + c * sums.rate_2 + by_overlap * pair.by_2
    row[at + F_2] += by_rate * (pair.dev_12 * rate_1 + pair.dev_2 * rate_2)
    row[at + F_RATE_1] = c * sums.rate_by_1 + by_rate * pair.by_1
    row[at + F_RATE_2] = c * sums.rate_by_2 + by_rate * pair.by_2


@compiled_once
def linearise_pairs(system: System, n: int, branch: Branch, loads: Loads, row: Floats) -> None:
    """Fill what mesh n's row of slopes has of its pairs, their rows of the contact table and the sums filled.

    Of a mesh with an envelope all but its pairs.
    """
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
    if mesh.envelope == 1:
        return
    for flank in range(FLANKS):
        deepest = -math.inf
        for slot in range(mesh.pairs):
            k = first_pair(mesh, flank) + slot
            at = column_of(mesh, flank, slot)
            pair = pair_overlap(mesh, system, out, flank, slot)
            rates = overlap_rate(mesh, out, flank, pair)
            rate = rates[0]
            _store(row, at, pair)
            row[at + P_RATE] = penetration_rate(pair, rate, rates[2])
            row[at + F] = loads.contacts[k, FORCE]
            if row[at + F] != 0.0 and pair.touching != AWAY:
                if mesh.varies == 1:
                    _store_oblique(mesh, system, row, at, flank, pair, rates)
                else:
                    stiffness, k_1, k_2 = pair_stiffness(mesh, system, flank, pair)
                    share = fading(mesh, stiffness)
                    row[at + F_P], by_rate = flank_slopes(mesh, stiffness, pair.p, share * rate, ON_RAMP, 0)
                    row[at + F_R] = share * by_rate
                    by_k = pair.p
                    if mesh.fades == 1:
                        by_k += flank_damping(mesh, pair.p, ON_RAMP, 0) * rate / mesh.stiffest
                    row[at + F_1], row[at + F_2] = k_1 * by_k, k_2 * by_k
                if mesh.friction > 0.0 and row[at + F] > 0.0:
                    row[at + GRIP], row[at + GRIP_SLOPE] = grip_of(mesh, loads.contacts[k, SLIDING])
            if loads.contacts[k, PENETRATION] > deepest:
                deepest = loads.contacts[k, PENETRATION]
                row[DEEPEST + flank] = slot


@compiled_once
def linearise_envelope(system: System, n: int, branch: Branch, loads: Loads, row: Floats) -> None:
    """Fill what mesh n's row of slopes has of its flanks' leads and the pairs that follow them; the rest is filled."""
    mesh, out = system.records[MESH][n], loads.out
    fill_psi(mesh, branch.memory, out)
    segment = branch.modes[mesh.mode + SEGMENT]
    k_mesh = mesh_stiffness(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI], segment)
    k_slope = stiffness_slope(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI])
    for flank in range(FLANKS):
        k, lead = mesh.contact + flank, lead_of(mesh, system, out, flank, branch)
        row[DEEPEST + flank] = 0.0
        for place in range(LEADING):
            slot = lead if place == 0 else deepest_slot(mesh, system, out, flank, lead)[0]
            at = column_of(mesh, flank, place)
            pair = pair_overlap(mesh, system, out, flank, slot)
            rate, _, rate_1, _ = overlap_rate(mesh, out, flank, pair)
            _store(row, at, pair)
            row[at + P_RATE] = moving = penetration_rate(pair, rate, rate_1)
            force = loads.contacts[k, FORCE]
            if place == 1 or force == 0.0:
                continue
            row[at + F] = force
            past = branch.modes[mesh.mode + flank]
            row[at + F_P], row[at + F_R] = flank_slopes(mesh, k_mesh, pair.penetration, moving, past, flank)
            row[at + F_PSI] = k_slope * pair.penetration
            if mesh.friction > 0.0 and force > 0.0:
                row[at + GRIP], row[at + GRIP_SLOPE] = grip_of(mesh, loads.contacts[k, SLIDING])
