"""One gear mesh: stiffness, transmission error, flank penetrations and their rates, flank forces."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.involute import involute_difference
from gearplay.kernels.layout import (
    MESH_COUPLED,
    MESH_PRINTED_COUPLED,
    RAMP_SMOOTH,
    STIFFNESS_FOURIER,
    STIFFNESS_SQUARE,
    System,
)

Floats = NDArray[np.float64]
TWO_PI = 2.0 * math.pi


@compiled_inline
def harmonics(
    terms: Floats, start: int, count: int, cos_psi: float, sin_psi: float
) -> tuple[float, float, float]:
    """Return sum a cos(k psi + phase), sum a sin(k psi + phase) and the latter's slope sum k a cos(k psi + phase).

    The multiples of psi come from its sine and cosine by rotation, so one pair serves every term of a mesh.
    """
    cosines, sines, slopes = 0.0, 0.0, 0.0
    c, s, order = 1.0, 0.0, 0.0
    for i in range(start, start + count):
        while order < terms[i, 0]:
            c, s = c * cos_psi - s * sin_psi, s * cos_psi + c * sin_psi
            order += 1.0
        cosine, sine = terms[i, 1] * c - terms[i, 2] * s, terms[i, 1] * s + terms[i, 2] * c
        cosines += cosine
        sines += sine
        slopes += order * cosine
    return cosines, sines, slopes


@compiled_inline
def spline_piece(mesh: Any, system: System, psi: float) -> tuple[int, float]:
    """Return the row of the spline that holds the mesh phase psi [rad], and how far psi lies behind its start [rad]."""
    turn = (psi + mesh.phase) / TWO_PI
    angle = TWO_PI * (turn - math.floor(turn))
    row = mesh.stiffness_start + mesh.stiffness_count - 1
    while row > mesh.stiffness_start and system.spline[row, 0] > angle:
        row -= 1
    x = angle - system.spline[row, 0]
    if x < 0.0:  # before the first knot: the last piece, wrapped round
        row = mesh.stiffness_start + mesh.stiffness_count - 1
        x = angle + TWO_PI - system.spline[row, 0]
    return row, x


@compiled_inline
def mesh_stiffness(
    mesh: Any, system: System, psi: float, cos_psi: float, sin_psi: float, segment: int
) -> float:
    """Return K(psi) [N/m] at mesh phase psi [rad], eq. (16) and its generalisations.

    ``segment`` counts the half-waves passed by a square wave, so that a stage of the stepper that overshoots
    a jump still sees the branch it started on.
    """
    if mesh.stiffness_kind == STIFFNESS_FOURIER:
        swing, _, _ = harmonics(system.terms, mesh.stiffness_start, mesh.stiffness_count, cos_psi, sin_psi)
        return mesh.k_m + swing
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        return mesh.k_m if segment % 2 == 0 else mesh.k_single
    row, x = spline_piece(mesh, system, psi)
    p = system.spline[row]
    return p[1] + x * (p[2] + x * (p[3] + x * p[4]))


@compiled_inline
def square_edge(mesh: Any, segment: int) -> float:
    """Return the mesh phase psi [rad] at which segment ``segment`` of a square wave begins."""
    turns = segment // 2
    part = mesh.duty if segment % 2 == 1 else 0.0
    return TWO_PI * (turns + part) - mesh.phase


@compiled
def square_segment(mesh: Any, psi: float) -> int:
    """Return the segment of a square wave that holds the mesh phase psi [rad]."""
    turn = (psi + mesh.phase) / TWO_PI
    whole = math.floor(turn)
    return int(2 * whole + (1 if turn - whole >= mesh.duty else 0))


@compiled_inline
def damping_ramp(u: float, past: int) -> float:
    """Return s(u) = u^2 (3 - 2u), the ramp that (17) means: 0 at first touch, 1 from u = p/d = 1 on.

    >>> damping_ramp(0.5, 0)
    0.5
    """
    if past == 1:
        return 1.0
    if u <= 0.0:
        return 0.0
    return u * u * (3.0 - 2.0 * u)


@compiled_inline
def flank_damping(mesh: Any, p: float, past: int, back: int) -> float:
    """Return C(p) [N s/m] at penetration p [m], eq. (17): smooth ramp, or the ramp as printed.

    As printed: C_m (1 - b^2 (3 - 2b)) for 0 <= b = p/d < 1, C_m beyond, nothing on the back flank.
    """
    if mesh.C_m == 0.0:
        return 0.0
    if mesh.ramp == RAMP_SMOOTH:
        return mesh.C_m * damping_ramp(p * mesh.inv_depth, past)
    if back == 1:
        return 0.0
    return mesh.C_m if past == 1 else mesh.C_m * (1.0 - damping_ramp(p * mesh.inv_depth, past))


@compiled_inline
def flank_force(
    mesh: Any, stiffness: float, p: float, rate: float, past: int, back: int
) -> tuple[float, float]:
    """Return the force K p + C(p) dp/dt [N] of a flank and its margin, positive while it presses.

    On the smooth ramp the margin is F / p [N/m]: it keeps its sign where p vanishes, so that a flank which lets go and
    takes hold again before it opens (the ramp ends with p^2) shows both.
    """
    if past == 1 or mesh.ramp != RAMP_SMOOTH:
        force = stiffness * p + flank_damping(mesh, p, past, back) * rate
        return force, force
    u = max(p * mesh.inv_depth, 0.0)
    margin = stiffness + mesh.C_m * mesh.inv_depth * u * (3.0 - 2.0 * u) * rate
    return p * margin, margin


NEARBY = 0.03  # rad, within which the series of `nearby_angle` is exact to rounding


@compiled_inline
def nearby_angle(angle: float, known: Floats, j: int, slot: int) -> tuple[float, float]:
    """Return cos, sin of an angle [rad], from a known one if that is near: row j of ``known`` holds (angle, cos, sin)s.

    A stage of a step turns each angle by far less than ``NEARBY``; half the time of a right-hand side went into sines.
    """
    d = angle - known[j, slot]
    if not abs(d) < NEARBY:
        return math.cos(angle), math.sin(angle)
    q = d * d
    sine = d * (1.0 - q * (1 / 6 - q * (1 / 120 - q / 5040)))
    cosine = 1.0 - q * (0.5 - q * (1 / 24 - q * (1 / 720 - q / 40320)))
    c, s = known[j, slot + 1], known[j, slot + 2]
    return c * cosine - s * sine, s * cosine + c * sine


@compiled_inline
def toothing_angle(rotor: Any, t: float, theta: float) -> float:
    """Return the angle [rad] of a toothing's eccentricity at relative rotation theta [rad]."""
    return float(rotor.nominal_speed * t + theta + rotor.eccentricity_phase)


@compiled_inline
def toothing_arm(rotor: Any, t: float, theta: float, known: Floats, j: int, slot: int) -> tuple[float, float]:
    """Return the vector [m] from a rotor's shaft to the centre of its toothing, at relative rotation theta [rad]."""
    if rotor.eccentricity == 0.0:
        return 0.0, 0.0
    cosine, sine = nearby_angle(toothing_angle(rotor, t, theta), known, j, slot)
    return rotor.eccentricity * cosine, rotor.eccentricity * sine


@compiled_inline
def know_angles(system: System, j: int, t: float, y: Floats) -> None:
    """Note mesh j's angles at (t, y) with their cosines and sines, for `nearby_angle`."""
    mesh, known = system.meshes[j], system.known_angles
    psi, _ = mesh_phase(mesh, system, t, y)
    known[j, 0] = toothing_angle(system.rotors[mesh.a], t, y[3 * mesh.a + 2])
    known[j, 3] = toothing_angle(system.rotors[mesh.b], t, y[3 * mesh.b + 2])
    known[j, 6] = psi
    for slot in (0, 3, 6):
        known[j, slot + 1], known[j, slot + 2] = math.cos(known[j, slot]), math.sin(known[j, slot])


@compiled_inline
def mesh_phase(mesh: Any, system: System, t: float, y: Floats) -> tuple[float, float]:
    """Return the mesh phase psi [rad] and its rate [rad/s]: z theta of the driver, as its carrier sees it."""
    n, d = system.rotors.size, mesh.driver
    omega = system.rotors[d].nominal_speed
    angle, rate = y[3 * d + 2], y[3 * (n + d) + 2]
    if mesh.frame >= 0:
        omega -= system.rotors[mesh.frame].nominal_speed
        angle -= y[3 * mesh.frame + 2]
        rate -= y[3 * (n + mesh.frame) + 2]
    return mesh.z_driver * (omega * t + angle), mesh.z_driver * (omega + rate)


@compiled_inline
def follow_orbit(system: System, j: int, y: Floats) -> None:
    """Let mesh j's reference of phi follow a gear that travels round its partner, so that phi never jumps by a turn.

    Called between steps on a run's own copy of the system; a step itself turns phi by far less than half a turn.
    """
    mesh = system.meshes[j]
    if mesh.kind != MESH_COUPLED or mesh.frame >= 0:
        return
    dx, dy = y[3 * mesh.b] - y[3 * mesh.a], y[3 * mesh.b + 1] - y[3 * mesh.a + 1]
    length = mesh.A0 + dx * mesh.u0_x + dy * mesh.u0_y
    across = -dx * mesh.u0_y + dy * mesh.u0_x
    c, sn = mesh.turned_cos, mesh.turned_sin
    ahead, aside = c * length + sn * across, c * across - sn * length
    if abs(aside) > 0.5 * ahead:
        mesh.turned += math.atan2(aside, ahead)
        mesh.turned_cos, mesh.turned_sin = math.cos(mesh.turned), math.sin(mesh.turned)


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
    return x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q * (1.0 / 7.0 - q / 9.0))))


@compiled_inline
def mesh_gaps(system: System, j: int, t: float, y: Floats, out: Floats) -> int:
    """Fill the positions of ``out`` (see `mesh_geometry`) for mesh j at state y; return 0, or 1 where it cannot mesh.

    Equations (3)-(6), (18), (19); section "Mesh" of docs/theory.
    """
    mesh = system.meshes[j]
    a, b = mesh.a, mesh.b
    lx_a, ly_a = toothing_arm(system.rotors[a], t, y[3 * a + 2], system.known_angles, j, 0)
    lx_b, ly_b = toothing_arm(system.rotors[b], t, y[3 * b + 2], system.known_angles, j, 3)
    dx, dy = y[3 * b] + lx_b - (y[3 * a] + lx_a), y[3 * b + 1] + ly_b - (y[3 * a + 1] + ly_a)
    out[14], out[15], out[16], out[17] = lx_a, ly_a, lx_b, ly_b
    psi, psi_rate = mesh_phase(mesh, system, t, y)
    cos_psi, sin_psi = nearby_angle(psi, system.known_angles, j, 6)
    out[19], out[20] = cos_psi, sin_psi
    _, e, slope = harmonics(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    out[12], out[13], out[24] = psi, psi_rate, slope * psi_rate
    s, sigma = mesh.s, mesh.sigma
    roll = sigma * (mesh.rho_a * y[3 * a + 2] + mesh.rho_b * y[3 * b + 2])

    u_x, u_y = mesh.u0_x, mesh.u0_y
    frame_angle = 0.0
    if mesh.frame >= 0:  # the nominal direction turns with the carrier
        frame_angle = y[3 * mesh.frame + 2]
        turn = system.rotors[mesh.frame].nominal_speed * t + frame_angle
        c, sn = math.cos(turn), math.sin(turn)
        u_x, u_y = c * mesh.u0_x - sn * mesh.u0_y, sn * mesh.u0_x + c * mesh.u0_y
        # (dx, dy) counts from the fixed start position; from here on it counts from the turned one.
        dx += mesh.A0 * (mesh.u0_x - u_x)
        dy += mesh.A0 * (mesh.u0_y - u_y)

    along, across = dx * u_x + dy * u_y, -dx * u_y + dy * u_x
    length = mesh.A0 + along
    A_squared = length * length + across * across
    A = math.sqrt(A_squared)
    out[8] = A
    if not (mesh.A_min < A < mesh.A_max):
        return 1
    u = (A_squared - mesh.A_nominal_squared) * mesh.inv_A_nominal_squared
    opening = mesh.c0 * involute_difference(
        A, mesh.c0, mesh.inv_alpha0, u, mesh.u_series, system.involutes, j
    )
    inv_A = 1.0 / A
    out[26] = inv_A
    out[9] = math.sqrt(A_squared - mesh.c0 * mesh.c0) * inv_A
    out[21], out[22] = inv_A * (length * u_x - across * u_y), inv_A * (length * u_y + across * u_x)
    if mesh.kind == MESH_COUPLED:
        phi = small_angle(across, length)
        if mesh.turned != 0.0:
            c, sn = mesh.turned_cos, mesh.turned_sin
            phi = mesh.turned + small_angle(c * across - sn * length, c * length + sn * across)
        w = roll - sigma * (mesh.rho_a + mesh.rho_b) * (frame_angle + phi)
        out[0], out[1] = w + e + s * opening, -w - e + s * opening - mesh.backlash
        out[10], out[11] = mesh.backlash - 2.0 * s * opening, w
        return 0
    # One fixed line of action through the nominal position.
    out[4] = s * (mesh.sin_alpha0 * u_x - sigma * mesh.cos_alpha0 * u_y)
    out[5] = s * (mesh.sin_alpha0 * u_y + sigma * mesh.cos_alpha0 * u_x)
    g = mesh.opening0 + roll + out[4] * dx + out[5] * dy
    backlash = mesh.backlash - 2.0 * mesh.opening0
    if mesh.kind == MESH_PRINTED_COUPLED:  # (6) with the external sign whatever the pair
        backlash = mesh.backlash + 2.0 * opening
    out[0], out[1], out[10], out[11] = g + e, -g - e - backlash, backlash, g
    return 0


@compiled_inline
def mesh_geometry(system: System, j: int, t: float, y: Floats, out: Floats) -> int:
    """Fill ``out`` with mesh j's kinematics at state y; return 0, or 1 where the pair cannot mesh.

    Positions: 0 p_d, 1 p_b [m], 8 A [m], 9 sin(alpha_w), 10 b_t [m], 11 w - e [m], 12 psi [rad], 14-17 lever arms of the
    toothing centres of a and b [m], 19-20 cos and sin of psi, 21-22 direction of the line of centres, 26 1/A [1/m].
    Rates: 2 dp_d/dt, 3 dp_b/dt [m/s], 13 dpsi/dt [rad/s], 18 dg/dt of the printed single line of action, 23 dA/dt,
    24 de/dt [m/s], 25 speed squared of the toothing centre of b against that of a [m^2/s^2].
    Gradients by the displacement of b: 4-5 of p_d, 6-7 of p_b.
    """
    if mesh_gaps(system, j, t, y, out) != 0:
        return 1
    n, mesh = system.rotors.size, system.meshes[j]
    a, b = mesh.a, mesh.b
    at_a, at_b = 3 * (n + a), 3 * (n + b)
    omega_a, omega_b = y[at_a + 2], y[at_b + 2]
    spin_a, spin_b = system.rotors[a].nominal_speed + omega_a, system.rotors[b].nominal_speed + omega_b
    dvx = y[at_b] - spin_b * out[17] - (y[at_a] - spin_a * out[15])
    dvy = y[at_b + 1] + spin_b * out[16] - (y[at_a + 1] + spin_a * out[14])
    s, sigma, sin_w, inv_A = mesh.s, mesh.sigma, out[9], out[26]
    cos_w = mesh.c0 * inv_A
    e_x, e_y, e_rate = out[21], out[22], out[24]
    roll_rate = sigma * (mesh.rho_a * omega_a + mesh.rho_b * omega_b)
    A_rate = dvx * e_x + dvy * e_y
    out[23], out[25] = A_rate, dvx * dvx + dvy * dvy
    if mesh.kind == MESH_COUPLED:
        # d(phi)/dt counts from the fixed axes; the nominal turning of the frame is already in the roll.
        phi_rate = (-dvx * e_y + dvy * e_x) * inv_A
        if mesh.frame >= 0:
            phi_rate -= system.rotors[mesh.frame].nominal_speed
        w_rate = roll_rate - sigma * (mesh.rho_a + mesh.rho_b) * phi_rate
        out[2] = w_rate + e_rate + s * sin_w * A_rate
        out[3] = -w_rate - e_rate + s * sin_w * A_rate
        out[4] = s * (sin_w * e_x - sigma * cos_w * e_y)
        out[5] = s * (sin_w * e_y + sigma * cos_w * e_x)
        out[6] = s * (sin_w * e_x + sigma * cos_w * e_y)
        out[7] = s * (sin_w * e_y - sigma * cos_w * e_x)
        return 0
    g_rate = roll_rate + out[4] * dvx + out[5] * dvy
    backlash_rate = 2.0 * sin_w * A_rate if mesh.kind == MESH_PRINTED_COUPLED else 0.0
    out[2] = out[18] = g_rate + e_rate
    out[3] = -g_rate - e_rate - backlash_rate
    out[6], out[7] = -out[4], -out[5]
    return 0
