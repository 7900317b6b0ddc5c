"""The right-hand side: all forces of the current contact modes, then Newton and Euler, eq. (20)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import (
    DRIVE_SERVO,
    DRIVE_SPEED,
    FORCE,
    FORCE_X,
    FORCE_Y,
    LOADED,
    MARGIN,
    MESH_COUPLED,
    MESH_UNCOUPLED,
    PENETRATION,
    RATE,
    System,
)
from gearplay.kernels.mesh import flank_force, mesh_geometry, mesh_stiffness
from gearplay.kernels.ripple import follow_ripple
from gearplay.kernels.roster import Roster
from gearplay.kernels.sleeve import sleeve_force, sleeve_geometry, smooth_sign

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@compiled_inline
def drive_target(rotor: Any, t: float, ramping: int) -> float:
    """Return the commanded speed [rad/s] of a servo at time t [s], with its linear ramp."""
    if ramping == 1:
        return rotor.ramp_start + rotor.ramp_acceleration * t
    return rotor.drive_speed


@compiled_inline
def servo_torque(system: System, i: int, t: float, y: Floats, ramping: int) -> float:
    """Return the unlimited torque [N m] of rotor i's servo: kp (target - omega) + ki z."""
    r = system.rotors[i]
    omega = r.nominal_speed + y[3 * (system.rotors.size + i) + 2]
    return r.servo_gain * (drive_target(r, t, ramping) - omega) + r.servo_integral_gain * y[r.servo_slot]


@compiled_inline
def press_sleeve(
    system: System, k: int, y: Floats, t: float, modes: Ints, latch: Floats, contacts: Floats, out: Floats
) -> float:
    """Fill sleeve k's row of ``contacts`` and ``out``; return the tangential force [N] on the journal."""
    sleeve = system.sleeves[k]
    sleeve_geometry(sleeve, system, t, y, out)
    delta, rate = out[0], out[1]
    normal, margin = sleeve_force(sleeve, delta, rate, latch[k])
    contacts[k, PENETRATION], contacts[k, RATE], contacts[k, MARGIN] = delta, rate, margin
    if modes[k] != LOADED:
        contacts[k, FORCE], contacts[k, FORCE_X], contacts[k, FORCE_Y] = 0.0, 0.0, 0.0
        return 0.0
    tangential = 0.0
    if sleeve.friction > 0.0:
        tangential = -sleeve.friction * normal * smooth_sign(out[4] / sleeve.friction_speed)
    contacts[k, FORCE] = normal
    contacts[k, FORCE_X] = -normal * out[2] - tangential * out[3]
    contacts[k, FORCE_Y] = -normal * out[3] + tangential * out[2]
    return tangential


@compiled_inline
def add_sleeve(
    system: System,
    k: int,
    y: Floats,
    t: float,
    modes: Ints,
    latch: Floats,
    force: Floats,
    contacts: Floats,
    out: Floats,
) -> None:
    """Add sleeve k's forces to ``force`` [rotor, (N, N, N m)] and fill its row of ``contacts``."""
    tangential = press_sleeve(system, k, y, t, modes, latch, contacts, out)
    if modes[k] != LOADED:
        return
    sleeve = system.sleeves[k]
    f_x, f_y = contacts[k, FORCE_X], contacts[k, FORCE_Y]
    j = sleeve.journal
    force[j, 0] += f_x
    force[j, 1] += f_y
    force[j, 2] += sleeve.shaft_radius * tangential
    if sleeve.bush >= 0:
        b = sleeve.bush
        force[b, 0] -= f_x
        force[b, 1] -= f_y
        force[b, 2] -= out[5] * f_y - out[6] * f_x
        force[b, 2] -= (sleeve.shaft_radius + sleeve.clearance) * tangential


@compiled_inline
def press_mesh(
    system: System, j: int, y: Floats, t: float, modes: Ints, contacts: Floats, out: Floats
) -> int:
    """Fill mesh j's two rows of ``contacts`` and ``out``; return 1 where it cannot mesh."""
    if mesh_geometry(system, j, t, y, out) != 0:
        return 1
    mesh = system.meshes[j]
    n_s, n_m = system.sleeves.size, system.meshes.size
    first = n_s + 2 * j
    square = modes[n_s + 4 * n_m + j]
    k_mesh = mesh_stiffness(mesh, system, out[12], out[19], out[20], square)
    printed = mesh.kind != MESH_COUPLED and mesh.kind != MESH_UNCOUPLED
    for flank in range(2):
        row = first + flank
        p, rate = out[flank], out[2 + flank]
        past = modes[n_s + 2 * n_m + 2 * j + flank]
        # The printed damping follows g alone; the flank's own rate also holds the change of backlash.
        damping_rate = rate if not printed else (out[18] if flank == 0 else -out[18])
        f, margin = flank_force(mesh, k_mesh, p, damping_rate, past, flank)
        contacts[row, PENETRATION], contacts[row, RATE] = p, rate
        contacts[row, MARGIN] = 1.0 if printed else margin
        contacts[row, FORCE] = f if modes[row] == LOADED else 0.0
    return 0


@compiled_inline
def add_mesh(
    system: System, j: int, y: Floats, t: float, modes: Ints, force: Floats, contacts: Floats, out: Floats
) -> int:
    """Add mesh j's flank forces to ``force`` and fill its two rows of ``contacts``; 1 where it cannot mesh.

    Generalised forces are -F dp/dq exactly, equations (15), (20) with consistent signs.
    """
    if press_mesh(system, j, y, t, modes, contacts, out) != 0:
        return 1
    mesh = system.meshes[j]
    first = system.sleeves.size + 2 * j
    f_d, f_b = contacts[first, FORCE], contacts[first + 1, FORCE]
    if f_d == 0.0 and f_b == 0.0:
        return 0
    f_x, f_y = -f_d * out[4] - f_b * out[6], -f_d * out[5] - f_b * out[7]
    twist = -mesh.sigma * (f_d - f_b)
    a, b = mesh.a, mesh.b
    force[b, 0] += f_x
    force[b, 1] += f_y
    force[b, 2] += twist * mesh.rho_b + out[16] * f_y - out[17] * f_x
    force[a, 0] -= f_x
    force[a, 1] -= f_y
    force[a, 2] += twist * mesh.rho_a - (out[14] * f_y - out[15] * f_x)
    return 0


@compiled_inline
def right_hand_side(
    system: System,
    roster: Roster,
    t: float,
    y: Floats,
    modes: Ints,
    latch: Floats,
    dy: Floats,
    contacts: Floats,
    force: Floats,
    out: Floats,
) -> int:
    """Fill ``dy`` with the derivative of the roster's active states; return 0, or 1 where a pair cannot mesh.

    ``modes`` fixes which smooth branch each contact is on, ``latch`` holds the impact speeds [m/s]; the rows of
    ``contacts`` of touching elements, ``force`` and ``out`` are filled on the way. A rippling drive's rotation is a function of
    t alone: it is set in ``y``, whatever was there. State order: docs/conventions.
    """
    n = system.rotors.size
    n_s, n_m = system.sleeves.size, system.meshes.size
    for a in range(1, roster.active[0] + 1):
        i = roster.active[a]
        r = system.rotors[i]
        if r.ripple_count > 0:
            dy[3 * (n + i) + 2] = follow_ripple(system, i, t, y)
        omega = r.nominal_speed + y[3 * (n + i) + 2]
        force[i, 0] = r.mass * system.gravity[0] - r.radial_damping * y[3 * (n + i)]
        force[i, 1] = r.mass * system.gravity[1] - r.radial_damping * y[3 * (n + i) + 1]
        force[i, 2] = r.torque - r.drag * omega
        if r.friction > 0.0:
            force[i, 2] -= r.friction * smooth_sign(omega / r.friction_speed)
        if r.drive == DRIVE_SERVO:
            ramping = modes[n_s + 5 * n_m + n + i]
            wanted = servo_torque(system, i, t, y, ramping)
            mode = modes[n_s + 5 * n_m + i]
            torque = wanted if mode == 0 else mode * r.servo_limit
            force[i, 2] += torque
            # Back-calculation: the integral follows what the limit lets through.
            dy[r.servo_slot] = drive_target(r, t, ramping) - omega + (torque - wanted) / r.servo_gain
    for k in range(1, roster.sleeves[0] + 1):
        add_sleeve(system, roster.sleeves[k], y, t, modes, latch, force, contacts, out)
    for j in range(1, roster.meshes[0] + 1):
        if add_mesh(system, roster.meshes[j], y, t, modes, force, contacts, out) != 0:
            return 1
    for a in range(1, roster.active[0] + 1):
        i = roster.active[a]
        r = system.rotors[i]
        for c in range(3):
            dy[3 * i + c] = y[3 * (n + i) + c]
        dy[3 * (n + i)] = r.inv_mass * force[i, 0]
        dy[3 * (n + i) + 1] = r.inv_mass * force[i, 1]
        if r.ripple_count == 0:
            dy[3 * (n + i) + 2] = r.inv_inertia * force[i, 2]
        if r.drive == DRIVE_SPEED and modes[n_s + 5 * n_m + n + i] == 1:
            dy[3 * (n + i) + 2] = r.ramp_acceleration
    return 0
