"""Torques of drive and load of a rotor, and its power losses: drag, dry friction, damping.

For audits of energy: input is drive torque times speed, output minus load torque times speed, losses are these and those
of elements, the rest is stored (docs/theory, section 4).
"""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import pull
from gearplay.kernels.layout import Branch, System, spin_of, turn_of, vx_of, vy_of
from gearplay.kernels.smooth_sign import smooth_sign
from gearplay.parts.drive import excitation, positioner, servo


@compiled_inline
def braking(drag: float, friction: float, friction_speed: float, spin: float) -> float:
    """Return the torque [N m] against a spin [rad/s] of drag and dry friction."""
    torque = drag * spin
    if friction > 0.0:
        torque += friction * smooth_sign(spin / friction_speed)
    return torque


@compiled_inline
def lost_power(brake: float, spin: float, damping: float, v_x: float, v_y: float) -> float:
    """Return the power [W] that a rotor loses to a torque [N m] against its spin and to the damping of its centre."""
    return brake * spin + damping * (v_x * v_x + v_y * v_y)


@compiled_once
def applied_torque(system: System, i: int, y: Floats) -> float:
    """Return the torque [N m] on rotor i that is not of an element: constant torque, drag, dry friction."""
    r, spin = system.rotors[i], spin_of(system, i, y)
    return float(r.torque - braking(r.drag, r.friction, r.friction_speed, spin))


@compiled_once
def shaft_power(
    system: System,
    i: int,
    t: float,
    y: Floats,
    branch: Branch,
    torque: float,
    a_x: float,
    a_y: float,
    alpha: float,
) -> tuple[float, float, float]:
    """Return rotor i's drive torque and load torque [N m], counter-clockwise positive, and the power it loses [W].

    ``torque`` is the sum on it without a prescribed drive's torque, (a_x, a_y, alpha) its acceleration.
    """
    r, spin = system.rotors[i], spin_of(system, i, y)
    drive, load = r.drive_torque, r.torque - r.drive_torque
    if r.excitation >= 0:
        n = system.elements[r.excitation].index
        by_drive, by_load, _ = excitation.torques_of(system, n, t, y)
        drive += by_drive
        load += by_load
    if r.controller >= 0:
        controller = system.elements[r.controller]
        if controller.kind == servo.KIND:
            drive += servo.torque_of(system, controller.index, t, y, branch)
        else:
            drive += positioner.torque_of(system, controller.index, t, y, branch)
    if r.inv_inertia == 0.0:
        drive = r.inertia * alpha - torque
        if r.unbalance > 0.0:
            psi = turn_of(system, i, t, y) + r.unbalance_phase
            h_x, h_y = pull(system, t)
            drive += r.unbalance * (math.cos(psi) * (a_y - h_y) - math.sin(psi) * (a_x - h_x))
    v_x, v_y = y[vx_of(system, i)], y[vy_of(system, i)]
    brake = braking(r.drag, r.friction, r.friction_speed, spin)
    return drive, load, lost_power(brake, spin, r.radial_damping, v_x, v_y)


@compiled_inline
def is_plain(system: System, i: int) -> bool:
    """Return whether rotor i's torques and lost power follow from its speeds and its drive's acceleration alone."""
    r = system.rotors[i]
    return bool(r.group < 0 and r.excitation < 0 and r.controller < 0 and r.unbalance == 0.0)
