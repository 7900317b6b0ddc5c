"""Which smooth branch every contact is on, and the functions whose zeros end a branch.

The motion is piecewise smooth. A *mode* names the branch of one element, a *switch* is a function that is
negative while the branch holds and crosses zero upwards where it ends. ``modes`` is laid out as

====================  ======================================  ===============================================
slice                 element                                 value
====================  ======================================  ===============================================
``[0, nc)``           sleeves, then drive/back flank a mesh   OPEN, LOADED or SEPARATING (touching, no force)
``+ 2 nm``            the same flanks                         1 beyond the damping ramp's end, else 0
``+ nm``              meshes with square stiffness            half-waves passed
``+ nr``              servos                                  0 linear, +1/-1 at the torque limit
``+ nr``              ramps                                   1 while ramping
====================  ======================================  ===============================================

with nc = ns + 2 nm contacts. Switches: nc penetrations, nc force margins, 2 nm ramp ends, nm jumps, nr servos.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import (
    DRIVE_SERVO,
    LOADED,
    MARGIN,
    MESH_COUPLED,
    MESH_UNCOUPLED,
    OPEN,
    PENETRATION,
    RATE,
    SEPARATING,
    STIFFNESS_SQUARE,
    System,
    contact_count,
)
from gearplay.kernels.mesh import mesh_phase, square_edge, square_segment
from gearplay.kernels.motion import servo_torque
from gearplay.kernels.roster import Roster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

INACTIVE = -1.0


@compiled_inline
def is_printed(system: System, mesh: int) -> bool:
    """Return whether mesh ``mesh`` follows the article's equations as printed."""
    kind = system.meshes[mesh].kind
    return bool(kind != MESH_COUPLED and kind != MESH_UNCOUPLED)


@compiled_inline
def flank_is_idle(system: System, contact: int, modes: Ints) -> bool:
    """Return whether a printed back flank is overruled by its loaded drive flank (g >= 0 is tested first)."""
    flank = contact - system.sleeves.size
    if flank < 0 or flank % 2 == 0 or not is_printed(system, flank // 2):
        return False
    return bool(modes[contact - 1] == LOADED)


@compiled_inline
def contact_of_switch(system: System, s: int) -> int:
    """Return the contact whose penetration, force margin or ramp end switch s is; -1 for jumps and servos."""
    n_c, n_s, n_m = contact_count(system), system.sleeves.size, system.meshes.size
    if s < 2 * n_c:
        return s if s < n_c else s - n_c
    return n_s + s - 2 * n_c if s < 2 * n_c + 2 * n_m else -1


@compiled_inline
def switch_value(system: System, s: int, t: float, y: Floats, modes: Ints, contacts: Floats) -> float:
    """Return switch function s [m, N, 1, rad or N m] from the state and the contact table of its element."""
    n_c, n_s, n_m, n_r = contact_count(system), system.sleeves.size, system.meshes.size, system.rotors.size
    if s < n_c:
        p = contacts[s, PENETRATION]
        if modes[s] == OPEN:
            return INACTIVE if flank_is_idle(system, s, modes) else p
        return -p
    if s < 2 * n_c:
        k = s - n_c
        margin = contacts[k, MARGIN]
        return INACTIVE if modes[k] == OPEN else -margin if modes[k] == LOADED else margin
    if s < 2 * n_c + 2 * n_m:
        f = s - 2 * n_c
        mesh = system.meshes[f // 2]
        if mesh.C_m == 0.0 or modes[n_s + f] == OPEN:
            return INACTIVE
        beyond = contacts[n_s + f, PENETRATION] - mesh.depth
        return beyond if modes[n_s + 2 * n_m + f] == 0 else -beyond
    if s < 2 * n_c + 3 * n_m:
        j = s - 2 * n_c - 2 * n_m
        mesh = system.meshes[j]
        psi, _ = mesh_phase(mesh, system, t, y)
        segment = modes[n_s + 4 * n_m + j]
        return max(psi - square_edge(mesh, segment + 1), square_edge(mesh, segment) - psi)
    i = s - 2 * n_c - 3 * n_m
    limit = system.rotors[i].servo_limit
    mode = modes[n_s + 5 * n_m + i]
    wanted = servo_torque(system, i, t, y, modes[n_s + 5 * n_m + n_r + i])
    return abs(wanted) - limit if mode == 0 else limit - mode * wanted


@compiled_inline
def switch_values(
    system: System, roster: Roster, t: float, y: Floats, modes: Ints, contacts: Floats, g: Floats
) -> None:
    """Fill ``g`` with the roster's switch functions from the contact table of the same state."""
    for c in range(1, roster.switches[0] + 1):
        s = roster.switches[c]
        g[s] = switch_value(system, s, t, y, modes, contacts)


@compiled
def latch_speed(system: System, k: int, rate: float, latch: Floats) -> None:
    """Latch the impact speed [m/s] of sleeve k at an onset, floored by the sleeve's minimum."""
    if k < system.sleeves.size:
        latch[k] = max(rate, system.sleeves[k].minimum_speed)


@compiled
def settle_printed_flanks(system: System, modes: Ints, contacts: Floats) -> None:
    """Make the two flanks of each printed mesh exclusive: one force f_g (19), the drive branch first."""
    n_s = system.sleeves.size
    for j in range(system.meshes.size):
        if not is_printed(system, j):
            continue
        drive, back = n_s + 2 * j, n_s + 2 * j + 1
        if modes[drive] == LOADED:
            modes[back] = OPEN
        elif modes[back] == OPEN and contacts[back, PENETRATION] > 0.0:
            modes[back] = LOADED


@compiled
def settle_segment(system: System, j: int, t: float, y: Floats, modes: Ints) -> None:
    """Set the segment of mesh j's square wave from the state; while the mesh is open nobody counts segments."""
    mesh = system.meshes[j]
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        psi, _ = mesh_phase(mesh, system, t, y)
        modes[system.sleeves.size + 4 * system.meshes.size + j] = square_segment(mesh, psi)


@compiled
def settle_modes(system: System, t: float, y: Floats, modes: Ints, contacts: Floats, latch: Floats) -> None:
    """Set every mode from the state alone; used once, at the start of a run.

    A sleeve that starts in contact latches its present rate of penetration, unless it goes on from another run.
    """
    n_c, n_s, n_m, n_r = contact_count(system), system.sleeves.size, system.meshes.size, system.rotors.size
    for k in range(n_c):
        if k < n_s and latch[k] <= system.sleeves[k].minimum_speed:
            latch_speed(system, k, contacts[k, RATE], latch)
        bearing = k < n_s and system.sleeves[k].clearance == 0.0  # always touches, even at its centre
        modes[k] = LOADED if bearing or contacts[k, PENETRATION] > 0.0 else OPEN
    settle_printed_flanks(system, modes, contacts)
    for f in range(2 * n_m):
        modes[n_s + 2 * n_m + f] = 1 if contacts[n_s + f, PENETRATION] > system.meshes[f // 2].depth else 0
    for j in range(n_m):
        settle_segment(system, j, t, y, modes)
    for i in range(n_r):
        r = system.rotors[i]
        modes[n_s + 5 * n_m + n_r + i] = 1 if t < r.ramp_time else 0
        if r.drive == DRIVE_SERVO:
            torque = servo_torque(system, i, t, y, modes[n_s + 5 * n_m + n_r + i])
            modes[n_s + 5 * n_m + i] = int(math.copysign(1.0, torque)) if abs(torque) > r.servo_limit else 0


@compiled
def settle_margins(system: System, modes: Ints, contacts: Floats) -> None:
    """Mark contacts that would pull as separating; used once, after `settle_modes`."""
    for k in range(contact_count(system)):
        if modes[k] == LOADED and contacts[k, MARGIN] < 0.0:
            modes[k] = SEPARATING


@compiled
def switch_mode(
    system: System, k: int, t: float, y: Floats, modes: Ints, contacts: Floats, latch: Floats
) -> None:
    """Apply switch k: change the mode that it guards."""
    n_c, n_s, n_m, n_r = contact_count(system), system.sleeves.size, system.meshes.size, system.rotors.size
    if k < n_c:  # a penetration crossed zero
        if modes[k] == OPEN:
            latch_speed(system, k, contacts[k, RATE], latch)
            modes[k] = LOADED
            if k >= n_s:
                modes[2 * n_m + k] = 0
                if modes[n_s + ((k - n_s) ^ 1)] == OPEN:
                    settle_segment(system, (k - n_s) // 2, t, y, modes)
        else:
            modes[k] = OPEN
        settle_printed_flanks(system, modes, contacts)
    elif k < 2 * n_c:  # the formula's force crossed zero while touching
        if modes[k - n_c] != OPEN:
            modes[k - n_c] = SEPARATING if modes[k - n_c] == LOADED else LOADED
    elif k < 2 * n_c + 2 * n_m:
        slot = n_s + 2 * n_m + (k - 2 * n_c)
        modes[slot] = 1 - modes[slot]
    elif k < 2 * n_c + 3 * n_m:
        mesh = k - 2 * n_c - 2 * n_m
        slot = n_s + 4 * n_m + mesh
        m = system.meshes[mesh]
        psi, _ = mesh_phase(m, system, t, y)
        modes[slot] += (
            1 if psi > 0.5 * (square_edge(m, modes[slot]) + square_edge(m, modes[slot] + 1)) else -1
        )
    else:
        rotor = k - 2 * n_c - 3 * n_m
        slot = n_s + 5 * n_m + rotor
        if modes[slot] == 0:
            torque = servo_torque(system, rotor, t, y, modes[n_s + 5 * n_m + n_r + rotor])
            modes[slot] = int(math.copysign(1.0, torque))
        else:
            modes[slot] = 0
