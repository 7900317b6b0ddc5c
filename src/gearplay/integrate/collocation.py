"""Implicit steps of bodies in contact: Radau collocation of order 5, solved by Newton's method with a reused Jacobian.

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
    TRACED,
    C,
    correct,
    factorise,
    find_unknowns,
    position_of,
)
from gearplay.integrate.implicit_stages import place_stage, predict
from gearplay.integrate.jacobian import differentiate, is_worn, wear
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import CALLS, ERROR_SHARE, INSIDE, Run, T
from gearplay.integrate.runge_kutta import NODES, STAGES
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, vx_of, x_of

_FOUR = np.array([0.0, *C])


def _lagrange(at: Floats, nodes: Floats) -> Floats:
    """Return what polynomials through values at nodes have at other places, shape [place, node]."""
    powers = np.vander(nodes, increasing=True)
    return np.ascontiguousarray(np.vander(at, nodes.size, increasing=True) @ np.linalg.inv(powers))


AT_STAGES = _lagrange(
    NODES, _FOUR
)  # derivatives at the nodes of the explicit method: its interpolant is made of them
ERROR = 8e-3
"""Share of the fourth differences: of order 5 like the explicit estimate, above the errors of method and interpolant."""

KEPT = 1  # stage whose loads are kept
NEWTON = 8  # iterations at most
ENOUGH = 0.05  # of the allowed error that Newton's method may leave
FORGETS, WORST = 1.05, 0.3
"""By how much its convergence is taken to be worse from step to step, as one iteration does not show it; at most so bad."""


@compiled_once
def solve(system: System, run: Run, t: float, h: float) -> int:
    """Solve the equations of a step of h [s] from t [s] for the guessed accelerations at the stages.

    Returns the number of iterations, 0 where they do not converge, or too slowly.
    """
    kept, active_set, scale, error_weight = run.implicit, run.active_set, run.scale, run.implicit.error_weight
    k, rest, stages, sizes = kept.k, kept.rest, run.stages, kept.sizes
    for c in range(1, active_set.active[0] + 1):
        first = vx_of(system, active_set.active[c])
        for s in range(first, first + 3):
            error_weight[s] = (
                h * max(1.0 / scale[s], h / scale[position_of(system, s)]) / run.clock[ERROR_SHARE]
            )
    longer = h / sizes[H_TRACED] if kept.numbers[TRACED] > 0 else 1.0
    sizes[CONTRACTION] = min(WORST, FORGETS * sizes[CONTRACTION] * max(1.0, longer * longer))
    before = 0.0
    for turn in range(NEWTON):
        for stage in range(3):
            place_stage(system, run, stage, h)
            run.counts[CALLS] += 1
            at, row = t + C[stage] * h, stages[1 + stage]
            loads = run.loads_inside if stage == KEPT else run.loads
            if rates_of(system, active_set, at, run.y_new, run.branch, row, loads) != 0:
                return 0
            for c in range(1, active_set.active[0] + 1):
                first = vx_of(system, active_set.active[c])
                for s in range(first, first + 3):
                    rest[stage, s] = row[s] - k[stage, s]
        correct(kept)
        size = 0.0
        for c in range(1, active_set.active[0] + 1):
            first = vx_of(system, active_set.active[c])
            for s in range(first, first + 3):
                for stage in range(3):
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
    """Try a step of h [s] of the active rotors into y_new, and leave behind what an explicit step does; return 0, or 1."""
    kept, active_set, t = run.implicit, run.active_set, run.clock[T]
    numbers = kept.numbers
    if numbers[IN_USE] == 0:
        find_unknowns(system, active_set, kept)
        numbers[TRACED] = 0
        kept.sizes[CONTRACTION] = WORST
    predict(system, run, h)
    if (numbers[IN_USE] == 0 or is_worn(kept)) and differentiate(system, run, t, h) != 0:
        return 1
    while True:
        if (numbers[FACTORED] == 0 or kept.sizes[H_FACTORED] != h) and factorise(kept, h) != 0:
            return 1
        turns = solve(system, run, t, h)
        if turns > 0:
            break
        if numbers[AGE] == 0:
            return 1
        kept.sizes[CONTRACTION] = WORST
        predict(system, run, h)
        if differentiate(system, run, t, h) != 0:
            return 1
    wear(kept, turns)
    run.clock[INSIDE] = C[KEPT]
    place_stage(system, run, 2, h)
    run.counts[CALLS] += 1
    if rates_of(system, active_set, t + h, run.y_new, run.branch, run.stages[STAGES - 1], run.loads) != 0:
        return 1
    fill_stages(system, run)
    return 0


@compiled_inline
def fill_stages(system: System, run: Run) -> None:
    """Fill the rows of the explicit method's stages with derivatives at its nodes."""
    active_set, stages, k, v = run.active_set, run.stages, run.implicit.k, run.implicit.v
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        for axis in range(3):
            q, s = x_of(i) + axis, vx_of(system, i) + axis
            for row in range(1, STAGES - 1):
                w = AT_STAGES[row]
                stages[row, q] = w[0] * stages[0, q] + w[1] * v[0, q] + w[2] * v[1, q] + w[3] * stages[6, q]
                stages[row, s] = w[0] * stages[0, s] + w[1] * k[0, s] + w[2] * k[1, s] + w[3] * stages[6, s]


@compiled
def implicit_error(system: System, run: Run, h: float) -> float:
    """Return the largest local error over its allowance, from fourth differences of the derivatives; inf for NaN.

    They reach back to the second stage of the step before; without one the step is as long as an explicit one, and trusted.
    """
    kept, active_set, stages, worst = run.implicit, run.active_set, run.stages, 0.0
    k, v = kept.k, kept.v
    if kept.numbers[TRACED] == 0:
        for s in range(1, active_set.states[0] + 1):
            if not abs(stages[6, active_set.states[s]]) < np.inf:
                return np.inf
        return 0.5
    back = -(1.0 - C[1]) * kept.sizes[H_TRACED] / h
    w_b = ERROR / (back * (back - C[0]) * (back - C[1]) * (back - 1.0))
    w_0 = ERROR / ((0.0 - back) * (0.0 - C[0]) * (0.0 - C[1]) * (0.0 - 1.0))
    w_1 = ERROR / ((C[0] - back) * C[0] * (C[0] - C[1]) * (C[0] - 1.0))
    w_2 = ERROR / ((C[1] - back) * C[1] * (C[1] - C[0]) * (C[1] - 1.0))
    w_3 = ERROR / ((1.0 - back) * (1.0 - C[0]) * (1.0 - C[1]))
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        for axis in range(3):
            q, s = x_of(i) + axis, vx_of(system, i) + axis
            e = w_b * kept.last_v[q] + w_0 * stages[0, q] + w_1 * v[0, q] + w_2 * v[1, q] + w_3 * stages[6, q]
            d = (
                w_b * kept.last[1, s]
                + w_0 * stages[0, s]
                + w_1 * k[0, s]
                + w_2 * k[1, s]
                + w_3 * stages[6, s]
            )
            size = h * max(abs(e) / run.scale[q], abs(d) / run.scale[s])
            if not size <= worst:
                worst = size
                if not size < np.inf:
                    return np.inf
    return worst / run.clock[ERROR_SHARE]
