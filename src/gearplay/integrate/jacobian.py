"""Jacobian of an implicit step by exact slopes, body by body; computed anew only when it is stale."""

from gearplay.integrate.active_set import add, copy_list
from gearplay.integrate.implicit import (
    AGE,
    COST,
    EXCESS,
    FACTORED,
    FRESH,
    METHOD,
    WORK,
    Implicit,
)
from gearplay.integrate.implicit_stages import place_stage
from gearplay.integrate.radau import STAGES, C
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import CALLS, Run
from gearplay.integrate.slopes import linearise, rate_of_change
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, members, vx_of, x_of

FACTORS, CHANGES = 1.4, 1.5
"""What its factors cost for each stage, and its columns for each rotor of an element, in right-hand sides."""
OLDEST = 50  # steps that it is used for


@compiled_inline
def find_beside(system: System, run: Run, i: int) -> None:
    """List the acting elements that rotor i is a member of, and as active the rotors that these move."""
    kept, active, unknowns = run.implicit, run.active_set.active, run.implicit.unknowns
    kept.beside[0], active[0] = 0, 1
    active[1] = i
    for c in range(1, kept.whole[0] + 1):
        e = kept.whole[c]
        first, second, third = members(system, e)
        if i not in (first, second, third):
            continue
        add(kept.beside, e)
        for other in (first, second, third):
            if other < 0 or max(unknowns[3 * other], unknowns[3 * other + 1], unknowns[3 * other + 2]) < 0:
                continue
            listed = False
            for a in range(1, active[0] + 1):
                listed = listed or active[a] == other
            if not listed:
                add(active, other)


@compiled_once
def differentiate(system: System, run: Run, t: float, h: float) -> int:
    """Fill the Jacobian at the guess of the middle stage of a step of h [s] from t [s]; return 1 where a pair cannot mesh.

    The change of each coordinate moves the elements beside its rotor alone.
    """
    kept, active_set, method, slopes = run.implicit, run.active_set, run.implicit.numbers[METHOD], run.slopes
    middle, count, y = STAGES[method] // 2, run.implicit.places[0], run.y_new
    at = t + C[method, middle] * h
    place_stage(system, run, middle, h)
    run.counts[CALLS] += 2
    if rates_of(system, active_set, at, y, run.branch, run.stages[1], run.loads_try) != 0:
        return 1
    if linearise(system, active_set, at, y, run.branch, slopes, run.loads_try) != 0:
        return 1
    kept.positions[:count, :count] = 0.0
    kept.velocities[:count, :count] = 0.0
    copy_list(active_set.acting, kept.whole)
    copy_list(active_set.active, kept.bodies)
    beside = 0
    for c in range(1, kept.bodies[0] + 1):
        find_beside(system, run, kept.bodies[c])
        copy_list(kept.beside, active_set.acting)
        differentiate_by(system, run, kept.bodies[c])
        beside += kept.beside[0]
    copy_list(kept.whole, active_set.acting)
    copy_list(kept.bodies, active_set.active)
    kept.numbers[AGE] = kept.numbers[FACTORED] = 0
    kept.sizes[COST] = 3.0 + CHANGES * beside / (1.0 + kept.whole[0]) + FACTORS * STAGES[method]
    kept.sizes[WORK] += kept.sizes[COST]
    return 0


@compiled_once
def differentiate_by(system: System, run: Run, i: int) -> None:
    """Fill the columns of rotor i from the elements that act on it."""
    kept, active_set, z, dz = run.implicit, run.active_set, run.change, run.stages[2]
    for axis in range(3):
        column = kept.unknowns[3 * i + axis]
        if column < 0:
            continue
        for kind in range(2):
            place = x_of(i) + axis if kind == 0 else vx_of(system, i) + axis
            target = kept.positions if kind == 0 else kept.velocities
            z[place] = 1.0
            rate_of_change(system, active_set, run.branch, run.slopes, z, dz)
            z[place] = 0.0
            for c in range(1, active_set.active[0] + 1):
                first = vx_of(system, active_set.active[c])
                for other in range(3):
                    row = kept.unknowns[3 * active_set.active[c] + other]
                    if row >= 0:
                        target[row, column] = dz[first + other]


@compiled_inline
def is_worn(kept: Implicit) -> bool:
    """Return whether a new Jacobian costs no more than the old one has cost since it was new."""
    numbers = kept.numbers
    return bool(numbers[AGE] >= OLDEST or numbers[EXCESS] >= kept.sizes[COST])


@compiled_inline
def wear(kept: Implicit, turns: int) -> None:
    """Note how many iterations a step has taken, each of a right-hand side a stage, beyond those with a new Jacobian."""
    numbers = kept.numbers
    if numbers[AGE] == 0:
        numbers[FRESH], numbers[EXCESS] = turns, 0
    else:
        numbers[FRESH] = min(numbers[FRESH], turns)
        numbers[EXCESS] += STAGES[numbers[METHOD]] * (turns - numbers[FRESH])
