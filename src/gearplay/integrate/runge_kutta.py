"""Dormand-Prince 5(4) with dense output: one step, its error, its interpolant.

J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19; the continuous extension of order 4 is that of
E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.6.
"""

import numpy as np

from gearplay.integrate.active_set import ActiveSet
from gearplay.integrate.right_hand_side import rates_of
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import Branch, Loads, System

STAGES = 7
ORDER = 5
KEPT = 2  # stage whose loads are kept
NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
W = WEIGHTS = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
ERROR = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
DENSE = np.array(
    [
        -12715105075 / 11282082432,
        0.0,
        87487479700 / 32700410799,
        -10690763975 / 1880347072,
        701980252875 / 199316789632,
        -1453857185 / 822651844,
        69997945 / 29380423,
    ]
)


@compiled
def stage_state(stage: int, active_set: ActiveSet, h: float, y: Floats, k: Floats, result: Floats) -> None:
    """Fill the active states of ``result`` with those at a stage, 0 to 6, of a step of h [s] from y; ``k`` are the stages.

    A loop for each stage, its sum written out: a loop over the terms takes half as long again.
    """
    states = active_set.states
    if stage == 0:
        for s in range(1, states[0] + 1):
            result[states[s]] = y[states[s]]
    elif stage == 1:
        for s in range(1, states[0] + 1):
            i = states[s]
            result[i] = y[i] + h * (W[1, 0] * k[0, i])
    elif stage == 2:
        for s in range(1, states[0] + 1):
            i = states[s]
            result[i] = y[i] + h * (W[2, 0] * k[0, i] + W[2, 1] * k[1, i])
    elif stage == 3:
        for s in range(1, states[0] + 1):
            i = states[s]
            result[i] = y[i] + h * (W[3, 0] * k[0, i] + W[3, 1] * k[1, i] + W[3, 2] * k[2, i])
    elif stage == 4:
        for s in range(1, states[0] + 1):
            i = states[s]
            result[i] = y[i] + h * (
                W[4, 0] * k[0, i] + W[4, 1] * k[1, i] + W[4, 2] * k[2, i] + W[4, 3] * k[3, i]
            )
    elif stage == 5:
        for s in range(1, states[0] + 1):
            i = states[s]
            total = W[5, 0] * k[0, i] + W[5, 1] * k[1, i] + W[5, 2] * k[2, i]
            result[i] = y[i] + h * (total + W[5, 3] * k[3, i] + W[5, 4] * k[4, i])
    else:
        for s in range(1, states[0] + 1):
            i = states[s]
            total = W[6, 0] * k[0, i] + W[6, 1] * k[1, i] + W[6, 2] * k[2, i] + W[6, 3] * k[3, i]
            result[i] = y[i] + h * (total + W[6, 4] * k[4, i] + W[6, 5] * k[5, i])


@compiled_inline
def step(
    system: System,
    active_set: ActiveSet,
    t: float,
    h: float,
    y: Floats,
    stages: Floats,
    branch: Branch,
    y_new: Floats,
    inside: Loads,
    loads: Loads,
) -> int:
    """Advance the active states of y by one step h [s] on fixed modes; return 0, or 1 where a pair cannot mesh.

    ``stages`` [7, state] holds f(t, y) in row 0 on entry and f(t + h, y_new) in row 6 on return, when
    ``inside`` belongs to stage ``KEPT`` and ``loads`` to (t + h, y_new).
    """
    for stage in range(1, STAGES):
        stage_state(stage, active_set, h, y, stages, y_new)
        at = t + NODES[stage] * h
        seen = inside if stage == KEPT else loads
        if rates_of(system, active_set, at, y_new, branch, stages[stage], seen) != 0:
            return 1
    return 0


@compiled
def error_norm(active_set: ActiveSet, h: float, stages: Floats, scale: Floats) -> float:
    """Return the largest local error over its allowance: max_i |e_i| / scale_i; NaN and inf pass through."""
    worst = 0.0
    for s in range(1, active_set.states[0] + 1):
        i = active_set.states[s]
        e = 0.0
        for j in range(STAGES):
            e += ERROR[j] * stages[j, i]
        e = abs(h * e) / scale[i]
        if not (e <= worst):  # also true for NaN
            worst = e
            if not (e < np.inf):
                return np.inf
    return worst


@compiled_inline
def interpolate_state(i: int, x: float, h: float, y: Floats, y_new: Floats, stages: Floats) -> float:
    """Return the continuous extension of state i at t + x h, 0 <= x <= 1 (order 4)."""
    difference = y_new[i] - y[i]
    curvature = h * stages[0, i] - difference
    d = 0.0
    for j in range(STAGES):
        d += DENSE[j] * stages[j, i]
    r4 = difference - h * stages[6, i] - curvature
    return y[i] + x * (difference + (1.0 - x) * (curvature + x * (r4 + (1.0 - x) * h * d)))
