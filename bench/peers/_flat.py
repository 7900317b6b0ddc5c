"""The common right-hand side as a compiled function of (t, y, dy), for solvers that pass nothing more."""

from functools import lru_cache

import numpy as np
from numba import carray, njit
from numba.core import cgutils, types
from numba.extending import intrinsic

from bench.problem import STATES, derivative
from gearplay.kernels.layout import Branch, Loads, System
from gearplay.kernels.roster import Roster

SMALLEST_RELATIVE = 100.0 * np.finfo(float).eps  # SciPy raises anything below to this
EVALUATION_LIMIT = 20_000_000  # a solver that needs more has failed
# Rates where the pair cannot mesh, in natural sizes per second: an error test turns such a trial step down,
# while LSODA and CVODE never recover from the NaN of `derivative`.
OUTSIDE = 1e9


@intrinsic
def pointer(typing_context, address):
    """Turn an address into a pointer."""

    def generate(context, builder, signature, values):
        return builder.inttoptr(values[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


def view(array):
    """Return a compiled function that gives the array by its address, which is cheaper than passing it."""
    address, shape, dtype = array.ctypes.data, array.shape, array.dtype

    @njit
    def get():
        return carray(pointer(address), shape, dtype)

    return get


@lru_cache
def flat(problem):
    """Return the compiled ``rhs(t, y, dy)`` of a problem; its arrays live as long as the program."""
    outside = OUTSIDE * problem.packed.natural
    arguments = problem.arguments()
    flat.kept.append(arguments)
    system, roster, branch, loads = arguments
    rotors, elements, contacts, switches, _, terms, involutes, spline, gravity = (
        None if isinstance(a, tuple) else view(a) for a in system
    )
    servos, sleeves, meshes, couplings = (view(a) for a in system.records)
    (roles, doings, since, origin, due, active, states, acting, watched, near, looked_at, hiding,
     grounded) = (view(a) for a in roster)  # fmt: skip
    modes, latch, memory = (view(a) for a in branch)
    table, force, out = (view(a) for a in loads)

    @njit(nogil=True, error_model="numpy")
    def rhs(t, y, dy):
        derivative(
            System(
                rotors(), elements(), contacts(), switches(), (servos(), sleeves(), meshes(), couplings()), terms(),
                involutes(), spline(), gravity(),
            ),
            Roster(
                roles(), doings(), since(), origin(), due(), active(), states(), acting(), watched(), near(),
                looked_at(), hiding(), grounded(),
            ),
            Branch(modes(), latch(), memory()), Loads(table(), force(), out()), t, y, dy,
        )  # fmt: skip
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
