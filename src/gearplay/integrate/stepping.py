"""Steps of a run between communication points, with inputs held over each: torques and set-points that a caller changes.

A step that ends at a communication point leaves the learnt step length and the implicit method as they were. An input that does
not change leaves no trace; one that does is a jump of the right-hand side at the start of a step.
"""

import math
from dataclasses import dataclass

import numpy as np

from gearplay.integrate import dispatch
from gearplay.integrate.implicit import GROWTH, H_EXPLICIT, IN_USE, TRACED
from gearplay.integrate.method_choice import GROWS, SHRINKS
from gearplay.integrate.restart import evaluate, restart
from gearplay.integrate.run import (
    AHEAD,
    BEGUN,
    BURST,
    BURST_START,
    CANNOT_MESH,
    DONE,
    LAST_SAMPLE,
    LOGGED,
    NEXT_SAMPLE,
    PAUSED,
    REJECTED,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    T_END,
    H,
    Run,
    T,
)
from gearplay.integrate.sampling import record_samples
from gearplay.integrate.stepper import advance, log_is_full
from gearplay.kernels.arrays import Floats, Ints
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import ACTIVE, System, theta_of
from gearplay.parts.registry import POSITIONER, SERVO

# Kinds of inputs: torque of a drive, of a load, commanded speed of a servo, commanded angle of a position servo.
DRIVE_INPUT, LOAD_INPUT, SPEED_INPUT, ANGLE_INPUT = range(4)
# Effect of a change of inputs: none, a new derivative, a new active set.
UNCHANGED, JUMPS, RESTARTS = range(3)
MOST_PARTS = 100.0
"""Implicit steps up to a communication point that are made equally long."""
FORESIGHT = 0.1
"""Time [s] beyond a communication point up to which touches of free bodies are predicted: few points need a new prediction."""
# Slots of Held.clock: end of the present step [s].
UNTIL = 0


@dataclass(frozen=True, eq=False)
class Held(Group):
    """Inputs of a run, held over a step; made by `make_held`."""

    kinds: Ints  # per input, see above
    places: Ints  # its rotor, or its row among the records of its kind
    signs: Floats  # of a load: against the nominal sense
    wanted: Floats  # values asked for: N m, rad/s, rad
    values: Floats  # values in use
    drives: Floats  # [rotor], N m, constant torque of its drive
    loads: Floats  # and of its load
    pulls: Ints  # [rotor], word of `Joined.numbers` that its torque is part of, -1 for none
    rest: Floats  # [rotor], that word without it
    clock: Floats  # slots above


def make_held(system: System, kinds: Ints, places: Ints, signs: Floats, values: Floats) -> Held:
    """Allocate the inputs of a system: their kinds, rotors or records, signs and present values, shape [input]."""
    rotors, joined = system.rotors, system.joined
    pulls = np.full(rotors.size, -1, dtype=np.int64)
    for i in range(rotors.size):
        chain, number = (
            joined.places[2 * theta_of(i) : 2 * theta_of(i) + 2].tolist() if joined.places.size else (-1, 0)
        )
        if chain >= 0 and number < joined.chains[chain].count:
            row = 2 * int(joined.chains[chain].count + joined.chains[chain].fixed)
            pulls[i] = joined.chains[chain].pull + number * (row + 1) + row
    rest = np.zeros(rotors.size)
    joins = pulls >= 0
    rest[joins] = joined.numbers[pulls[joins]] - rotors["inv_inertia"][joins] * rotors["torque"][joins]
    return Held(
        kinds=kinds,
        places=places,
        signs=signs,
        wanted=values.copy(),
        values=values.copy(),
        drives=rotors["drive_torque"].copy(),
        loads=rotors["torque"] - rotors["drive_torque"],
        pulls=pulls,
        rest=rest,
        clock=np.zeros(1),
    )


@compiled_inline
def set_torque(system: System, held: Held, i: int) -> None:
    """Set the constant torque of rotor i, of its drive and its load."""
    torque = held.drives[i] + held.loads[i]
    system.rotors[i].torque = torque
    if held.pulls[i] >= 0:
        system.joined.numbers[held.pulls[i]] = held.rest[i] + system.rotors[i].inv_inertia * torque


@compiled_once
def set_input(system: System, held: Held, k: int, value: float) -> None:
    """Set input k to a value, in the records alone."""
    at = held.places[k]
    held.wanted[k] = held.values[k] = value
    if held.kinds[k] == DRIVE_INPUT:
        held.drives[at] = value
        system.rotors[at].drive_torque = value
        set_torque(system, held, at)
    elif held.kinds[k] == LOAD_INPUT:
        held.loads[at] = held.signs[k] * value
        set_torque(system, held, at)
    elif held.kinds[k] == SPEED_INPUT:
        system.records[SERVO][at].speed = value
    else:
        system.records[POSITIONER][at].angle = value


@compiled_inline
def release(system: System, run: Run, i: int) -> None:
    """End the closed form of rotor i, and of all that springs join to it: it begins anew from the present state."""
    group = system.rotors[i].group
    for j in range(system.rotors.size):
        if j == i or (group >= 0 and system.rotors[j].group == group):
            run.active_set.body_states[j] = ACTIVE


@compiled_inline
def change_input(system: System, run: Run, held: Held, k: int) -> int:
    """Apply a new value of input k at a communication point; return `UNCHANGED`, `JUMPS` or `RESTARTS`."""
    kind, at = held.kinds[k], held.places[k]
    set_input(system, held, k, held.wanted[k])
    if kind <= LOAD_INPUT:
        if run.active_set.body_states[at] == ACTIVE:
            return JUMPS
        release(system, run, at)
        return RESTARTS
    if kind == ANGLE_INPUT and system.records[POSITIONER][at].sample_time > 0.0:
        return UNCHANGED  # until the next sample
    e = system.records[SERVO][at].element if kind == SPEED_INPUT else system.records[POSITIONER][at].element
    dispatch.initialise(system, e, run.clock[T], run.y, run.branch, run.loads_0)
    return JUMPS


@compiled_once
def change_inputs(system: System, run: Run, held: Held) -> int:
    """Put the wanted values of inputs into use, at the start of a step; return a status."""
    asked = UNCHANGED
    for k in range(held.values.size):
        if held.wanted[k] == held.values[k]:
            continue
        if run.counts[BEGUN] == 0:
            set_input(system, held, k, held.wanted[k])
        else:
            asked = max(asked, change_input(system, run, held, k))
    if asked == RESTARTS:
        burst, start = run.counts[BURST], run.clock[BURST_START]  # an input is no event
        status = restart(system, run)
        run.counts[BURST], run.clock[BURST_START] = burst, start
        return status
    if asked == JUMPS:
        if evaluate(system, run, run.clock[T]) != 0:
            return CANNOT_MESH
        if run.implicit.numbers[IN_USE] == 1:  # what was traced does not go on
            run.implicit.numbers[TRACED] = 0
            run.clock[H] = min(run.clock[H], run.implicit.sizes[H_EXPLICIT])
    return DONE


@compiled_inline
def learn_step(run: Run, h: float, taken: float) -> None:
    """Learn the next step's length from a step of ``taken`` [s] that an interval made shorter than h [s].

    An explicit one shows nothing of longer ones. An implicit one has an error estimate, and all of an interval are equally long:
    the factors of its equations stay, so the length changes only where that pays.
    """
    clock, implicit = run.clock, run.implicit
    if implicit.numbers[IN_USE] == 0:
        clock[H] = max(h, clock[H])
        return
    growth = implicit.sizes[GROWTH]
    if growth < SHRINKS:
        clock[H] = taken * growth
    elif growth >= GROWS:
        clock[H] = max(h, taken * min(growth, 2.0))
    else:
        clock[H] = h


@compiled_once
def advance_to(system: System, run: Run, t_end: float, steps: int) -> int:
    """Advance to a communication point t_end [s] by at most ``steps`` steps; return a status, PAUSED before it is reached."""
    clock, counts, implicit = run.clock, run.counts, run.implicit.numbers
    end = max(t_end, clock[T])
    clock[T_END], clock[AHEAD] = end, FORESIGHT
    if counts[BEGUN] == 0:
        status = advance(system, run, 0)
        if status != PAUSED:
            return status
    for _ in range(steps):
        if log_is_full(run):
            counts[LOGGED] = 0
        t, h, burst, rejected, method = clock[T], clock[H], counts[BURST], counts[REJECTED], implicit[IN_USE]
        parts = 1.0
        if method == 1 and (end - t) < MOST_PARTS * h:
            parts = max(1.0, math.ceil((1.0 - 1e-9) * (end - t) / h))
        clock[T_END] = end if parts == 1.0 else t + (end - t) / parts
        status = advance(system, run, 1)
        same = counts[BURST] == burst and counts[REJECTED] == rejected and implicit[IN_USE] == method
        if status == DONE and same:
            learn_step(run, h, clock[T] - t)
        if status != PAUSED and not (parts > 1.0 and status == DONE):
            return status
    return PAUSED


@compiled_once
def observe_now(system: System, run: Run) -> None:
    """Fill the first column of ``rows`` with the signals of the present state."""
    clock, counts = run.clock, run.counts
    if run.columns.size == 0:
        return
    clock[SAMPLE_START], clock[SAMPLE_INTERVAL] = clock[T], 1.0
    counts[NEXT_SAMPLE] = counts[LAST_SAMPLE] = counts[ROWS] = 0
    record_samples(system, run, 1.0, clock[T])
    counts[LAST_SAMPLE] = -1
