"""The right-hand side to first order, and free flight to first order: how small changes of the state move on.

The exact derivative of `motion.right_hand_side` on fixed modes and of `flight.fly` (docs/theory, "Tangent of the motion"). A
change z holds the states in their order, then the latched impact speeds, one a sleeve.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.flight import decay
from gearplay.kernels.layout import (
    CONTACT_COLUMNS,
    DRIVE_SERVO,
    LOADED,
    OUT_SIZE,
    System,
    contact_count,
)
from gearplay.kernels.linear_mesh import MESH_SLOPES, add_mesh_change, linearise_mesh
from gearplay.kernels.linear_sleeve import (
    SLEEVE_SLOPES,
    add_sleeve_change,
    linearise_sleeve,
    smooth_sign_slope,
)
from gearplay.kernels.roster import Roster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Slopes(NamedTuple):
    """First-order data of all elements at one state, and scratch; made by `make_slopes`."""

    sleeves: Floats  # [sleeve, SLEEVE_SLOPES]
    meshes: Floats  # [mesh, MESH_SLOPES]
    rotors: Floats  # [rotor], slope of dry friction by the speed [N m s]
    force: Floats  # [rotor, 3]
    contacts: Floats
    out: Floats


def make_slopes(system: System) -> Slopes:
    """Allocate the slopes of a system."""
    n = system.rotors.size
    return Slopes(
        sleeves=np.zeros((system.sleeves.size, SLEEVE_SLOPES)),
        meshes=np.zeros((system.meshes.size, MESH_SLOPES)),
        rotors=np.zeros(n),
        force=np.zeros((n, 3)),
        contacts=np.zeros((contact_count(system), CONTACT_COLUMNS)),
        out=np.zeros(OUT_SIZE),
    )


@compiled
def linearise(
    system: System, roster: Roster, t: float, y: Floats, modes: Ints, latch: Floats, slopes: Slopes
) -> int:
    """Fill ``slopes`` at (t, y) for what the roster says is active and touching; return 1 where a pair cannot mesh."""
    n = system.rotors.size
    for a in range(1, roster.active[0] + 1):
        i = roster.active[a]
        r = system.rotors[i]
        slopes.rotors[i] = 0.0
        if r.friction > 0.0:
            omega = r.nominal_speed + y[3 * (n + i) + 2]
            slopes.rotors[i] = r.friction / r.friction_speed * smooth_sign_slope(omega / r.friction_speed)
    for c in range(1, roster.sleeves[0] + 1):
        k = roster.sleeves[c]
        linearise_sleeve(system, k, t, y, modes, latch, slopes.sleeves[k], slopes.out)
    for c in range(1, roster.meshes[0] + 1):
        j = roster.meshes[c]
        if linearise_mesh(system, j, t, y, modes, slopes.contacts, slopes.meshes[j], slopes.out) != 0:
            return 1
    return 0


@compiled
def rate_of_change(
    system: System, roster: Roster, modes: Ints, slopes: Slopes, z: Floats, dz: Floats
) -> None:
    """Fill the active entries of ``dz`` with the rate at which a change ``z`` grows."""
    n, n_s, n_m, force = system.rotors.size, system.sleeves.size, system.meshes.size, slopes.force
    first_latch = z.size - n_s
    for a in range(1, roster.active[0] + 1):
        i = roster.active[a]
        r = system.rotors[i]
        spin = z[3 * (n + i) + 2]
        force[i, 0] = -r.radial_damping * z[3 * (n + i)]
        force[i, 1] = -r.radial_damping * z[3 * (n + i) + 1]
        force[i, 2] = -(r.drag + slopes.rotors[i]) * spin
        if r.drive == DRIVE_SERVO:
            wanted = -r.servo_gain * spin + r.servo_integral_gain * z[r.servo_slot]
            torque = wanted if modes[n_s + 5 * n_m + i] == 0 else 0.0
            force[i, 2] += torque
            dz[r.servo_slot] = -spin + (torque - wanted) / r.servo_gain
    for c in range(1, roster.sleeves[0] + 1):
        k = roster.sleeves[c]
        if modes[k] == LOADED:
            add_sleeve_change(system, k, slopes.sleeves[k], z, z[first_latch + k], force)
    for c in range(1, roster.meshes[0] + 1):
        j = roster.meshes[c]
        add_mesh_change(system, j, slopes.meshes[j], z, force)
    for a in range(1, roster.active[0] + 1):
        i = roster.active[a]
        r = system.rotors[i]
        for c in range(3):
            dz[3 * i + c] = z[3 * (n + i) + c]
        dz[3 * (n + i)] = r.inv_mass * force[i, 0]
        dz[3 * (n + i) + 1] = r.inv_mass * force[i, 1]
        dz[3 * (n + i) + 2] = r.inv_inertia * force[i, 2]


@compiled_inline
def fly_change(system: System, i: int, tau: float, z: Floats) -> None:
    """Let rotor i's entries of a change ``z`` go on by a flight of tau [s]: v' = -gamma v in closed form."""
    at, vat = 3 * i, 3 * (system.rotors.size + i)
    r = system.rotors[i]
    phi_1, _ = decay(r.radial_damping * r.inv_mass * tau)
    shrink = math.exp(-r.radial_damping * r.inv_mass * tau)
    for c in range(2):
        z[at + c] += tau * phi_1 * z[vat + c]
        z[vat + c] *= shrink
    phi_1, _ = decay(r.drag * r.inv_inertia * tau)
    z[at + 2] += tau * phi_1 * z[vat + 2]
    z[vat + 2] *= math.exp(-r.drag * r.inv_inertia * tau)
