"""The right-hand side: all forces of the current contact modes, then Newton and Euler, eq. (20)."""

import numpy as np

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import ActiveSet
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import pull
from gearplay.kernels.layout import (
    CONTACT_COLUMNS,
    DRIVE_SPEED,
    OUT_SIZE,
    Branch,
    Loads,
    System,
    omega_of,
    ramp_of,
    spin_of,
    vx_of,
    vy_of,
    x_of,
)
from gearplay.kernels.prescribed import follow_drive
from gearplay.kernels.smooth_sign import smooth_sign
from gearplay.kernels.unbalance import accelerate


def make_loads(system: System) -> Loads:
    """Allocate the loads of a system."""
    return Loads(
        contacts=np.zeros((system.contacts.size, CONTACT_COLUMNS)),
        rotors=np.zeros((system.rotors.size, 3)),
        out=np.zeros(OUT_SIZE),
    )


@compiled_inline
def right_hand_side(
    system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch, dy: Floats, loads: Loads
) -> int:
    """Fill ``dy`` with the derivative of the active states; return 0, or 1 where a pair cannot mesh.

    ``branch`` fixes which smooth branch each contact is on and the stored impact speeds [m/s]; ``loads`` is filled on the
    way for what acts. A rippling drive's rotation is a function of t alone: it is set in ``y``, whatever was there. State
    order: docs/conventions.
    """
    force = loads.rotors
    pull_x, pull_y = pull(system, t)
    for a in range(1, active_set.active[0] + 1):
        i = active_set.active[a]
        r = system.rotors[i]
        if r.varying == 1:
            dy[omega_of(system, i)] = follow_drive(system, i, t, y)
        omega = spin_of(system, i, y)
        force[i, 0] = r.mass * pull_x - r.radial_damping * y[vx_of(system, i)]
        force[i, 1] = r.mass * pull_y - r.radial_damping * y[vy_of(system, i)]
        force[i, 2] = r.torque - r.drag * omega
        if r.friction > 0.0:
            force[i, 2] -= r.friction * smooth_sign(omega / r.friction_speed)
    if dispatch.apply_forces(system, active_set.acting, t, y, branch, loads, dy) != 0:
        return 1
    for a in range(1, active_set.active[0] + 1):
        i = active_set.active[a]
        r = system.rotors[i]
        for axis in range(3):
            dy[x_of(i) + axis] = y[vx_of(system, i) + axis]
        dy[vx_of(system, i)] = r.inv_mass * force[i, 0]
        dy[vy_of(system, i)] = r.inv_mass * force[i, 1]
        if r.varying == 0:
            dy[omega_of(system, i)] = r.inv_inertia * force[i, 2]
        if r.drive == DRIVE_SPEED and branch.modes[ramp_of(system, branch.modes, i)] == 1:
            dy[omega_of(system, i)] = r.ramp_acceleration
        if r.unbalance > 0.0:
            accelerate(system, i, t, y, force, dy)
    return 0


@compiled_once
def rates_of(
    system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch, dy: Floats, loads: Loads
) -> int:
    """Evaluate `right_hand_side` as a function of the library: a copy of its code for each caller would not fit in the cache."""
    return right_hand_side(system, active_set, t, y, branch, dy, loads)
