"""Forces of the pairs of teeth of a mesh, their powers, and the time for which they stay apart in free motion.

F_j = K_j p_j + C_j dp_j/dt of each pair, cut at zero; generalised forces are -F_j dp_j/dq, deviations aside (docs/teeth).
"""

import math
from typing import Any

from gearplay.kernels.advancement import PASSES, RESOLUTION, STAYS_OPEN, TOUCHES, open_span, rotor_bounds
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    RATE,
    Branch,
    Loads,
    System,
)
from gearplay.parts.mesh.centre_bounds import centre_bounds, pull_of_centres
from gearplay.parts.mesh.flank import ON_RAMP, flank_force
from gearplay.parts.mesh.geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    DISTANCE,
    DISTANCE_RATE,
    E_X,
    E_Y,
    ERROR_RATE,
    INV_A,
    MESH,
    PAIRS_LOST,
    PAIRS_PUT_IN,
    PHI_RATE,
    PSI_RATE,
    PULL_1,
    PULL_2,
    PULL_A,
    SPEED_SQUARED,
    SPIN_1,
    SPIN_2,
)
from gearplay.parts.mesh.pairs.friction import SLIDING, arms_of, grip_of, sliding_of
from gearplay.parts.mesh.pairs.oblique import (
    Sums,
    line_of_contact,
    oblique_force,
    oblique_powers,
    sums_over_line,
)
from gearplay.parts.mesh.pairs.overlap import (
    AWAY,
    STEEP,
    TIP_OF_1,
    TIP_OF_2,
    Pair,
    flank_rows,
    overlap_rate,
    pair_overlap,
    pair_stiffness,
    penetration_rate,
    sense,
)
from gearplay.parts.mesh.pairs.record import FLANKS


@compiled_inline
def first_pair(mesh: Any, flank: int) -> int:
    """Return the row of the contact table of a flank's first slot."""
    return int(mesh.contact + FLANKS + flank * mesh.pairs)


@compiled_inline
def fading(mesh: Any, stiffness: float) -> float:
    """Return the share of the damping that a pair has: of oblique lines of contact that of its stiffness in the largest."""
    return stiffness / mesh.stiffest if mesh.fades == 1 else 1.0


@compiled_inline
def oblique_sums(
    mesh: Any, system: System, flank: int, pair: Pair, rate: float, worn: float, rate_1: float, rate_2: float
) -> Sums:
    """Return the sums over the line of contact of a helical pair, its rates those of `overlap_rate`."""
    at_1, at_2 = flank_rows(mesh, flank, pair.number)
    line = line_of_contact(mesh, pair.rho_1, pair.rho_2, pair.place, at_1, at_2)
    return sums_over_line(mesh, system, line, pair.p, rate + worn, rate_1, rate_2)


@compiled_inline
def pair_force(
    mesh: Any, system: System, flank: int, pair: Pair, rate: float
) -> tuple[float, float, float, float, float]:
    """Return the force K p + C dp/dt [N] of a pair and its margin, its stiffness [N/m] and the slopes by both places.

    Of deviations that do not vary along an oblique line of contact.
    """
    stiffness, k_1, k_2 = pair_stiffness(mesh, system, flank, pair)
    force, margin = flank_force(mesh, stiffness, pair.p, fading(mesh, stiffness) * rate, ON_RAMP, 0)
    return force, margin, stiffness, k_1, k_2


@compiled_once
def press_pairs(system: System, n: int, branch: Branch, loads: Loads, whole: bool) -> None:
    """Fill mesh n's rows of the contact table and the sums over its pairs, `mesh_geometry` in the scratch.

    Unless ``whole`` open pairs have their force alone.
    """
    mesh, out, contacts, modes = system.records[MESH][n], loads.out, loads.contacts, branch.modes
    pull_a, pull_1, pull_2, lost, put_in = 0.0, 0.0, 0.0, 0.0, 0.0
    for flank in range(FLANKS):
        m, total, deepest, its_rate = sense(mesh, flank), 0.0, -math.inf, 0.0
        error_rate = out[ERROR_RATE] if flank == 0 else -out[ERROR_RATE]
        for slot in range(mesh.pairs):
            k = first_pair(mesh, flank) + slot
            if modes[k] == OPEN and not whole:
                contacts[k, FORCE] = 0.0
                continue
            pair = pair_overlap(mesh, system, out, flank, slot)
            rate, worn, rate_1, rate_2 = overlap_rate(mesh, out, flank, pair)
            moving = penetration_rate(pair, rate, rate_1)
            contacts[k, PENETRATION], contacts[k, RATE] = pair.penetration, moving
            contacts[k, MARGIN], contacts[k, FORCE], contacts[k, SLIDING] = 1.0, 0.0, 0.0
            if pair.touching != AWAY:
                p = pair.p
                if mesh.varies == 1:
                    sums = oblique_sums(mesh, system, flank, pair, rate, worn, rate_1, rate_2)
                    force, margin = oblique_force(mesh, p, sums)
                    pressed = modes[k] == LOADED
                    lose, put = oblique_powers(mesh, p, sums, pressed, force * error_rate)
                else:
                    force, margin, stiffness, k_1, k_2 = pair_force(mesh, system, flank, pair, rate)
                    acts = force if modes[k] == LOADED else 0.0
                    lose = (acts - stiffness * p) * rate
                    put = acts * (error_rate - worn) + 0.5 * (k_1 * rate_1 + k_2 * rate_2) * p * p
                contacts[k, MARGIN] = margin
                if mesh.friction > 0.0:
                    contacts[k, SLIDING] = sliding_of(mesh, out, flank, pair)
                if modes[k] == LOADED:
                    contacts[k, FORCE] = force
                    total += force
                    pull_a += force * pair.by_a
                    pull_1 += m * force * pair.p_1
                    pull_2 += m * force * pair.p_2
                if modes[k] != OPEN:
                    force = contacts[k, FORCE]
                    lost += lose
                    put_in += put
                    if mesh.friction > 0.0 and force > 0.0:
                        s_a, s_1, s_2 = arms_of(mesh, out, pair)
                        grip = force * grip_of(mesh, contacts[k, SLIDING])[0]
                        pull_a += grip * s_a
                        pull_1 += m * grip * s_1
                        pull_2 += m * grip * s_2
                        lost += grip * contacts[k, SLIDING]
            if pair.penetration > deepest:
                deepest, its_rate = pair.penetration, moving
        k = mesh.contact + flank
        contacts[k, FORCE] = total
        if deepest > -math.inf:
            contacts[k, PENETRATION], contacts[k, RATE] = deepest, its_rate
            contacts[k, MARGIN], contacts[k, SLIDING] = 1.0, 0.0
    out[PULL_A], out[PULL_1], out[PULL_2] = pull_a, pull_1, pull_2
    out[PAIRS_LOST], out[PAIRS_PUT_IN] = lost, put_in


@compiled_inline
def add_pair_forces(system: System, n: int, loads: Loads) -> None:
    """Add the sums over mesh n's pairs to the forces on its rotors."""
    mesh, out, force = system.records[MESH][n], loads.out, loads.rotors
    a, b = mesh.a, mesh.b
    along, across = -out[PULL_A], (out[PULL_1] + out[PULL_2]) * out[INV_A]
    f_x, f_y = along * out[E_X] - across * out[E_Y], along * out[E_Y] + across * out[E_X]
    on_a, on_b = (-out[PULL_2], -out[PULL_1]) if mesh.s > 0.0 else (-out[PULL_1], -out[PULL_2])
    force[b, 0] += f_x
    force[b, 1] += f_y
    force[b, 2] += on_b + out[ARM_B_X] * f_y - out[ARM_B_Y] * f_x
    force[a, 0] -= f_x
    force[a, 1] -= f_y
    force[a, 2] += on_a - (out[ARM_A_X] * f_y - out[ARM_A_Y] * f_x)


@compiled_once
def deepest_overlaps(system: System, n: int, out: Floats) -> tuple[float, float]:
    """Return the largest penetration [m] of the pairs of either flank of mesh n, `mesh_gaps` in the scratch."""
    mesh = system.records[MESH][n]
    drive, back = -math.inf, -math.inf
    for slot in range(mesh.pairs):
        drive = max(drive, pair_overlap(mesh, system, out, 0, slot).penetration)
        back = max(back, pair_overlap(mesh, system, out, 1, slot).penetration)
    return drive, back


@compiled_inline
def kink_distance(mesh: Any, pair: Pair) -> float:
    """Return the way of a pair [m] to the nearest place at which a deviation begins to be held: a tip, or an end of the path."""
    way = min(abs(pair.rho_1 - mesh.tip_length_1), abs(pair.rho_2 - mesh.tip_length_2))
    way = min(way, abs(pair.rho_1 - mesh.low_1), abs(pair.rho_1 - mesh.high_1))
    way = min(way, abs(pair.rho_2 - mesh.low_2), abs(pair.rho_2 - mesh.high_2))
    if mesh.varies == 1:
        at = pair.place
        way = min(way, abs(at + mesh.oblique - mesh.path_start), abs(at - mesh.oblique - mesh.path_end))
    return way


@compiled_once
def pairs_stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of the gaps of mesh n's pairs, and a time [s] for which all provably stay open.

    `mesh_geometry` has filled the scratch.

    Each overlap follows p(A, a_1, a_2): p'' is bounded by the bounds of the accelerations and the second derivatives of p. Where
    a relief begins p' falls. At the tips and the ends of the path, where deviations are held, p' may rise by their slope times
    the rolling speed: it counts from the start for a pair that comes so far. The involutes' overlap bounds that of a pair from
    above where its tip leaves or enters the path. A pair that is away comes no nearer than a quarter of a base pitch in the time
    considered.
    """
    mesh = system.records[MESH][n]
    a_a, alpha_a, spin_a = rotor_bounds(system, mesh.a, t, y, branch)
    a_b, alpha_b, spin_b = rotor_bounds(system, mesh.b, t, y, branch)
    alpha_1, alpha_2 = (alpha_b, alpha_a) if mesh.s > 0.0 else (alpha_a, alpha_b)
    psi_curvature = mesh.z_driver * (alpha_a if mesh.driver == mesh.a else alpha_b)
    if mesh.frame >= 0:
        _, alpha_f, _ = rotor_bounds(system, mesh.frame, t, y, branch)
        psi_curvature += mesh.z_driver * alpha_f
    A, c0 = out[DISTANCE], mesh.c0
    speed, approach = math.sqrt(out[SPEED_SQUARED]), abs(out[DISTANCE_RATE])
    turn_1, turn_2 = abs(out[SPIN_1] - out[PHI_RATE]), abs(out[SPIN_2] - out[PHI_RATE])
    room = max(0.5 * min(A - mesh.A_min, mesh.A_max - A), 1e-9)
    slack = RESOLUTION * system.contacts[mesh.contact].natural
    over, best, looked = longest, 0.0, 0
    for _ in range(40):
        pull = pull_of_centres(mesh, a_a + a_b, alpha_a, spin_a, alpha_b, spin_b, over)
        fastest, distance_curvature, approach_most, way = centre_bounds(pull, speed, approach, A, over)
        if way > room:
            over *= max(0.1, 0.5 * room / way)
            continue
        nearest, farthest = max(A - way, c0), A + way
        swing = (pull + 2.0 * approach_most * fastest / nearest) / nearest  # |phi''|
        most_1, most_2 = turn_1 + (alpha_1 + swing) * over, turn_2 + (alpha_2 + swing) * over
        sine = math.sqrt(max(nearest * nearest - c0 * c0, 1e-30)) / nearest
        leaning = c0 / (nearest * nearest * sine)  # d(alpha_w)/dA
        bend = c0 * c0 / (nearest * nearest * nearest * sine)
        rolling = max(
            mesh.base_1 * (most_1 + leaning * approach_most), mesh.base_2 * (most_2 + leaning * approach_most)
        )
        if rolling * over > 0.25 * mesh.base_pitch:
            over = 0.2 * mesh.base_pitch / rolling
            continue
        leaning_curvature = (
            leaning * distance_curvature
            + 3.0 * leaning / (nearest * sine * sine) * approach_most * approach_most
        )
        rolling_curvature = max(mesh.base_1 * (alpha_1 + swing), mesh.base_2 * (alpha_2 + swing))
        rolling_curvature += max(mesh.base_1, mesh.base_2) * leaning_curvature
        worn = 2.0 * (mesh.deviation_curvature * rolling * rolling + mesh.deviation_slope * rolling_curvature)
        sine_most = math.sqrt(farthest * farthest - c0 * c0) / farthest
        rolled = mesh.base_1 * alpha_1 + mesh.base_2 * alpha_2 + c0 * swing
        smooth = rolled + sine_most * distance_curvature + bend * approach_most * approach_most + worn
        psi_most = abs(out[PSI_RATE]) + psi_curvature * over
        smooth += mesh.error_curvature * psi_most * psi_most + mesh.error_slope * psi_curvature
        span = over
        for flank in range(FLANKS):
            for slot in range(mesh.pairs):
                pair = pair_overlap(mesh, system, out, flank, slot)
                if pair.touching == AWAY:
                    continue
                rate, _, rate_1, _ = overlap_rate(mesh, out, flank, pair)
                p, rate, curvature = pair.penetration, penetration_rate(pair, rate, rate_1), smooth
                if pair.edge != 0.0:
                    curvature = max(smooth, STEEP * rolling_curvature)
                if looked == 0 and p >= 0.0 and rate > 0.0:
                    return TOUCHES, 0.0
                if pair.edge == 0.0 and kink_distance(mesh, pair) <= rolling * over:
                    rate += mesh.deviation_slope * rolling
                if pair.touching == TIP_OF_1 or pair.touching == TIP_OF_2:
                    tip, turn, alpha = mesh.tip_1, most_1, alpha_1
                    other_base, other_alpha = mesh.base_2, alpha_2
                    if pair.touching == TIP_OF_2:
                        tip, turn, alpha = mesh.tip_2, most_2, alpha_2
                        other_base, other_alpha = mesh.base_1, alpha_1
                    passing = approach_most + tip * turn
                    if passing * over > 0.5 * pair.length:
                        span = min(span, 0.5 * pair.length / passing)
                    bowed = (
                        tip * alpha + other_base * other_alpha + farthest * swing + distance_curvature + worn
                    )
                    bowed += 2.0 * passing * passing / pair.length + tip * turn * turn
                    curvature = max(curvature, bowed)
                span = min(span, open_span(min(p, 0.0) - slack, rate, curvature))
        if span >= over:
            return STAYS_OPEN, over
        best = max(best, span)
        looked += 1
        if looked >= PASSES or span > 0.5 * over:
            break
        over = max(math.sqrt(over * span), span)
    return STAYS_OPEN, best
