"""Nonlinear analysis of a case: sections, diagrams over a field, exponents, periodic orbits and their branches."""

import json
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.api.result import Source
from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.reading import load_case
from gearplay.solver.flow import prepare_tangent
from gearplay.solver.simulate import prepare, worker_count
from gearplay.study.nonlinear.basins import Basins, Grid, basins_of_attraction
from gearplay.study.nonlinear.branches import Branch, Settings, follow_branch
from gearplay.study.nonlinear.lyapunov import Exponents, lyapunov_exponents
from gearplay.study.nonlinear.motion import Motion, identify_motion
from gearplay.study.nonlinear.orbits import Orbit, find_orbit
from gearplay.study.nonlinear.period_map import StrobeMap, along
from gearplay.study.nonlinear.sections import (
    Section,
    bifurcation_diagram,
    contact_section,
    stroboscopic_section,
)
from gearplay.study.plan_values import number_in_si, value_at
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.quantities import RESULT_VARIABLES
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float, float], None]


def _case(source: Source) -> Case:
    return source if isinstance(source, Case) else load_case(source)


def bifurcation(
    case: Source,
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
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> "xr.Dataset":
    """Return what a motion settles to over a field of a case: signals once per period after it has settled.

    ``values`` of the field at ``path`` rise; numbers in SI or texts with a unit. ``signals`` are ``ring.x``,
    ``pinion-ring.drive_penetration`` ...: those that follow from the state. At each value ``settle`` periods pass and ``keep``
    are kept; ``period`` is "common", "mesh", "shaft" or a time in s. With ``carry`` each value goes on from the one before it, up
    and down.

    The result has a variable for each signal over ``direction``, the field's name and ``section``, and ``reason`` where a value
    failed.

    Raises `InputError` for a field, value or signal that cannot be.

    >>> found = bifurcation("han2021", "meshes.0.backlash", ["90 um", "100 um"], ["ring.x"], settle=2, keep=3, period="mesh")
    >>> dict(found.sizes), found["ring.x"].attrs["units"]
    ({'direction': 2, 'backlash': 2, 'section': 3}, 'm')
    """
    import xarray as xr

    base = _case(case)
    numbers = [number_in_si(base, (path,), value, f"values.{at}") for at, value in enumerate(values)]
    found = bifurcation_diagram(
        along(base, path),
        numbers,
        signals,
        settle=settle,
        keep=keep,
        period=period,
        directions=directions,
        carry=carry,
        threads=worker_count() if threads is None else threads,
        progress=progress,
        stop=stop,
    )
    name = path.rpartition(".")[2]
    variables: dict[str, Any] = {}
    for at, signal in enumerate(found.names):
        label, _, kind = signal.rpartition(".")
        quantity = RESULT_VARIABLES[kind]
        words = {"units": quantity.unit, "long_name": f"{quantity.long_name}, {label}"}
        variables[signal] = (("direction", name, "section"), found.values[..., at], words)
    variables["reason"] = (
        ("direction", name),
        np.array(found.reasons, dtype=object),
        {"long_name": "why a value failed"},
    )
    coordinates = {
        "direction": ("direction", np.array(found.directions, dtype=object)),
        name: (name, found.parameters, {"units": unit_at(base, path), "long_name": path}),
    }
    attributes = {
        "title": base.title,
        "case": json.dumps(base.resolved()),
        "case_sha256": base.sha256,
        "settle": settle,
        "keep": keep,
        "period": period,
        "carried": int(carry),
        "gearplay_version": VERSION,
    }
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def periodic_orbit(case: Source, *, order: int = 1, settle: int = 200) -> Orbit:
    """Return the periodic orbit of an order near what a case settles to in ``settle`` common periods.

    States at the section are those of `StrobeMap`: free positions and rotations, their velocities, latched impact speeds.

    Raises `InputError` for a case without a period, `SimulationError` where no orbit is near.
    """
    _check_order(order)
    base = _case(case)
    prepare_tangent(base)
    period_map = StrobeMap(lambda _: base, 0.0)
    return find_orbit(period_map, period_map.settle(period_map.start(0.0), 0.0, settle), 0.0, order=order)


def branch(
    case: Source,
    path: str,
    low: Any,
    high: Any,
    *,
    order: int = 1,
    settle: int = 200,
    size: float | None = None,
    orbits: int = 500,
    upwards: bool = True,
    progress: Progress | None = None,
) -> Branch:
    """Return the branch of periodic orbits over a field of a case, from near what the case itself settles to.

    ``low`` and ``high`` bound the field, in SI or with a unit; ``size`` is its natural size, a tenth of the range if not given.
    The branch is followed through folds, stable and unstable, until the field leaves its bounds; see `follow_branch`.

    Raises `InputError` for a field or bounds that cannot be, `SimulationError` where there is no orbit to start from.
    """
    _check_order(order)
    base = _case(case)
    prepare_tangent(base)
    ends = [number_in_si(base, (path,), value, name) for name, value in (("low", low), ("high", high))]
    if not ends[0] < ends[1]:
        raise InputError(Fault("high", high, "must be above low", "Swap them"))
    now = number_in_si(base, (path,), value_at(base.resolved(), path), path)
    period_map = StrobeMap(along(base, path), now)
    start = find_orbit(period_map, period_map.settle(period_map.start(now), now, settle), now, order=order)
    settings = Settings(
        low=ends[0], high=ends[1], size=0.1 * (ends[1] - ends[0]) if size is None else size, orbits=orbits
    )
    return follow_branch(period_map, start, settings, upwards=upwards, progress=progress)


def _check_order(order: int) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or not 1 <= order <= 1000:
        raise InputError(Fault("order", order, "must be a whole number from 1 to 1000", "Choose one"))


def lyapunov(
    case: Source,
    *,
    count: int | None = None,
    time: float | None = None,
    transient: float | None = None,
    member: int = 0,
    progress: Progress | None = None,
) -> Exponents:
    """Return the Lyapunov exponents of a case's motion with their intervals; see `lyapunov_exponents`."""
    base = _case(case)
    prepare_tangent(base)
    return lyapunov_exponents(
        base, count=count, time=time, transient=transient, member=member, progress=progress
    )


def motion(
    case: Source,
    *,
    periods: int = 1000,
    settle: int = 300,
    period: str | float = "common",
    members: int = 12,
    compare: bool = True,
    progress: Callable[[str, float, float], None] | None = None,
    stop: threading.Event | None = None,
) -> Motion:
    """Return what kind of motion a case settles to, with the evidence; see `identify_motion`."""
    base = _case(case)
    (prepare_tangent if base.run.fixed_step is None else prepare)(base)
    return identify_motion(
        base,
        periods=periods,
        settle=settle,
        period=period,
        members=members,
        compare=compare,
        progress=progress,
        stop=stop,
    )


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
    """Return which motion each initial state of a grid leads to; see `basins_of_attraction`.

    ``first`` and ``second`` are an entry of the state, its least and largest value in SI, and their number:
    ``("ring.vx", -0.1, 0.1, 50)``.
    """
    base = _case(case)
    prepare(base)
    return basins_of_attraction(
        base,
        Grid(*first),
        Grid(*second),
        settle=settle,
        period=period,
        threads=worker_count() if threads is None else threads,
        progress=progress,
        stop=stop,
    )


def section(
    case: Source,
    signals: Sequence[str],
    *,
    count: int = 1000,
    skip: int = 0,
    period: str | float = "common",
    member: int = 0,
) -> Section:
    """Return signals of a case once per period; see `stroboscopic_section`."""
    base = _case(case)
    prepare(base)
    return stroboscopic_section(base, signals, count=count, skip=skip, period=period, member=member)


def impacts(
    case: Source,
    signals: Sequence[str],
    contact: str,
    *,
    change: str = "onset",
    duration: float | None = None,
    transient: float | None = None,
    member: int = 0,
) -> Section:
    """Return signals of a case at every onset or release of a contact; see `contact_section`."""
    base = _case(case)
    prepare(base)
    return contact_section(
        base,
        signals,
        contact,
        change=change,
        duration=base.run.duration if duration is None else duration,
        transient=base.run.transient if transient is None else transient,
        member=member,
    )
