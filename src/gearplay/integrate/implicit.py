"""Workspace of the Radau IIA step: reused Jacobian, LU factors, stage accelerations of the previous step.

Newton's method for the three stages of a Radau step, all at once, falls apart into a real and a complex system of the size of one
stage (J. C. Butcher, BIT 16 (1976) 237; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., section IV.8).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.active_set import ActiveSet
from gearplay.kernels.arrays import ComplexRows, Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elimination import eliminate, substitute
from gearplay.kernels.layout import System, vx_of

# Slots of Implicit.numbers: steps since anything happened, whether it is in use, steps since the Jacobian, how many steps are
# traced (2 at most), whether factors are known, how many quiet explicit steps it waits for, steps since then, Newton's iterations
# of a step with a new Jacobian, right-hand sides beyond those since then, and all there had been when steps were counted last.
QUIET, IN_USE, AGE, TRACED, FACTORED, BACKOFF, TRIED, FRESH, EXCESS, CALLS_TRIED = range(10)
# Slots of Implicit.sizes: lengths [s] of the last step traced, of the one that the factors are for, of the last explicit one; how
# fast Newton's method converges; lengths of the step traced before the last, and of the three that the weights are for; what a
# Jacobian costs, in right-hand sides.
H_TRACED, H_FACTORED, H_EXPLICIT, CONTRACTION, H_OLDER = range(5)
WEIGHED_H, WEIGHED_TRACED, WEIGHED_OLDER, COST = range(5, 9)

FIRST_BACKOFF, MOST_BACKOFF = 12, 200  # explicit steps without an event after which it is tried
LARGEST = 60
"""Unknown accelerations at most: with more, factors and what is kept of them cost too much."""

_ROOT = float(np.sqrt(6.0))
C = np.array([0.4 - 0.1 * _ROOT, 0.4 + 0.1 * _ROOT, 1.0])
A = np.array(
    [
        [(88.0 - 7.0 * _ROOT) / 360.0, (296.0 - 169.0 * _ROOT) / 1800.0, (-2.0 + 3.0 * _ROOT) / 225.0],
        [(296.0 + 169.0 * _ROOT) / 1800.0, (88.0 + 7.0 * _ROOT) / 360.0, (-2.0 - 3.0 * _ROOT) / 225.0],
        [(16.0 - _ROOT) / 36.0, (16.0 + _ROOT) / 36.0, 1.0 / 9.0],
    ]
)
AA = A @ A  # positions from accelerations


def _spectrum() -> tuple[float, complex, Floats, NDArray[np.complex128], Floats, NDArray[np.complex128]]:
    """Return the real and a complex eigenvalue of A, their right and their left vectors, scaled to each other."""
    values, vectors = np.linalg.eig(A)
    inverse = np.linalg.inv(vectors)
    real = int(np.argmin(np.abs(values.imag)))
    upper = int(np.argmax(values.imag))
    scale = vectors[0, real]
    return (
        float(values[real].real),
        complex(values[upper]),
        np.ascontiguousarray((vectors[:, real] / scale).real),
        np.ascontiguousarray(vectors[:, upper]),
        np.ascontiguousarray((inverse[real] * scale).real),
        np.ascontiguousarray(inverse[upper]),
    )


REAL, COMPLEX, RIGHT_REAL, RIGHT_COMPLEX, LEFT_REAL, LEFT_COMPLEX = _spectrum()


@dataclass(frozen=True, eq=False)
class Implicit(Group):
    """What the implicit method keeps from step to step, for m unknown accelerations at most."""

    numbers: Ints  # slots above
    sizes: Floats
    places: Ints  # [1 + m] places of velocities in the state, the first entry their number
    positions: Rows  # [m, m] derivatives of accelerations by positions
    velocities: Rows  # [m, m]
    real: Rows  # [m, m] factors
    complex: ComplexRows  # [m, m]
    real_swaps: Ints  # [m]
    complex_swaps: Ints
    k: Rows  # [3, state] accelerations at the stages, in their places
    last: Rows  # [3, state] of the step before
    last_v: Floats  # [state] velocities at its second stage, in the places of positions
    older: Rows  # [2, state] accelerations at the first stages of the step before that
    nodes: Floats  # [5] where the last five of them lie, in step lengths
    weights: Rows  # [3, 5] by which they are carried on to the stages
    error_weight: Floats  # [state] what a change of an acceleration changes, in allowed errors
    rest: Rows  # [3, state] what is left of the equations, then the correction
    v: Rows  # [3, state] velocities at the stages, in the places of positions
    beside: Ints  # list: acting elements of a rotor
    whole: Ints  # list: all of them
    right: Floats  # [m]
    right_complex: NDArray[np.complex128]  # [m]


def make_implicit(rotors: int, elements: int, states: int) -> Implicit:
    """Allocate what the implicit method keeps, for a number of rotors, elements and states."""
    m = min(3 * rotors, LARGEST)
    numbers, sizes = np.zeros(10, dtype=np.int64), np.zeros(9)
    numbers[BACKOFF] = FIRST_BACKOFF
    return Implicit(
        numbers=numbers,
        sizes=sizes,
        places=np.zeros(m + 1, dtype=np.int64),
        positions=np.zeros((m, m)),
        velocities=np.zeros((m, m)),
        real=np.zeros((m, m)),
        complex=np.zeros((m, m), dtype=np.complex128),
        real_swaps=np.zeros(m, dtype=np.int64),
        complex_swaps=np.zeros(m, dtype=np.int64),
        k=np.zeros((3, states)),
        last=np.zeros((3, states)),
        last_v=np.zeros(states),
        older=np.zeros((2, states)),
        nodes=np.zeros(5),
        weights=np.zeros((3, 5)),
        error_weight=np.zeros(states),
        rest=np.zeros((3, states)),
        v=np.zeros((3, states)),
        beside=np.zeros(elements + 1, dtype=np.int64),
        whole=np.zeros(elements + 1, dtype=np.int64),
        right=np.zeros(m),
        right_complex=np.zeros(m, dtype=np.complex128),
    )


@compiled_inline
def position_of(system: System, speed: int) -> int:
    """Return the place of the position whose velocity is at a place."""
    return speed - vx_of(system, 0)


@compiled_once
def find_unknowns(system: System, active_set: ActiveSet, kept: Implicit) -> None:
    """List the velocities of active rotors that forces can change; none where they are too many."""
    places = kept.places
    places[0] = 0
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        r = system.rotors[i]
        for axis in range(3):
            if (r.inv_mass if axis < 2 else r.inv_inertia) > 0.0:
                if places[0] == places.size - 1:
                    places[0] = 0
                    return
                places[0] += 1
                places[places[0]] = vx_of(system, i) + axis


@compiled_once
def factorise(kept: Implicit, h: float) -> int:
    """Factor both matrices of Newton's method for a step of h [s]; return 1 where one is singular."""
    count = kept.places[0]
    for i in range(count):
        for j in range(count):
            one = 1.0 if i == j else 0.0
            q, v = h * h * kept.positions[i, j], h * kept.velocities[i, j]
            kept.real[i, j] = one - REAL * v - REAL * REAL * q
            kept.complex[i, j] = one - COMPLEX * v - COMPLEX * COMPLEX * q
    failed = eliminate(kept.real, kept.real_swaps, count)
    if failed == 0:
        failed = eliminate(kept.complex, kept.complex_swaps, count)
    kept.numbers[FACTORED] = 1 - failed
    kept.sizes[H_FACTORED] = h
    return failed


@compiled_once
def correct(kept: Implicit) -> None:
    """Turn what is left of the equations at the stages into the correction of the accelerations."""
    count, places, rest = kept.places[0], kept.places, kept.rest
    x, z = kept.right, kept.right_complex
    for c in range(count):
        s = places[c + 1]
        x[c] = LEFT_REAL[0] * rest[0, s] + LEFT_REAL[1] * rest[1, s] + LEFT_REAL[2] * rest[2, s]
        z[c] = LEFT_COMPLEX[0] * rest[0, s] + LEFT_COMPLEX[1] * rest[1, s] + LEFT_COMPLEX[2] * rest[2, s]
    substitute(kept.real, kept.real_swaps, x, count)
    substitute(kept.complex, kept.complex_swaps, z, count)
    for c in range(count):
        s = places[c + 1]
        for stage in range(3):
            rest[stage, s] = RIGHT_REAL[stage] * x[c] + 2.0 * (RIGHT_COMPLEX[stage] * z[c]).real
