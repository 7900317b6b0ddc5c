"""Gaps, forces and signals of a mesh, and the guaranteed time without contact in free motion."""

import math
from typing import Any

from gearplay.kernels.advancement import FAILS, RESOLUTION, STAYS_OPEN, TOUCHES, open_span, rotor_bounds
from gearplay.kernels.arrays import Floats, Ints, Rows
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
from gearplay.kernels.sample_block import place_rotor
from gearplay.parts.mesh.centre_bounds import centre_bounds, pull_of_centres
from gearplay.parts.mesh.flank import flank_force
from gearplay.parts.mesh.geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    B_T,
    BY_FRAME,
    COS_PSI,
    DISTANCE,
    DISTANCE_RATE,
    ERROR_RATE,
    G_RATE,
    MESH_PRINTED_COUPLED,
    N_B_X,
    N_B_Y,
    N_D_X,
    N_D_Y,
    OPENING,
    P_B,
    P_B_RATE,
    P_D,
    P_D_RATE,
    PAIRS_LOST,
    PAIRS_PUT_IN,
    PSI,
    PSI_RATE,
    ROLLED,
    SIN_PSI,
    SIN_W,
    SPEED_SQUARED,
    TURNED,
    fill_psi,
    follow_orbit,
    is_coupled,
    is_printed,
    mesh_gaps,
    mesh_geometry,
    mesh_phase,
    store_angles,
)
from gearplay.parts.mesh.law.friction import add_friction, fill_sliding, friction_loss
from gearplay.parts.mesh.law.record import BACK, DRIVE, KIND, SHOWN
from gearplay.parts.mesh.pairs.envelope import press_envelope
from gearplay.parts.mesh.pairs.forces import (
    add_pair_forces,
    deepest_overlaps,
    pairs_stay_open,
    press_pairs,
)
from gearplay.parts.mesh.pairs.record import SEGMENT
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness, stiffness_slope


@compiled_inline
def damping_rate(mesh: Any, flank: int, out: Floats) -> float:
    """Return the rate [m/s] that a flank's damping follows: as printed that of g alone, without the change of backlash."""
    if is_printed(mesh):
        return out[G_RATE] if flank == DRIVE else -out[G_RATE]
    return out[P_D_RATE + flank]


@compiled_inline
def press(system: System, n: int, mesh: Any, branch: Branch, loads: Loads, whole: bool) -> None:
    """Fill the rows of the contact table of mesh n and the sums over its pairs of teeth, `mesh_geometry` in the scratch.

    Unless ``whole`` the rows of open contacts have the force alone, which is 0.
    """
    if mesh.envelope == 1:
        press_envelope(system, n, branch, loads, whole)
    else:
        press_pairs(system, n, branch, loads, whole)


@compiled_inline
def contact_kinematics(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill mesh n's rows of the contact table at (t, y); return 1 where it cannot mesh."""
    return fill_contacts(system, n, t, y, branch, loads, True)


@compiled_inline
def fill_contacts(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, whole: bool
) -> int:
    """Fill mesh n's rows of the contact table at (t, y), of pairs of teeth as `press`; return 1 where it cannot mesh."""
    out, contacts, modes = loads.out, loads.contacts, branch.modes
    if mesh_geometry(system, n, t, y, branch.memory, out) != 0:
        return 1
    mesh = system.records[KIND][n]
    if mesh.pairs > 0:
        press(system, n, mesh, branch, loads, whole)
        return 0
    segment = modes[mesh.mode + SEGMENT]
    if mesh.error_count == 0:
        fill_psi(mesh, branch.memory, out)
    k_mesh = mesh_stiffness(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI], segment)
    printed = is_printed(mesh)
    for flank in range(2):
        row = mesh.contact + flank
        p, past = out[P_D + flank], modes[mesh.mode + flank]
        f, margin = flank_force(mesh, k_mesh, p, damping_rate(mesh, flank, out), past, flank)
        contacts[row, PENETRATION], contacts[row, RATE] = p, out[P_D_RATE + flank]
        contacts[row, MARGIN] = 1.0 if printed else margin
        contacts[row, FORCE] = f if modes[row] == LOADED else 0.0
    if mesh.friction > 0.0:
        fill_sliding(system, n, y, modes, loads)
    return 0


@compiled_inline
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add mesh n's flank forces to the sums on its rotors, rows of the contact table filled; 1 where it cannot mesh.

    Open contacts of pairs of teeth are left out (`Assembly.add`, deferred).
    Generalised forces are -F dp/dq exactly, equations (15), (20) with consistent signs.
    """
    if fill_contacts(system, n, t, y, branch, loads, False) != 0:
        return 1
    out, force = loads.out, loads.rotors
    mesh = system.records[KIND][n]
    if mesh.pairs > 0:
        add_pair_forces(system, n, loads)
        return 0
    f_d, f_b = loads.contacts[mesh.contact + DRIVE, FORCE], loads.contacts[mesh.contact + BACK, FORCE]
    if f_d == 0.0 and f_b == 0.0:
        return 0
    f_x, f_y = -f_d * out[N_D_X] - f_b * out[N_B_X], -f_d * out[N_D_Y] - f_b * out[N_B_Y]
    twist = -mesh.sigma * (f_d - f_b)
    a, b = mesh.a, mesh.b
    force[b, 0] += f_x
    force[b, 1] += f_y
    force[b, 2] += twist * mesh.rho_b + out[ARM_B_X] * f_y - out[ARM_B_Y] * f_x
    force[a, 0] -= f_x
    force[a, 1] -= f_y
    force[a, 2] += twist * mesh.rho_a - (out[ARM_A_X] * f_y - out[ARM_A_Y] * f_x)
    if mesh.friction > 0.0:
        add_friction(system, n, branch.modes, loads)
    if mesh.frame >= 0:  # a line of action that the carrier turns
        force[mesh.frame, 2] -= (f_d - f_b) * out[BY_FRAME]
    return 0


@compiled_once
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of both gaps of mesh n at (t, y), and a time [s], at most ``longest``, for which they provably stay open.

    The bound M adds roll, rotation of the line of centres, error of the teeth and opening of the flanks, each at its largest
    while the centre distance keeps to half its way to the ends of meshing.
    """
    follow_orbit(system, n, y, branch.memory)
    if mesh_geometry(system, n, t, y, branch.memory, out) != 0:
        return FAILS, 0.0
    mesh = system.records[KIND][n]
    if mesh.pairs > 0:
        return pairs_stay_open(system, n, t, y, branch, longest, out)
    if (out[P_D] >= 0.0 and out[P_D_RATE] > 0.0) or (out[P_B] >= 0.0 and out[P_B_RATE] > 0.0):
        return TOUCHES, 0.0
    A, c0 = out[DISTANCE], mesh.c0
    a_a, alpha_a, spin_a = rotor_bounds(system, mesh.a, t, y, branch)
    a_b, alpha_b, spin_b = rotor_bounds(system, mesh.b, t, y, branch)
    alpha_f, spin_f = 0.0, 0.0
    driver_is_a = mesh.driver == mesh.a
    psi_curvature = mesh.z_driver * (alpha_a if driver_is_a else alpha_b)
    if mesh.frame >= 0:
        _, alpha_f, spin_f = rotor_bounds(system, mesh.frame, t, y, branch)
        psi_curvature += mesh.z_driver * alpha_f
    roll = abs(mesh.rho_a) * alpha_a + abs(mesh.rho_b) * alpha_b
    rho = abs(mesh.rho_a + mesh.rho_b)
    speed, approach = math.sqrt(out[SPEED_SQUARED]), abs(out[DISTANCE_RATE])
    room = max(0.5 * min(A - mesh.A_min, mesh.A_max - A), 1e-9)
    slack = RESOLUTION * system.contacts[mesh.contact].natural
    over, best = longest, 0.0
    for _ in range(60):
        pull = pull_of_centres(mesh, a_a + a_b, alpha_a, spin_a, alpha_b, spin_b, over)
        fastest, distance_curvature, fastest_approach, way = centre_bounds(pull, speed, approach, A, over)
        if way > room:
            over *= max(0.1, 0.5 * room / way)
            continue
        nearest, farthest = max(A - way, c0), A + way
        psi_most = abs(out[PSI_RATE]) + psi_curvature * over
        curvature = roll + mesh.error_curvature * psi_most * psi_most + mesh.error_slope * psi_curvature
        if is_coupled(mesh):
            curvature += rho * (pull / nearest + 2.0 * fastest_approach * fastest / (nearest * nearest))
        else:
            curvature += pull
            if mesh.frame >= 0:  # n.D + roll in the frame: n turns with the carrier
                spin = spin_f + alpha_f * over
                curvature += rho * alpha_f + 2.0 * spin * fastest + farthest * (spin * spin + alpha_f)
        widening = 1.0 if is_coupled(mesh) else 2.0 if mesh.kind == MESH_PRINTED_COUPLED else 0.0
        if widening > 0.0:
            sine = math.sqrt(max(nearest * nearest - c0 * c0, 1e-30)) / nearest
            sine_most = math.sqrt(farthest * farthest - c0 * c0) / farthest
            curving = c0 * c0 / (nearest * nearest * nearest * sine)
            curvature += widening * (
                sine_most * distance_curvature + curving * fastest_approach * fastest_approach
            )
        span = min(
            open_span(min(out[P_D], 0.0) - slack, out[P_D_RATE], curvature),
            open_span(min(out[P_B], 0.0) - slack, out[P_B_RATE], curvature),
        )
        if span >= over:
            return STAYS_OPEN, over
        narrower = max(math.sqrt(over * span), span)
        done = best > 0.0 and span < 1.5 * best
        best = max(best, span)
        if done or narrower > 0.5 * over:
            break
        over = narrower
    return STAYS_OPEN, best


@compiled_inline
def start_step(system: System, n: int, t: float, y: Floats, branch: Branch) -> None:
    """Store mesh n's angles at (t, y), from which those of the stages differ little."""
    store_angles(system, n, t, y, branch.memory, False)


@compiled_inline
def end_step(system: System, n: int, y: Floats, branch: Branch) -> None:
    """Update the line of action of a gear that moves around its partner."""
    follow_orbit(system, n, y, branch.memory)


@compiled_inline
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] with which stiffness and errors of mesh n force it."""
    mesh = system.records[KIND][n]
    _, rate = mesh_phase(mesh, system, t, y)
    return abs(rate) * mesh.highest_order


@compiled_once
def mesh_powers(system: System, n: int, y: Floats, branch: Branch, loads: Loads) -> tuple[float, float]:
    """Return the powers [W] that mesh n loses, and that errors and varying stiffness of its teeth put in.

    Its rows of the contact table and the scratch are filled. With k p^2 / 2 stored in a flank that touches, F p' is that and what
    damping takes; the rotors give F (p' - e') of it.
    """
    mesh, out, modes = system.records[KIND][n], loads.out, branch.modes
    if mesh.pairs > 0:
        press(system, n, mesh, branch, loads, False)
        return out[PAIRS_LOST], out[PAIRS_PUT_IN]
    fill_psi(mesh, branch.memory, out)
    k_mesh = mesh_stiffness(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI], modes[mesh.mode + SEGMENT])
    k_slope = stiffness_slope(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI])
    lost, put_in = 0.0, 0.0
    for flank in range(2):
        if modes[mesh.contact + flank] == OPEN:
            continue
        p, force = out[P_D + flank], loads.contacts[mesh.contact + flank, FORCE]
        lost += (force - k_mesh * p) * out[P_D_RATE + flank]
        put_in += force * (1.0 - 2.0 * flank) * out[ERROR_RATE] + 0.5 * k_slope * out[PSI_RATE] * p * p
    if mesh.friction > 0.0:
        lost += friction_loss(mesh, loads)
    return lost, put_in


@compiled_inline
def overlaps(system: System, n: int, out: Floats) -> tuple[float, float]:
    """Return the penetrations [m] of both flanks of mesh n, its gaps found: of pairs of teeth those of the deepest ones."""
    if system.records[KIND][n].pairs > 0:
        return deepest_overlaps(system, n, out)
    return out[P_D], out[P_B]


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill mesh n's signals of a full ``row``; where it acts its rows of the contact table are of (t, y).

    A flank force never pulls, but as printed: what it is just before a located release is cut at zero.
    """
    mesh = system.records[KIND][n]
    out, modes = loads.out, branch.modes
    at, k = mesh.signal, mesh.contact
    whole = acting and mesh_geometry(system, n, t, y, branch.memory, out) == 0
    if not whole and mesh_gaps(system, n, t, y, branch.memory, out) != 0:
        for column in range(SHOWN):
            row[at + column] = math.nan
        return
    row[at], row[at + 1] = overlaps(system, n, out)
    row[at + 2], row[at + 3] = 0.0, 0.0
    if acting:
        for flank in range(2):
            force = loads.contacts[k + flank, FORCE]
            row[at + 2 + flank] = force if is_printed(mesh) else max(force, 0.0)
    row[at + 4], row[at + 5] = out[B_T], pressure_angle(mesh, out)
    row[at + 6], row[at + 7] = out[DISTANCE], out[ROLLED]
    row[at + 9], row[at + 10] = 0.0, 0.0
    if whole:
        row[at + 9], row[at + 10] = mesh_powers(system, n, y, branch, loads)
    row[at + 8] = contact_state(modes, k)


@compiled_inline
def pressure_angle(mesh: Any, out: Floats) -> float:
    """Return the working pressure angle [rad], its gaps found: its tangent less its involute."""
    return float(out[SIN_W] * out[DISTANCE] / mesh.c0 - (mesh.inv_alpha0 + out[OPENING] / mesh.c0))


@compiled_inline
def contact_state(modes: Ints, k: int) -> float:
    """Return 1 for a touching drive flank plus 2 for a touching back flank, of the contacts k and k + 1."""
    return (1.0 if modes[k + DRIVE] != OPEN else 0.0) + (2.0 if modes[k + BACK] != OPEN else 0.0)


@compiled_once
def show_free(
    system: System, n: int, times: Floats, count: int, free_states: Rows, y: Floats, branch: Branch, angles: Rows, out: Floats,
    shown: Rows,
) -> bool:  # fmt: skip
    """Fill mesh n's signals in a block of free motion, ``angles`` the memory of these evaluations; return True."""
    mesh = system.records[KIND][n]
    a, b, frame, e = mesh.a, mesh.b, mesh.frame, mesh.element
    state = contact_state(branch.modes, mesh.contact)
    for k in range(TURNED, TURNED + 3):
        angles[e, k] = branch.memory[e, k]
    for s in range(count):
        t = times[s]
        place_rotor(system, a, free_states, s, y)
        place_rotor(system, b, free_states, s, y)
        if frame >= 0:
            place_rotor(system, frame, free_states, s, y)
        store_angles(system, n, t, y, angles, True)
        if mesh_gaps(system, n, t, y, angles, out) != 0:
            for k in range(SHOWN):
                shown[k, s] = math.nan
            continue
        shown[0, s], shown[1, s] = overlaps(system, n, out)
        shown[2, s], shown[3, s] = 0.0, 0.0
        shown[4, s], shown[5, s], shown[6, s] = out[B_T], pressure_angle(mesh, out), out[DISTANCE]
        shown[7, s], shown[8, s], shown[9, s], shown[10, s] = out[ROLLED], state, 0.0, 0.0
    return True
