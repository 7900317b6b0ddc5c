"""Stage values of an implicit step: predicted accelerations, the states that they give, their polynomial."""

from gearplay.integrate.implicit import (
    AGE,
    COLLOCATED,
    H_OLDER,
    H_TRACED,
    IN_USE,
    LAST_METHOD,
    METHOD,
    OLDER_METHOD,
    TRACED,
    WEIGHED,
    WEIGHED_H,
    WEIGHED_OLDER,
    WEIGHED_TRACED,
    Implicit,
)
from gearplay.integrate.radau import AA, DENSE, STAGES, A, C
from gearplay.integrate.run import Run
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import first_axis
from gearplay.kernels.layout import System, vx_of, x_of


@compiled_once
def weigh(kept: Implicit, h: float) -> None:
    """Fill the weights of the traced accelerations at the stages of a step of h [s]: Lagrange's polynomials."""
    nodes, sizes, numbers = kept.nodes, kept.sizes, kept.numbers
    method, of_last, of_older = numbers[METHOD], numbers[LAST_METHOD], numbers[OLDER_METHOD]
    last, older = sizes[H_TRACED] / h, sizes[H_OLDER] / h
    count = 2 + STAGES[of_last]
    for j in range(2):
        nodes[j] = (C[of_older, j] - 1.0) * older - last
    for j in range(STAGES[of_last]):
        nodes[2 + j] = (C[of_last, j] - 1.0) * last
    first = 0 if numbers[TRACED] > 1 else 2
    for stage in range(STAGES[method]):
        for j in range(count):
            w = 1.0 if j >= first else 0.0
            for other in range(first, count):
                if other != j:
                    w *= (C[method, stage] - nodes[other]) / (nodes[j] - nodes[other])
            kept.weights[stage, j] = w
    sizes[WEIGHED_H], sizes[WEIGHED_TRACED], sizes[WEIGHED_OLDER] = h, sizes[H_TRACED], sizes[H_OLDER]
    numbers[WEIGHED] = methods_traced(kept)


@compiled_inline
def methods_traced(kept: Implicit) -> int:
    """Return a number for the methods of this step and of those traced, and for how many these are."""
    numbers = kept.numbers
    return int(numbers[METHOD] + 2 * numbers[LAST_METHOD] + 4 * numbers[OLDER_METHOD] + 8 * numbers[TRACED])


@compiled_inline
def predict(system: System, run: Run, h: float, onward: bool) -> None:
    """Predict the accelerations at the stages: extrapolated from the last two steps (``onward``), or constant."""
    kept, active = run.implicit, run.active_set.active
    sizes, w, last, older, k = kept.sizes, kept.weights, kept.last, kept.older, kept.k
    traced, stages = onward and kept.numbers[TRACED] > 0, STAGES[kept.numbers[METHOD]]
    if traced and (
        kept.numbers[WEIGHED] != methods_traced(kept)
        or sizes[WEIGHED_H] != h
        or sizes[WEIGHED_TRACED] != sizes[H_TRACED]
        or sizes[WEIGHED_OLDER] != sizes[H_OLDER]
    ):
        weigh(kept, h)
    longer = STAGES[kept.numbers[LAST_METHOD]] == 5
    for c in range(1, active[0] + 1):
        i = active[c]
        for s in range(vx_of(system, i) + first_axis(system, i, run.y), vx_of(system, i) + 3):
            for stage in range(stages):
                if traced:
                    total = (
                        w[stage, 0] * older[0, s]
                        + w[stage, 1] * older[1, s]
                        + w[stage, 2] * last[0, s]
                        + w[stage, 3] * last[1, s]
                        + w[stage, 4] * last[2, s]
                    )
                    if longer:
                        total += w[stage, 5] * last[3, s] + w[stage, 6] * last[4, s]
                    k[stage, s] = total
                else:
                    k[stage, s] = run.stages[0, s]


@compiled_inline
def combine(w: Floats, k: Rows, s: int, stages: int) -> float:
    """Return the weighted sum of the derivatives of state s at the stages, three or five."""
    total = w[0] * k[0, s] + w[1] * k[1, s] + w[2] * k[2, s]
    if stages == 5:
        total += w[3] * k[3, s] + w[4] * k[4, s]
    return float(total)


@compiled_inline
def place_stage(system: System, run: Run, stage: int, h: float) -> None:
    """Fill y_new with the state at a stage."""
    active_set, y, k, method = run.active_set, run.y, run.implicit.k, run.implicit.numbers[METHOD]
    stages, a, aa, along = STAGES[method], A[method, stage], AA[method, stage], C[method, stage]
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        for axis in range(first_axis(system, i, y), 3):
            q, s = x_of(i) + axis, vx_of(system, i) + axis
            k[stage, q] = y[s] + h * combine(a, k, s, stages)
            run.y_new[s] = k[stage, q]
            run.y_new[q] = y[q] + h * (along * y[s] + h * combine(aa, k, s, stages))


@compiled_inline
def trace(run: Run, h: float) -> None:
    """Store the derivatives of an accepted step, from which the next stages are predicted."""
    kept, states, numbers = run.implicit, run.active_set.states, run.implicit.numbers
    for c in range(1, states[0] + 1):
        s = states[c]
        for stage in range(2):  # zero without a step before, as are their weights
            kept.older[stage, s] = kept.last[stage, s] if numbers[TRACED] > 0 else 0.0
        for stage in range(STAGES[numbers[METHOD]]):
            kept.last[stage, s] = kept.k[stage, s]
    kept.sizes[H_OLDER], kept.sizes[H_TRACED] = kept.sizes[H_TRACED], h
    numbers[OLDER_METHOD], numbers[LAST_METHOD] = numbers[LAST_METHOD], numbers[METHOD]
    numbers[TRACED] = min(numbers[TRACED] + 1, 2)
    numbers[IN_USE] = 1
    numbers[AGE] += 1


@compiled_inline
def fill_rows(run: Run) -> None:
    """Fill the rows of the explicit method's stages with the derivatives at the stages, the last of them more than once."""
    active_set, stages, k = run.active_set, run.stages, run.implicit.k
    count = STAGES[run.implicit.numbers[METHOD]]
    for c in range(1, active_set.states[0] + 1):
        s = active_set.states[c]
        for row in range(1, stages.shape[0] - 1):
            stages[row, s] = k[min(row, count) - 1, s]
    run.implicit.numbers[COLLOCATED] = count


@compiled
def weigh_inside(kept: Implicit, x: float) -> None:
    """Fill the weights of the interpolant at x, in step lengths: the integral of the polynomial through start and stages."""
    stages = kept.numbers[COLLOCATED]
    method = 0 if stages == STAGES[0] else 1
    for j in range(stages + 1):
        total = DENSE[method, stages, j]
        for power in range(stages):
            total = total * x + DENSE[method, stages - 1 - power, j]
        kept.dense[j] = total * x


@compiled_inline
def collocate(run: Run, i: int, h: float) -> float:
    """Return state i on the interpolant of an implicit step of h [s], at the place of the weights."""
    w, stages = run.implicit.dense, run.stages
    total = w[0] * stages[0, i] + w[1] * stages[1, i] + w[2] * stages[2, i] + w[3] * stages[3, i]
    if run.implicit.numbers[COLLOCATED] == 5:
        total += w[4] * stages[4, i] + w[5] * stages[5, i]
    return float(run.y[i] + h * total)
