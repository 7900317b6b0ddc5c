"""Sections of a motion: its state once per period, or at every change of a contact; diagrams over a parameter."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.nonlinear.crew import share_out
from gearplay.nonlinear.orbits.period_map import Family, common_period, section_period
from gearplay.solver.flow import Flow
from gearplay.solver.observables import Observables
from gearplay.solver.simulate import prepare
from gearplay.solver.trajectory import all_columns
from gearplay.vocabulary.errors import Fault, GearplayError, InputError

Floats = NDArray[np.float64]
CHANGES = {"onset": 1.0, "release": 0.0}
DEEPEST = 20e-6
"""Deepest penetration [m] with which a motion is carried on to a changed case: a deeper one would be shot out of its contact."""


@dataclass(frozen=True)
class Section:
    """A motion seen at some instants: times [s], shape [instant], and signals, shape [instant, signal], SI."""

    times: Floats
    values: Floats
    names: tuple[str, ...]


def stroboscopic_section(
    case: Case,
    signals: Sequence[str],
    *,
    count: int,
    skip: int = 0,
    period: str | float = "common",
    member: int = 0,
) -> Section:
    """Return signals once per period, ``count`` times after ``skip`` periods.

    ``period`` is "common" (after which all that excites begins anew), that of the first "mesh" or of its driver ("shaft"), or a
    time in s. Signals are those that follow from the state (`Observables`).

    Raises `InputError` for a case without a period or signals it does not have.
    """
    for name, number, least in (("count", count, 1), ("skip", skip, 0), ("member", member, 0)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Raise it"))
    flow = Flow(case)
    step = section_period(flow.packed, period)
    observe, course = Observables(flow.packed, signals), flow.begin(flow.start(member))
    if skip:
        course.advance(skip * step)
    values = []
    for at in range(count):
        course.advance((skip + at) * step)
        values.append(observe(course.time, course.state, course.run.branch))
    return Section(
        step * np.arange(skip, skip + count, dtype=np.float64),
        np.array(values).reshape(count, -1),
        observe.names,
    )


def contact_section(
    case: Case,
    signals: Sequence[str],
    contact: str,
    *,
    change: str = "onset",
    duration: float,
    transient: float = 0.0,
    member: int = 0,
) -> Section:
    """Return signals at every onset or release of a contact, with ``rate`` [m/s] of its penetration last.

    ``contact`` is a sleeve's name or a flank, ``pinion-ring:drive``; the instants are those of the solver's located events.

    Raises `InputError` for a contact, change or signals that the case does not have.
    """
    flow = Flow(case)
    labels = flow.packed.contact_labels
    if contact not in labels:
        rule = "must be a contact of this case"
        raise InputError(Fault("contact", contact, rule, f"Choose from: {', '.join(labels)}"))
    if change not in CHANGES:
        raise InputError(Fault("change", change, "must be onset or release", "Choose one"))
    if not transient >= 0.0:
        raise InputError(Fault("transient", transient, "must be 0 s or more", "Correct it"))
    observe, course = Observables(flow.packed, signals), flow.begin(flow.start(member))
    if transient > 0.0:
        course.advance(transient)
    end = transient + _positive("duration", duration)
    times, values = [], []
    while course.time < end:
        for t, which, began, rate in course.advance_to_change(end):
            if int(which) == labels.index(contact) and began == CHANGES[change]:
                times.append(t)
                values.append(np.append(observe(course.time, course.state, course.run.branch), rate))
    names = (*observe.names, f"{contact}.rate")
    return Section(np.array(times), np.array(values).reshape(len(times), len(names)), names)


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


def _positive(name: str, value: float) -> float:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(Fault(name, value, "must be above 0 s", "Correct it"))
    return float(value)


@dataclass(frozen=True)
class Diagram:
    """A bifurcation diagram: signals once per period, shape [direction, parameter, period, signal], NaN where a case failed.

    ``reasons`` says why, shape [direction, parameter].
    """

    parameters: Floats
    directions: tuple[str, ...]
    values: Floats
    names: tuple[str, ...]
    reasons: tuple[tuple[str, ...], ...]


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
    progress: Callable[[float, float], None] | None = None,
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
    prepare(first)
    packed = Flow(first).packed
    names = Observables(packed, signals).names
    section_period(packed, period)
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
                    state, latch = flow.start(), None
                course = flow.begin(state, latch=latch, stop=asked)
                for n in range(settle + keep):
                    course.advance((n + 1) * step)
                    if n >= settle:
                        table[way, at, n - settle] = observe(course.time, course.state, course.run.branch)
                course.advance(_whole(flow, (settle + keep) * step))
                state, latch = course.state.copy(), course.latch.copy()
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
    return Diagram(values, tuple(directions), table, names, tuple(tuple(row) for row in reasons))
