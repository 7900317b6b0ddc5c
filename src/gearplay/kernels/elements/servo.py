"""A servo: a speed loop between the ground and a rotor, proportional and integral, with a torque limit.

No contact, one state of its own (the integral of the speed error), one mode (0 linear, +1/-1 at the limit), one switch.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.advancement import STAYS_OPEN
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import Branch, Loads, Signal, System, omega_of, ramp_of, spin_of

Floats = NDArray[np.float64]

KIND = 0
RECORD = np.dtype(
    [
        ("rotor", "i8"),
        ("gain", "f8"),  # N m s
        ("integral_gain", "f8"),  # N m
        ("limit", "f8"),  # N m
        ("speed", "f8"),  # rad/s, once the ramp of its rotor is over
    ],
    align=True,
)
SIGNALS: tuple[Signal, ...] = ()
MEMORY: tuple[float, ...] = ()
MODES = 1
PER_CONTACT = 2
SLOPES = 0


@compiled_inline
def _target(system: System, e: int, t: float, branch: Branch) -> float:
    """Return the commanded speed [rad/s] at time t [s], with the rotor's linear ramp."""
    servo = system.records[KIND][system.elements[e].index]
    rotor = system.rotors[servo.rotor]
    if branch.modes[ramp_of(system, branch.modes, servo.rotor)] == 1:
        return rotor.ramp_start + rotor.ramp_acceleration * t
    return servo.speed


@compiled_inline
def wanted_torque(system: System, e: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the torque [N m] without its limit: kp (target - omega) + ki z."""
    element = system.elements[e]
    servo = system.records[KIND][element.index]
    error = _target(system, e, t, branch) - spin_of(system, servo.rotor, y)
    return servo.gain * error + servo.integral_gain * y[element.state]


@compiled_inline
def press(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Return 0: a servo has no contact."""
    return 0


@compiled_inline
def act(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats) -> int:
    """Add servo e's torque to the sum on its rotor, and the rate of its integral to ``dy``; return 0."""
    element = system.elements[e]
    servo = system.records[KIND][element.index]
    wanted = wanted_torque(system, e, t, y, branch)
    mode = branch.modes[element.mode]
    torque = wanted if mode == 0 else mode * servo.limit
    loads.rotors[servo.rotor, 2] += torque
    # Back-calculation: the integral follows what the limit lets through.
    error = _target(system, e, t, branch) - spin_of(system, servo.rotor, y)
    dy[element.state] = error + (torque - wanted) / servo.gain
    return 0


@compiled_inline
def stay_open(
    system: System, e: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return that nothing can touch."""
    return STAYS_OPEN, longest


@compiled_inline
def own_switch(system: System, e: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return how far [N m] servo e is beyond its limit, or from it where it is limited."""
    element = system.elements[e]
    limit, mode = system.records[KIND][element.index].limit, branch.modes[element.mode]
    wanted = wanted_torque(system, e, t, y, branch)
    return abs(wanted) - limit if mode == 0 else limit - mode * wanted


@compiled
def switch_own(system: System, e: int, s: int, t: float, y: Floats, branch: Branch) -> None:
    """Reach the limit or leave it."""
    slot = system.elements[e].mode
    if branch.modes[slot] == 0:
        branch.modes[slot] = int(math.copysign(1.0, wanted_torque(system, e, t, y, branch)))
    else:
        branch.modes[slot] = 0


@compiled
def settle(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set servo e's mode from the state alone."""
    element = system.elements[e]
    torque, limit = wanted_torque(system, e, t, y, branch), system.records[KIND][element.index].limit
    branch.modes[element.mode] = int(math.copysign(1.0, torque)) if abs(torque) > limit else 0


@compiled
def linearise(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Return 0: a servo is linear on each of its modes."""
    return 0


@compiled
def crossing(system: System, e: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return zeros: nothing jumps where a servo reaches its limit."""
    return 0.0, 0.0, 0.0


@compiled
def add_change(
    system: System, e: int, row: Floats, z: Floats, branch: Branch, force: Floats, dz: Floats
) -> None:
    """Add to ``force`` and ``dz`` what a change z of the state changes in servo e's torque and in its integral's rate."""
    element = system.elements[e]
    servo = system.records[KIND][element.index]
    spin = z[omega_of(system, servo.rotor)]
    wanted = -servo.gain * spin + servo.integral_gain * z[element.state]
    torque = wanted if branch.modes[element.mode] == 0 else 0.0
    force[servo.rotor, 2] += torque
    dz[element.state] = -spin + (torque - wanted) / servo.gain


@compiled_inline
def may_return(
    system: System, e: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, stages: Floats,
    g_0: Floats, g_1: Floats,
) -> bool:  # fmt: skip
    """Return whether switch s of servo e, not positive at both ends of a step of h [s], may be so in between.

    Where the torque wanted rises and falls among the stages it may do so by half of its fastest change.
    """
    element = system.elements[e]
    servo = system.records[KIND][element.index]
    ramp = 0.0
    if branch.modes[ramp_of(system, branch.modes, servo.rotor)] == 1:
        ramp = system.rotors[servo.rotor].ramp_acceleration
    least, most = math.inf, -math.inf
    for stage in range(stages.shape[0]):
        error_rate = ramp - stages[stage, omega_of(system, servo.rotor)]
        rate = servo.gain * error_rate + servo.integral_gain * stages[stage, element.state]
        least, most = min(least, rate), max(most, rate)
    if least >= 0.0 or most <= 0.0:
        return False
    return max(g_0[element.switch], g_1[element.switch]) + 0.5 * h * max(most, -least) > 0.0


@compiled_inline
def observe(
    system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill nothing: a servo has no signals."""
