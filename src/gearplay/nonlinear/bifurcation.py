"""Bifurcation diagrams: stroboscopic sections of the settled motion over a field of a case."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.families import Family, Varied
from gearplay.model.initial import usual_member
from gearplay.model.reading import Source
from gearplay.nonlinear.diagrams import Diagram
from gearplay.nonlinear.orbits.period_map import common_period, section_period
from gearplay.nonlinear.thread_pool import share_out
from gearplay.solver.continuation import ramp_speeds
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import Observables
from gearplay.solver.trajectory import all_columns
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import GearplayError, InputError, ResourceError, SimulationError
from gearplay.vocabulary.progress import Progress, ticking

Floats = NDArray[np.float64]
MOST_VALUES = 100_000
"""Values of the parameter on one diagram."""
REMARKABLE = 20e-6
"""Increase of a penetration [m] due to a parameter step alone above which the result reports it: contacts may rebound."""
ANEW = "began anew, "
OUT_OF_TIME = "not reached within run.max_wall_time, the limit of all values together"
PENETRATIONS = ("sleeve_penetration", "drive_penetration", "back_penetration")


def _penetrations(flow: Flow, state: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Return the penetrations [m] of a state at t = 0, NaN in a mesh whose gears cannot mesh, and their names."""
    names = [f"{c.label}.{c.signal}" for c in all_columns(flow.packed) if c.signal in PENETRATIONS]
    observe = Observables(flow.packed, names)
    return observe(0.0, state), observe.names


@dataclass(frozen=True)
class _Last:
    """Final state of the previous value: its flow, the state at the end of a common period, and stored impact speeds."""

    flow: Flow
    state: Floats
    impact_speeds: Floats


def _carried(last: _Last | None, flow: Flow) -> tuple[Floats | None, str]:
    """Return the start of a changed case from the final state of the previous value, or None and the reason.

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


def bifurcation(
    case: Source | Family,
    path: str,
    values: Sequence[Any],
    signals: Sequence[str],
    *,
    settle: int = 400,
    keep: int = 100,
    period: str | float = "common",
    directions: Sequence[str] = ("up", "down"),
    carry: bool = True,
    threads: int | None = None,
    keep_load: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Diagram:
    """Return the bifurcation diagram over a field of a case: signals once per period of the settled motion.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; or a function that returns a `Case` for a value of a parameter.
    path
        The field: ``rotors.pinion.drive.speed``; of a function the name of its parameter.
    values
        Its values, rising: numbers in SI or texts with a unit; of a function plain numbers.
    signals
        ``ring.x``, ``pinion-ring.drive_penetration`` ...: those that follow from the state.
    settle, keep
        Periods that pass at each value, and periods that are kept.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    directions
        "up", "down" or both: the ways along the values.
    carry
        Whether each value continues from the final state of the one before it, so that jumps show where a branch ends.
    threads
        Threads; the cores by default. It changes nothing in the result.
    keep_load
        Whether loads stay what they are at the case's own speeds, although drag follows the speed.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Diagram
        ``ds`` has a variable for each signal over ``direction``, the field's name and ``section``, ``reason`` where a value
        failed, and ``start`` where one did not go on from the end of the one before it, with the reason.

    Raises
    ------
    InputError
        For an unknown field or signal, and for an invalid value.

    Examples
    --------
    >>> found = bifurcation("han2021", "meshes.0.backlash", ["90 um", "100 um"], ["ring.x"], settle=2, keep=3, period="mesh")
    >>> dict(found.ds.sizes), found.ds["ring.x"].attrs["units"]
    ({'direction': 2, 'backlash': 2, 'section': 3}, 'm')

    """
    varied = Varied(case, path)
    if len(values) > MOST_VALUES:
        raise ResourceError(
            f"bifurcation: {len(values)} values, more than {MOST_VALUES} on one diagram. Give fewer."
        )
    numbers = np.array([varied.number(value, f"values.{at}") for at, value in enumerate(values)])
    if not numbers.size or not np.all(np.diff(numbers) > 0.0):
        raise InputError.of("values", "the list", "must have values that rise", "Sort it")
    if not directions or set(directions) - {"up", "down"} or len(set(directions)) < len(directions):
        raise InputError.of("directions", list(directions), "must be up, down or both", "Correct it")
    base, threads = varied.case(numbers[0]), threads or worker_count()
    family = varied.family(base, keep_load=keep_load)
    first = family(float(numbers[0]))
    packed = Flow(first).packed
    names = Observables(packed, signals).names
    span = (settle + keep) * section_period(packed, period) * numbers.size * len(directions)
    check_work(
        "bifurcation", packed, seconds=span, numbers=float(numbers.size) * len(directions) * keep * len(names)
    )
    table = np.full((len(directions), numbers.size, keep, len(names)), np.nan)
    reasons = [[""] * numbers.size for _ in directions]
    starts = [[""] * numbers.size for _ in directions]
    stopping = stop or threading.Event()

    def value(way: int, at: int, flow: Flow, state: Floats, impact_speeds: Floats | None) -> _Last:
        """Compute the sections of a value from a start; return its final state."""
        step, observe = section_period(flow.packed, period), Observables(flow.packed, signals)
        integration = flow.begin(state, impact_speeds=impact_speeds, stop=stopping)
        integration.advance_periods(step, settle)
        for n in range(keep):
            integration.advance((settle + n + 1) * step)
            table[way, at, n] = observe(integration.time, integration.state, integration.run.branch)
        integration.advance(_whole(flow, (settle + keep) * step))
        return _Last(
            flow,
            flow.frames.seen(integration.time, integration.state).copy(),
            integration.impact_speeds.copy(),
        )

    def go(job: tuple[int, Sequence[int]], tick: Callable[[], None]) -> None:
        way, places = job
        last: _Last | None = None
        for number, at in enumerate(places):
            if stopping.is_set():
                return
            if time_left.is_over():
                reasons[way][at] = OUT_OF_TIME
                continue
            try:
                flow, state = Flow(family(float(numbers[at]))), None
                if carry and number:
                    state, starts[way][at] = _carried(last, flow)
                if state is not None and last is not None:
                    try:
                        last = value(way, at, flow, state, last.impact_speeds)
                    except OutOfTimeError:
                        raise
                    except SimulationError as error:
                        if stopping.is_set():
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

    ways = [list(range(numbers.size))[:: 1 if way == "up" else -1] for way in directions]
    jobs = [(w, way) for w, way in enumerate(ways)]
    if not carry:
        jobs = [(w, way[k::threads]) for w, way in enumerate(ways) for k in range(threads)]
    total = table.shape[0] * numbers.size
    with limited(first.run.max_wall_time) as time_left:
        tick = ticking(progress, base.title or "diagram")
        share_out(jobs, go, total=total, threads=threads, stop=stopping, progress=tick)
    settings = {"settle": settle, "keep": keep, "period": period, "carried": int(carry)}
    failed, began = (tuple(tuple(row) for row in rows) for rows in (reasons, starts))
    return Diagram(numbers, tuple(directions), table, names, failed, began, base, path, settings)


def _whole(flow: Flow, time: float) -> float:
    """Return the end [s] of the common period that contains a time; the time itself without a common period."""
    try:
        period = common_period(flow.packed)
    except InputError:
        return time
    return float(np.ceil(time / period * (1.0 - 1e-12)) * period)


def _line(error: GearplayError) -> str:
    return str(error).splitlines()[0]
