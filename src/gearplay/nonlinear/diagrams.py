"""Bifurcation diagrams: what a motion settles to over a field of its case, seen once per period."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.initial import usual_member
from gearplay.nonlinear.crew import share_out
from gearplay.nonlinear.families import Family
from gearplay.nonlinear.orbits.period_map import common_period, section_period
from gearplay.results.account import Account
from gearplay.results.answer import Answer, WasDataset, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow
from gearplay.solver.limits import check_work
from gearplay.solver.observables import Observables
from gearplay.solver.trajectory import all_columns
from gearplay.vocabulary.errors import Fault, GearplayError, InputError
from gearplay.vocabulary.progress import Tick

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
DEEPEST = 20e-6
"""Deepest penetration [m] with which a motion is carried on to a changed case: a deeper one would be shot out of its contact."""


@dataclass(frozen=True, repr=False)
class Diagram(Answer, WasDataset):
    """A bifurcation diagram over a field: signals once per period, NaN where a value failed.

    ``values`` has shape [direction, parameter, period, signal], SI; ``parameters`` [SI] rise; ``reasons``, shape [direction,
    parameter], says why a value failed. ``path`` is the field's, where the family is of one; ``settings`` is how it was made.
    """

    parameters: Floats
    directions: tuple[str, ...]
    values: Floats
    names: tuple[str, ...]
    reasons: tuple[tuple[str, ...], ...]
    case: Case
    path: str
    settings: dict[str, Any] = field(default_factory=dict)

    answer = "bifurcation"

    @property
    def ds(self) -> "xr.Dataset":
        """A variable for each signal over ``direction``, the field's name and ``section``; ``reason`` where a value failed."""
        import xarray as xr

        name = self.path.rpartition(".")[2]
        variables: dict[str, Any] = {
            signal: (("direction", name, "section"), self.values[..., at], signal_words(signal))
            for at, signal in enumerate(self.names)
        }
        reasons = np.array(self.reasons, dtype=object)
        variables["reason"] = (("direction", name), reasons, {"long_name": "why a value failed"})
        coordinates = {
            "direction": ("direction", np.array(self.directions, dtype=object)),
            name: (name, self.parameters, {"units": unit_at(self.case, self.path), "long_name": self.path}),
        }
        return xr.Dataset(variables, coords=coordinates, attrs=provenance(self.case, **self.settings))

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the diagram whose ``ds`` it was."""
        check_kind(dataset, cls.answer)
        names = tuple(str(name) for name in dataset.data_vars if name != "reason")
        axis = dataset[dataset["reason"].dims[1]]
        known = ("settle", "keep", "period", "carried")
        return cls(
            axis.values,
            tuple(str(way) for way in dataset["direction"].values),
            np.stack([dataset[name].values for name in names], axis=-1),
            names,
            tuple(tuple(str(each) for each in row) for row in dataset["reason"].values),
            case_in(dataset),
            str(axis.attrs["long_name"]),
            {name: dataset.attrs[name] for name in known if name in dataset.attrs},
        )

    @property
    def account(self) -> Account:
        """How many values were followed, each way, and why some were not."""
        reasons = np.array(self.reasons, dtype=object)
        return Account.of(np.array(reasons != "", dtype=np.int64), reasons)

    @property
    def message(self) -> str:
        """Range of the field, and how many values failed."""
        unit, (low, high) = unit_at(self.case, self.path), self.parameters[[0, -1]]
        ways = " and ".join(self.directions)
        return f"{self.path} from {low:.4g} to {high:.4g} {unit}, {ways}; {self.account}"

    def plot(self, *, title: str = "") -> "Figure":
        """Draw every section of each signal over the field, both ways in their colours; returns the figure."""
        from gearplay.nonlinear.figures import bifurcation_drawing

        drawn: Figure = bifurcation_drawing(self.ds, self.names, title=title)
        return drawn


def _whole(flow: Flow, time: float) -> float:
    """Return the end [s] of the common period that holds a time; the time itself where there is none."""
    try:
        period = common_period(flow.packed)
    except InputError:
        return time
    return float(np.ceil(time / period * (1.0 - 1e-12)) * period)


def _deepest(flow: Flow, state: Floats) -> float:
    """Return the largest penetration [m] of a state at t = 0, NaN where its gears cannot mesh."""
    wanted = ("sleeve_penetration", "drive_penetration", "back_penetration")
    names = [f"{c.label}.{c.signal}" for c in all_columns(flow.packed) if c.signal in wanted]
    return float(np.max(Observables(flow.packed, names)(0.0, state), initial=-np.inf))


def bifurcation_diagram(
    family: Family,
    parameters: Sequence[float],
    signals: Sequence[str],
    *,
    settle: int = 400,
    keep: int = 100,
    period: str | float = "common",
    directions: Sequence[str] = ("up", "down"),
    carry: bool = True,
    threads: int = 2,
    progress: Tick | None = None,
    stop: threading.Event | None = None,
) -> Diagram:
    """Return what a motion settles to over a parameter: ``keep`` sections after ``settle`` periods at each of its values.

    ``family`` returns the case at a value, ``period`` is that of `stroboscopic_section`. With ``carry`` each value goes on from
    the end of the one before it, upwards and downwards, so that a jump shows where a branch ends and not which start was
    drawn; without, each starts as its case says, as it does where the carried state would begin deep inside a contact. What
    excites begins anew at each value, so a run goes on to the end of the common period, where there is one.

    Raises `InputError` for directions, signals or a case that cannot be.
    """
    values = np.array(parameters, dtype=np.float64)
    if values.ndim != 1 or values.size == 0 or not np.all(np.diff(values) > 0.0):
        raise InputError(Fault("parameters", "the list", "must have values that rise", "Sort it"))
    if not directions or set(directions) - {"up", "down"} or len(set(directions)) < len(directions):
        raise InputError(Fault("directions", list(directions), "must be up, down or both", "Correct it"))
    for name, number, least in (("settle", settle, 0), ("keep", keep, 1)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Correct it"))
    first = family(float(values[0]))
    packed = Flow(first).packed
    names = Observables(packed, signals).names
    span = (settle + keep) * section_period(packed, period) * values.size * len(directions)
    check_work(
        "bifurcation", packed, seconds=span, numbers=float(values.size) * len(directions) * keep * len(names)
    )
    prepare(first)
    table = np.full((len(directions), values.size, keep, len(names)), np.nan)
    reasons = [[""] * values.size for _ in directions]
    asked = stop or threading.Event()

    def go(job: tuple[int, Sequence[int]], tick: Callable[[], None]) -> None:
        way, places = job
        state: Floats | None = None
        latch: Floats | None = None
        for at in places:
            if asked.is_set():
                return
            try:
                flow = Flow(family(float(values[at])))
                step = section_period(flow.packed, period)
                observe = Observables(flow.packed, signals)
                if state is None or not carry or not _deepest(flow, state) <= DEEPEST:
                    state, latch = flow.start(usual_member(flow.case)), None
                course = flow.begin(state, latch=latch, stop=asked)
                for n in range(settle + keep):
                    course.advance((n + 1) * step)
                    if n >= settle:
                        table[way, at, n - settle] = observe(course.time, course.state, course.run.branch)
                course.advance(_whole(flow, (settle + keep) * step))
                state, latch = flow.frames.seen(course.time, course.state).copy(), course.latch.copy()
            except GearplayError as error:
                reasons[way][at] = str(error).splitlines()[0]
                state, latch = None, None
            tick()

    ways = [list(range(values.size))[:: 1 if way == "up" else -1] for way in directions]
    jobs = [(w, way) for w, way in enumerate(ways)]
    if not carry:
        jobs = [(w, way[k::threads]) for w, way in enumerate(ways) for k in range(threads)]
    total = table.shape[0] * values.size
    share_out(jobs, go, total=total, threads=threads, stop=asked, progress=progress)
    settings = {"settle": settle, "keep": keep, "period": period, "carried": int(carry)}
    said = tuple(tuple(row) for row in reasons)
    return Diagram(values, tuple(directions), table, names, said, first, "", settings)
