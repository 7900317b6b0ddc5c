"""Implicit steps of bodies in contact: Radau collocation, solved by Newton's method with a reused Jacobian.

Pressed contacts are stiff and smooth. An explicit method steps as their fastest vibration bids, though it has died down; this
one steps as the forcing does. Radau IIA damps what is too fast for a step: E. Hairer, G. Wanner, Solving Ordinary Differential
Equations II, 2nd ed., sections IV.5 and IV.8. Only accelerations are unknown: velocities and positions at the stages follow.
A step leaves behind what an explicit one does, so that switches, samples and statistics see no difference.
"""

import numpy as np

from gearplay.integrate.implicit import (
    AGE,
    CONTRACTION,
    FACTORED,
    H_FACTORED,
    H_TRACED,
    IN_USE,
    LAST_METHOD,
    METHOD,
    TRACED,
    WORK,
    correct,
    factorise,
    find_unknowns,
    position_of,
)
from gearplay.integrate.implicit_stages import fill_rows, place_stage, predict
from gearplay.integrate.jacobian import differentiate, is_worn, wear
from gearplay.integrate.radau import HIGH, STAGES, C
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import CALLS, ERROR_SHARE, INSIDE, Run, T
from gearplay.integrate.runge_kutta import STAGES as ROWS
from gearplay.kernels.compiled import compiled
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import first_axis
from gearplay.kernels.layout import System, vx_of

ERROR, ERROR_OF_FIVE = 8e-3, 2e-3
"""Shares of the differences in the error estimate: twice and sixteen times those in the error of the interpolant."""
NEWTON = 8  # iterations at most
CLOSE = 1e-9  # by which a step may differ from the one that the factors are for
ENOUGH = 0.02  # of the allowed error that Newton's method may leave
FORGETS, WORST = 1.05, 0.3
"""By how much its convergence is taken to be worse from step to step, as one iteration does not show it; at most so bad."""


@compiled_once
def solve(system: System, run: Run, t: float, h: float) -> int:
    """Solve the equations of a step of h [s] from t [s] for the guessed accelerations at the stages.

    Returns the number of iterations, 0 where they do not converge, or too slowly.
    """
    kept, active_set, scale, error_weight = run.implicit, run.active_set, run.scale, run.implicit.error_weight
    k, rest, stages, sizes, method = kept.k, kept.rest, run.stages, kept.sizes, kept.numbers[METHOD]
    count = STAGES[method]
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        for s in range(vx_of(system, i) + first_axis(system, i, run.y), vx_of(system, i) + 3):
            error_weight[s] = (
                h * max(1.0 / scale[s], h / scale[position_of(system, s)]) / run.clock[ERROR_SHARE]
            )
    longer = h / sizes[H_TRACED] if kept.numbers[TRACED] > 0 else 1.0
    sizes[CONTRACTION] = min(WORST, FORGETS * sizes[CONTRACTION] * max(1.0, longer * longer))
    before = 0.0
    for turn in range(NEWTON):
        for stage in range(count):
            place_stage(system, run, stage, h)
            run.counts[CALLS] += 1
            sizes[WORK] += 1.0
            at, row = t + C[method, stage] * h, stages[1 + stage]
            loads = run.loads_inside if stage == count // 2 else run.loads
            if rates_of(system, active_set, at, run.y_new, run.branch, row, loads) != 0:
                return 0
            for c in range(1, active_set.active[0] + 1):
                i = active_set.active[c]
                for s in range(vx_of(system, i) + first_axis(system, i, run.y), vx_of(system, i) + 3):
                    rest[stage, s] = row[s] - k[stage, s]
        correct(kept)
        size = 0.0
        for c in range(1, active_set.active[0] + 1):
            i = active_set.active[c]
            for s in range(vx_of(system, i) + first_axis(system, i, run.y), vx_of(system, i) + 3):
                for stage in range(count):
                    k[stage, s] += rest[stage, s]
                    change = error_weight[s] * abs(rest[stage, s])
                    if not change <= size:
                        size = change
                        if not size < 1e12:
                            return 0
        if turn > 0:
            sizes[CONTRACTION] = max(size / before, 0.3 * sizes[CONTRACTION])
            if sizes[CONTRACTION] >= 0.9:
                return 0
        left = sizes[CONTRACTION] * size
        if left <= ENOUGH:
            return turn + 1
        if turn > 0 and left * sizes[CONTRACTION] ** (NEWTON - 1 - turn) > ENOUGH:
            return 0
        before = size
    return 0


@compiled_once
def attempt_implicit(system: System, run: Run, h: float) -> int:
    """Try a step of h [s] of the active rotors into y_new, with the same side data as an explicit step; return 0, or 1."""
    kept, active_set, t = run.implicit, run.active_set, run.clock[T]
    numbers = kept.numbers
    if numbers[IN_USE] == 0:
        find_unknowns(system, active_set, kept)
        numbers[TRACED] = 0
        kept.sizes[CONTRACTION] = WORST
    predict(system, run, h, True)
    onward = True
    if (numbers[IN_USE] == 0 or is_worn(kept)) and differentiate(system, run, t, h) != 0:
        return 1
    while True:
        if abs(kept.sizes[H_FACTORED] - h) > CLOSE * h:
            numbers[FACTORED], kept.sizes[H_FACTORED] = 0, h
        if numbers[FACTORED] == 0 and factorise(kept, kept.sizes[H_FACTORED]) != 0:
            return 1
        turns = solve(system, run, t, h)
        if turns > 0:
            break
        if not onward:
            return 1
        # With a new Jacobian, and then without a polynomial: of vibrations it is far off.
        onward = numbers[AGE] > 0
        kept.sizes[CONTRACTION] = WORST
        predict(system, run, h, onward)
        if differentiate(system, run, t, h) != 0:
            return 1
    wear(kept, turns)
    method = numbers[METHOD]
    run.clock[INSIDE] = C[method, STAGES[method] // 2]
    for stage in range(STAGES[method]):  # the last of them is the end
        place_stage(system, run, stage, h)
    run.counts[CALLS] += 1
    if rates_of(system, active_set, t + h, run.y_new, run.branch, run.stages[ROWS - 1], run.loads) != 0:
        return 1
    fill_rows(run)
    return 0


@compiled
def implicit_error(run: Run, h: float, low: bool) -> float:
    """Return the largest local error of the step last tried over its allowance, from differences of the derivatives; inf for NaN.

    Fourth differences for three stages, or where ``low``: what three stages would err by; sixth ones for five. They reach back to
    the middle stage of the step before; without one the step is as long as an explicit one, and trusted.
    """
    kept, states, stages, worst = run.implicit, run.active_set.states, run.stages, 0.0
    k, nodes, w, method = kept.k, kept.nodes, kept.differences, kept.numbers[METHOD]
    if kept.numbers[TRACED] == 0:
        for c in range(1, states[0] + 1):
            if not abs(stages[ROWS - 1, states[c]]) < np.inf:
                return np.inf
        return 0.5
    last = kept.numbers[LAST_METHOD]
    back = STAGES[last] // 2
    first = 1 if method == HIGH and low else 0
    count = 7 if method == HIGH and not low else 5
    nodes[0], nodes[1], nodes[2] = (C[last, back] - 1.0) * kept.sizes[H_TRACED] / h, 0.0, 1.0
    for j in range(3, count):
        nodes[j] = C[method, first + j - 3]
    for j in range(count):
        w[j] = ERROR if count == 5 else ERROR_OF_FIVE
        for other in range(count):
            if other != j:
                w[j] /= nodes[j] - nodes[other]
    for c in range(1, states[0] + 1):
        s = states[c]
        e = w[0] * kept.last[back, s] + w[1] * stages[0, s] + w[2] * stages[ROWS - 1, s]
        e += w[3] * k[first, s] + w[4] * k[first + 1, s]
        if count == 7:
            e += w[5] * k[2, s] + w[6] * k[3, s]
        size = h * abs(e) / run.scale[s]
        if not size <= worst:
            worst = size
            if not size < np.inf:
                return np.inf
    return worst / run.clock[ERROR_SHARE]
