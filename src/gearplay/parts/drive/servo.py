"""A servo: a speed loop between the ground and a rotor, proportional and integral, with a torque limit.

No contact, one state of its own (the integral of the speed error), one mode (0 linear, +1/-1 at the limit), one switch.

A motor at a voltage u is one too: L i' + R i + k omega = u, T = k i, is lag T' = (k^2 / R) (u / k - omega) - T with the lag
L / R, so that its gain is k^2 / R, its speed u / k; T is a second state, and the first rests.
"""

import math

import numpy as np

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    PLACES,
    Branch,
    Loads,
    Signal,
    System,
    omega_of,
    ramp_of,
    spin_of,
)
from gearplay.kernels.set_point import FIELDS, set_point
from gearplay.parts.drive.torque_limit import limit_of, limited, may_pass, past_limit, shown

KIND = 0
RECORD = np.dtype(
    [
        *PLACES,
        ("rotor", "i8"),
        ("gain", "f8"),  # N m s
        ("integral_gain", "f8"),  # N m
        ("limit", "f8"),  # N m
        ("lag", "f8"),  # s, time constant of a motor's winding, 0 for none
        ("speed", "f8"),  # rad/s, once the ramp of its rotor is over
        *FIELDS,
    ],
    align=True,
)
SIGNALS: tuple[Signal, ...] = ()
MEMORY: tuple[float, ...] = ()
MODES = 1
PER_CONTACT = 0
SLOPES = 0
LAGGED = 1  # place among its states of the torque of a motor


@compiled_inline
def _target(system: System, n: int, t: float, branch: Branch) -> float:
    """Return the commanded speed [rad/s] at time t [s], with the rotor's linear ramp."""
    servo = system.records[KIND][n]
    rotor = system.rotors[servo.rotor]
    if branch.modes[ramp_of(system, branch.modes, servo.rotor)] == 1:
        return rotor.ramp_start + rotor.ramp_acceleration * t
    speed, _ = set_point(system, servo.speed, servo.set_point, servo.set_points, servo.wave, t)
    return speed


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] of sines; NaN for other set-points over time, which do not repeat."""
    each = system.records[KIND]
    waves = system.terms[each["wave"][each["wave"] >= 0], 0]
    return [*waves.tolist(), *[math.nan] * int(np.sum(each["set_points"] > 0))]


@compiled_inline
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the angular frequency [rad/s] of its set-point's sine."""
    wave = system.records[KIND][n].wave
    return float(system.terms[wave, 0]) if wave >= 0 else 0.0


@compiled_inline
def wanted_torque(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the torque [N m] without its limit: kp (target - omega) + ki z."""
    servo = system.records[KIND][n]
    error = _target(system, n, t, branch) - spin_of(system, servo.rotor, y)
    return servo.gain * error + servo.integral_gain * y[servo.state]


@compiled_once
def torque_of(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return servo n's torque [N m] at (t, y)."""
    servo = system.records[KIND][n]
    if servo.lag > 0.0:
        return y[servo.state + LAGGED]
    wanted = wanted_torque(system, n, t, y, branch)
    return shown(limited(wanted, servo.limit, branch.modes[servo.mode]), servo.limit)


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add servo n's torque to the sum on its rotor, and the rate of its integral to ``dy``; return 0."""
    servo = system.records[KIND][n]
    wanted = wanted_torque(system, n, t, y, branch)
    torque = limited(wanted, servo.limit, branch.modes[servo.mode])
    if servo.lag > 0.0:
        loads.rotors[servo.rotor, 2] += y[servo.state + LAGGED]
        dy[servo.state], dy[servo.state + LAGGED] = 0.0, (torque - y[servo.state + LAGGED]) / servo.lag
        return 0
    loads.rotors[servo.rotor, 2] += torque
    # Back-calculation: the integral follows what the limit lets through.
    error = _target(system, n, t, branch) - spin_of(system, servo.rotor, y)
    dy[servo.state] = error + (torque - wanted) / servo.gain
    return 0


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return how far [N m] servo n is beyond its limit, or from it where it is limited."""
    servo = system.records[KIND][n]
    return past_limit(wanted_torque(system, n, t, y, branch), servo.limit, branch.modes[servo.mode])


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Reach the limit or leave it."""
    slot = system.records[KIND][n].mode
    if branch.modes[slot] == 0:
        branch.modes[slot] = limit_of(wanted_torque(system, n, t, y, branch))
    else:
        branch.modes[slot] = 0


@compiled_once
def initialise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set servo n's mode from the state alone."""
    servo = system.records[KIND][n]
    torque, limit = wanted_torque(system, n, t, y, branch), servo.limit
    branch.modes[servo.mode] = limit_of(torque) if abs(torque) > limit else 0


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Return 0: a servo is linear on each of its modes."""
    return 0


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the changes of servo n's torque and of its integral's rate by a change z of the state to ``force`` and ``dz``."""
    servo = system.records[KIND][n]
    spin = z[omega_of(system, servo.rotor)]
    wanted = -servo.gain * spin + servo.integral_gain * z[servo.state]
    torque = wanted if branch.modes[servo.mode] == 0 else 0.0
    if servo.lag > 0.0:
        force[servo.rotor, 2] += z[servo.state + LAGGED]
        dz[servo.state], dz[servo.state + LAGGED] = 0.0, (torque - z[servo.state + LAGGED]) / servo.lag
        return
    force[servo.rotor, 2] += torque
    dz[servo.state] = -spin + (torque - wanted) / servo.gain


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether switch s of servo n, not positive at both ends of a step of h [s], may be so in between.

    The stages show the rates of the torque wanted.
    """
    servo = system.records[KIND][n]
    ramp = 0.0
    if branch.modes[ramp_of(system, branch.modes, servo.rotor)] == 1:
        ramp = system.rotors[servo.rotor].ramp_acceleration
    least, most = math.inf, -math.inf
    for stage in range(stages.shape[0]):
        error_rate = ramp - stages[stage, omega_of(system, servo.rotor)]
        rate = servo.gain * error_rate + servo.integral_gain * stages[stage, servo.state]
        least, most = min(least, rate), max(most, rate)
    moved = servo.gain * servo.steepest
    return may_pass(least - moved, most + moved, h, g_0[servo.switch], g_1[servo.switch])


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill nothing: a servo has no signals."""
