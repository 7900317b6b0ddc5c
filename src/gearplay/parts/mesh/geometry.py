"""Kinematics of one gear mesh: phase, toothing centres, penetrations of both flanks, their rates and directions."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.carrier_motion import carried
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, omega_of, spin_of, theta_of, turn_of, vx_of, vy_of, x_of, y_of
from gearplay.parts.mesh.involute import involute_difference
from gearplay.parts.mesh.tooth_stiffness import harmonics

MESH = 2  # place of its records in `layout.System`
MESH_COUPLED, MESH_UNCOUPLED, MESH_PRINTED_COUPLED, MESH_PRINTED_UNCOUPLED = 0, 1, 2, 3

# Slots of the scratch ``out``. Of both flanks: penetration [m], its rate [m/s], its gradient by the displacement of b;
P_D, P_B, P_D_RATE, P_B_RATE, N_D_X, N_D_Y, N_B_X, N_B_Y = range(8)
# centre distance A [m], sin(alpha_w), b_t [m], w - e [m], psi [rad], its rate, lever arms of both toothing centres [m];
DISTANCE, SIN_W, B_T, ROLLED, PSI, PSI_RATE, ARM_A_X, ARM_A_Y, ARM_B_X, ARM_B_Y = range(8, 18)
# dg/dt [m/s] of a fixed line of action, cos and sin of psi, direction of the line of centres, dA/dt, de/dt [m/s];
G_RATE, COS_PSI, SIN_PSI, E_X, E_Y, DISTANCE_RATE, ERROR_RATE = range(18, 25)
# speed squared of the toothing centre of b against that of a, 1/A, dg/dtheta [m] of the carrier that turns a fixed line, opening
# c0 (inv(alpha_w) - inv(alpha_0)) [m].
SPEED_SQUARED, INV_A, BY_FRAME, OPENING = range(25, 29)
# Behind `kernels.carrier_motion`'s, of pairs of teeth: rotation of the line of centres from its nominal direction [rad], its rate
# and the absolute speeds of the first (external) and the second gear [rad/s]; sums over the pairs,
# `gearplay.parts.mesh.pairs.forces`.
PHI, PHI_RATE, SPIN_1, SPIN_2, PULL_A, PULL_1, PULL_2, PAIRS_LOST, PAIRS_PUT_IN = range(32, 41)

# Slots of a mesh's memory, each the first of an (angle, cosine, sine): toothings of a and b, psi; how far the reference of
# phi has followed an orbiting gear.
KNOWN_A, KNOWN_B, KNOWN_PSI, TURNED = 0, 3, 6, 9
FRESH = (math.inf,) * 9 + (0.0, 1.0, 0.0)  # memory without stored angles

NEARBY = 0.03  # rad, within which the series of `nearby_angle` is exact to rounding
GRID, PER_GRID = 0.05, 20.0  # rad, grid of angles for samples in free motion, and points per radian


@compiled_inline
def is_coupled(mesh: Any) -> bool:
    """Return whether the lines of action follow the actual centres; else one fixed line serves both flanks."""
    return bool(mesh.kind == MESH_COUPLED)


@compiled_inline
def is_printed(mesh: Any) -> bool:
    """Return whether a mesh follows the article's equations as printed."""
    return bool(mesh.kind == MESH_PRINTED_COUPLED or mesh.kind == MESH_PRINTED_UNCOUPLED)


@compiled_inline
def nearby_angle(angle: float, known: Floats, e: int, slot: int) -> tuple[float, float]:
    """Return cos, sin of an angle [rad], from a known one if that is near: ``slot`` of row e of ``known`` and the next two.

    A stage of a step turns each angle by far less than ``NEARBY``; half the time of a right-hand side went into sines.
    """
    d = angle - known[e, slot]
    if not abs(d) < NEARBY:
        return math.cos(angle), math.sin(angle)
    q = d * d
    sine = d * (1.0 - q * (1 / 6 - q * (1 / 120 - q * (1 / 5040))))
    cosine = 1.0 - q * (0.5 - q * (1 / 24 - q * (1 / 720 - q * (1 / 40320))))
    c, s = known[e, slot + 1], known[e, slot + 2]
    return c * cosine - s * sine, s * cosine + c * sine


@compiled_inline
def store_angle(angle: float, known: Floats, e: int, slot: int) -> None:
    """Note an angle [rad] with its cosine and sine, for `nearby_angle`."""
    known[e, slot], known[e, slot + 1], known[e, slot + 2] = angle, math.cos(angle), math.sin(angle)


@compiled_inline
def toothing_angle(rotor: Any, t: float, theta: float, phase: float) -> float:
    """Return the angle [rad] of a toothing's eccentricity at relative rotation theta [rad]; ``phase`` is that at no rotation."""
    return float(rotor.nominal_speed * t + theta + phase)


@compiled_inline
def toothing_arm(runout: float, angle: float, known: Floats, e: int, slot: int) -> tuple[float, float]:
    """Return the vector [m] from a rotor's shaft to the centre of a toothing, its eccentricity at an angle [rad]."""
    if runout == 0.0:
        return 0.0, 0.0
    cosine, sine = nearby_angle(angle, known, e, slot)
    return runout * cosine, runout * sine


@compiled_inline
def mesh_phase(mesh: Any, system: System, t: float, y: Floats) -> tuple[float, float]:
    """Return the mesh phase psi [rad] and its rate [rad/s]: psi_0 + z theta of the driver relative to its carrier."""
    d = mesh.driver
    omega = system.rotors[d].nominal_speed
    angle, rate = y[theta_of(d)], y[omega_of(system, d)]
    if mesh.frame >= 0:
        omega -= system.rotors[mesh.frame].nominal_speed
        angle -= y[theta_of(mesh.frame)]
        rate -= y[omega_of(system, mesh.frame)]
    return mesh.z_driver * (omega * t + angle) + mesh.psi_0, mesh.z_driver * (omega + rate)


@compiled_inline
def update_angle(angle: float, known: Floats, e: int, slot: int, on_grid: bool) -> None:
    """Store the angle as `store_angle` does, or the nearest one of a grid, so that the result is independent of earlier calls."""
    if on_grid:
        angle = GRID * math.floor(angle * PER_GRID + 0.5)
    if not on_grid or known[e, slot] != angle:
        store_angle(angle, known, e, slot)


@compiled_inline
def store_angles(system: System, n: int, t: float, y: Floats, memory: Floats, on_grid: bool) -> None:
    """Note those of mesh n's angles at (t, y) that count, or the nearest of a grid, with their sines for `nearby_angle`."""
    mesh = system.records[MESH][n]
    a, b, e = mesh.a, mesh.b, mesh.element
    if mesh.runout_a != 0.0:
        angle = toothing_angle(system.rotors[a], t, y[theta_of(a)], mesh.runout_phase_a)
        update_angle(angle, memory, e, KNOWN_A, on_grid)
    if mesh.runout_b != 0.0:
        angle = toothing_angle(system.rotors[b], t, y[theta_of(b)], mesh.runout_phase_b)
        update_angle(angle, memory, e, KNOWN_B, on_grid)
    psi, _ = mesh_phase(mesh, system, t, y)
    update_angle(psi, memory, e, KNOWN_PSI, on_grid)


@compiled_inline
def fill_psi(mesh: Any, memory: Floats, out: Floats) -> None:
    """Fill cosine and sine of the mesh phase that is in ``out``; `mesh_gaps` has done so only where its teeth have errors."""
    out[COS_PSI], out[SIN_PSI] = nearby_angle(out[PSI], memory, mesh.element, KNOWN_PSI)


@compiled_inline
def follow_orbit(system: System, n: int, y: Floats, memory: Floats) -> None:
    """Let mesh n's reference of phi follow a gear that travels round its partner, so that phi never jumps by a turn.

    Called between steps; a step itself turns phi by far less than half a turn.
    """
    mesh = system.records[MESH][n]
    if not is_coupled(mesh) or mesh.frame >= 0:
        return
    e = mesh.element
    dx, dy = y[x_of(mesh.b)] - y[x_of(mesh.a)], y[y_of(mesh.b)] - y[y_of(mesh.a)]
    length = mesh.A0 + dx * mesh.u0_x + dy * mesh.u0_y
    across = -dx * mesh.u0_y + dy * mesh.u0_x
    c, sn = memory[e, TURNED + 1], memory[e, TURNED + 2]
    ahead, aside = c * length + sn * across, c * across - sn * length
    if abs(aside) > 0.5 * ahead:
        store_angle(memory[e, TURNED] + math.atan2(aside, ahead), memory, e, TURNED)


@compiled_inline
def small_angle(across: float, length: float) -> float:
    """Return atan2(across, length) [rad] for length > 0, by its series for slopes below 0.01.

    >>> small_angle(1e-3, 1.0) == math.atan(1e-3)
    True
    """
    x = across / length
    if abs(x) > 0.01 or length <= 0.0:
        return math.atan2(across, length)
    q = x * x
    return x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q * (1.0 / 7.0 - q * (1.0 / 9.0)))))


@compiled_inline
def mesh_gaps(system: System, n: int, t: float, y: Floats, memory: Floats, out: Floats) -> int:
    """Fill the positions of ``out`` for mesh n at state y; return 0, or 1 where it cannot mesh.

    Equations (3)-(6), (18), (19); section "Mesh" of docs/theory.
    """
    mesh = system.records[MESH][n]
    e = mesh.element
    a, b = mesh.a, mesh.b
    angle_a = toothing_angle(system.rotors[a], t, y[theta_of(a)], mesh.runout_phase_a)
    angle_b = toothing_angle(system.rotors[b], t, y[theta_of(b)], mesh.runout_phase_b)
    lx_a, ly_a = toothing_arm(mesh.runout_a, angle_a, memory, e, KNOWN_A)
    lx_b, ly_b = toothing_arm(mesh.runout_b, angle_b, memory, e, KNOWN_B)
    dx, dy = y[x_of(b)] + lx_b - (y[x_of(a)] + lx_a), y[y_of(b)] + ly_b - (y[y_of(a)] + ly_a)
    out[ARM_A_X], out[ARM_A_Y], out[ARM_B_X], out[ARM_B_Y] = lx_a, ly_a, lx_b, ly_b
    out[PSI], psi_rate = mesh_phase(mesh, system, t, y)
    error, slope = 0.0, 0.0
    if mesh.error_count > 0:
        fill_psi(mesh, memory, out)
        _, error, slope = harmonics(
            system.terms, mesh.error_start, mesh.error_count, out[COS_PSI], out[SIN_PSI]
        )
    out[PSI_RATE], out[ERROR_RATE] = psi_rate, slope * psi_rate
    s, sigma = mesh.s, mesh.sigma
    roll = sigma * (mesh.rho_a * y[theta_of(a)] + mesh.rho_b * y[theta_of(b)])

    u_x, u_y = mesh.u0_x, mesh.u0_y
    frame_angle = 0.0
    if mesh.frame >= 0:  # the nominal direction turns with the carrier
        frame_angle = y[theta_of(mesh.frame)]
        shift_x, shift_y, _, _ = carried(turn_of(system, mesh.frame, t, y), mesh.u0_x, mesh.u0_y, out)
        u_x, u_y = mesh.u0_x + shift_x, mesh.u0_y + shift_y
        # (dx, dy) counts from the fixed start position; from here on it counts from the turned one.
        dx -= mesh.A0 * shift_x
        dy -= mesh.A0 * shift_y

    along, across = dx * u_x + dy * u_y, -dx * u_y + dy * u_x
    length = mesh.A0 + along
    A_squared = length * length + across * across
    A = math.sqrt(A_squared)
    out[DISTANCE] = A
    if not (mesh.A_min < A < mesh.A_max):
        return 1
    u = (A_squared - mesh.A_nominal_squared) * mesh.inv_A_nominal_squared
    opening = mesh.c0 * involute_difference(
        A, mesh.c0, mesh.inv_alpha0, u, mesh.u_series, system.involutes, n
    )
    out[OPENING] = opening
    inv_A = 1.0 / A
    out[INV_A] = inv_A
    out[SIN_W] = math.sqrt(A_squared - mesh.c0 * mesh.c0) * inv_A
    out[E_X], out[E_Y] = inv_A * (length * u_x - across * u_y), inv_A * (length * u_y + across * u_x)
    out[BY_FRAME] = 0.0
    if is_coupled(mesh):
        phi = small_angle(across, length)
        if memory[e, TURNED] != 0.0:
            c, sn = memory[e, TURNED + 1], memory[e, TURNED + 2]
            phi = memory[e, TURNED] + small_angle(c * across - sn * length, c * length + sn * across)
        out[PHI] = phi
        w = roll - sigma * (mesh.rho_a + mesh.rho_b) * (frame_angle + phi)
        out[P_D], out[P_B] = w + error + s * opening, -w - error + s * opening - mesh.backlash
        out[B_T], out[ROLLED] = mesh.backlash - 2.0 * s * opening, w
        return 0
    # One line of action through the nominal position, fixed in the carrier where there is one.
    n_x = s * (mesh.sin_alpha0 * u_x - sigma * mesh.cos_alpha0 * u_y)
    n_y = s * (mesh.sin_alpha0 * u_y + sigma * mesh.cos_alpha0 * u_x)
    out[N_D_X], out[N_D_Y] = n_x, n_y
    g = mesh.opening0 + roll + n_x * dx + n_y * dy
    if mesh.frame >= 0:  # both gears roll in the frame of the carrier
        rolling = sigma * (mesh.rho_a + mesh.rho_b)
        g -= rolling * frame_angle
        out[BY_FRAME] = A * (n_x * out[E_Y] - n_y * out[E_X]) - rolling
    backlash = mesh.backlash - 2.0 * mesh.opening0
    if mesh.kind == MESH_PRINTED_COUPLED:  # (6) with the external sign whatever the pair
        backlash = mesh.backlash + 2.0 * opening
    out[P_D], out[P_B], out[B_T], out[ROLLED] = g + error, -g - error - backlash, backlash, g
    return 0


@compiled_inline
def mesh_geometry(system: System, n: int, t: float, y: Floats, memory: Floats, out: Floats) -> int:
    """Fill ``out`` with mesh n's kinematics at state y, rates and gradients too; return 0, or 1 where the pair cannot mesh."""
    if mesh_gaps(system, n, t, y, memory, out) != 0:
        return 1
    mesh = system.records[MESH][n]
    a, b = mesh.a, mesh.b
    omega_a, omega_b = y[omega_of(system, a)], y[omega_of(system, b)]
    spin_a, spin_b = spin_of(system, a, y), spin_of(system, b, y)
    dvx = y[vx_of(system, b)] - spin_b * out[ARM_B_Y] - (y[vx_of(system, a)] - spin_a * out[ARM_A_Y])
    dvy = y[vy_of(system, b)] + spin_b * out[ARM_B_X] - (y[vy_of(system, a)] + spin_a * out[ARM_A_X])
    s, sigma, sin_w, inv_A = mesh.s, mesh.sigma, out[SIN_W], out[INV_A]
    cos_w = mesh.c0 * inv_A
    e_x, e_y, error_rate = out[E_X], out[E_Y], out[ERROR_RATE]
    roll_rate = sigma * (mesh.rho_a * omega_a + mesh.rho_b * omega_b)
    A_rate = dvx * e_x + dvy * e_y
    out[DISTANCE_RATE], out[SPEED_SQUARED] = A_rate, dvx * dvx + dvy * dvy
    if is_coupled(mesh):
        # d(phi)/dt counts from the fixed axes; the nominal turning of the frame is already in the roll.
        out[PHI_RATE] = phi_rate = (-dvx * e_y + dvy * e_x) * inv_A
        out[SPIN_1], out[SPIN_2] = (spin_b, spin_a) if s > 0.0 else (spin_a, spin_b)
        if mesh.frame >= 0:
            phi_rate -= system.rotors[mesh.frame].nominal_speed
        w_rate = roll_rate - sigma * (mesh.rho_a + mesh.rho_b) * phi_rate
        out[P_D_RATE] = w_rate + error_rate + s * sin_w * A_rate
        out[P_B_RATE] = -w_rate - error_rate + s * sin_w * A_rate
        out[N_D_X] = s * (sin_w * e_x - sigma * cos_w * e_y)
        out[N_D_Y] = s * (sin_w * e_y + sigma * cos_w * e_x)
        out[N_B_X] = s * (sin_w * e_x + sigma * cos_w * e_y)
        out[N_B_Y] = s * (sin_w * e_y - sigma * cos_w * e_x)
        return 0
    g_rate = roll_rate + out[N_D_X] * dvx + out[N_D_Y] * dvy
    if (
        mesh.frame >= 0
    ):  # the line of action turns with all of the carrier's turning, the roll counts from its nominal one
        rolling = sigma * (mesh.rho_a + mesh.rho_b)
        nominal = system.rotors[mesh.frame].nominal_speed
        g_rate += out[BY_FRAME] * y[omega_of(system, mesh.frame)] + (out[BY_FRAME] + rolling) * nominal
    backlash_rate = 2.0 * sin_w * A_rate if mesh.kind == MESH_PRINTED_COUPLED else 0.0
    out[P_D_RATE] = out[G_RATE] = g_rate + error_rate
    out[P_B_RATE] = -g_rate - error_rate - backlash_rate
    out[N_B_X], out[N_B_Y] = -out[N_D_X], -out[N_D_Y]
    return 0


@compiled_once
def gaps_at(system: System, n: int, t: float, y: Floats, memory: Rows, out: Floats) -> int:
    """Evaluate `mesh_gaps`, as a function of the library for Python."""
    return mesh_gaps(system, n, t, y, memory, out)
