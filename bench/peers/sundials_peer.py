"""SUNDIALS' CVODE through scikit-sundae, with a compiled right-hand side behind a Python callback."""

import time

import numpy as np

from bench.peers._flat import SMALLEST_RELATIVE, flat
from bench.problem import STATES

NAME = ["BDF", "Adams"]
LIMIT = 2_000_000  # evaluations and steps


def missing():
    """Return what to install, None if nothing."""
    try:
        import sksundae.cvode  # noqa: F401
    except ImportError:
        return "pip install scikit-sundae"
    return None


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds the call took and the evaluations; NaN where the solver gave up."""
    from sksundae.cvode import CVODE

    rhs, room = flat(problem), np.empty(STATES)
    count = 0

    def function(t, y, dy):
        nonlocal count
        count += 1
        if count > LIMIT:  # CVODE may go on for ever
            raise RuntimeError("gave up")
        room[:] = y  # which CVODE lends for reading only, while a drive's ripple is written there
        rhs(t, room, dy)

    start, allowed = problem.start(member), tolerance * problem.packed.natural

    def call(span):
        times = np.array([0.0, 0.5, 1.0]) * span  # with two times it would store every step
        solver = CVODE(function, method=method, rtol=SMALLEST_RELATIVE, atol=allowed, max_num_steps=LIMIT)
        began = time.perf_counter()
        try:
            answer = solver.solve(times, start)
        except Exception:  # whatever the wrapper raises, the solver gave up
            return None, time.perf_counter() - began
        return answer, time.perf_counter() - began

    function(0.0, start, np.empty(STATES))  # a fault of ours is not CVODE's giving up
    call(1e-6)
    count = 0
    answer, seconds = call(problem.span)
    if (
        answer is None
        or not answer.success
        or answer.t[-1] != problem.span
        or not np.all(np.isfinite(answer.y[-1]))
    ):
        return np.full(STATES, np.nan), seconds, count
    return answer.y[-1].copy(), seconds, count
