"""Periodic orbits of a case and their branches over one of its fields."""

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.plan_values import number_in_si, value_at
from gearplay.nonlinear.orbits.branch_tree import branch_tree, settled_orbits, signals_of
from gearplay.nonlinear.orbits.branches import Branch, Settings, follow_branch
from gearplay.nonlinear.orbits.orbits import Orbit, find_orbit
from gearplay.nonlinear.orbits.period_map import StrobeMap, along
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.result import Source, case_of
from gearplay.solver.flow import prepare_tangent
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float, float], None]


def periodic_orbit(case: Source, *, order: int = 1, settle: int = 200) -> Orbit:
    """Return the periodic orbit of an order near what a case settles to in ``settle`` common periods.

    States at the section are those of `StrobeMap`: free positions and rotations, their velocities, latched impact speeds.

    Raises `InputError` for a case without a period, `SimulationError` where no orbit is near.
    """
    _check_whole("order", order, 1, 1000)
    _check_whole("settle", settle, 0, 10_000_000)
    base = case_of(case)
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
    The branch is followed upwards (or downwards) from the case's own value, through folds, stable and unstable, until the field
    leaves its bounds; see `follow_branch`, and `branches` for both ways at once.

    Raises `InputError` for a field or bounds that cannot be, `SimulationError` where there is no orbit to start from.
    """
    _check_whole("order", order, 1, 1000)
    _check_whole("settle", settle, 0, 10_000_000)
    base = case_of(case)
    prepare_tangent(base)
    settings = _settings(base, path, low, high, size, orbits)
    now = _value_now(base, path)
    period_map = StrobeMap(along(base, path), now)
    (start,) = settled_orbits(period_map, [now], order=order, settle=settle)
    return follow_branch(period_map, start, settings, upwards=upwards, progress=progress)


def branches(
    case: Source,
    path: str,
    low: Any,
    high: Any,
    *,
    order: int = 1,
    doublings: int = 1,
    settle: int = 200,
    size: float | None = None,
    orbits: int = 500,
    progress: Progress | None = None,
) -> tuple[Branch, ...]:
    """Return the branch of periodic orbits over a field both ways, and those that leave it at period doublings.

    Starts are near what the case settles to at its own value of the field, if that lies within the bounds, and at these; a
    start on the branch of another is left out. ``doublings`` says how many times the order may double; ``orbits`` bounds each
    branch each way; the rest as in `branch`.

    Raises as `branch` does.
    """
    _check_whole("order", order, 1, 1000)
    _check_whole("doublings", doublings, 0, 8)
    base = case_of(case)
    prepare_tangent(base)
    settings = _settings(base, path, low, high, size, orbits)
    now = _value_now(base, path)
    places = [now] if settings.low <= now <= settings.high else []
    places += [end for end in (settings.low, settings.high) if end != now]
    period_map = StrobeMap(along(base, path), places[0])
    starts = settled_orbits(period_map, places, order=order, settle=settle)
    return branch_tree(period_map, starts, settings, doublings=doublings, progress=progress)


def check_branches(case: Source, path: str, *, order: int, doublings: int) -> None:
    """Raise `InputError` where branches of a case cannot be followed: before long work begins."""
    _check_whole("order", order, 1, 1000)
    _check_whole("doublings", doublings, 0, 8)
    base = case_of(case)
    now = _value_now(base, path)
    flow = StrobeMap(along(base, path), now).member(now).flow
    flow.begin(flow.start(), changes=np.zeros((1, flow.size + flow.latches)))


def branch_signals(case: Source, path: str, branch: Branch, signals: Sequence[str]) -> Any:
    """Return signals at the sections of each orbit of a branch over a field, shape [orbit, order, signal], SI."""
    return signals_of(
        StrobeMap(along(case_of(case), path), branch.orbits[0].parameter), branch, list(signals)
    )


def branches_dataset(
    case: Source, path: str, found: Sequence[Branch], signals: Sequence[str], levels: Sequence[Any]
) -> "xr.Dataset":
    """Return branches as one table: a row for each orbit, with signals at its first section, and one for each special point.

    ``levels`` are the signals of each branch as `branch_signals` returns them.

    Coordinates: ``orbit`` with ``branch`` (number), ``order``, the field, ``stable`` (1 or 0) and ``multiplier`` (the largest
    modulus); ``special`` with its kind, branch and field.
    """
    import xarray as xr

    base = case_of(case)
    name = path.rpartition(".")[2]
    unit = {"units": unit_at(base, path), "long_name": path}
    rows = [
        (at, branch.order, orbit.parameter, int(orbit.stable), abs(orbit.multipliers[0]))
        for at, branch in enumerate(found)
        for orbit in branch.orbits
    ]
    numbers, orders, places, stable, largest = zip(*rows, strict=True)
    points = [(s.kind, at, s.orbit.parameter) for at, branch in enumerate(found) for s in branch.special]
    variables: dict[str, Any] = {
        "branch": ("orbit", np.array(numbers), {"long_name": "number of the branch"}),
        "order": ("orbit", np.array(orders), {"long_name": "periods after which the orbit repeats"}),
        name: ("orbit", np.array(places), unit),
        "stable": ("orbit", np.array(stable), {"long_name": "whether small changes decay"}),
        "multiplier": ("orbit", np.array(largest), {"units": "1", "long_name": "largest modulus of the Floquet multipliers"}),
        "special_kind": ("special", np.array([p[0] for p in points], dtype=object), {"long_name": "what happens there"}),
        "special_branch": ("special", np.array([p[1] for p in points], dtype=np.int64), {"long_name": "number of the branch"}),
        f"special_{name}": ("special", np.array([p[2] for p in points]), unit),
    }  # fmt: skip
    values = np.concatenate([each[:, 0] for each in levels])
    for at, signal in enumerate(signals):
        variables[signal] = ("orbit", values[:, at], signal_words(signal))
    ended = json.dumps([each.ended for each in found])
    return xr.Dataset(variables, attrs=provenance(base, ended=ended))


def _value_now(base: Case, path: str) -> float:
    """Return the case's own value of a field [SI]."""
    return number_in_si(base, (path,), value_at(base.resolved(), path), path)


def _settings(base: Case, path: str, low: Any, high: Any, size: float | None, orbits: int) -> Settings:
    ends = [number_in_si(base, (path,), value, name) for name, value in (("low", low), ("high", high))]
    if not ends[0] < ends[1]:
        raise InputError(Fault("high", high, f"must be above low, {low}", "Give the lower first"))
    if size is not None and not (np.isfinite(size) and size > 0.0):
        raise InputError(Fault("size", size, "must be above 0", "Leave it out for a tenth of the range"))
    _check_whole("orbits", orbits, 2, 100_000)
    return Settings(
        low=ends[0], high=ends[1], size=0.1 * (ends[1] - ends[0]) if size is None else size, orbits=orbits
    )


def _check_whole(name: str, value: int, least: int, most: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError(Fault(name, value, f"must be a whole number from {least} to {most}", "Choose one"))
