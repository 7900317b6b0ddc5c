"""Choice between explicit and implicit steps: implicit while no event occurs and while they cost less."""

import math

from gearplay.integrate.collocation import attempt_implicit, implicit_error
from gearplay.integrate.events import first_switch
from gearplay.integrate.implicit import (
    BACKOFF,
    FACTORED,
    FIRST_BACKOFF,
    GROWTH,
    H_EXPLICIT,
    H_OLDER,
    HELD,
    IN_USE,
    METHOD,
    MOST_BACKOFF,
    QUIET,
    SHORT,
    TRACED,
    TRIED,
    WORK,
    pairs_of,
)
from gearplay.integrate.implicit_stages import trace
from gearplay.integrate.next_touch import something_is_due
from gearplay.integrate.radau import HIGH, LOW
from gearplay.integrate.restart import locate_kinks, restart
from gearplay.integrate.run import DONE, REJECTED, T_END, H, Run, T
from gearplay.integrate.runge_kutta import ORDER, STAGES
from gearplay.integrate.step_end import accept, go_on
from gearplay.integrate.switches import switch_values
from gearplay.integrate.trial_step import watch
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System

NOT_TAKEN = -1
SHORTEST = 1.3  # explicit steps: what is tried is that long, where longer steps have failed
TRIAL = 30  # steps before their cost is compared
LONG_BACKOFF = 1000  # most explicit steps until the implicit method is tried again
REJECTIONS = 4  # of one step, before an explicit one is taken
GROWS, GROWS_AGAIN, SHRINKS = 1.25, 1.8, 0.86
"""Factors by which a step could change from which on it does, as that costs factors; and where it has just grown."""
FINE, COARSE = 0.7, 0.85
"""Shares of the longest step: where three stages can only take shorter ones, five are taken, and three again above the other."""
LOOKS = 16  # steps of five stages after which three are considered
HOLD, GAIN = 8, 1.3
"""Steps of three stages where the equations of five were not solved; by how much longer five must be."""
SHORTER = 0.4  # of a step whose equations are not solved, what is tried next


@compiled_inline
def is_quiet(system: System, run: Run) -> bool:
    """Return whether the next step may be implicit: only rotors move, by forces, and nothing has happened for a while."""
    numbers, active_set = run.implicit.numbers, run.active_set
    if numbers[IN_USE] == 1:
        return True
    waits = numbers[QUIET] < numbers[BACKOFF] or run.implicit.sizes[H_EXPLICIT] == 0.0
    for c in range(1, active_set.acting[0] + 1):
        waits = waits or system.elements[active_set.acting[c]].states > 0
    return not waits


@compiled_inline
def fall_back(system: System, run: Run, backoff: int) -> int:
    """Return to explicit steps for at least ``backoff`` steps; return `NOT_TAKEN`."""
    numbers = run.implicit.numbers
    numbers[IN_USE] = numbers[QUIET] = 0
    numbers[BACKOFF] = backoff
    run.clock[H] = run.implicit.sizes[H_EXPLICIT]
    locate_kinks(system, run, True)
    return NOT_TAKEN


@compiled_inline
def order_of(run: Run) -> float:
    """Return by which power of the step's length the error estimate of the method in use grows."""
    return 5.0 if run.implicit.numbers[METHOD] == LOW else 7.0


@compiled_inline
def choose_method(run: Run, part: float, longest: float, longer: float) -> int:
    """Return the method of the steps after one of ``part`` [s], by the length that three stages could have.

    That is ``longer`` [s] where they are in use. Five cost 1.2 to 1.8 times as much. Where they are not longer, or
    their equations are not solved, three are taken for a while.
    """
    numbers, sizes = run.implicit.numbers, run.implicit.sizes
    numbers[HELD] = max(numbers[HELD] - 1, 0)
    if numbers[METHOD] == LOW:
        if numbers[HELD] > 0 or numbers[TRACED] < 2 or longer >= FINE * longest:
            return LOW
        sizes[SHORT], numbers[HELD] = longer, LOOKS
        return HIGH
    error = max(implicit_error(run, part, True), 1e-12)
    sizes[SHORT] = min(sizes[SHORT], 0.8 * part * error ** (-1.0 / ORDER))
    if numbers[HELD] > 0:
        return HIGH
    method, numbers[HELD] = LOW if sizes[SHORT] > COARSE * longest else HIGH, LOOKS
    if part < GAIN * sizes[SHORT]:
        method, numbers[HELD] = LOW, TRIAL
    sizes[SHORT] = longest
    return method


@compiled_inline
def pays(run: Run, h: float) -> bool:
    """Return whether implicit steps of h [s], at the cost of the trial's, are cheaper than explicit ones over the same time.

    Costs are in evaluations of the right-hand side; an explicit step costs seven. A step's equations are assembled and solved in
    some 2 ns for each pair of unknowns, stage and iteration, where an acting element takes 90 ns.
    """
    sizes = run.implicit.sizes
    calls = sizes[WORK] / TRIAL
    solving = 0.024 * calls * pairs_of(run.implicit) / max(run.active_set.acting[0], 1)
    return bool(h * STAGES > sizes[H_EXPLICIT] * (calls + solving + 2.0))


@compiled_once
def take_quiet_step(system: System, run: Run, stop: float, longest: float) -> int:
    """Take an implicit step without events, to ``stop`` [s] or for ``longest`` [s] at most; return a status.

    `NOT_TAKEN` where an event occurs, Newton's method fails or the step costs more than explicit ones: the state is unchanged.
    """
    clock, counts, numbers, sizes = run.clock, run.counts, run.implicit.numbers, run.implicit.sizes
    if numbers[IN_USE] == 0:
        clock[H] = sizes[H_EXPLICIT]
        numbers[TRIED], sizes[WORK], numbers[METHOD], numbers[HELD] = 0, 0.0, LOW, TRIAL
    twice, t = min(2 * numbers[BACKOFF], MOST_BACKOFF), clock[T]
    h, error = min(clock[H], longest), 0.0
    for turn in range(REJECTIONS + 1):
        if turn == REJECTIONS or something_is_due(run, min(t + h, stop)):
            return fall_back(system, run, twice)
        ahead = (1.0 - 1e-12) * (stop - t) / h  # in steps; the last few before a stop are equally long
        left = 1.0 if ahead <= 1.0 else 2.0 if ahead <= 2.0 else 3.0
        part = (stop - t) / left if ahead <= 3.0 else h
        to_stop = ahead <= 1.0
        if attempt_implicit(system, run, part) != 0:
            counts[REJECTED] += 1
            h = SHORTER * part
            if numbers[METHOD] == HIGH and max(sizes[SHORT], SHORTEST * sizes[H_EXPLICIT]) > h:
                numbers[METHOD], numbers[FACTORED], numbers[HELD] = LOW, 0, HOLD
                h = part
            elif h < SHORTEST * sizes[H_EXPLICIT]:
                return fall_back(system, run, twice)
            continue
        error = implicit_error(run, part, False)
        if error <= 1.0:
            break
        counts[REJECTED] += 1
        if not math.isfinite(error):
            return fall_back(system, run, twice)
        h = part * max(0.2, 0.8 * error ** (-1.0 / order_of(run)))
    t_new = stop if to_stop else t + part
    if watch(system, run, t_new, run.y_new, run.loads) != 0:
        return fall_back(system, run, twice)
    switch_values(system, run.active_set, t_new, run.y_new, run.branch, run.loads, run.g_1)
    first, _ = first_switch(system, run, part, True)
    if first >= 0:
        return fall_back(system, run, FIRST_BACKOFF if numbers[TRIED] > 5 * TRIAL else twice)
    status = accept(system, run, part, t_new, -1)
    if status != DONE:
        return status
    growth = 0.8 * max(error, 1e-12) ** (-1.0 / order_of(run))
    sizes[GROWTH] = growth
    changes = growth < SHRINKS or growth >= (GROWS if part <= sizes[H_OLDER] else GROWS_AGAIN)
    longer = h
    if part < h:  # what was cut short says nothing of longer ones
        longer = min(h, part * growth)
    elif changes:
        longer = h * min(2.0, growth)
    method = choose_method(run, part, longest, longer)
    trace(run, part)
    numbers[TRIED] += 1
    if method != numbers[METHOD]:
        numbers[METHOD], numbers[FACTORED] = method, 0
    if to_stop and stop < clock[T_END]:
        return restart(system, run)
    go_on(system, run)
    if numbers[TRIED] == 1:  # the first step, whose error is not estimated, has none
        locate_kinks(system, run, False)
    clock[H] = longer
    if numbers[TRIED] % TRIAL == 0:
        if not pays(run, h):
            fall_back(system, run, min(4 * numbers[BACKOFF], LONG_BACKOFF))
        sizes[WORK] = 0.0
    return DONE
