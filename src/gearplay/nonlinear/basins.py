"""Basins of attraction: which of several motions an initial state leads to, on a grid of two of its entries."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.nonlinear.crew import share_out
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.solver.flow import Flow
from gearplay.solver.observables import state_names
from gearplay.vocabulary.errors import Fault, GearplayError, InputError

Floats = NDArray[np.float64]
IRREGULAR, FAILED = -1, -2
MOST_ORDER = 8
ALIKE = 1e-3
"""Distance [natural sizes] within which two sections are those of one motion."""


@dataclass(frozen=True)
class Grid:
    """Values of one entry of the initial state, like ``ring.vx``, from ``low`` to ``high`` in SI; rotations are relative ones."""

    name: str
    low: float
    high: float
    count: int


@dataclass(frozen=True)
class Basins:
    """Where each initial state leads, shape [second, first]: the place of its motion in ``attractors``.

    -1 marks motions that do not repeat within 8 periods, -2 starts that cannot be followed. Each attractor holds its sections,
    shape [order, free state].
    """

    first: Floats
    second: Floats
    labels: NDArray[np.int64]
    attractors: tuple[Floats, ...]

    @property
    def shares(self) -> Floats:
        """Share of the grid that leads to each attractor, shape [attractor]."""
        return np.array([np.mean(self.labels == at) for at in range(len(self.attractors))])


def basins_of_attraction(
    case: Case,
    first: Grid,
    second: Grid,
    *,
    settle: int = 300,
    period: str | float = "common",
    threads: int = 2,
    progress: Callable[[float, float], None] | None = None,
    stop: threading.Event | None = None,
) -> Basins:
    """Return which motion each start of a grid settles to within ``settle`` periods; all other entries are those of the case.

    Two starts lead to the same motion where a section of one comes within 1e-3 natural sizes of one of the other: settle for long
    enough. Attractors are numbered in the order of the grid, whatever the number of threads.

    Raises `InputError` for entries, ranges or a case that cannot be.
    """
    flow = Flow(case)
    step = section_period(flow.packed, period)
    places = [_place(flow, grid) for grid in (first, second)]
    if places[0] == places[1]:
        raise InputError(Fault("second", second.name, "must be another entry than the first", "Choose one"))
    if settle < 1:
        raise InputError(Fault("settle", settle, "must be 1 or more", "Raise it"))
    axes = [np.linspace(grid.low, grid.high, grid.count) for grid in (first, second)]
    start, total = flow.start(), axes[0].size * axes[1].size
    sections = np.full((total, 2 * MOST_ORDER, len(flow.free)), np.nan)
    asked = stop or threading.Event()

    def go(at: int, tick: Callable[[], None]) -> None:
        if asked.is_set():
            return
        state = start.copy()
        state[places[0]], state[places[1]] = axes[0][at % axes[0].size], axes[1][at // axes[0].size]
        try:
            course = flow.begin(state, stop=asked)
            for n in range(2 * MOST_ORDER):
                course.advance((settle + n) * step)
                sections[at, n] = course.state[flow.free]
        except GearplayError:
            sections[at] = np.nan
        tick()

    share_out(range(total), go, total=total, threads=threads, stop=asked, progress=progress)
    labels, attractors = _labels(sections, flow.natural[flow.free])
    return Basins(axes[0], axes[1], labels.reshape(axes[1].size, axes[0].size), attractors)


def _place(flow: Flow, grid: Grid) -> int:
    """Return the place of an entry in the state; `InputError` where it is none, prescribed, or its range is empty."""
    free = flow.free_names
    if grid.name not in free:
        rule = "must be an entry of the state that is not prescribed"
        raise InputError(Fault("name", grid.name, rule, f"Choose from: {', '.join(free)}"))
    if not grid.low < grid.high or grid.count < 2:
        rule = "must have low below high and a count of 2 or more"
        raise InputError(Fault(grid.name, f"{grid.low:g} to {grid.high:g}, {grid.count}", rule, "Correct it"))
    return state_names(flow.packed).index(grid.name)


def _labels(sections: Floats, scale: Floats) -> tuple[NDArray[np.int64], tuple[Floats, ...]]:
    """Return the label of each start from its last sections, shape [start, period, state], and the attractors."""
    labels = np.empty(len(sections), dtype=np.int64)
    attractors: list[Floats] = []
    for at, seen in enumerate(sections):
        if not np.isfinite(seen).all():
            labels[at] = FAILED
            continue
        order = _order(seen / scale)
        if order == 0:
            labels[at] = IRREGULAR
            continue
        same = (k for k, known in enumerate(attractors) if _is_on(seen[0], known, scale))
        labels[at] = next(same, len(attractors))
        if labels[at] == len(attractors):
            attractors.append(seen[:order].copy())
    return labels, tuple(attractors)


def _order(scaled: Floats) -> int:
    """Return after how many periods sections repeat, 0 for more than `MOST_ORDER`."""
    for order in range(1, MOST_ORDER + 1):
        if np.max(np.abs(scaled[order:] - scaled[:-order])) < ALIKE:
            return order
    return 0


def _is_on(state: Floats, attractor: Floats, scale: Floats) -> bool:
    return bool(np.min(np.max(np.abs(attractor - state) / scale, axis=1)) < ALIKE)
