"""Members that take the same steps between communication points, each with its own inputs, on one reused run.

A member's words between its steps are those of `integrate.members.in_one_block`; those of the implicit method only while it is
in use, in an array of their own: the others of all members lie close together.
"""

from dataclasses import dataclass

import numpy as np

from gearplay.integrate.implicit import IN_USE
from gearplay.integrate.run import DONE, PAUSED, STEPS, Run, T
from gearplay.integrate.stepping import UNTIL, Held, advance_to, change_inputs, observe_now, set_input
from gearplay.kernels.arrays import Cubes, Floats, IntRows, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System


@dataclass(frozen=True, eq=False)
class StepBatch(Group):
    """Members that take the same steps, each with its own inputs; one thread has a share of them, and a run."""

    system: System
    run: Run
    held: Held
    place: Ints  # slots below
    words: Ints  # the block of the reused run
    states: IntRows  # [member, word], the words of all members between their steps
    implicit: IntRows  # [member, word], those of the implicit method
    values: Rows  # [member, input] in use
    inputs: Cubes  # [step, member, input]
    outputs: Cubes  # [step, member, output]
    ends: Floats  # [step], length of each [s]
    status: Ints  # [member]


# Slots of StepBatch.place: the first member, the one after the last, the present one, the present step and its phase; where in
# the block the words begin that a member has without the implicit method; steps of the integrator in one call.
FIRST, BEHIND, MEMBER, STEP, PHASE, QUIET_WORDS, MOST = range(7)
UNLOADED, LOADED, STEPPING = range(3)


@compiled_inline
def copy_words(source: Ints, target: Ints) -> None:
    """Copy all of ``source`` to the start of ``target``."""
    for k in range(source.size):
        target[k] = source[k]


@compiled_once
def load_member(batch: StepBatch, m: int) -> None:
    """Bring the run and the inputs to those of member m."""
    held, words, first = batch.held, batch.words, batch.place[QUIET_WORDS]
    if batch.states.shape[0] > 1:  # one alone lives in the run
        copy_words(batch.states[m], words[first:])
        if batch.run.implicit.numbers[IN_USE] == 1:
            copy_words(batch.implicit[m], words)
        batch.run.stages[1:] = 0.0  # laws read those of rotors that are not integrated, too
    for k in range(held.values.size):
        if held.values[k] != batch.values[m, k]:
            set_input(batch.system, held, k, batch.values[m, k])


@compiled_once
def store_member(batch: StepBatch, m: int) -> None:
    """Keep the run and the inputs of member m."""
    held, words, first = batch.held, batch.words, batch.place[QUIET_WORDS]
    if batch.states.shape[0] > 1:
        copy_words(words[first : first + batch.states.shape[1]], batch.states[m])
        if batch.run.implicit.numbers[IN_USE] == 1:
            copy_words(words[:first], batch.implicit[m])
    for k in range(held.values.size):
        batch.values[m, k] = held.values[k]


@compiled_once
def step_members(batch: StepBatch) -> int:
    """Take all steps of each member in turn, by at most MOST steps of the integrator; return DONE, or PAUSED before.

    A member that fails has its status, and outputs that are NaN from there on.
    """
    system, run, held, place = batch.system, batch.run, batch.held, batch.place
    count, left = batch.ends.size, place[MOST]
    while place[MEMBER] < place[BEHIND]:
        m = place[MEMBER]
        if place[PHASE] == UNLOADED:
            load_member(batch, m)
            place[PHASE], place[STEP] = LOADED, 0
        while place[STEP] < count:
            s, status = place[STEP], batch.status[m]
            if status == DONE and place[PHASE] == LOADED:
                for k in range(held.values.size):
                    held.wanted[k] = batch.inputs[s, m, k]
                held.clock[UNTIL] = run.clock[T] + batch.ends[s]
                status = change_inputs(system, run, held)
                place[PHASE] = STEPPING
            if status == DONE:
                before = run.counts[STEPS]
                status = advance_to(system, run, held.clock[UNTIL], max(left, 1))
                left -= run.counts[STEPS] - before
                if status == PAUSED:
                    return PAUSED
            if status == DONE:
                observe_now(system, run)
            for c in range(batch.outputs.shape[2]):
                batch.outputs[s, m, c] = run.rows[c, 0] if status == DONE else np.nan
            batch.status[m] = status
            place[STEP], place[PHASE] = s + 1, LOADED
        store_member(batch, m)
        place[MEMBER], place[PHASE] = m + 1, UNLOADED
        if left <= 0 and place[MEMBER] < place[BEHIND]:
            return PAUSED
    place[MEMBER] = place[FIRST]
    return DONE
