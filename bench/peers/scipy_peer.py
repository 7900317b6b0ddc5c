"""SciPy's solve_ivp with a compiled right-hand side."""

import time
import warnings

import numpy as np
from scipy.integrate import solve_ivp

from bench.peers._flat import EVALUATION_LIMIT, SMALLEST_RELATIVE, flat

NAME = ["RK45", "DOP853", "LSODA", "Radau"]


def missing():
    """Return None: SciPy comes with the package."""
    return None


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds the call took and the evaluations; NaN where the solver gave up."""
    rhs = flat(problem)
    count, states, begin = 0, problem.packed.state_size, problem.begin

    def function(t, y):
        nonlocal count
        count += 1
        if count > EVALUATION_LIMIT:
            raise RuntimeError("too many evaluations")
        dy = np.empty(states)
        rhs(t, np.ascontiguousarray(y), dy)
        return dy

    start = problem.start(member)
    options = {"method": method, "rtol": SMALLEST_RELATIVE, "atol": tolerance * problem.packed.natural}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        solve_ivp(function, (begin, begin + 1e-6), start, **options)
        count = 0
        began = time.perf_counter()
        try:
            answer = solve_ivp(function, (begin, begin + problem.span), start, **options)
        except (RuntimeError, ValueError, np.linalg.LinAlgError):
            return np.full(states, np.nan), time.perf_counter() - began, count
        seconds = time.perf_counter() - began
    end = answer.y[:, -1]
    good = answer.success and np.all(np.isfinite(end))
    return end if good else np.full(states, np.nan), seconds, count
