"""The common right-hand side as a compiled function of (t, y, dy), for solvers that pass nothing more."""

from functools import lru_cache

import numpy as np
from numba import njit
from numba.core import cgutils
from numba.extending import intrinsic

from bench.jit import group_type
from bench.problem import STATES, derivative

SMALLEST_RELATIVE = 100.0 * np.finfo(float).eps  # SciPy raises anything below to this
EVALUATION_LIMIT = 20_000_000  # a solver that needs more has failed
# Rates where the pair cannot mesh, in natural sizes per second: an error test turns such a trial step down,
# while LSODA and CVODE never recover from the NaN of `derivative`.
OUTSIDE = 1e9


def held(group):
    """Return a compiled function that gives the group, which is an address."""
    kind, address = group_type(type(group)), group._address

    @intrinsic
    def at(typing_context, number):
        def generate(context, builder, signature, values):
            return builder.inttoptr(values[0], cgutils.voidptr_t)

        return kind(number), generate

    @njit
    def get():
        return at(address)

    return get


@lru_cache
def flat(problem):
    """Return the compiled ``rhs(t, y, dy)`` of a problem; its arrays live as long as the program."""
    outside = OUTSIDE * problem.packed.natural
    arguments = problem.arguments()
    flat.kept.append(arguments)
    system, active_set, branch, loads = (held(group) for group in arguments)

    @njit(nogil=True, error_model="numpy")
    def rhs(t, y, dy):
        derivative(system(), active_set(), branch(), loads(), t, y, dy)
        if dy[0] != dy[0]:
            dy[:] = outside

    return rhs


flat.kept = []


def random_states(problem, count=200, seed=0):
    """Return (t, y) pairs about the clearances, many of them with sleeve and flanks in contact."""
    rng = np.random.default_rng(seed)
    natural = problem.packed.natural
    spread = 1.5 * natural
    spread[2] = 0.0  # the ring alone spans the backlash
    for _ in range(count):
        yield rng.uniform(0.0, 1.0), rng.uniform(-1.0, 1.0, STATES) * spread


def largest_difference(problem, other):
    """Return the largest difference of ``other(t, y) -> dy`` from ours, relative to the largest entry."""
    rhs, dy, worst = flat(problem), np.empty(STATES), 0.0
    half = STATES // 2
    for t, y in random_states(problem):
        rhs(t, y, dy)
        theirs = np.asarray(other(t, y))
        for part in (slice(0, half), slice(half, STATES)):
            worst = max(worst, np.max(np.abs(theirs[part] - dy[part])) / np.max(np.abs(dy[part])))
    return float(worst)
