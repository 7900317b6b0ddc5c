"""The control: the same kernels under a plain embedded 5(4) method, without events, flights or active sets."""

import time

import numpy as np

from bench.jit import jitted
from bench.problem import STATES, derivative
from gearplay.integrate.runge_kutta import ERROR, ORDER, STAGES, WEIGHTS
from gearplay.kernels.compiled import compiled_inline

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)


@compiled_inline
def stage_state(y, h, stages, stage, result):
    """Fill ``result`` with the state at which a stage is evaluated."""
    for i in range(y.size):
        total = 0.0
        for j in range(stage):
            total += WEIGHTS[stage, j] * stages[j, i]
        result[i] = y[i] + h * total


@jitted
def integrate(system, active_set, branch, loads, y, span, first, scale, stages, y_new):
    """Advance y to ``span`` by Dormand-Prince 5(4) with the usual step control; return the evaluations."""
    t, h, calls, fresh = 0.0, first, 1, True
    derivative(system, active_set, branch, loads, t, y, stages[0])
    while t < span:
        h = min(h, span - t)
        for stage in range(1, STAGES):
            stage_state(y, h, stages, stage, y_new)
            derivative(system, active_set, branch, loads, t + NODES[stage] * h, y_new, stages[stage])
        calls += STAGES - 1
        worst = 0.0
        for i in range(y.size):
            e = 0.0
            for j in range(STAGES):
                e += ERROR[j] * stages[j, i]
            e = abs(h * e) / scale[i]
            worst = max(worst, e) if e < np.inf else np.inf  # a trial step may go where the pair cannot mesh
        factor = 0.9 * max(worst, 1e-12) ** (-1.0 / ORDER)
        if worst == np.inf:
            factor = 0.1
        if worst <= 1.0:
            t += h
            for i in range(y.size):
                y[i] = y_new[i]
                stages[0, i] = stages[STAGES - 1, i]
            h *= min(5.0 if fresh else 1.0, factor)
            fresh = True
        else:
            h *= max(0.1, factor)
            fresh = False
    return calls


NAME = ["5(4)"]


def missing():
    """Return None: nothing to install."""
    return None


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds and the evaluations."""
    scale = tolerance * problem.packed.natural
    stages, y_new = np.zeros((STAGES, scale.size)), np.zeros(scale.size)
    integrate(*problem.arguments(), problem.start(member), 1e-6, 1e-7, scale, stages, y_new)
    arguments, y = problem.arguments(), problem.start(member)
    began = time.perf_counter()
    calls = integrate(*arguments, y, problem.span, 1e-6, scale, stages, y_new)
    return y, time.perf_counter() - began, calls


@jitted
def integrate_fixed(system, active_set, branch, loads, y, span, steps, stages, y_new):
    """Advance y to ``span`` by ``steps`` equal steps of the fifth-order formula."""
    h = span / steps
    for n in range(steps):
        for stage in range(STAGES - 1):
            stage_state(y, h, stages, stage, y_new)
            derivative(system, active_set, branch, loads, n * h + NODES[stage] * h, y_new, stages[stage])
        for i in range(y.size):
            for j in range(STAGES - 1):
                y[i] += h * WEIGHTS[STAGES - 1, j] * stages[j, i]


def fixed_step_evaluations(problem, wanted):
    """Return how many evaluations equal steps need for a median error [m] at most ``wanted``, among powers of two."""
    steps = 1024
    while steps < 2**22:
        steps *= 2
        errors = []
        for member in problem.members:
            y, scratch = problem.start(member), np.zeros(STATES)
            integrate_fixed(*problem.arguments(), y, problem.span, steps, np.zeros((STAGES, STATES)), scratch)
            errors.append(problem.error(member, y))
        if np.median(errors) <= wanted:
            return steps * (STAGES - 1)
    return float("nan")
