"""Stage values of an implicit step: predicted accelerations and the states that they give."""

from gearplay.integrate.implicit import (
    AA,
    AGE,
    H_OLDER,
    H_TRACED,
    IN_USE,
    TRACED,
    WEIGHED_H,
    WEIGHED_OLDER,
    WEIGHED_TRACED,
    A,
    C,
    Implicit,
    position_of,
)
from gearplay.integrate.run import Run
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, vx_of, x_of

BACK = 5  # places that the polynomial goes through: two stages of the step before the last, three of the last


@compiled_once
def weigh(kept: Implicit, h: float) -> None:
    """Fill the weights of the traced accelerations at the stages of a step of h [s]: Lagrange's polynomials."""
    nodes, sizes = kept.nodes, kept.sizes
    last, older = sizes[H_TRACED] / h, sizes[H_OLDER] / h
    for j in range(2):
        nodes[j] = (C[j] - 1.0) * older - last
    for j in range(3):
        nodes[2 + j] = (C[j] - 1.0) * last
    first = 0 if kept.numbers[TRACED] > 1 else 2
    for stage in range(3):
        for j in range(BACK):
            w = 1.0 if j >= first else 0.0
            for other in range(first, BACK):
                if other != j:
                    w *= (C[stage] - nodes[other]) / (nodes[j] - nodes[other])
            kept.weights[stage, j] = w
    sizes[WEIGHED_H], sizes[WEIGHED_TRACED], sizes[WEIGHED_OLDER] = h, sizes[H_TRACED], sizes[H_OLDER]


@compiled_inline
def predict(system: System, run: Run, h: float) -> None:
    """Guess the accelerations at the stages: those of the last two steps go on, or they stay what they are."""
    kept, active = run.implicit, run.active_set.active
    sizes, w, last, older, k = kept.sizes, kept.weights, kept.last, kept.older, kept.k
    traced = kept.numbers[TRACED] > 0
    if traced and (
        sizes[WEIGHED_H] != h
        or sizes[WEIGHED_TRACED] != sizes[H_TRACED]
        or sizes[WEIGHED_OLDER] != sizes[H_OLDER]
    ):
        weigh(kept, h)
    for c in range(1, active[0] + 1):
        first = vx_of(system, active[c])
        for s in range(first, first + 3):
            for stage in range(3):
                if traced:
                    k[stage, s] = (
                        w[stage, 0] * older[0, s]
                        + w[stage, 1] * older[1, s]
                        + w[stage, 2] * last[0, s]
                        + w[stage, 3] * last[1, s]
                        + w[stage, 4] * last[2, s]
                    )
                else:
                    k[stage, s] = run.stages[0, s]


@compiled_inline
def place_stage(system: System, run: Run, stage: int, h: float) -> None:
    """Fill y_new with the state at a stage."""
    active_set, y, k, v = run.active_set, run.y, run.implicit.k, run.implicit.v
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        for axis in range(3):
            q, s = x_of(i) + axis, vx_of(system, i) + axis
            v[stage, q] = y[s] + h * (A[stage, 0] * k[0, s] + A[stage, 1] * k[1, s] + A[stage, 2] * k[2, s])
            run.y_new[s] = v[stage, q]
            curvature = AA[stage, 0] * k[0, s] + AA[stage, 1] * k[1, s] + AA[stage, 2] * k[2, s]
            run.y_new[q] = y[q] + h * (C[stage] * y[s] + h * curvature)


@compiled_inline
def trace(system: System, run: Run, h: float) -> None:
    """Keep the accelerations of a step that was accepted, for the guesses of the next ones."""
    kept, active = run.implicit, run.active_set.active
    for c in range(1, active[0] + 1):
        first = vx_of(system, active[c])
        for s in range(first, first + 3):
            kept.last_v[position_of(system, s)] = kept.v[1, position_of(system, s)]
            kept.older[0, s], kept.older[1, s] = kept.last[0, s], kept.last[1, s]
            for stage in range(3):
                kept.last[stage, s] = kept.k[stage, s]
    kept.sizes[H_OLDER], kept.sizes[H_TRACED] = kept.sizes[H_TRACED], h
    kept.numbers[TRACED] = min(kept.numbers[TRACED] + 1, 2)
    kept.numbers[IN_USE] = 1
    kept.numbers[AGE] += 1
