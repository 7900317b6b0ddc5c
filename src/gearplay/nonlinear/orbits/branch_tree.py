"""All connected branches: both directions, and branch switching at period doublings."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.orbits.branches import (
    CLOSED,
    DOUBLING,
    OUT_OF_TIME,
    Branch,
    Settings,
    doubled,
    follow_branch,
)
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.orbits.shooting import Orbit, constants, find_orbit
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.observables import Observables
from gearplay.vocabulary.errors import SimulationError
from gearplay.vocabulary.progress import Tick

Floats = NDArray[np.float64]

CLOSE = 1e-6
"""Distance in natural sizes within which two doublings, or two orbits, count as the same."""
NEAR = 0.2
"""Largest distance of an orbit from the line between two neighbours of a branch, over their distance."""


def settled_orbits(
    period_map: StrobeMap, places: Sequence[float], *, order: int, settle: int
) -> tuple[tuple[Orbit, ...], tuple[str, ...]]:
    """Return the periodic orbits of an order near the settled motion at each of ``places``, and the reasons where there is none.

    Raises `SimulationError` where there is none at all.
    """
    found, missed = list[Orbit](), list[str]()
    last: SimulationError | None = None
    for place in places:
        try:
            settled = period_map.settle(period_map.start(place), place, settle)
            found.append(find_orbit(period_map, settled, place, order=order))
        except SimulationError as error:
            if isinstance(error, OutOfTimeError) and not found:
                raise
            last = error
            missed.append(f"no start at {place:.6g}: {str(error).splitlines()[0]}")
    if found:
        return tuple(found), tuple(missed)
    tried = ", ".join(f"{place:.6g}" for place in places)
    raise SimulationError(
        f"branch: no periodic orbit of order {order} was found near the settled motion (tried at {tried}). "
        f"Begin at a value where the motion repeats, or give its order. Last attempt: {last}"
    ) from last


def whole_branch(
    period_map: StrobeMap, start: Orbit, settings: Settings, *, progress: Tick | None = None
) -> Branch:
    """Return the branch through ``start`` in both directions."""
    down = follow_branch(period_map, start, settings, upwards=False, progress=progress)
    if down.ended == CLOSED:
        return down
    up = follow_branch(period_map, start, settings, upwards=True, progress=progress)
    return joined(down, up)


def joined(one: Branch, other: Branch) -> Branch:
    """Join two branches from one orbit in opposite directions: ``one`` backwards, then ``other``."""
    last = len(one.orbits) - 1
    special = [replace(each, place=last - each.place - 1) for each in reversed(one.special)]
    special += [replace(each, place=each.place + last) for each in other.special]
    ended = "; ".join(dict.fromkeys((one.ended, other.ended)))
    return Branch((*one.orbits[:0:-1], *other.orbits), tuple(special), ended, one.order)


def branch_tree(
    period_map: StrobeMap,
    starts: Sequence[Orbit],
    settings: Settings,
    *,
    doublings: int = 1,
    progress: Tick | None = None,
) -> tuple[tuple[Branch, ...], tuple[str, ...]]:
    """Return the branches through ``starts`` and, ``doublings`` deep, those of twice the order that leave them at doublings.

    The second value names the doublings behind which nothing was followed because time was over.

    A start that lies on the branch of another gives no second one; a doubling from which no other branch could be followed
    stays a special point without one.
    """
    found: list[Branch] = []
    for start in starts:
        if not any(_lies_on(start, branch, period_map.scale) for branch in found):
            found.append(whole_branch(period_map, start, settings, progress=progress))
    row, late = list(found), list[str]()
    for _ in range(doublings):
        switched: list[Branch] = []
        for branch in row:
            for special in branch.special:
                if special.kind != DOUBLING or _is_met(special.orbit, found + switched, settings):
                    continue
                try:
                    orbit = doubled(period_map, special.orbit)
                    other = follow_branch(period_map, orbit, settings, progress=progress)
                except OutOfTimeError:
                    at = special.orbit.parameter
                    late.append(
                        f"the branch from the period doubling at {at:.6g} was not followed: {OUT_OF_TIME}"
                    )
                    continue
                except SimulationError:
                    continue
                middle = other.orbits[len(other.orbits) // 2]  # another end of a branch that is known?
                if not any(_lies_on(middle, each, period_map.scale) for each in found + switched):
                    switched.append(other)
        found += switched
        row = switched
    return tuple(found), tuple(late)


def _lies_on(orbit: Orbit, branch: Branch, scale: Floats) -> bool:
    """Return whether an orbit is one of a branch: near the line between two of its orbits."""
    if orbit.order != branch.order:
        return False
    free = ~constants(orbit.matrix)  # stored impact speeds depend on the history
    for a, b in pairwise(branch.orbits):
        if not min(a.parameter, b.parameter) <= orbit.parameter <= max(a.parameter, b.parameter):
            continue
        share = (orbit.parameter - a.parameter) / (b.parameter - a.parameter or 1.0)
        there = (1.0 - share) * a.states[0] + share * b.states[0]
        reach = NEAR * float(np.max(np.abs(b.states[0] - a.states[0])[free] / scale[free])) + CLOSE
        if any(np.max(np.abs(state - there)[free] / scale[free]) <= reach for state in orbit.states):
            return True
    return False


def _is_met(orbit: Orbit, branches: Sequence[Branch], settings: Settings) -> bool:
    """Return whether a branch of twice the order of ``orbit`` already ends or begins at its parameter."""
    return any(
        branch.order == 2 * orbit.order
        and min(abs(branch.orbits[end].parameter - orbit.parameter) for end in (0, -1))
        < CLOSE * settings.size
        for branch in branches
    )


def signals_of(period_map: StrobeMap, branch: Branch, signals: Sequence[str]) -> Floats:
    """Return signals at the sections of each orbit of a branch, shape [orbit, order, signal]."""
    rows = []
    for orbit in branch.orbits:
        flow = period_map.member(orbit.parameter).flow
        observe = Observables(flow.packed, signals)
        full = np.zeros((branch.order, flow.size))
        full[:, flow.free] = orbit.states[:, : len(flow.free)]
        rows.append([observe(0.0, state) for state in full])
    return np.array(rows)
