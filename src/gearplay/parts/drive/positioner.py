"""A position servo: T = s (kp e + ki z - kd omega), e = angle - theta, limited; theta and omega of a sensor's rotor, which turns
the driven one's way, s = 1, or against it, s = -1 (docs/theory, section 4).

Continuous: one switch, at its limit or below it; z' = e + s (T_limited - T) / kp. Sampled: one switch, the next sample; two
states, which only samples change: z, and the torque that is held until the next.
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
    spin_of,
    theta_of,
    turn_of,
)
from gearplay.parts.drive.torque_limit import limit_of, limited, may_pass, past_limit

KIND = 7
RECORD = np.dtype(
    [
        *PLACES,
        ("rotor", "i8"),
        ("sensor", "i8"),  # rotor
        ("sense", "f8"),  # s
        ("angle", "f8"),  # rad
        ("proportional_gain", "f8"),  # N m/rad
        ("integral_gain", "f8"),  # N m/(rad s)
        ("derivative_gain", "f8"),  # N m s/rad
        ("limit", "f8"),  # N m
        ("sample_time", "f8"),  # s, 0 for a continuous one
    ],
    align=True,
)
SIGNALS = (
    Signal("position_torque", "T", "N m", "N m", 1.0, "torque of the position servo", True),
    Signal(
        "position_error", "e", "rad", "deg", 180.0 / math.pi, "angle wanted less that of the sensor", True
    ),
)
# Slots of the memory: how many samples there have been, whether the last one was limited.
SAMPLES, LIMITED = range(2)
MEMORY = (0.0, 0.0)
MODES = 1
PER_CONTACT = 0
SLOPES = 0


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] of sampled controls."""
    sampled = system.records[KIND]["sample_time"]
    return (2.0 * math.pi / sampled[sampled > 0.0]).tolist()


@compiled_inline
def error_of(system: System, n: int, t: float, y: Floats) -> float:
    """Return servo n's angle wanted less that of its sensor [rad]."""
    each = system.records[KIND][n]
    return each.angle - turn_of(system, each.sensor, t, y)


@compiled_inline
def wanted_torque(system: System, n: int, t: float, y: Floats) -> float:
    """Return the torque [N m] without its limit."""
    each = system.records[KIND][n]
    return each.sense * (
        each.proportional_gain * error_of(system, n, t, y)
        + each.integral_gain * y[each.state]
        - each.derivative_gain * spin_of(system, each.sensor, y)
    )


@compiled_once
def torque_of(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the torque [N m] at (t, y): that of the last sample, or the limited one."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return y[each.state + 1]
    return limited(wanted_torque(system, n, t, y), each.limit, branch.modes[each.mode])


@compiled_once
def take_sample(system: System, n: int, t: float, y: Floats, branch: Branch) -> None:
    """Let servo n take its next sample at (t, y): set its torque and its integral in ``y``."""
    each = system.records[KIND][n]
    memory = branch.memory[each.element]
    wanted = wanted_torque(system, n, t, y)
    torque = min(max(wanted, -each.limit), each.limit)
    y[each.state] += each.sample_time * (
        error_of(system, n, t, y) + each.sense * (torque - wanted) / each.proportional_gain
    )
    y[each.state + 1] = torque
    memory[SAMPLES] += 1.0
    memory[LIMITED] = 1.0 if torque != wanted else 0.0


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add servo n's torque to the sum on its rotor, and the rates of its states to ``dy``; return 0."""
    each = system.records[KIND][n]
    torque = torque_of(system, n, t, y, branch)
    loads.rotors[each.rotor, 2] += torque
    if each.sample_time > 0.0:
        dy[each.state] = dy[each.state + 1] = 0.0
    else:
        wanted = wanted_torque(system, n, t, y)
        # Back-calculation: the integral follows what the limit lets through.
        dy[each.state] = error_of(system, n, t, y) + each.sense * (torque - wanted) / each.proportional_gain
    return 0


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return how late [s] the next sample is, or how far [N m] the servo is beyond its limit, or from it where limited."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return t - branch.memory[each.element, SAMPLES] * each.sample_time
    return past_limit(wanted_torque(system, n, t, y), each.limit, branch.modes[each.mode])


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Take a sample, or reach the limit or leave it."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
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


@compiled_inline
def _wanted_change(system: System, n: int, z: Floats) -> float:
    """Return the change of the unlimited torque [N m] by a change z of the state."""
    each = system.records[KIND][n]
    return each.sense * (
        each.integral_gain * z[each.state]
        - each.proportional_gain * z[theta_of(each.sensor)]
        - each.derivative_gain * z[omega_of(system, each.sensor)]
    )


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the changes of servo n's torque and of its states' rates by a change z of the state to ``force`` and ``dz``."""
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        force[each.rotor, 2] += z[each.state + 1]
        dz[each.state] = dz[each.state + 1] = 0.0
        return
    wanted = _wanted_change(system, n, z)
    torque = wanted if branch.modes[each.mode] == 0 else 0.0
    force[each.rotor, 2] += torque
    dz[each.state] = -z[theta_of(each.sensor)] + each.sense * (torque - wanted) / each.proportional_gain


@compiled_once
def carry_sample(system: System, n: int, before: Rows, branch: Branch, z: Floats) -> None:
    """Carry a change z of the state over a sample just taken by servo n, ``before`` the memories until then."""
    each = system.records[KIND][n]
    memory = branch.memory[each.element]
    if each.sample_time == 0.0 or memory[SAMPLES] == before[each.element, SAMPLES]:
        return
    wanted = _wanted_change(system, n, z)
    torque = wanted if memory[LIMITED] == 0.0 else 0.0
    z[each.state] += each.sample_time * (
        -z[theta_of(each.sensor)] + each.sense * (torque - wanted) / each.proportional_gain
    )
    z[each.state + 1] = torque


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether the limit of servo n, not passed at both ends of a step of h [s], may be so in between.

    The stages show the rates of the torque wanted.
    """
    each = system.records[KIND][n]
    if each.sample_time > 0.0:
        return False
    least, most = math.inf, -math.inf
    for stage in range(stages.shape[0]):
        rate = (
            each.integral_gain * stages[stage, each.state]
            - each.proportional_gain * stages[stage, theta_of(each.sensor)]
            - each.derivative_gain * stages[stage, omega_of(system, each.sensor)]
        )
        least, most = min(least, rate), max(most, rate)
    return may_pass(least, most, h, g_0[each.switch], g_1[each.switch])


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill servo n's signals of a full ``row`` at (t, y)."""
    at = system.records[KIND][n].signal
    row[at], row[at + 1] = torque_of(system, n, t, y, branch), error_of(system, n, t, y)
