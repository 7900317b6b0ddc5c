"""Jacobian of an implicit step by finite differences, body by body; computed anew only when it is stale."""

from gearplay.integrate.active_set import add, copy_list
from gearplay.integrate.implicit import (
    AGE,
    COST,
    EXCESS,
    FACTORED,
    FRESH,
    C,
    Implicit,
    position_of,
)
from gearplay.integrate.implicit_stages import place_stage
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import CALLS, Run
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, members, vx_of

MIDDLE = 1  # the stage at whose guessed state it is taken
FACTORS = 4.0  # what its factors cost, in right-hand sides
OLDEST = 50  # steps that it is used for


@compiled_inline
def find_beside(system: System, run: Run, i: int) -> None:
    """List the acting elements that rotor i is a member of: no others feel it move."""
    kept = run.implicit
    kept.beside[0] = 0
    for c in range(1, kept.whole[0] + 1):
        e = kept.whole[c]
        first, second, third = members(system, e)
        if i in (first, second, third):
            add(kept.beside, e)


@compiled_once
def differentiate(system: System, run: Run, t: float, h: float) -> int:
    """Fill the Jacobian at a guessed state of a step of h [s] from t [s], by differences; return 1 where a pair cannot mesh."""
    kept, active_set = run.implicit, run.active_set
    copy_list(active_set.acting, kept.whole)
    place_stage(system, run, MIDDLE, h)
    kept.sizes[COST] = FACTORS
    failed = 0
    for c in range(1, active_set.active[0] + 1):
        if failed == 0:
            find_beside(system, run, active_set.active[c])
            copy_list(kept.beside, active_set.acting)
            failed = differentiate_by(system, run, t + C[MIDDLE] * h, active_set.active[c])
    copy_list(kept.whole, active_set.acting)
    kept.numbers[AGE] = kept.numbers[FACTORED] = 0
    return failed


@compiled_once
def differentiate_by(system: System, run: Run, t: float, i: int) -> int:
    """Fill the columns of rotor i, only the elements beside it acting; return 1 where a pair cannot mesh."""
    kept, active_set, y, before, after = run.implicit, run.active_set, run.y_new, run.stages[1], run.stages[2]
    if rates_of(system, active_set, t, y, run.branch, before, run.loads_try) != 0:
        return 1
    part = (1.0 + active_set.acting[0]) / (1.0 + kept.whole[0])
    run.counts[CALLS] += 1
    kept.sizes[COST] += part
    for c in range(kept.places[0]):
        speed = kept.places[c + 1]
        if not vx_of(system, i) <= speed < vx_of(system, i) + 3:
            continue
        for kind in range(2):
            place = position_of(system, speed) if kind == 0 else speed
            target = kept.positions if kind == 0 else kept.velocities
            far, held = (1e-5 if kind == 0 else 1e-4) * run.natural[place], y[place]
            y[place] = held + far
            run.counts[CALLS] += 1
            kept.sizes[COST] += part
            if rates_of(system, active_set, t, y, run.branch, after, run.loads_try) != 0:
                return 1
            y[place] = held
            for other in range(kept.places[0]):
                at = kept.places[other + 1]
                target[other, c] = (after[at] - before[at]) / far
    return 0


@compiled_inline
def is_worn(kept: Implicit) -> bool:
    """Return whether a new Jacobian costs no more than the old one has cost since it was new."""
    numbers = kept.numbers
    return bool(numbers[AGE] >= OLDEST or numbers[EXCESS] >= kept.sizes[COST])


@compiled_inline
def wear(kept: Implicit, turns: int) -> None:
    """Note how many iterations a step has taken, each of three right-hand sides, beyond those with a new Jacobian."""
    numbers = kept.numbers
    if numbers[AGE] == 0:
        numbers[FRESH], numbers[EXCESS] = turns, 0
    else:
        numbers[FRESH] = min(numbers[FRESH], turns)
        numbers[EXCESS] += 3 * (turns - numbers[FRESH])
