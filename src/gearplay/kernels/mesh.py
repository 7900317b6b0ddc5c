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
    turn = (psi + mesh.phase) / TWO_PI
    angle = TWO_PI * (turn - math.floor(turn))
    row = mesh.stiffness_start + mesh.stiffness_count - 1
    while row > mesh.stiffness_start and system.spline[row, 0] > angle:
        row -= 1
    x = angle - system.spline[row, 0]
    if x < 0.0:  # before the first knot: the last piece, wrapped round
        row = mesh.stiffness_start + mesh.stiffness_count - 1
        x = angle + TWO_PI - system.spline[row, 0]
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
        return mesh.C_m * damping_ramp(p / mesh.depth, past)
    if back == 1:
        return 0.0
    return mesh.C_m if past == 1 else mesh.C_m * (1.0 - damping_ramp(p / mesh.depth, 0))


@compiled_inline
def toothing_centre(
    rotor: Any, t: float, y: Floats, i: int, n: int
) -> tuple[float, float, float, float, float, float]:
    """Return displacement, velocity and lever arm of rotor i's toothing centre: x, y, vx, vy, lx, ly [m, m/s]."""
    x, y_, vx, vy = y[3 * i], y[3 * i + 1], y[3 * (n + i)], y[3 * (n + i) + 1]
    if rotor.eccentricity == 0.0:
        return x, y_, vx, vy, 0.0, 0.0
    angle = rotor.nominal_speed * t + y[3 * i + 2] + rotor.eccentricity_phase
    lx, ly = rotor.eccentricity * math.cos(angle), rotor.eccentricity * math.sin(angle)
    omega = rotor.nominal_speed + y[3 * (n + i) + 2]
    return x + lx, y_ + ly, vx - omega * ly, vy + omega * lx, lx, ly


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


@compiled
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
def mesh_geometry(system: System, j: int, t: float, y: Floats, out: Floats) -> int:
    """Fill ``out`` with mesh j's kinematics at state y; return 0, or 1 where the pair cannot mesh.

    out: 0 p_d, 1 p_b [m], 2 dp_d/dt, 3 dp_b/dt [m/s], 4-5 gradient of p_d by the displacement of b, 6-7 the
    same of p_b, 8 A [m], 9 sin(alpha_w), 10 b_t [m], 11 w - e [m], 12 psi [rad], 13 dpsi/dt [rad/s],
    14-17 lever arms of the toothing centres of a and b [m], 18 dg/dt of the printed single line of action,
    19-20 cos and sin of psi, 21-22 velocity of the toothing centre of b against that of a
    [m/s], 23 dA/dt [m/s].
    Equations (3)-(6), (18), (19); section "Mesh" of docs/theory.
    """
    n, mesh = system.rotors.size, system.meshes[j]
    a, b = mesh.a, mesh.b
    x_a, y_a, vx_a, vy_a, lx_a, ly_a = toothing_centre(system.rotors[a], t, y, a, n)
    x_b, y_b, vx_b, vy_b, lx_b, ly_b = toothing_centre(system.rotors[b], t, y, b, n)
    dx, dy, dvx, dvy = x_b - x_a, y_b - y_a, vx_b - vx_a, vy_b - vy_a
    out[14], out[15], out[16], out[17] = lx_a, ly_a, lx_b, ly_b
    out[21], out[22] = dvx, dvy
    theta_a, theta_b = y[3 * a + 2], y[3 * b + 2]
    omega_a, omega_b = y[3 * (n + a) + 2], y[3 * (n + b) + 2]
    psi, psi_rate = mesh_phase(mesh, system, t, y)
    cos_psi, sin_psi = math.cos(psi), math.sin(psi)
    out[19], out[20] = cos_psi, sin_psi
    _, e, slope = harmonics(system.terms, mesh.error_start, mesh.error_count, cos_psi, sin_psi)
    e_rate = slope * psi_rate
    out[12], out[13] = psi, psi_rate
    s, sigma = mesh.s, mesh.sigma
    roll = sigma * (mesh.rho_a * theta_a + mesh.rho_b * theta_b)
    roll_rate = sigma * (mesh.rho_a * omega_a + mesh.rho_b * omega_b)

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
    u = (A_squared - mesh.A_nominal_squared) / mesh.A_nominal_squared
    opening = mesh.c0 * involute_difference(
        A, mesh.c0, mesh.inv_alpha0, u, mesh.u_series, system.involutes, j
    )
    cos_w = mesh.c0 / A
    sin_w = math.sqrt(A_squared - mesh.c0 * mesh.c0) / A
    out[9] = sin_w
    phi = small_angle(across, length)
    if mesh.turned != 0.0:
        c, sn = mesh.turned_cos, mesh.turned_sin
        phi = mesh.turned + small_angle(c * across - sn * length, c * length + sn * across)
    e_x, e_y = (length * u_x - across * u_y) / A, (length * u_y + across * u_x) / A  # actual direction
    out[23] = dvx * e_x + dvy * e_y

    if mesh.kind == MESH_COUPLED:
        rho = mesh.rho_a + mesh.rho_b
        w = roll - sigma * rho * (frame_angle + phi)
        # d(phi)/dt counts from the fixed axes; the nominal turning of the frame is already in `roll`.
        phi_rate = (-dvx * e_y + dvy * e_x) / A
        if mesh.frame >= 0:
            phi_rate -= system.rotors[mesh.frame].nominal_speed
        w_rate = roll_rate - sigma * rho * phi_rate
        opening_rate = sin_w * (dvx * e_x + dvy * e_y)
        out[0] = w + e + s * opening
        out[1] = -w - e + s * opening - mesh.backlash
        out[2] = w_rate + e_rate + s * opening_rate
        out[3] = -w_rate - e_rate + s * opening_rate
        out[4] = s * (sin_w * e_x - sigma * cos_w * e_y)
        out[5] = s * (sin_w * e_y + sigma * cos_w * e_x)
        out[6] = s * (sin_w * e_x + sigma * cos_w * e_y)
        out[7] = s * (sin_w * e_y - sigma * cos_w * e_x)
        out[10] = mesh.backlash - 2.0 * s * opening
        out[11] = w
        return 0

    # One fixed line of action through the nominal position.
    g_x = s * (mesh.sin_alpha0 * u_x - sigma * mesh.cos_alpha0 * u_y)
    g_y = s * (mesh.sin_alpha0 * u_y + sigma * mesh.cos_alpha0 * u_x)
    g = roll + g_x * dx + g_y * dy
    g_rate = roll_rate + g_x * dvx + g_y * dvy
    backlash, backlash_rate = mesh.backlash - 2.0 * mesh.opening0, 0.0
    if mesh.kind == MESH_PRINTED_COUPLED:  # (6) with the external sign whatever the pair
        backlash = mesh.backlash + 2.0 * opening
        backlash_rate = 2.0 * sin_w * (dvx * e_x + dvy * e_y)
    g += mesh.opening0
    out[0] = g + e
    out[1] = -g - e - backlash
    out[2] = g_rate + e_rate
    out[3] = -g_rate - e_rate - backlash_rate
    out[4], out[5] = g_x, g_y
    out[6], out[7] = -g_x, -g_y
    out[10] = backlash
    out[11] = g
    out[18] = g_rate + e_rate
    return 0
