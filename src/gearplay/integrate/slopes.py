"""First-order changes of the right-hand side and of free motion.

The derivative of `right_hand_side` on fixed modes and of `free_motion.propagate` (docs/theory, "Tangent of the motion"):
every element computes its own slopes; here they are assembled. A change z holds the states in their order, then the stored
impact speeds.
"""

import math
from dataclasses import dataclass

import numpy as np

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import ActiveSet
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.decay import decay
from gearplay.kernels.layout import (
    THETA,
    Branch,
    Loads,
    System,
    omega_of,
    spin_of,
    vx_of,
    vy_of,
    x_of,
)
from gearplay.kernels.smooth_sign import smooth_sign_slope
from gearplay.kernels.unbalance import COLUMNS, change_accelerations, linearise_unbalance
from gearplay.parts.registry import KINDS


@dataclass(frozen=True, eq=False)
class Slopes(Group):
    """First-order data of all elements at one state, and scratch; made by `make_slopes`."""

    elements: Rows  # [element, columns of the widest kind]
    rotors: Floats  # [rotor], slope of dry friction by the speed [N m s]
    unbalances: Rows  # [rotor, COLUMNS]
    force: Rows  # [rotor, 3]


def make_slopes(system: System) -> Slopes:
    """Allocate the slopes of a system."""
    n, widest = system.rotors.size, max(kind.file.SLOPES for kind in KINDS)
    widest += int(np.max(system.elements["more_slopes"], initial=0))
    return Slopes(
        elements=np.zeros((system.elements.size, widest)),
        rotors=np.zeros(n),
        unbalances=np.zeros((n, COLUMNS)),
        force=np.zeros((n, 3)),
    )


@compiled_once
def linearise(
    system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch, slopes: Slopes, loads: Loads
) -> int:
    """Fill ``slopes``, and contacts of ``loads`` on the way, at (t, y) for what is active and acting; 1 where a pair cannot mesh.

    The sums of forces on the rotors in ``loads`` are those of (t, y) already.
    """
    for a in range(1, active_set.active[0] + 1):
        i = active_set.active[a]
        r = system.rotors[i]
        slopes.rotors[i] = 0.0
        if r.friction > 0.0:
            u = spin_of(system, i, y) / r.friction_speed
            slopes.rotors[i] = r.friction / r.friction_speed * smooth_sign_slope(u)
        if r.unbalance > 0.0:
            linearise_unbalance(system, i, t, y, loads.rotors, slopes.unbalances[i])
    for c in range(1, active_set.acting[0] + 1):
        e = active_set.acting[c]
        if dispatch.linearise(system, e, t, y, branch, loads, slopes.elements[e]) != 0:
            return 1
    return 0


@compiled_once
def rate_of_change(
    system: System, active_set: ActiveSet, branch: Branch, slopes: Slopes, z: Floats, dz: Floats
) -> None:
    """Fill the active entries of ``dz`` with the rate at which a change ``z`` grows."""
    force = slopes.force
    for a in range(1, active_set.active[0] + 1):
        i = active_set.active[a]
        r = system.rotors[i]
        force[i, 0] = -r.radial_damping * z[vx_of(system, i)]
        force[i, 1] = -r.radial_damping * z[vy_of(system, i)]
        force[i, 2] = -(r.drag + slopes.rotors[i]) * z[omega_of(system, i)]
    for c in range(1, active_set.acting[0] + 1):
        e = active_set.acting[c]
        dispatch.add_change(system, e, slopes.elements[e], z, branch, force, dz)
    for a in range(1, active_set.active[0] + 1):
        i = active_set.active[a]
        r = system.rotors[i]
        for axis in range(3):
            dz[x_of(i) + axis] = z[vx_of(system, i) + axis]
        dz[vx_of(system, i)] = r.inv_mass * force[i, 0]
        dz[vy_of(system, i)] = r.inv_mass * force[i, 1]
        dz[omega_of(system, i)] = r.inv_inertia * force[i, 2]
        if r.unbalance > 0.0:
            change_accelerations(system, i, slopes.unbalances[i], z, force, dz)


@compiled_inline
def propagate_change(system: System, i: int, tau: float, z: Floats) -> None:
    """Let rotor i's entries of a change ``z`` propagate in free motion over tau [s]: v' = -gamma v in closed form.

    But for those that springs join to others: `joined.move_change`.
    """
    r = system.rotors[i]
    for axis in range(3):
        q, v = x_of(i) + axis, vx_of(system, i) + axis
        gamma = r.drag * r.inv_inertia if axis == THETA else r.radial_damping * r.inv_mass
        if system.joined.places[2 * q] < 0:
            phi_1, _ = decay(gamma * tau)
            z[q] += tau * phi_1 * z[v]
            z[v] *= math.exp(-gamma * tau)
