"""Nonlinear analysis of a case: sections, portraits, diagrams over a field, exponents, kinds of motion, basins."""

import contextlib
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.field_units import unit_at
from gearplay.model.plan_values import number_in_si
from gearplay.nonlinear.basins import Basins, Grid, basins_of_attraction
from gearplay.nonlinear.kinds.lyapunov import Exponents, lyapunov_exponents
from gearplay.nonlinear.kinds.motion import Motion, identify_motion, prepare_motion
from gearplay.nonlinear.orbits.period_map import along, section_period
from gearplay.nonlinear.sections import (
    Section,
    bifurcation_diagram,
    contact_section,
    stroboscopic_section,
)
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.result import Source, case_of
from gearplay.solver.flow import Flow, prepare_tangent
from gearplay.solver.simulate import prepare, worker_count
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[float, float], None]
PARTS = 200
"""Samples of a portrait's path in each mesh period."""


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

    base = case_of(case)
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
        variables[signal] = (("direction", name, "section"), found.values[..., at], signal_words(signal))
    variables["reason"] = (
        ("direction", name),
        np.array(found.reasons, dtype=object),
        {"long_name": "why a value failed"},
    )
    coordinates = {
        "direction": ("direction", np.array(found.directions, dtype=object)),
        name: (name, found.parameters, {"units": unit_at(base, path), "long_name": path}),
    }
    attributes = provenance(base, settle=settle, keep=keep, period=period, carried=int(carry))
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


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
    base = case_of(case)
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
    base = case_of(case)
    prepare_motion(base)
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
    base = case_of(case)
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
    base = case_of(case)
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
    base = case_of(case)
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


def portrait(
    case: Source,
    *,
    settle: int = 200,
    keep: int = 500,
    show: int = 60,
    period: str | float = "mesh",
    member: int = 0,
) -> "xr.Dataset":
    """Return all that is free to move along a settled motion, once per period, and at each onset of a contact.

    ``settle`` periods pass; then the path is sampled `PARTS` times a mesh period over ``show`` periods, and the section and the
    onsets are those of ``keep`` periods. ``period`` is that of `section`.

    The result has ``path.SIGNAL`` over ``path_time``, ``section.SIGNAL`` over ``section_time`` and ``onset.SIGNAL`` over
    ``onset_time`` with ``contact``, the contact's name; signals are ``ring.x`` and so on, rotations from the nominal ones.

    Raises `InputError` for a case without a period or numbers that cannot be.
    """
    import xarray as xr

    for name, number, least in (("settle", settle, 0), ("keep", keep, 1), ("show", show, 1)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Raise it"))
    base = case_of(case)
    prepare(base)
    flow = Flow(base)
    packed, signals = flow.packed, flow.free_names
    if not signals:
        rule = "must leave a rotor free to move or turn"
        raise InputError(Fault("rotors", ", ".join(packed.rotor_names), rule, "Give one a sleeve or a load"))
    step, parts = section_period(packed, period), PARTS
    with contextlib.suppress(InputError):  # of a mesh period where there is one
        parts = PARTS * max(1, min(100, round(step / section_period(packed, "mesh"))))
    path = stroboscopic_section(
        base, signals, count=show * parts + 1, skip=settle * parts, period=step / parts, member=member
    )
    strobe = stroboscopic_section(base, signals, count=keep, skip=settle, period=step, member=member)
    hits = {
        label: contact_section(
            base, signals, label, duration=keep * step, transient=settle * step, member=member
        )
        for label in packed.contact_labels
    }
    instants = np.concatenate([np.zeros(0), *(each.times for each in hits.values())])
    order = np.argsort(instants, kind="stable")
    names = [label for label, each in hits.items() for _ in each.times]
    rows = np.concatenate([np.zeros((0, len(signals) + 1)), *(each.values for each in hits.values())])
    contact = np.array(names, dtype=object)[order]
    variables: dict[str, Any] = {"contact": ("onset_time", contact, {"long_name": "contact that begins"})}
    for at, signal in enumerate(signals):
        words = signal_words(signal)
        variables[f"path.{signal}"] = ("path_time", path.values[:, at], words)
        variables[f"section.{signal}"] = ("section_time", strobe.values[:, at], words)
        variables[f"onset.{signal}"] = ("onset_time", rows[order, at], words)
    seconds = {"units": "s", "long_name": "time"}
    coordinates = {
        "path_time": ("path_time", path.times, seconds),
        "section_time": ("section_time", strobe.times, seconds),
        "onset_time": ("onset_time", instants[order], seconds),
    }
    return xr.Dataset(variables, coords=coordinates, attrs=provenance(base, settle=settle, period=step))
