"""Workspace of the Radau IIA step: reused Jacobian, factors, stage derivatives of the steps before."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.active_set import ActiveSet
from gearplay.integrate.radau import (
    COMPLEX,
    LEFT_COMPLEX,
    LEFT_REAL,
    MOST,
    REAL,
    RIGHT_COMPLEX,
    RIGHT_REAL,
    STAGES,
)
from gearplay.kernels.arrays import ComplexRows, Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elimination import eliminate, substitute
from gearplay.kernels.layout import System, members, vx_of

# Slots of Implicit.numbers: steps since anything happened, whether it is in use, steps since the Jacobian, how many steps are
# traced (2 at most), whether factors are known, how many quiet explicit steps it waits for, steps since then, Newton's iterations
# of a step with a new Jacobian, right-hand sides beyond those since then.
QUIET, IN_USE, AGE, TRACED, FACTORED, BACKOFF, TRIED, FRESH, EXCESS = range(9)
# The method, by its row in the tables, of the next step, of the last one traced and of the one before; which of these the weights
# of the guess are for; the number of stages whose polynomial interpolates the step last tried, 0 for an explicit one;
# for how many steps the method is kept.
METHOD, LAST_METHOD, OLDER_METHOD, WEIGHED, COLLOCATED, HELD = range(9, 15)
NUMBERS = 15
# Slots of Implicit.sizes: lengths [s] of the last step traced, of the one that the factors are for, of the last explicit one; how
# fast Newton's method converges; lengths of the step traced before the last, and of the three that the weights are for; what a
# Jacobian costs, and steps since they were counted last, in right-hand sides; the shortest step that three stages would have
# taken lately; by which factor the error estimate of the last step lets the next one be longer.
H_TRACED, H_FACTORED, H_EXPLICIT, CONTRACTION, H_OLDER = range(5)
WEIGHED_H, WEIGHED_TRACED, WEIGHED_OLDER, COST, WORK, SHORT, GROWTH = range(5, 12)
SIZES = 12

FIRST_BACKOFF, MOST_BACKOFF = 12, 200  # explicit steps without an event after which it is tried
LARGEST = 240
"""Unknown accelerations at most: what is kept of their matrices takes 3 MB."""
HUB = 4  # joints of a rotor from which on its unknowns come last


@dataclass(frozen=True, eq=False)
class Implicit(Group):
    """Workspace of the implicit method that persists between steps, for at most m unknown accelerations."""

    numbers: Ints  # slots above
    sizes: Floats
    places: Ints  # [1 + m] places of velocities in the state, the first entry their number
    positions: Rows  # [m, m] derivatives of accelerations by positions
    velocities: Rows  # [m, m]
    real: Rows  # [m, m] factors
    complex: ComplexRows  # [2 m, m] of both pairs of eigenvalues
    first: Ints  # [m] columns where the rows of these matrices begin
    unknowns: Ints  # [3 rotors] places in them of what each rotor can do, -1 for what it cannot
    k: Rows  # [5, state] derivatives at the stages
    last: Rows  # [5, state] of the step before
    older: Rows  # [2, state] at the first stages of the step before that
    nodes: Floats  # [7] where the last of them lie, in step lengths
    weights: Rows  # [5, 7] by which they are carried on to the stages
    differences: Floats  # [7] weights of the error estimate
    dense: Floats  # [6] weights of the interpolant
    error_weight: Floats  # [state] what a change of an acceleration changes, in allowed errors
    rest: Rows  # [5, state] residuals of the equations, then the correction
    beside: Ints  # list: acting elements of a rotor
    whole: Ints  # list: all of them
    bodies: Ints  # list: all active rotors
    right: Floats  # [m]
    right_complex: NDArray[np.complex128]  # [2 m]


def make_implicit(rotors: int, elements: int, states: int) -> Implicit:
    """Allocate the workspace of the implicit method for a number of rotors, elements and states."""
    m = min(3 * rotors, LARGEST)
    numbers, sizes = np.zeros(NUMBERS, dtype=np.int64), np.zeros(SIZES)
    numbers[BACKOFF] = FIRST_BACKOFF
    return Implicit(
        numbers=numbers,
        sizes=sizes,
        places=np.zeros(m + 1, dtype=np.int64),
        positions=np.zeros((m, m)),
        velocities=np.zeros((m, m)),
        real=np.zeros((m, m)),
        complex=np.zeros((2 * m, m), dtype=np.complex128),
        first=np.zeros(m, dtype=np.int64),
        unknowns=np.zeros(3 * rotors, dtype=np.int64),
        k=np.zeros((MOST, states)),
        last=np.zeros((MOST, states)),
        older=np.zeros((2, states)),
        nodes=np.zeros(MOST + 2),
        weights=np.zeros((MOST, MOST + 2)),
        differences=np.zeros(MOST + 2),
        dense=np.zeros(MOST + 1),
        error_weight=np.zeros(states),
        rest=np.zeros((MOST, states)),
        beside=np.zeros(elements + 1, dtype=np.int64),
        whole=np.zeros(elements + 1, dtype=np.int64),
        bodies=np.zeros(rotors + 1, dtype=np.int64),
        right=np.zeros(m),
        right_complex=np.zeros(2 * m, dtype=np.complex128),
    )


@compiled_inline
def position_of(system: System, speed: int) -> int:
    """Return the place of the position whose velocity is at a place."""
    return speed - vx_of(system, 0)


@compiled_inline
def joins(system: System, active_set: ActiveSet, i: int) -> int:
    """Return the number of acting elements between rotor i and others."""
    count = 0
    for c in range(1, active_set.acting[0] + 1):
        first, second, third = members(system, active_set.acting[c])
        count += int(second >= 0 and i in (first, second, third))
    return count


@compiled_once
def find_unknowns(system: System, active_set: ActiveSet, kept: Implicit) -> None:
    """List the velocities of active rotors that forces can change, and what they are joined to; none where they are too many.

    Rotors that many others are joined to, a sun, a ring, a carrier, come last: their rows alone are long.
    """
    places, unknowns, first = kept.places, kept.unknowns, kept.first
    places[0] = 0
    unknowns[:] = -1
    for hub in range(2):
        for c in range(1, active_set.active[0] + 1):
            i = active_set.active[c]
            if hub != int(joins(system, active_set, i) >= HUB):
                continue
            r, own = system.rotors[i], places[0]
            for axis in range(3):
                if (r.inv_mass if axis < 2 else r.inv_inertia) > 0.0:
                    if places[0] == places.size - 1:
                        places[0] = 0
                        return
                    unknowns[3 * i + axis], first[places[0]] = places[0], own
                    places[0] += 1
                    places[places[0]] = vx_of(system, i) + axis
    for c in range(1, active_set.acting[0] + 1):
        lowest = places[0]
        for i in members(system, active_set.acting[c]):
            for axis in range(3):
                if i >= 0 and unknowns[3 * i + axis] >= 0:
                    lowest = min(lowest, unknowns[3 * i + axis])
        for i in members(system, active_set.acting[c]):
            for axis in range(3):
                if i >= 0 and unknowns[3 * i + axis] >= 0:
                    row = unknowns[3 * i + axis]
                    first[row] = min(first[row], lowest)


@compiled_inline
def pairs_of(kept: Implicit) -> int:
    """Return the number of entries of the matrices that can be nonzero."""
    count = 0
    for row in range(kept.places[0]):
        count += 2 * (row - kept.first[row]) + 1
    return count


@compiled_once
def factorise(kept: Implicit, h: float) -> int:
    """Factor the matrices of Newton's method for a step of h [s]; return 1 where one is singular."""
    count, method, m, first = kept.places[0], kept.numbers[METHOD], kept.right.size, kept.first
    real = REAL[method]
    for i in range(count):
        for j in range(first[i], i + 1):
            q, v = h * h * kept.positions[i, j], h * kept.velocities[i, j]
            q_t, v_t = h * h * kept.positions[j, i], h * kept.velocities[j, i]
            one = 1.0 if i == j else 0.0
            kept.real[i, j] = one - real * v - real * real * q
            kept.real[j, i] = one - real * v_t - real * real * q_t
            for pair in range(STAGES[method] // 2):
                root = COMPLEX[method, pair]
                kept.complex[pair * m + i, j] = one - root * v - root * root * q
                kept.complex[pair * m + j, i] = one - root * v_t - root * root * q_t
    failed = eliminate(kept.real, first, count)
    for pair in range(STAGES[method] // 2):
        if failed == 0:
            failed = eliminate(kept.complex[pair * m : pair * m + m], first, count)
    kept.numbers[FACTORED] = 1 - failed
    kept.sizes[H_FACTORED] = h
    return failed


@compiled_once
def correct(kept: Implicit) -> None:
    """Turn the residuals of the equations at the stages into the correction of the accelerations."""
    count, places, rest = kept.places[0], kept.places, kept.rest
    method, m = kept.numbers[METHOD], kept.right.size
    stages = STAGES[method]
    x, z = kept.right, kept.right_complex
    for c in range(count):
        s = places[c + 1]
        total = LEFT_REAL[method, 0] * rest[0, s]
        for stage in range(1, stages):
            total += LEFT_REAL[method, stage] * rest[stage, s]
        x[c] = total
        for pair in range(stages // 2):
            of_pair = LEFT_COMPLEX[method, pair, 0] * rest[0, s]
            for stage in range(1, stages):
                of_pair += LEFT_COMPLEX[method, pair, stage] * rest[stage, s]
            z[pair * m + c] = of_pair
    substitute(kept.real, kept.first, x, count)
    for pair in range(stages // 2):
        start, end = pair * m, pair * m + m
        substitute(kept.complex[start:end], kept.first, z[start:end], count)
    for c in range(count):
        s = places[c + 1]
        for stage in range(stages):
            change = RIGHT_REAL[method, stage] * x[c]
            for pair in range(stages // 2):
                change += 2.0 * (RIGHT_COMPLEX[method, pair, stage] * z[pair * m + c]).real
            rest[stage, s] = change
