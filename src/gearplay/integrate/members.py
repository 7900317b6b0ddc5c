"""Members of an ensemble, simulated one after another on one reused run.

All arrays that a run changes lie in one block of memory. A new run is a copy of that block, so that a member begins with one
copy and its results are those of a run of its own, bit for bit.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.run import (
    DONE,
    ERROR_SHARE,
    FIXED,
    H_BEGIN,
    H_RESTART,
    LAST_SAMPLE,
    LOGGED,
    PAUSED,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    STEPS,
    T_END,
    TOLERANCE,
    Run,
    T,
)
from gearplay.integrate.stepper import advance, log_is_full
from gearplay.kernels.arrays import Cubes, Floats, IntRows, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System

TOO_MANY_STEPS = 20
"""Status of a member that took the largest number of steps."""

# Slots of Batch.place: the present member and its phase, where its contact changes begin in the log; then what all members
# have in common: samples of each, the largest number of steps.
MEMBER, PHASE, LOG_BEGIN, SAMPLES, MOST_STEPS = range(5)
UNBEGUN, LEADING, RECORDING = range(3)
# Slots of Batch.times [s].
LEAD, END, INTERVAL = range(3)

_OUTSIDE = ("columns", "wanted_rotors", "wanted_elements", "needed", "free_states", "shown", "rows", "log")
"""Arrays of a run that stay as they are: requests, outputs, and scratch of samples."""
WHILE_IMPLICIT = {
    f"implicit.{name}"
    for name in (
        "places",
        "positions",
        "velocities",
        "real",
        "complex",
        "first",
        "unknowns",
        "last",
        "older",
        "weights",
    )
}
"""Arrays that are read between steps while the implicit method is in use, and written anew when it is taken up."""
WITHIN_STEP = {
    *(f"implicit.{name}" for name in ("k", "nodes", "differences", "dense", "error_weight", "rest")),
    *(f"implicit.{name}" for name in ("beside", "whole", "bodies", "right", "right_complex")),
    *(
        f"{name}.{array}"
        for name in ("loads", "loads_inside", "loads_try")
        for array in ("contacts", "rotors", "out")
    ),
    *(
        "loads_0.rotors",
        "loads_0.out",
        "slopes.elements",
        "slopes.rotors",
        "slopes.unbalances",
        "slopes.force",
    ),
    *("modes_0", "dy_try", "g_1", "g_try", "row", "times"),
}
"""Arrays that a step writes before it reads them."""
FIRST_ROW = "stages"
"""Array that a step writes but for its first row."""
COMMON = {"change", "scale", "natural", "stops"}
"""Arrays that are the same between the steps of all members."""


@dataclass(frozen=True, eq=False)
class Batch(Group):
    """Members of one case: starts, common data, final state of each."""

    place: Ints  # slots above
    times: Floats  # [s]: end of the transient, end of the run, sampling interval
    fresh: Ints  # the block of a run that has not begun
    words: Ints  # the block of the reused run
    starts: Rows  # [member, state]
    status: Ints  # per member
    reached: Floats  # [s]
    states: Rows  # [member, state]
    tallies: Cubes  # [member, contact, TALLIES]
    counts: IntRows  # [member, slots of Run.counts]
    memory: Cubes  # [member, element, MEMORY]
    impact_speeds: Rows  # [member, impact speed]
    log_ends: Ints  # where each one's contact changes end in the log


def make_batch(
    run: Run, words: Ints, fresh: Ints, starts: Floats, times: Floats, samples: int, most_steps: int
) -> Batch:
    """Allocate a batch of members with given starts, shape [member, state]."""
    count = len(starts)
    branch = run.branch
    return Batch(
        place=np.array([0, UNBEGUN, 0, samples, most_steps], dtype=np.int64),
        times=times,
        fresh=fresh,
        words=words,
        starts=starts,
        status=np.full(count, PAUSED, dtype=np.int64),
        reached=np.zeros(count),
        states=np.zeros(starts.shape),
        tallies=np.zeros((count, *run.tallies.shape)),
        counts=np.zeros((count, run.counts.size), dtype=np.int64),
        memory=np.zeros((count, *branch.memory.shape)),
        impact_speeds=np.zeros((count, branch.impact_speeds.size)),
        log_ends=np.zeros(count, dtype=np.int64),
    )


def in_one_block(run: Run) -> tuple[Run, Ints, tuple[int, int]]:
    """Return a copy of a run whose arrays, those of `_OUTSIDE` aside, are views of one block, the block, and two places in it.

    From the first to the second place are the words that a member has between its steps, in front of them those that it has
    in addition while the implicit method is in use. Behind the second one nothing belongs to a member.
    """
    arrays: dict[int, tuple[int, NDArray[Any]]] = {}
    for name, array in _arrays(run):
        part = (
            0
            if name in WHILE_IMPLICIT
            else 3
            if name in WITHIN_STEP | COMMON
            else 2
            if name == FIRST_ROW
            else 1
        )
        arrays.setdefault(id(array), (part, array))  # loads share some
    words = np.empty(sum(array.nbytes for _, array in arrays.values()) // 8, dtype=np.int64)
    views, at, ends = {}, 0, [0, 0, 0, 0]
    for key, (part, array) in sorted(arrays.items(), key=lambda item: item[1][0]):
        view = words[at : at + array.nbytes // 8].view(array.dtype).reshape(array.shape)
        view[...] = array
        views[key], at = view, at + array.nbytes // 8
        ends[part:] = [at] * (4 - part)
    return _moved(run, views), words, (ends[0], ends[1] + run.y.size)


def _arrays(group: Any, within: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a group with their names, ``implicit.k``."""
    for field in fields(group):
        value, name = getattr(group, field.name), within + field.name
        if isinstance(value, Group):
            yield from _arrays(value, f"{name}.")
        elif name not in _OUTSIDE:
            yield name, value


def _moved(group: Any, views: dict[int, NDArray[Any]]) -> Any:
    values = {field.name: getattr(group, field.name) for field in fields(group)}
    return replace(
        group,
        **{
            name: _moved(value, views) if isinstance(value, Group) else views.get(id(value), value)
            for name, value in values.items()
        },
    )


def set_case(
    run: Run, natural: Floats, restart_step: float, stops: Floats, tolerance: float, fixed_step: float | None
) -> None:
    """Give a run that has not begun the numbers of another case of the same build."""
    run.natural[:], run.stops[:] = natural, stops
    run.scale[:] = tolerance * natural
    run.clock[H_RESTART] = run.clock[H_BEGIN] = restart_step
    run.clock[TOLERANCE], run.clock[ERROR_SHARE] = tolerance, 1.0
    run.clock[FIXED] = fixed_step or 0.0


@compiled_once
def begin_member(run: Run, batch: Batch) -> None:
    """Bring the run to the start of the present member."""
    place, words = batch.place, batch.words
    for k in range(words.size):
        words[k] = batch.fresh[k]
    for k in range(run.y.size):
        run.y[k] = run.y_new[k] = run.y_try[k] = batch.starts[place[MEMBER], k]
    run.counts[LOGGED] = place[LOG_BEGIN]
    place[PHASE] = LEADING
    if batch.times[LEAD] <= 0.0:
        begin_record(run, batch)


@compiled_once
def begin_record(run: Run, batch: Batch) -> None:
    """Begin the record of the present member: its samples, statistics and contact log."""
    place = batch.place
    place[PHASE] = RECORDING
    for k in range(run.tallies.shape[0]):
        for column in range(run.tallies.shape[1]):
            run.tallies[k, column] = 0.0
    run.clock[SAMPLE_START], run.clock[SAMPLE_INTERVAL] = batch.times[LEAD], batch.times[INTERVAL]
    run.counts[LAST_SAMPLE] = place[SAMPLES] - 1
    run.counts[ROWS] = place[MEMBER] * place[SAMPLES]
    run.counts[LOGGED] = place[LOG_BEGIN]


@compiled_once
def end_member(run: Run, batch: Batch, status: int) -> None:
    """Store the state in which the present member ended; the next one's turn comes."""
    place, branch = batch.place, run.branch
    m = place[MEMBER]
    if place[PHASE] == LEADING:
        run.counts[LOGGED] = place[LOG_BEGIN]
    batch.status[m], batch.reached[m] = status, run.clock[T]
    for k in range(run.y.size):
        batch.states[m, k] = run.y[k]
    for k in range(run.tallies.shape[0]):
        for column in range(run.tallies.shape[1]):
            batch.tallies[m, k, column] = run.tallies[k, column]
    for k in range(run.counts.size):
        batch.counts[m, k] = run.counts[k]
    for e in range(branch.memory.shape[0]):
        for k in range(branch.memory.shape[1]):
            batch.memory[m, e, k] = branch.memory[e, k]
    for k in range(branch.impact_speeds.size):
        batch.impact_speeds[m, k] = branch.impact_speeds[k]
    batch.log_ends[m] = place[LOG_BEGIN] = run.counts[LOGGED]
    place[MEMBER], place[PHASE] = m + 1, UNBEGUN


@compiled_once
def advance_members(system: System, run: Run, batch: Batch, steps: int) -> int:
    """Simulate members in turn for ``steps`` steps, or until the log is full; DONE once all have ended, else PAUSED.

    It can return at any step and be called again without a trace in the results.
    """
    place, counts = batch.place, run.counts
    left = steps
    while place[MEMBER] < batch.starts.shape[0]:
        if place[PHASE] == UNBEGUN:
            begin_member(run, batch)
        status = TOO_MANY_STEPS
        if counts[STEPS] < place[MOST_STEPS]:
            run.clock[T_END] = batch.times[LEAD if place[PHASE] == LEADING else END]
            before = counts[STEPS]
            status = advance(system, run, min(left, place[MOST_STEPS] - before))
            left -= counts[STEPS] - before
            if place[PHASE] == LEADING and status == DONE:
                begin_record(run, batch)
                status = PAUSED
            elif status == PAUSED and log_is_full(run):
                if place[PHASE] == RECORDING:
                    return PAUSED
                counts[LOGGED] = place[LOG_BEGIN]
        if status != PAUSED:
            end_member(run, batch, status)
        if left <= 0 and place[MEMBER] < batch.starts.shape[0]:
            return PAUSED
    return DONE


@compiled_once
def advance_periods(system: System, run: Run, period: float, passed: Ints, last: int, steps: int) -> int:
    """Advance to ``last`` times a period [s] by at most ``steps`` steps; a step ends at each multiple; return a status.

    ``passed``, shape [1], is how many have passed.
    """
    left = steps
    while passed[0] < last:
        run.clock[T_END] = (passed[0] + 1) * period
        before = run.counts[STEPS]
        status = advance(system, run, left)
        if status != DONE:
            return status
        passed[0] += 1
        left -= run.counts[STEPS] - before
        if left <= 0 and passed[0] < last:
            return PAUSED
    return DONE
