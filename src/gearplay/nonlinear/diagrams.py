"""Bifurcation diagrams: stroboscopic sections of the settled motion over a field of the case."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.families import Family
from gearplay.model.field_units import unit_at
from gearplay.model.initial import usual_member
from gearplay.nonlinear.orbits.period_map import common_period, section_period
from gearplay.nonlinear.thread_pool import share_out
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.outcomes import Account
from gearplay.results.provenance import provenance, signal_words
from gearplay.solver.compiling import prepare
from gearplay.solver.continuation import ramp_speeds
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import Observables
from gearplay.solver.trajectory import all_columns
from gearplay.vocabulary.errors import Fault, GearplayError, InputError, SimulationError
from gearplay.vocabulary.progress import Tick

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
REMARKABLE = 20e-6
"""Increase of a penetration [m] due to a parameter step alone above which the result reports it: contacts may rebound."""


@dataclass(frozen=True, repr=False)
class Diagram(AnalysisResult):
    """A bifurcation diagram over a field: signals once per period, NaN where a value failed.

    ``values`` has shape [direction, parameter, period, signal], SI; ``parameters`` [SI] rise; ``reasons``, shape [direction,
    parameter], says why a value failed; ``starts``, of the same shape, what each value began with where that is not the plain
    end of the one before it: a fresh start and why, or a state that the step of the parameter pressed deeper into a contact.
    ``path`` is the field's, where the family is of one; ``settings`` is how it was made.
    """

    parameters: Floats
    directions: tuple[str, ...]
    values: Floats
    names: tuple[str, ...]
    reasons: tuple[tuple[str, ...], ...]
    case: Case
    path: str
    settings: dict[str, Any] = field(default_factory=dict)
    starts: tuple[tuple[str, ...], ...] = ()

    result_kind = "bifurcation"

    @property
    def ds(self) -> "xr.Dataset":
        """A variable for each signal over ``direction``, the field's name and ``section``; ``reason`` and ``start`` as text."""
        import xarray as xr

        name = self.path.rpartition(".")[2]
        variables: dict[str, Any] = {
            signal: (("direction", name, "section"), self.values[..., at], signal_words(signal))
            for at, signal in enumerate(self.names)
        }
        for variable, rows, words in (
            ("reason", self.reasons, "why a value failed"),
            (
                "start",
                self.starts,
                "what a value began with, where not with the plain end of the one before it",
            ),
        ):
            if rows:
                texts = np.array(rows, dtype=object)
                variables[variable] = (("direction", name), texts, {"long_name": words})
        coordinates = {
            "direction": ("direction", np.array(self.directions, dtype=object)),
            name: (name, self.parameters, {"units": unit_at(self.case, self.path), "long_name": self.path}),
        }
        return xr.Dataset(variables, coords=coordinates, attrs=provenance(self.case, **self.settings))

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the diagram whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        names = tuple(str(name) for name in dataset.data_vars if name not in ("reason", "start"))
        axis = dataset[dataset["reason"].dims[1]]
        known = ("settle", "keep", "period", "carried")
        return cls(
            axis.values,
            tuple(str(way) for way in dataset["direction"].values),
            np.stack([dataset[name].values for name in names], axis=-1),
            names,
            _texts(dataset["reason"].values),
            case_in(dataset),
            str(axis.attrs["long_name"]),
            {name: dataset.attrs[name] for name in known if name in dataset.attrs},
            _texts(dataset["start"].values) if "start" in dataset else (),
        )

    @property
    def account(self) -> Account:
        """How many values were followed, each way, and why some were not."""
        reasons = np.array(self.reasons, dtype=object)
        return Account.of(np.array(reasons != "", dtype=np.int64), reasons)

    @property
    def interruptions(self) -> tuple[str, ...]:
        """Texts, one per value, where a state could not be carried or the step itself pressed a contact deeper."""
        unit = unit_at(self.case, self.path)
        return tuple(
            f"{way} at {value:.6g} {unit}: {start}"
            for way, row in zip(self.directions, self.starts, strict=False)
            for value, start in zip(self.parameters, row, strict=True)
            if start
        )

    @property
    def message(self) -> str:
        """Range of the field, how many values failed, and where the state was not carried."""
        unit, (low, high) = unit_at(self.case, self.path), self.parameters[[0, -1]]
        ways = " and ".join(self.directions)
        said = f"{self.path} from {low:.4g} to {high:.4g} {unit}, {ways}; {self.account}"
        found = self.interruptions
        if found:
            more = f", and at {len(found) - 1} more" if len(found) > 1 else ""
            said += f". {found[0][0].upper()}{found[0][1:]}{more}"
        return said

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


def _line(error: GearplayError) -> str:
    return str(error).splitlines()[0]


def _texts(rows: NDArray[Any]) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(str(each) for each in row) for row in rows)


PENETRATIONS = ("sleeve_penetration", "drive_penetration", "back_penetration")


def _penetrations(flow: Flow, state: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Return the penetrations [m] of a state at t = 0, NaN in a mesh whose gears cannot mesh, and their names."""
    names = [f"{c.label}.{c.signal}" for c in all_columns(flow.packed) if c.signal in PENETRATIONS]
    observe = Observables(flow.packed, names)
    return observe(0.0, state), observe.names


@dataclass(frozen=True)
class _Last:
    """Where the value before ended: its flow, the state at the end of a common period, and stored impact speeds."""

    flow: Flow
    state: Floats
    impact_speeds: Floats


ANEW = "began anew, "
OUT_OF_TIME = "not reached within run.max_wall_time, the limit of all values together"


def _carried(last: _Last | None, flow: Flow) -> tuple[Floats | None, str]:
    """Return the start that the end of the value before is for a changed case, or None and why it can be none.

    Rotations and speeds relative to the nominal ones are continued; a prescribed shaft with a ramp begins at its start speed. The
    returned text reports a change that itself presses contacts deeper by more than `REMARKABLE`.
    """
    if last is None:
        return None, f"{ANEW}as the value before failed"
    old, new = last.flow.packed, flow.packed
    if old.labels != new.labels or last.flow.size != flow.size or last.flow.impact_count != flow.impact_count:
        return None, f"{ANEW}as it is another mechanism than the value before"
    state = last.state.copy()
    ramp_speeds(state, new)
    before, _ = _penetrations(last.flow, last.state)
    now, names = _penetrations(flow, state)
    if np.any(np.isnan(now)):
        where = names[int(np.flatnonzero(np.isnan(now))[0])].rpartition(".")[0]
        return None, f"{ANEW}as with the state of the value before the gears of {where} could not mesh"
    rise = np.maximum(now, 0.0) - np.maximum(before, 0.0)
    if not rise.size or np.max(rise) <= REMARKABLE:
        return state, ""
    at = int(np.argmax(rise))
    depth = f"{names[at]} from {1e6 * max(before[at], 0.0):.4g} to {1e6 * now[at]:.4g} um"
    return state, f"the step itself raised {depth}: take smaller ones if the motion jumps here"


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
    """Return the bifurcation diagram over a parameter: ``keep`` sections after ``settle`` periods at each of its values.

    ``family`` returns the case at a value, ``period`` is that of `stroboscopic_section`. With ``carry`` each value continues
    from the final state of the one before it, upwards and downwards, so that a jump shows where a branch ends and not which
    start was drawn; without, each starts as its case specifies. It does so too, with the reason in ``starts``, after a value
    that failed, and where the changed case is another mechanism, its gears could not mesh, or the motion from the carried state
    cannot be followed.
    The excitation restarts at each value, so a run continues to the end of the common period, where there is one.

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
    starts = [[""] * values.size for _ in directions]
    asked = stop or threading.Event()

    def value(way: int, at: int, flow: Flow, state: Floats, impact_speeds: Floats | None) -> _Last:
        """Fill the sections of a value from a start; return its end."""
        step, observe = section_period(flow.packed, period), Observables(flow.packed, signals)
        course = flow.begin(state, impact_speeds=impact_speeds, stop=asked)
        for n in range(settle + keep):
            course.advance((n + 1) * step)
            if n >= settle:
                table[way, at, n - settle] = observe(course.time, course.state, course.run.branch)
        course.advance(_whole(flow, (settle + keep) * step))
        return _Last(flow, flow.frames.seen(course.time, course.state).copy(), course.impact_speeds.copy())

    def go(job: tuple[int, Sequence[int]], tick: Callable[[], None]) -> None:
        way, places = job
        last: _Last | None = None
        for number, at in enumerate(places):
            if asked.is_set():
                return
            if time_left.is_over():
                reasons[way][at] = OUT_OF_TIME
                continue
            try:
                flow, state = Flow(family(float(values[at]))), None
                if carry and number:
                    state, starts[way][at] = _carried(last, flow)
                if state is not None and last is not None:
                    try:
                        last = value(way, at, flow, state, last.impact_speeds)
                    except OutOfTimeError:
                        raise
                    except SimulationError as error:
                        if asked.is_set():
                            raise
                        state, table[way, at] = None, np.nan
                        starts[way][at] = f"{ANEW}from the state of the value before: {_line(error)}"
                if state is None:
                    last = value(way, at, flow, flow.start(usual_member(flow.case)), None)
            except OutOfTimeError:
                table[way, at], reasons[way][at], last = np.nan, OUT_OF_TIME, None
            except GearplayError as error:
                table[way, at], reasons[way][at], last = np.nan, _line(error), None
            tick()

    ways = [list(range(values.size))[:: 1 if way == "up" else -1] for way in directions]
    jobs = [(w, way) for w, way in enumerate(ways)]
    if not carry:
        jobs = [(w, way[k::threads]) for w, way in enumerate(ways) for k in range(threads)]
    total = table.shape[0] * values.size
    with limited(first.run.max_wall_time) as time_left:
        share_out(jobs, go, total=total, threads=threads, stop=asked, progress=progress)
    settings = {"settle": settle, "keep": keep, "period": period, "carried": int(carry)}
    said, began = (tuple(tuple(row) for row in rows) for rows in (reasons, starts))
    return Diagram(values, tuple(directions), table, names, said, first, "", settings, began)
