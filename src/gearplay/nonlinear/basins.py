"""Basins of attraction over a grid of two initial coordinates."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import Source
from gearplay.nonlinear.kinds.repetition import repeating_orders
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.nonlinear.pair_coordinates import ENTRIES, NAMES, PairCoordinates, pair_coordinates
from gearplay.nonlinear.thread_pool import share_out
from gearplay.pictures.canvas import PALETTE, SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.words import axis_label
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.simulate import case_of
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import state_names
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import GearplayError, InputError
from gearplay.vocabulary.progress import Progress, ticking

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
IRREGULAR, FAILED, LATE = -1, -2, -3
MOST_ORDER = 8
ALIKE = 1e-3
"""Distance [natural sizes] within which two sections are those of one motion."""


@dataclass(frozen=True)
class Grid:
    """Values of one entry of the initial state, like ``ring.vx``, from ``low`` to ``high`` in SI; rotations are relative ones.

    Of a torsional pair ``x`` and ``x'`` are entries too (`PairCoordinates`), in half backlashes.
    """

    name: str
    low: float
    high: float
    count: int


@dataclass(frozen=True, repr=False)
class Basins(AnalysisResult):
    """Basins of attraction: for each initial state, shape [second, first], the index of its motion in ``attractors``.

    -1 marks motions that do not repeat within 8 periods, -2 starts that cannot be followed, -3 those that were not reached
    within ``run.max_wall_time``. Each attractor holds its sections, shape [order, entry]: the free states ``entries``, or x
    and x' where the grid is of these.
    """

    first: Floats
    second: Floats
    labels: NDArray[np.int64]
    attractors: tuple[Floats, ...]
    names: tuple[str, str]
    entries: tuple[str, ...]
    case: Case

    result_kind = "basins"

    @property
    def ds(self) -> "xr.Dataset":
        """Labels over both entries of the start, and the sections of each motion, filled up with NaN."""
        import xarray as xr

        most = max((len(each) for each in self.attractors), default=1)
        sections = np.full((len(self.attractors), most, len(self.entries)), np.nan)
        for at, each in enumerate(self.attractors):
            sections[at, : len(each)] = each
        first, second = self.names
        words = {"long_name": "motion that the start leads to", "flag_values": [LATE, FAILED, IRREGULAR],
                 "flag_meanings": "not_reached_within_max_wall_time cannot_be_followed does_not_repeat"}  # fmt: skip
        variables = {
            "motion": ((second, first), self.labels, words),
            "sections": (
                ("attractor", "order", "entry"),
                sections,
                {"long_name": "sections of a motion, SI"},
            ),
        }
        coordinates = {
            first: (first, self.first, signal_words(first)),
            second: (second, self.second, signal_words(second)),
            "entry": ("entry", np.array(self.entries, dtype=object)),
        }
        return xr.Dataset(variables, coordinates, provenance(self.case))

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the object whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        second, first = (str(dim) for dim in dataset["motion"].dims)
        sections = [each[np.isfinite(each).all(axis=1)] for each in dataset["sections"].values]
        return cls(
            dataset[first].values,
            dataset[second].values,
            dataset["motion"].values,
            tuple(sections),
            (first, second),
            tuple(str(entry) for entry in dataset["entry"].values),
            case_in(dataset),
        )

    @property
    def message(self) -> str:
        """Number of motions, and share of the grid that leads to each."""
        each = zip(self.shares, self.attractors, strict=True)
        shares = ", ".join(f"{100.0 * share:.0f} % (order {len(known)})" for share, known in each)
        count = len(self.attractors)
        found = f"{count} motion{'s' if count != 1 else ''}" + (f": {shares} of the starts" if shares else "")
        late = int(np.sum(self.labels == LATE))
        return found + (
            f"; {late} of {self.labels.size} starts were not reached within run.max_wall_time" if late else ""
        )

    @property
    def shares(self) -> Floats:
        """Share of the grid that leads to each attractor, shape [attractor]."""
        return np.array([np.mean(self.labels == at) for at in range(len(self.attractors))])

    def plot(self, *, title: str = "") -> "Figure":
        """Draw each start in the pale colour of its motion; returns the figure."""
        from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex, to_rgb

        marks = [PALETTE[at % len(PALETTE)] for at in range(len(self.attractors))]
        pale = [
            to_hex((0.5 + 0.5 * r, 0.5 + 0.5 * g, 0.5 + 0.5 * b)) for r, g, b in (to_rgb(m) for m in marks)
        ]
        colors = ListedColormap(["#ffffff", "#bbbbbb", "#eeeeee", *pale])
        norm = BoundaryNorm(np.arange(LATE - 0.5, len(marks) + 0.5), colors.N)
        figure, axes = make_figure(1, 1, 4.6)
        ax = axes[0, 0]
        ax.pcolormesh(
            self.first, self.second, self.labels, cmap=colors, norm=norm, shading="nearest", rasterized=True
        )
        handles = {
            f"motion {at + 1}, order {len(self.attractors[at])}, {100.0 * self.shares[at]:.0f} %": mark
            for at, mark in enumerate(marks)
        }
        for label, name, color in (
            (IRREGULAR, "does not repeat", "#dddddd"),
            (FAILED, "cannot be followed", "#bbbbbb"),
            (LATE, "not reached in time", "#ffffff"),
        ):
            if np.any(self.labels == label):
                handles[name] = color
        for set_label, name in zip((ax.set_xlabel, ax.set_ylabel), self.names, strict=True):
            set_label(axis_label(f"{name} [{signal_words(name)['units']}]", "1"), fontsize=SMALL)
        set_legend(figure, {name: legend_mark(color, marker="s") for name, color in handles.items()})
        set_title(figure, title)
        drawn: Figure = figure
        return drawn


def basins(
    case: Source,
    first: tuple[str, float, float, int],
    second: tuple[str, float, float, int],
    *,
    settle: int = 300,
    period: str | float = "common",
    threads: int | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Basins:
    """Return the basins of attraction over a grid of initial states.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    first, second
        An entry of the state, its least and largest value [SI], and their number: ``("ring.vx", -0.1, 0.1, 50)``. Of a
        torsional pair also its displacement and velocity in half backlashes, ``("x", -2, 2, 50)`` and ``("x'", -2, 2, 50)``,
        velocity over the natural frequency.
    settle
        Periods before the motions are compared, 1 or more.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    threads
        Threads; the cores by default. It changes nothing in the result.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Basins
        ``labels``, shape [second, first]: the place of the motion in ``attractors``; -1 does not repeat, -2 cannot be followed,
        -3 was not reached within ``run.max_wall_time``.

    Raises
    ------
    InputError
        For unknown entries of the state, invalid ranges or an invalid case.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.basins(gp.torsional_pair(0.7, force=0.05), ("x", 1.0, 1.2, 2), ("x'", -0.1, 0.1, 2), settle=300)
    >>> found.labels.shape, len(found.attractors)
    ((2, 2), 2)

    """
    base = case_of(case)
    flow = Flow(base)
    grids = (Grid(*first), Grid(*second))
    step = section_period(flow.packed, period)
    pair = pair_coordinates(flow)
    places = [_place(flow, grid, pair) for grid in grids]
    if places[0] == places[1]:
        raise InputError.of("second", grids[1].name, "must be another entry than the first", "Choose one")
    total = grids[0].count * grids[1].count
    check_work(
        "basins",
        flow.packed,
        seconds=total * settle * step,
        numbers=total * 2.0 * MOST_ORDER * len(flow.free),
    )
    axes = [np.linspace(grid.low, grid.high, grid.count) for grid in grids]
    starts = [
        values if pair is None or grid.name not in NAMES else pair.entry(grid.name, values)
        for grid, values in zip(grids, axes, strict=True)
    ]
    start = flow.start()
    sections = np.full((total, 2 * MOST_ORDER, len(flow.free)), np.nan)
    late = np.zeros(total, dtype=bool)
    stopping = stop or threading.Event()

    def go(at: int, tick: Callable[[], None]) -> None:
        if stopping.is_set():
            return
        state = start.copy()
        state[places[0]], state[places[1]] = starts[0][at % axes[0].size], starts[1][at // axes[0].size]
        try:
            integration = flow.begin(state, stop=stopping)
            for n in range(2 * MOST_ORDER):
                integration.advance((settle + n) * step)
                sections[at, n] = flow.seen(integration.time, integration.state)
        except OutOfTimeError:
            sections[at], late[at] = np.nan, True
        except GearplayError:
            sections[at] = np.nan
        tick()

    with limited(base.run.max_wall_time):
        tick = ticking(progress, "starts")
        share_out(
            range(total), go, total=total, threads=threads or worker_count(), stop=stopping, progress=tick
        )
    labels, attractors = _labels(sections, flow.natural[flow.free])
    labels[late] = LATE
    table = labels.reshape(axes[1].size, axes[0].size)
    entries = tuple(flow.free_names)
    names = (grids[0].name, grids[1].name)
    if pair is not None and set(names) & set(NAMES):
        entries = NAMES
        attractors = tuple(
            np.array([pair.at((settle + n) * step, seen) for n, seen in enumerate(each)])
            for each in attractors
        )
    return Basins(axes[0], axes[1], table, attractors, names, entries, base)


def _place(flow: Flow, grid: Grid, pair: PairCoordinates | None) -> int:
    """Return the index of an entry of the state; `InputError` for an unknown or prescribed one, or an empty range."""
    free = flow.free_names if pair is None else [*NAMES, *flow.free_names]
    if grid.name not in free:
        rule = "must be an entry of the state that is not prescribed"
        raise InputError.of("name", grid.name, rule, f"Choose from: {', '.join(free)}")
    if not grid.low < grid.high:
        raise InputError.of(
            grid.name, f"{grid.low:g} to {grid.high:g}", "must have low below high", "Correct it"
        )
    name = ENTRIES[NAMES.index(grid.name)] if grid.name in NAMES else grid.name
    return state_names(flow.packed).index(name)


def _labels(sections: Floats, scale: Floats) -> tuple[NDArray[np.int64], tuple[Floats, ...]]:
    """Return the label of each start from its last sections, shape [start, period, state], and the attractors."""
    labels = np.empty(len(sections), dtype=np.int64)
    attractors: list[Floats] = []
    for at, seen in enumerate(sections):
        if not np.isfinite(seen).all():
            labels[at] = FAILED
            continue
        order = next(repeating_orders(seen / scale, MOST_ORDER, ALIKE), 0)
        if order == 0:
            labels[at] = IRREGULAR
            continue
        distances = (np.min(np.max(np.abs(known - seen[0]) / scale, axis=1)) for known in attractors)
        same = (k for k, distance in enumerate(distances) if distance < ALIKE)
        labels[at] = next(same, len(attractors))
        if labels[at] == len(attractors):
            attractors.append(seen[:order].copy())
    return labels, tuple(attractors)
