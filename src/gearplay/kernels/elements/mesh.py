"""A mesh: two gears, external or internal, whose drive and back flanks are one-sided contacts (docs/theory, section 2).

Two contacts, drive then back. Each flank has a switch of its own, the end of its damping ramp; a square wave of stiffness adds
one for the mesh, its next edge. Gears on a carrier roll in its frame.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.advancement import FAILS, RESOLUTION, STAYS_OPEN, TOUCHES, open_span, rotor_bounds
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.flank import RAMP_SMOOTH, flank_force, flank_slopes
from gearplay.kernels.layout import (
    FORCE,
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    PLACES,
    PULL,
    RATE,
    Branch,
    Loads,
    Signal,
    System,
    omega_of,
    spin_of,
    theta_of,
    vx_of,
    vy_of,
    x_of,
    y_of,
)
from gearplay.kernels.mesh_geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    B_T,
    BY_FRAME,
    COS_PSI,
    DISTANCE,
    DISTANCE_RATE,
    E_X,
    E_Y,
    FRESH,
    G_RATE,
    INV_A,
    MESH,
    MESH_PRINTED_COUPLED,
    N_B_X,
    N_B_Y,
    N_D_X,
    N_D_Y,
    P_B,
    P_B_RATE,
    P_D,
    P_D_RATE,
    PSI,
    PSI_RATE,
    ROLLED,
    SIN_PSI,
    SIN_W,
    SPEED_SQUARED,
    is_coupled,
    is_printed,
    mesh_gaps,
    mesh_geometry,
    mesh_phase,
)
from gearplay.kernels.tooth_stiffness import (
    STIFFNESS_SQUARE,
    harmonic_bends,
    harmonics,
    mesh_stiffness,
    square_edge,
    square_segment,
    stiffness_slope,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

KIND = MESH
RECORD = np.dtype(
    [
        *PLACES,
        ("rho_a", "f8"),  # m, signed base (or pitch) radii, docs/conventions
        ("rho_b", "f8"),
        ("c0", "f8"),  # m, sum or difference of the base radii
        ("A0", "f8"),  # m, distance of the nominal centres as placed
        ("opening0", "f8"),  # m, s c0 (inv alpha - inv alpha0) as placed: 0 at the nominal distance
        ("u0_x", "f8"),  # nominal direction from a to b
        ("u0_y", "f8"),
        ("sin_alpha0", "f8"),  # of the working pressure angle as placed
        ("cos_alpha0", "f8"),
        ("A_nominal_squared", "f8"),  # m^2
        ("inv_A_nominal_squared", "f8"),  # 1/m^2
        ("u_series", "f8"),  # largest |(A/A0)^2 - 1| of the involute series
        ("inv_alpha0", "f8"),  # of the reference pressure angle
        ("sigma", "f8"),  # +1/-1, sense of the drive flank
        ("s", "f8"),  # +1 internal, -1 external
        ("backlash", "f8"),  # m, total, normal, at the nominal centre distance
        ("A_min", "f8"),  # m, smallest and largest centre distance that meshes
        ("A_max", "f8"),
        ("z_driver", "f8"),
        ("k_m", "f8"),  # N/m
        ("k_single", "f8"),  # N/m, square wave
        ("duty", "f8"),  # share of the mesh period with k_m in a square wave
        ("phase", "f8"),  # rad, of the square wave or spline
        ("C_m", "f8"),  # N s/m
        ("depth", "f8"),  # m
        ("inv_depth", "f8"),  # 1/m
        ("highest_order", "f8"),  # of stiffness and transmission error
        ("error_slope", "f8"),  # m, largest |de/dpsi| and |d2e/dpsi2| of the transmission error
        ("error_bend", "f8"),
        ("a", "i8"),  # rotor at the foot of the vector of centres
        ("b", "i8"),  # rotor at its tip
        ("driver", "i8"),
        ("frame", "i8"),  # carrier rotor that turns the nominal direction, -1 for none
        ("kind", "i8"),
        ("stiffness_kind", "i8"),
        ("ramp", "i8"),
        ("stiffness_start", "i8"),  # rows in System.terms or System.spline
        ("stiffness_count", "i8"),
        ("error_start", "i8"),
        ("error_count", "i8"),
    ],
    align=True,
)
_DEGREES = 180.0 / math.pi
SIGNALS = (
    Signal("drive_penetration", "p_d", "m", "um", 1e6, "penetration of the drive flanks", True),
    Signal("back_penetration", "p_b", "m", "um", 1e6, "penetration of the back flanks", True),
    Signal("drive_force", "F_d", "N", "N", 1.0, "normal force of the drive flanks"),
    Signal("back_force", "F_b", "N", "N", 1.0, "normal force of the back flanks"),
    Signal("backlash", "b_t", "m", "um", 1e6, "total normal backlash", True),
    Signal("working_pressure_angle", "alpha_w", "rad", "deg", _DEGREES, "working pressure angle"),
    Signal("center_distance", "A", "m", "mm", 1e3, "centre distance", True),
    Signal(
        "transmission_error_dynamic",
        "DTE",
        "m",
        "um",
        1e6,
        "dynamic transmission error along the line of action",
        True,
    ),
    Signal("contact_state", "state", "1", "1", 1.0, "contact state of the mesh"),
)
SHOWN = len(SIGNALS)
MEMORY = FRESH
PER_CONTACT = 3  # switches: touch, pull, end of the damping ramp

# Modes of its own: 1 for each flank beyond the damping ramp, then the half-waves passed by a square wave.
DRIVE, BACK = 0, 1
SEGMENT = 2
MODES = 3
# Switches: of each flank touch, pull and the ramp's end; then the edge of the square wave.
EDGE = 2 * PER_CONTACT


@compiled_inline
def _damping_rate(mesh: Any, flank: int, out: Floats) -> float:
    """Return the rate [m/s] that a flank's damping follows: as printed that of g alone, without the change of backlash."""
    if is_printed(mesh):
        return out[G_RATE] if flank == DRIVE else -out[G_RATE]
    return out[P_D_RATE + flank]


@compiled_inline
def press(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill mesh n's two rows of the contact table at (t, y); return 1 where it cannot mesh."""
    out, contacts, modes = loads.out, loads.contacts, branch.modes
    if mesh_geometry(system, n, t, y, branch.memory, out) != 0:
        return 1
    mesh = system.records[KIND][n]
    segment = modes[mesh.mode + SEGMENT]
    k_mesh = mesh_stiffness(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI], segment)
    printed = is_printed(mesh)
    for flank in range(2):
        row = mesh.contact + flank
        p, past = out[P_D + flank], modes[mesh.mode + flank]
        f, margin = flank_force(mesh, k_mesh, p, _damping_rate(mesh, flank, out), past, flank)
        contacts[row, PENETRATION], contacts[row, RATE] = p, out[P_D_RATE + flank]
        contacts[row, MARGIN] = 1.0 if printed else margin
        contacts[row, FORCE] = f if modes[row] == LOADED else 0.0
    return 0


@compiled_inline
def act(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats) -> int:
    """Add mesh n's flank forces to the sums on its rotors, its rows of the contact table filled; 1 where it cannot mesh.

    Generalised forces are -F dp/dq exactly, equations (15), (20) with consistent signs.
    """
    if press(system, n, t, y, branch, loads) != 0:
        return 1
    out, force = loads.out, loads.rotors
    mesh = system.records[KIND][n]
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
    if mesh.frame >= 0:  # a line of action that the carrier turns
        force[mesh.frame, 2] -= (f_d - f_b) * out[BY_FRAME]
    return 0


@compiled_inline
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return what both gaps of mesh n do at (t, y), and for how long [s] they surely stay open (at most ``longest``).

    The bound M adds roll, swing of the line of centres, error of the teeth and opening of the flanks, each at its largest
    while the centre distance keeps to half its way to the ends of meshing.
    """
    if mesh_geometry(system, n, t, y, branch.memory, out) != 0:
        return FAILS, 0.0
    mesh = system.records[KIND][n]
    if (out[P_D] >= 0.0 and out[P_D_RATE] > 0.0) or (out[P_B] >= 0.0 and out[P_B_RATE] > 0.0):
        return TOUCHES, 0.0
    A, c0 = out[DISTANCE], mesh.c0
    a_a, alpha_a, spin_a = rotor_bounds(system, mesh.a, y)
    a_b, alpha_b, spin_b = rotor_bounds(system, mesh.b, y)
    alpha_f, spin_f = 0.0, 0.0
    driver_is_a = mesh.driver == mesh.a
    psi_bend = mesh.z_driver * (alpha_a if driver_is_a else alpha_b)
    if mesh.frame >= 0:
        _, alpha_f, spin_f = rotor_bounds(system, mesh.frame, y)
        psi_bend += mesh.z_driver * alpha_f
    ecc_a, ecc_b = system.rotors[mesh.a].eccentricity, system.rotors[mesh.b].eccentricity
    roll = abs(mesh.rho_a) * alpha_a + abs(mesh.rho_b) * alpha_b
    rho = abs(mesh.rho_a + mesh.rho_b)
    speed, approach = math.sqrt(out[SPEED_SQUARED]), abs(out[DISTANCE_RATE])
    room = max(0.5 * min(A - mesh.A_min, mesh.A_max - A), 1e-9)
    slack = RESOLUTION * system.contacts[mesh.contact].natural
    over, best = longest, 0.0
    for _ in range(60):
        spin_a_most, spin_b_most = spin_a + alpha_a * over, spin_b + alpha_b * over
        pull = (
            a_a
            + a_b
            + ecc_a * (spin_a_most * spin_a_most + alpha_a)
            + ecc_b * (spin_b_most * spin_b_most + alpha_b)
        )
        fastest = speed + pull * over
        # |A'| <= |A'(0)| + |A''| tau with |A''| <= pull + v^2 / A
        distance_bend = pull + 2.0 * fastest * fastest / A
        fastest_approach = min(fastest, approach + distance_bend * over)
        way = (approach + 0.5 * distance_bend * over) * over
        if way > room:
            over *= max(0.1, 0.5 * room / way)
            continue
        nearest, farthest = max(A - way, c0), A + way
        psi_most = abs(out[PSI_RATE]) + psi_bend * over
        bend = roll + mesh.error_bend * psi_most * psi_most + mesh.error_slope * psi_bend
        if is_coupled(mesh):
            bend += rho * (pull / nearest + 2.0 * fastest_approach * fastest / (nearest * nearest))
        else:
            bend += pull
            if mesh.frame >= 0:  # n.D + roll in the frame: n turns with the carrier
                spin = spin_f + alpha_f * over
                bend += rho * alpha_f + 2.0 * spin * fastest + farthest * (spin * spin + alpha_f)
        widening = 1.0 if is_coupled(mesh) else 2.0 if mesh.kind == MESH_PRINTED_COUPLED else 0.0
        if widening > 0.0:
            sine = math.sqrt(max(nearest * nearest - c0 * c0, 1e-30)) / nearest
            sine_most = math.sqrt(farthest * farthest - c0 * c0) / farthest
            curving = c0 * c0 / (nearest * nearest * nearest * sine)
            bend += widening * (sine_most * distance_bend + curving * fastest_approach * fastest_approach)
        span = min(
            open_span(min(out[P_D], 0.0) - slack, out[P_D_RATE], bend),
            open_span(min(out[P_B], 0.0) - slack, out[P_B_RATE], bend),
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
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] with which stiffness and errors of mesh n force it."""
    mesh = system.records[KIND][n]
    _, rate = mesh_phase(mesh, system, t, y)
    return abs(rate) * mesh.highest_order


@compiled_inline
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return the end of a flank's ramp [m] or the edge of the square wave [rad] as a switch function."""
    modes = branch.modes
    mesh = system.records[KIND][n]
    if s == EDGE:
        psi, _ = mesh_phase(mesh, system, t, y)
        segment = modes[mesh.mode + SEGMENT]
        return max(psi - square_edge(mesh, segment + 1), square_edge(mesh, segment) - psi)
    flank = s // PER_CONTACT
    if mesh.C_m == 0.0 or modes[mesh.contact + flank] == OPEN:
        return -1.0
    beyond = loads.contacts[mesh.contact + flank, PENETRATION] - mesh.depth
    return beyond if modes[mesh.mode + flank] == 0 else -beyond


@compiled
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch) -> None:
    """Pass the end of a flank's ramp or the edge of the square wave."""
    modes = branch.modes
    mesh = system.records[KIND][n]
    if s == EDGE:
        psi, _ = mesh_phase(mesh, system, t, y)
        slot = mesh.mode + SEGMENT
        middle = 0.5 * (square_edge(mesh, modes[slot]) + square_edge(mesh, modes[slot] + 1))
        modes[slot] += 1 if psi > middle else -1
        return
    slot = mesh.mode + s // PER_CONTACT
    modes[slot] = 1 - modes[slot]


@compiled
def _settle_segment(system: System, n: int, t: float, y: Floats, modes: Ints) -> None:
    """Set the segment of mesh n's square wave from the state; while the mesh is open nobody counts segments."""
    mesh = system.records[KIND][n]
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        psi, _ = mesh_phase(mesh, system, t, y)
        modes[mesh.mode + SEGMENT] = square_segment(mesh, psi)


@compiled
def settle(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set mesh n's own modes from the state alone, its rows of the contact table filled."""
    mesh = system.records[KIND][n]
    depth = mesh.depth
    for flank in range(2):
        past = loads.contacts[mesh.contact + flank, PENETRATION] > depth
        branch.modes[mesh.mode + flank] = 1 if past else 0
    _settle_segment(system, n, t, y, branch.modes)


@compiled
def settle_touch(system: System, n: int, k: int, t: float, y: Floats, branch: Branch) -> None:
    """Set what the touch of contact k begins with: its ramp, and the segment if the mesh was open."""
    mesh = system.records[KIND][n]
    modes = branch.modes
    flank = k - mesh.contact
    modes[mesh.mode + flank] = 0
    if modes[mesh.contact + 1 - flank] == OPEN:
        _settle_segment(system, n, t, y, modes)


@compiled_inline
def _ramp_weight(u: float) -> float:
    """Return u (3 - 2 u) of the damping ramp's factor, 0 below its start; it is largest at u = 3/4."""
    return max(u * (3.0 - 2.0 * u), 0.0)


@compiled_inline
def _may_change_pull(mesh: Any, k: int, mode: int, start: Floats, end: Floats) -> bool:
    """Return whether flank contact k, on one mode at both ends of a step, may have let go, or taken hold, in between.

    On the smooth ramp F / p = K - (C / d) u (3 - 2u) |dp/dt|, u = p / d, whose one minimum lies at u = 3/4.
    """
    c = mesh.C_m * mesh.inv_depth
    fastest, slowest = max(-start[k, RATE], -end[k, RATE]), min(-start[k, RATE], -end[k, RATE])
    if mode == LOADED and fastest <= 0.0:
        return False
    u_0, u_1 = start[k, PENETRATION] * mesh.inv_depth, end[k, PENETRATION] * mesh.inv_depth
    # Stiffnesses at both ends, with a half to spare for what changes between them.
    k_0 = start[k, MARGIN] - c * _ramp_weight(u_0) * start[k, RATE]
    k_1 = end[k, MARGIN] - c * _ramp_weight(u_1) * end[k, RATE]
    if mode != LOADED:
        return 1.5 * max(k_0, k_1) > c * slowest * min(_ramp_weight(u_0), _ramp_weight(u_1))
    deepest, slightest = min(max(u_0, u_1), 0.75), max(min(u_0, u_1), 0.0)
    if slightest > 0.75:
        deepest = slightest
    return 0.5 * min(k_0, k_1) < c * fastest * _ramp_weight(deepest)


@compiled_inline
def _phase_bend(system: System, mesh: Any, stages: Floats) -> float:
    """Return the largest |psi''| [rad/s^2] at the stages of a step."""
    most = 0.0
    for stage in range(stages.shape[0]):
        alpha = stages[stage, omega_of(system, mesh.driver)]
        if mesh.frame >= 0:
            alpha -= stages[stage, omega_of(system, mesh.frame)]
        most = max(most, abs(alpha))
    return mesh.z_driver * most


@compiled_inline
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Floats,
) -> bool:  # fmt: skip
    """Return whether switch s of mesh n, not positive at both ends of a step of h [s], may be so in between."""
    modes, start, end = branch.modes, loads_0.contacts, loads.contacts
    mesh = system.records[KIND][n]
    at = mesh.switch + s
    if (
        s == EDGE
    ):  # a function with |g''| <= M rises by at most M h^2 / 8 above its ends; twice that, as M is of the stages
        return max(g_0[at], g_1[at]) + 0.25 * h * h * _phase_bend(system, mesh, stages) > 0.0
    flank, role = s // PER_CONTACT, s % PER_CONTACT
    k = mesh.contact + flank
    if modes[k] == OPEN:
        return False
    past = modes[mesh.mode + flank]
    if role == PULL:
        smooth = mesh.ramp == RAMP_SMOOTH and past == 0
        return smooth and g_0[at] < 0.0 and _may_change_pull(mesh, k, modes[k], start, end)
    sign = 1.0 if past == 0 else -1.0
    rising, falling = sign * start[k, RATE], -sign * end[k, RATE]
    return rising > 0.0 and falling > 0.0 and g_0[at] + rising * h > 0.0 and g_1[at] + falling * h > 0.0


@compiled
def jump(system: System, n: int, before: Ints, modes: Ints) -> int:
    """Return the switch at which mesh n's force has just jumped, by its modes before and now; -1 for none."""
    mesh = system.records[KIND][n]
    k, found = mesh.contact, -1
    if is_printed(mesh):
        for flank in range(2):
            if (before[k + flank] == OPEN) != (modes[k + flank] == OPEN) and found < 0:
                found = PER_CONTACT * flank
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        slot, closed = mesh.mode + SEGMENT, before[k + DRIVE] != OPEN or before[k + BACK] != OPEN
        if closed and before[slot] != modes[slot]:
            found = EDGE
    return found


# Columns of a mesh's row of slopes. Arms, direction of the line of centres, relative velocity of the toothing centres:
LA_X, LA_Y, LB_X, LB_Y, S_E_X, S_E_Y, DV_X, DV_Y, SPIN_A, SPIN_B, S_PSI_RATE = range(11)
# curvatures of the opening along and across, and of the roll; error by the phase;
BEND_E, BEND_N, BEND_MIXED, WIDEN, ERROR_1, ERROR_2 = range(11, 17)
# of a carrier that turns a fixed line of action: dg/dtheta, its spin, n.D with D the vector of centres;
S_BY_FRAME, SPIN_F, ALONG = range(17, 20)
# and for each flank: direction, rate, force, and the force's derivatives by penetration, rate and phase.
FLANK = 20
NU_X, NU_Y, P_RATE, F, F_P, F_R, F_PSI = range(7)
FLANK_SLOPES = 7
SLOPES = FLANK + 2 * FLANK_SLOPES


@compiled
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill mesh n's row of slopes at (t, y), the exact derivative of `act` on fixed modes; return 1 where it cannot mesh.

    A flank's penetration p has the gradient D on the coordinates q of its rotors; its force F acts along -D. So
    dQ = -D dF - F dD, with dD from the second derivatives of p (docs/theory, T18).
    """
    if press(system, n, t, y, branch, loads) != 0:
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
    cos_psi, sin_psi = out[COS_PSI], out[SIN_PSI]
    _, _, row[ERROR_1] = harmonics(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    _, row[ERROR_2] = harmonic_bends(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
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
            rate = _damping_rate(mesh, flank, out)
            row[at + F_P], row[at + F_R] = flank_slopes(mesh, k_mesh, p, rate, past, flank)
            row[at + F_PSI] = k_slope * p
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
def _bend_of(row: Floats, sign: float, d_x: float, d_y: float) -> tuple[float, float]:
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
    bend_x, bend_y = _bend_of(row, sign, d_x, d_y)
    turned, spun, by_frame = 0.0, 0.0, 0.0
    if mesh.frame >= 0 and not is_coupled(mesh):
        turned, spun = z[theta_of(mesh.frame)], z[omega_of(system, mesh.frame)]
        bend_x, bend_y = bend_x - nu_y * turned, bend_y + nu_x * turned
        by_frame = nu_x * d_y - nu_y * d_x - sign * row[ALONG] * turned
    roll = mesh.rho_a * z[theta_of(a)] + mesh.rho_b * z[theta_of(b)]
    roll_rate = mesh.rho_a * z[omega_of(system, a)] + mesh.rho_b * z[omega_of(system, b)]
    p = sign * (mesh.sigma * roll + row[ERROR_1] * psi + row[S_BY_FRAME] * turned) + nu_x * d_x + nu_y * d_y
    if flank == BACK:
        p -= row[WIDEN] * (d_x * row[S_E_X] + d_y * row[S_E_Y])
    rate = sign * (mesh.sigma * roll_rate + row[ERROR_1] * psi_rate + row[ERROR_2] * row[S_PSI_RATE] * psi)
    rate += nu_x * v_x + nu_y * v_y + bend_x * row[DV_X] + bend_y * row[DV_Y]
    rate += sign * row[S_BY_FRAME] * spun + row[SPIN_F] * by_frame
    return p, rate, bend_x, bend_y, by_frame


@compiled
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return what a change z changes in switch function s of mesh n and in its rate, and that rate."""
    mesh = system.records[KIND][n]
    if s == EDGE:
        _, _, _, _, psi, psi_rate = _mesh_changes(system, mesh, row, z)
        return psi, psi_rate, row[S_PSI_RATE]
    flank = s // PER_CONTACT
    p, rate, _, _, _ = _flank_change(system, mesh, flank, row, z)
    return p, rate, row[FLANK + FLANK_SLOPES * flank + P_RATE]


@compiled
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Floats, dz: Floats
) -> None:
    """Add to ``force`` [rotor, (N, N, N m)] what a change z of the state changes in mesh n's forces."""
    mesh = system.records[KIND][n]
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
        p, rate, bend_x, bend_y, by_frame = _flank_change(system, mesh, flank, row, z)
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
        if mesh.frame >= 0:
            force[mesh.frame, 2] -= sign * grown * row[S_BY_FRAME] + f * by_frame


@compiled_inline
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill mesh n's signals of a full ``row``; where it acts its rows of the contact table are of (t, y).

    A flank force never pulls: the last ulp before a located release is cut at zero. contact_state counts 1 for a
    touching drive flank and 2 for a touching back flank.
    """
    mesh = system.records[KIND][n]
    out, modes = loads.out, branch.modes
    at, k = mesh.signal, mesh.contact
    if mesh_gaps(system, n, t, y, branch.memory, out) != 0:
        for column in range(SHOWN):
            row[at + column] = math.nan
        return
    row[at], row[at + 1], row[at + 2], row[at + 3] = out[P_D], out[P_B], 0.0, 0.0
    if acting:
        for flank in range(2):
            force = loads.contacts[k + flank, FORCE]
            row[at + 2 + flank] = 0.0 if force < 0.0 and out[P_D + flank] < 1e-15 else force
    row[at + 4], row[at + 5] = out[B_T], math.asin(out[SIN_W])
    row[at + 6], row[at + 7] = out[DISTANCE], out[ROLLED]
    row[at + 8] = (1.0 if modes[k + DRIVE] != OPEN else 0.0) + (2.0 if modes[k + BACK] != OPEN else 0.0)
