"""A position loop: T = s (kp e + ki z - kd c omega), limited; e = angle + lead angle' - theta of a sensor's rotor, omega of the
rotor whose speed is measured. s = 1 where the sensor's rotor turns the driven one's way, -1 against it; c is the same between
the two sensors' rotors (docs/theory, section 4).

z' = e - share c omega + s (T_limited - T) / kp: with a share of 0 the integral is that of the angle's error, with kd / kp that of
the speed's error in a cascade, whose speed loop has the gain kd and wants the speed (kp / kd) e.

Continuous: one switch, at its limit or below it. Sampled: one switch, the next sample or the next torque; states that only these
change: z, the torque that is held, the one that waits for its delay, the error that the speed loop holds. A current loop of first
order is one more state in both.
"""

import math
from typing import Any

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
    spin_of,
    theta_of,
    turn_of,
)
from gearplay.kernels.set_point import FIELDS, set_point
from gearplay.parts.drive.torque_limit import limit_of, limited, may_pass, past_limit, shown

KIND = 7
RECORD = np.dtype(
    [
        *PLACES,
        ("rotor", "i8"),
        ("sensor", "i8"),  # rotor whose angle is measured
        ("speed_sensor", "i8"),  # rotor whose speed is measured
        ("sense", "f8"),  # s
        ("speed_sense", "f8"),  # c
        ("angle", "f8"),  # rad
        *FIELDS,
        ("lead", "f8"),  # s, share of the set-point's rate that is added to it
        ("proportional_gain", "f8"),  # N m/rad
        ("integral_gain", "f8"),  # N m/(rad s)
        ("derivative_gain", "f8"),  # N m s/rad
        ("share", "f8"),  # s, of the speed in the integral
        ("limit", "f8"),  # N m
        ("lag", "f8"),  # s, time constant of the current loop, 0 for none
        ("sample_time", "f8"),  # s, 0 for a continuous one
        ("every", "i8"),  # samples of the speed loop per sample of the position loop
        ("delay", "f8"),  # s, from a sample to its torque
        ("resolution", "f8"),  # rad, of the angle's encoder, 0 for an exact one
        (
            "speed_resolution",
            "f8",
        ),  # rad, of the encoder whose differences are the speed, 0 for an exact speed
        ("lagged", "i8"),  # place among its states of the torque behind the current loop
        ("waiting", "i8"),  # of the torque that waits for its delay
        ("held_error", "i8"),  # of the error that the speed loop holds
    ],
    align=True,
)
SIGNALS = (
    Signal("position_torque", "T", "N m", "N m", 1.0, "torque of the position servo", True),
    Signal(
        "position_error", "e", "rad", "deg", 180.0 / math.pi, "angle wanted less that of the sensor", True
    ),
)
# Slots of the memory: number of samples so far, whether the last torque was limited, number of torques given so far, last
# count of the encoder whose differences are the speed [rad].
SAMPLES, LIMITED, GIVEN, COUNT = range(4)
MEMORY = (0.0, 0.0, 0.0, 0.0)
MODES = 1
PER_CONTACT = 0
SLOPES = 0
HELD = 1  # place among its states of the torque of a sampled one


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] of sampled controls and of sines; NaN for other set-points, which do not repeat."""
    each = system.records[KIND]
    sampled = each["sample_time"]
    waves = system.terms[each["wave"][each["wave"] >= 0], 0]
    return [
        *(2.0 * math.pi / sampled[sampled > 0.0]).tolist(),
        *waves.tolist(),
        *[math.nan] * int(np.sum(each["set_points"] > 0)),
    ]


@compiled_inline
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the angular frequency [rad/s] of its set-point's sine."""
    wave = system.records[KIND][n].wave
    return float(system.terms[wave, 0]) if wave >= 0 else 0.0


@compiled_once
def target(system: System, n: int, t: float) -> tuple[float, float]:
    """Return the angle wanted [rad] and its rate [rad/s] at t [s]."""
    each = system.records[KIND][n]
    return set_point(system, each.angle, each.set_point, each.set_points, each.wave, t)


@compiled_inline
def error_of(system: System, n: int, t: float, y: Floats) -> float:
    """Return servo n's angle wanted less that of its sensor [rad]."""
    angle, _ = target(system, n, t)
    return angle - turn_of(system, system.records[KIND][n].sensor, t, y)


@compiled_inline
def _led_error(system: System, n: int, t: float, y: Floats) -> float:
    """Return the error [rad] with the lead of the set-point, of exact sensors."""
    each = system.records[KIND][n]
    angle, rate = target(system, n, t)
    return angle - turn_of(system, each.sensor, t, y) + each.lead * rate


@compiled_inline
def _demand(system: System, n: int, e: float, z: float, omega: float) -> float:
    """Return the torque [N m] without its limit, by an error, its integral and a speed."""
    each = system.records[KIND][n]
    return each.sense * (
        each.proportional_gain * e
        + each.integral_gain * z
        - each.derivative_gain * (each.speed_sense * omega)
    )


@compiled_inline
def _integral_rate(system: System, n: int, e: float, omega: float, excess: float) -> float:
    """Return z' by an error, a speed, and what the limit takes from the torque [N m]: back-calculation. Without a gain 0."""
    each = system.records[KIND][n]
    if each.integral_gain == 0.0:
        return 0.0
    rate = e + each.sense * excess / each.proportional_gain
    return rate - each.share * each.speed_sense * omega if each.share > 0.0 else rate


@compiled_inline
def wanted_torque(system: System, n: int, t: float, y: Floats) -> float:
    """Return the torque [N m] of a continuous loop without its limit."""
    each = system.records[KIND][n]
    omega = spin_of(system, each.speed_sensor, y)
    return _demand(system, n, _led_error(system, n, t, y), y[each.state], omega)


@compiled_inline
def _given_torque(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the torque [N m] that the control gives at (t, y): that of the last sample, or the limited one."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return y[each.state + HELD]
    return limited(wanted_torque(system, n, t, y), each.limit, branch.modes[each.mode])


@compiled_once
def torque_of(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the torque [N m] that acts at (t, y)."""
    each = system.records[KIND][n]
    if each.lag > 0.0:
        return y[each.state + each.lagged]
    return shown(_given_torque(system, n, t, y, branch), each.limit)


@compiled_inline
def counted(angle: float, resolution: float) -> float:
    """Return the nearest count [rad] of an encoder with a resolution [rad]; the angle itself for 0."""
    return resolution * math.floor(angle / resolution + 0.5) if resolution > 0.0 else angle


@compiled_inline
def _hold(each: Any, torque: float, y: Floats) -> None:
    """Put a sample's torque [N m], or its change, among the states ``y``: held, or waiting for its delay after the one before."""
    if each.delay > 0.0:
        if each.delay >= each.sample_time:
            y[each.state + HELD] = y[each.state + each.waiting]
        y[each.state + each.waiting] = torque
    else:
        y[each.state + HELD] = torque


@compiled_once
def take_sample(system: System, n: int, t: float, y: Floats, branch: Branch) -> None:
    """Let servo n take its next sample at (t, y): set its torque, or the one that waits, and its integral in ``y``."""
    each = system.records[KIND][n]
    memory = branch.memory[each.element]
    angle, rate = target(system, n, t)
    e = angle - counted(turn_of(system, each.sensor, t, y), each.resolution) + each.lead * rate
    if each.every > 1:
        if memory[SAMPLES] % each.every == 0.0:
            y[each.state + each.held_error] = e
        else:
            e = y[each.state + each.held_error]
    omega = spin_of(system, each.speed_sensor, y)
    if each.speed_resolution > 0.0:
        count = counted(turn_of(system, each.speed_sensor, t, y), each.speed_resolution)
        omega = (count - memory[COUNT]) / each.sample_time if memory[SAMPLES] > 0.0 else 0.0
        memory[COUNT] = count
    wanted = _demand(system, n, e, y[each.state], omega)
    torque = min(max(wanted, -each.limit), each.limit)
    y[each.state] += each.sample_time * _integral_rate(system, n, e, omega, torque - wanted)
    _hold(each, torque, y)
    memory[SAMPLES] += 1.0
    memory[LIMITED] = 1.0 if torque != wanted else 0.0


@compiled_inline
def _give_time(system: System, n: int, branch: Branch) -> float:
    """Return when the torque that waits is given [s], infinity where none waits or the next sample gives it."""
    each = system.records[KIND][n]
    memory = branch.memory[each.element]
    if each.delay == 0.0 or each.delay >= each.sample_time or memory[GIVEN] >= memory[SAMPLES]:
        return math.inf
    return float(memory[GIVEN] * each.sample_time + each.delay)


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add servo n's torque to the sum on its rotor, and the rates of its states to ``dy``; return 0."""
    each = system.records[KIND][n]
    given = _given_torque(system, n, t, y, branch)
    torque = given
    for k in range(each.state, each.state + each.states):
        dy[k] = 0.0
    if each.lag > 0.0:
        torque = y[each.state + each.lagged]
        dy[each.state + each.lagged] = (given - torque) / each.lag
    loads.rotors[each.rotor, 2] += torque
    if each.sample_time == 0.0:
        wanted, omega = wanted_torque(system, n, t, y), spin_of(system, each.speed_sensor, y)
        dy[each.state] = _integral_rate(system, n, _led_error(system, n, t, y), omega, given - wanted)
    return 0


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return how late [s] the next sample or torque is, or how far [N m] the servo is beyond its limit, or short of it."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return t - min(branch.memory[each.element, SAMPLES] * each.sample_time, _give_time(system, n, branch))
    return past_limit(wanted_torque(system, n, t, y), each.limit, branch.modes[each.mode])


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Take a sample, give the torque that waited, or reach the limit or leave it."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        memory = branch.memory[each.element]
        if _give_time(system, n, branch) < memory[SAMPLES] * each.sample_time:
            y[each.state + HELD] = y[each.state + each.waiting]
            memory[GIVEN] += 1.0
        else:
            take_sample(system, n, t, y, branch)
    elif branch.modes[each.mode] == 0:
        branch.modes[each.mode] = limit_of(wanted_torque(system, n, t, y))
    else:
        branch.modes[each.mode] = 0


@compiled_once
def initialise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set servo n's mode from the state alone, or take the sample of t = 0."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        take_sample(system, n, t, y, branch)
        return
    torque, limit = wanted_torque(system, n, t, y), each.limit
    branch.modes[each.mode] = limit_of(torque) if abs(torque) > limit else 0


@compiled_inline
def takes_samples(system: System, n: int) -> bool:
    """Return whether servo n is a sampled one."""
    return bool(system.records[KIND][n].sample_time > 0.0)


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Return 0: a servo is linear on each of its modes."""
    return 0


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the changes of servo n's torque and of its states' rates by a change z of the state to ``force`` and ``dz``."""
    each = system.records[KIND][n]
    for k in range(each.state, each.state + each.states):
        dz[k] = 0.0
    if each.sample_time > 0.0:
        given = z[each.state + HELD]
    else:
        e, omega = -z[theta_of(each.sensor)], z[omega_of(system, each.speed_sensor)]
        wanted = _demand(system, n, e, z[each.state], omega)
        given = wanted if branch.modes[each.mode] == 0 else 0.0
        dz[each.state] = _integral_rate(system, n, e, omega, given - wanted)
    torque = given
    if each.lag > 0.0:
        torque = z[each.state + each.lagged]
        dz[each.state + each.lagged] = (given - torque) / each.lag
    force[each.rotor, 2] += torque


@compiled_once
def carry_sample(system: System, n: int, before: Rows, branch: Branch, z: Floats) -> None:
    """Carry a change z of the state over a sample or a torque of servo n, ``before`` the memories until then.

    Counts of an encoder do not change with small changes of the angle.
    """
    each = system.records[KIND][n]
    memory = branch.memory[each.element]
    if each.sample_time == 0.0:
        return
    if memory[GIVEN] != before[each.element, GIVEN]:
        z[each.state + HELD] = z[each.state + each.waiting]
    if memory[SAMPLES] == before[each.element, SAMPLES]:
        return
    e = -z[theta_of(each.sensor)] if each.resolution == 0.0 else 0.0
    if each.every > 1:
        if before[each.element, SAMPLES] % each.every == 0.0:
            z[each.state + each.held_error] = e
        else:
            e = z[each.state + each.held_error]
    omega = z[omega_of(system, each.speed_sensor)] if each.speed_resolution == 0.0 else 0.0
    wanted = _demand(system, n, e, z[each.state], omega)
    torque = wanted if memory[LIMITED] == 0.0 else 0.0
    z[each.state] += each.sample_time * _integral_rate(system, n, e, omega, torque - wanted)
    _hold(each, torque, z)


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether the limit of servo n, not passed at both ends of a step of h [s], may be so in between.

    The stages show the rates of the torque wanted, but for that of the set-point, which is bounded.
    """
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return False
    least, most = math.inf, -math.inf
    for stage in range(stages.shape[0]):
        rate = (
            each.integral_gain * stages[stage, each.state]
            - each.proportional_gain * stages[stage, theta_of(each.sensor)]
            - each.derivative_gain * (each.speed_sense * stages[stage, omega_of(system, each.speed_sensor)])
        )
        least, most = min(least, rate), max(most, rate)
    moved = each.proportional_gain * each.steepest
    return may_pass(least - moved, most + moved, h, g_0[each.switch], g_1[each.switch])


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill servo n's signals of a full ``row`` at (t, y)."""
    at = system.records[KIND][n].signal
    row[at], row[at + 1] = torque_of(system, n, t, y, branch), error_of(system, n, t, y)
