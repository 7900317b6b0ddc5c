"""Basins of attraction over a grid of two initial coordinates."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.nonlinear.orders import repeating_orders
from gearplay.nonlinear.pair_coordinates import ENTRIES, NAMES, PairCoordinates, pair_coordinates
from gearplay.nonlinear.thread_pool import share_out
from gearplay.pictures.canvas import PALETTE, SMALL, legend_mark, make_figure, set_legend, set_title, to_png
from gearplay.pictures.words import axis_label
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words
from gearplay.solver.compiling import prepare
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import state_names
from gearplay.vocabulary.errors import Fault, GearplayError, InputError
from gearplay.vocabulary.progress import Tick

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
    """Where each initial state leads, shape [second, first]: the place of its motion in ``attractors``.

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
        """How many motions there are and how much of the grid leads to each."""
        each = zip(self.shares, self.attractors, strict=True)
        shares = ", ".join(f"{100.0 * share:.0f} % (order {len(known)})" for share, known in each)
        count = len(self.attractors)
        found = f"{count} motion{'s' if count != 1 else ''}" + (f": {shares} of the starts" if shares else "")
        late = int(np.sum(self.labels == LATE))
        return found + (
            f"; {late} of {self.labels.size} starts were not reached within run.max_wall_time" if late else ""
        )

    @property
    def labelled(self) -> tuple[str, str]:
        """Both entries with their units, for axes."""
        first, second = (f"{name} [{signal_words(name)['units']}]" for name in self.names)
        return first, second

    def plot(self, *, title: str = "") -> "Figure":
        """Draw each start in the pale colour of its motion; returns the figure."""
        drawn: Figure = basins_drawing(self, self.labelled, title=title)
        return drawn

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
    progress: Tick | None = None,
    stop: threading.Event | None = None,
) -> Basins:
    """Return which motion each start of a grid settles to within ``settle`` periods; all other entries are those of the case.

    Two starts lead to the same motion where a section of one comes within 1e-3 natural sizes of one of the other: settle for long
    enough. Attractors are numbered in the order of the grid, whatever the number of threads.

    Raises `InputError` for entries, ranges or a case that cannot be.
    """
    flow = Flow(case)
    step = section_period(flow.packed, period)
    pair = pair_coordinates(flow)
    places = [_place(flow, grid, pair) for grid in (first, second)]
    if places[0] == places[1]:
        raise InputError(Fault("second", second.name, "must be another entry than the first", "Choose one"))
    if settle < 1:
        raise InputError(Fault("settle", settle, "must be 1 or more", "Raise it"))
    total = first.count * second.count
    check_work(
        "basins",
        flow.packed,
        seconds=total * settle * step,
        numbers=total * 2.0 * MOST_ORDER * len(flow.free),
    )
    prepare(case)
    axes = [np.linspace(grid.low, grid.high, grid.count) for grid in (first, second)]
    starts = [_states(grid, values, pair) for grid, values in zip((first, second), axes, strict=True)]
    start = flow.start()
    sections = np.full((total, 2 * MOST_ORDER, len(flow.free)), np.nan)
    late = np.zeros(total, dtype=bool)
    asked = stop or threading.Event()

    def go(at: int, tick: Callable[[], None]) -> None:
        if asked.is_set():
            return
        state = start.copy()
        state[places[0]], state[places[1]] = starts[0][at % axes[0].size], starts[1][at // axes[0].size]
        try:
            course = flow.begin(state, stop=asked)
            for n in range(2 * MOST_ORDER):
                course.advance((settle + n) * step)
                sections[at, n] = flow.seen(course.time, course.state)
        except OutOfTimeError:
            sections[at], late[at] = np.nan, True
        except GearplayError:
            sections[at] = np.nan
        tick()

    with limited(case.run.max_wall_time):
        share_out(range(total), go, total=total, threads=threads, stop=asked, progress=progress)
    labels, attractors = _labels(sections, flow.natural[flow.free])
    labels[late] = LATE
    table = labels.reshape(axes[1].size, axes[0].size)
    entries = tuple(flow.free_names)
    if pair is not None and {first.name, second.name} & set(NAMES):
        entries = NAMES
        attractors = tuple(
            np.array([pair.at((settle + n) * step, seen) for n, seen in enumerate(each)])
            for each in attractors
        )
    return Basins(axes[0], axes[1], table, attractors, (first.name, second.name), entries, case)


def _place(flow: Flow, grid: Grid, pair: PairCoordinates | None) -> int:
    """Return the place of an entry in the state; `InputError` where it is none, prescribed, or its range is empty."""
    free = flow.free_names if pair is None else [*NAMES, *flow.free_names]
    if grid.name not in free:
        rule = "must be an entry of the state that is not prescribed"
        raise InputError(Fault("name", grid.name, rule, f"Choose from: {', '.join(free)}"))
    if not grid.low < grid.high or grid.count < 2:
        rule = "must have low below high and a count of 2 or more"
        raise InputError(Fault(grid.name, f"{grid.low:g} to {grid.high:g}, {grid.count}", rule, "Correct it"))
    name = ENTRIES[NAMES.index(grid.name)] if grid.name in NAMES else grid.name
    return state_names(flow.packed).index(name)


def _states(grid: Grid, values: Floats, pair: PairCoordinates | None) -> Floats:
    """Return the values of the state's entry for the values of a grid."""
    return values if pair is None or grid.name not in NAMES else pair.entry(grid.name, values)


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
        same = (k for k, known in enumerate(attractors) if _is_on(seen[0], known, scale))
        labels[at] = next(same, len(attractors))
        if labels[at] == len(attractors):
            attractors.append(seen[:order].copy())
    return labels, tuple(attractors)


def _is_on(state: Floats, attractor: Floats, scale: Floats) -> bool:
    return bool(np.min(np.max(np.abs(attractor - state) / scale, axis=1)) < ALIKE)


def basins_figure(basins: Basins, labels: tuple[str, str], *, title: str = "") -> bytes:
    """Return `basins_drawing` as PNG."""
    return to_png(basins_drawing(basins, labels, title=title))


def basins_drawing(basins: Basins, labels: tuple[str, str], *, title: str = "") -> Any:
    """Return the figure of basins of attraction: each start in the pale colour of its motion.

    ``labels`` are the labels of both axes; values are shown in SI.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    kinds = len(basins.attractors)
    pale = [_pale(PALETTE[at % len(PALETTE)]) for at in range(kinds)]
    figure, axes = make_figure(1, 1, 4.6)
    ax = axes[0, 0]
    colors = ListedColormap(["#ffffff", "#bbbbbb", "#eeeeee", *pale])
    norm = BoundaryNorm(np.arange(-3.5, kinds + 0.5), colors.N)
    ax.pcolormesh(
        basins.first, basins.second, basins.labels, cmap=colors, norm=norm, shading="nearest", rasterized=True
    )
    handles = {}
    for at in range(kinds):
        mark = PALETTE[at % len(PALETTE)]
        order = len(basins.attractors[at])
        handles[f"motion {at + 1}, order {order}, {100.0 * basins.shares[at]:.0f} %"] = legend_mark(
            mark, marker="s"
        )
    if np.any(basins.labels == IRREGULAR):
        handles["does not repeat"] = legend_mark("#dddddd", marker="s")
    if np.any(basins.labels == FAILED):
        handles["cannot be followed"] = legend_mark("#bbbbbb", marker="s")
    if np.any(basins.labels == LATE):
        handles["not reached in time"] = legend_mark("#ffffff", marker="s")
    ax.set_xlabel(axis_label(labels[0], "1"), fontsize=SMALL)
    ax.set_ylabel(axis_label(labels[1], "1"), fontsize=SMALL)
    set_legend(figure, handles)
    set_title(figure, title)
    return figure


def _pale(color: str) -> str:
    """Return a colour half-way to white."""
    from matplotlib.colors import to_hex, to_rgb

    red, green, blue = to_rgb(color)
    return str(to_hex((0.5 + 0.5 * red, 0.5 + 0.5 * green, 0.5 + 0.5 * blue)))
