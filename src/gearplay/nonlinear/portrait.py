"""Portraits of a settled motion or a stored result: paths of the free coordinates, sections once per period, onsets."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.initial import usual_member
from gearplay.model.reading import Source
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.nonlinear.sections import Section, impacts, section
from gearplay.parts.mesh.train.rolling import mesh_frequency, nominal_speeds
from gearplay.parts.protocol import without_slots
from gearplay.results.base import OfDataset
from gearplay.results.choice import cut, free_rotors, moves
from gearplay.results.mechanism import motion_of
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.result import Result
from gearplay.results.simulate import case_of
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS = 200
"""Samples of a portrait's path in each mesh period."""


@dataclass(frozen=True, repr=False)
class Portrait(OfDataset):
    """Path, section and onsets of a settled motion.

    ``ds`` has ``path.SIGNAL`` over ``path_time``, ``section.SIGNAL`` over ``section_time`` and ``onset.SIGNAL`` over
    ``onset_time`` with ``contact``, the contact's name; signals are ``ring.x`` and so on [SI], rotations from the nominal ones.
    """

    result_kind = "portrait"

    @property
    def message(self) -> str:
        """Summary of the contents as text."""
        sizes, period = self.dataset.sizes, float(self.dataset.attrs["period"])
        late = str(self.dataset.attrs.get("late", ""))
        return (
            f"{sizes['section_time']} sections, one per {period:.4g} s, and {sizes['onset_time']} onsets of contacts"
            + (f". Not complete within run.max_wall_time: {late}" if late else "")
        )

    def plot(self, *, rotors: tuple[str, ...] = (), title: str = "") -> "Figure":
        """Draw orbits in the clearance circles and phase portraits of all rotors, or the chosen ones; returns the figure."""
        from gearplay.nonlinear.portrait_figures import portrait_drawing

        drawn: Figure = portrait_drawing(self.dataset, rotors=rotors, title=title)
        return drawn


def portrait(
    case: Source,
    *,
    settle: int = 200,
    keep: int = 500,
    show: int = 60,
    period: str | float = "mesh",
    member: int | None = None,
) -> Portrait:
    """Return all that is free to move along a settled motion, once per period, and at each onset of a contact.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    settle, keep
        Periods that pass, and periods of section and onsets.
    show
        Periods over which the path is sampled, 200 times a mesh period.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Portrait
        ``ds`` has ``path.SIGNAL``, ``section.SIGNAL`` and ``onset.SIGNAL`` [SI], each over its time [s].

    Raises
    ------
    InputError
        For a case without a period, and for invalid numbers.

    Examples
    --------
    >>> portrait("han2021", settle=2, keep=3, show=1).ds.sizes["section_time"]
    3

    """
    base = case_of(case)
    member = usual_member(base) if member is None else member
    flow = Flow(base)
    packed, signals = flow.packed, flow.free_names
    if not signals:
        rule = "must leave a rotor free to move or turn"
        raise InputError.of("rotors", ", ".join(packed.rotor_names), rule, "Give one a sleeve or a load")
    step, parts = section_period(packed, period), PARTS
    with contextlib.suppress(InputError):  # of a mesh period where there is one
        parts = PARTS * max(1, min(100, round(step / section_period(packed, "mesh"))))
    check_work(
        "portrait",
        packed,
        seconds=(3 * settle + 2 * keep + show) * step,
        numbers=20.0 * (keep + show * parts),
    )
    import xarray as xr  # after the refusals, which are to come at once

    strobing = partial(section, base, signals, member=member)
    hitting = partial(impacts, base, signals, duration=keep * step, transient=settle * step, member=member)
    with limited(base.run.max_wall_time):
        path = strobing(keep=show * parts + 1, settle=settle * parts, period=step / parts)
        strobe = _until_late(partial(strobing, keep=keep, settle=settle, period=step), path)
        hits = {
            label: _until_late(partial(hitting, contact=label), path, 1)
            for label in without_slots(packed.contact_labels)
        }
    pieces = {"path": path, "sections": strobe} | {f"onsets of {label}": each for label, each in hits.items()}
    late = ", ".join(name for name, each in pieces.items() if each.ended)
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
    attributes = provenance(base, settle=settle, period=step, late=late)
    return Portrait(xr.Dataset(variables, coords=coordinates, attrs=attributes))


def _until_late(make: Callable[[], Section], like: Section, more: int = 0) -> Section:
    """Return a section; after a timeout before its first instant an empty one, with ``more`` signals than ``like``."""
    try:
        return make()
    except OutOfTimeError as error:
        nothing = np.zeros((0, len(like.names) + more))
        return Section(np.zeros(0), nothing, like.names, like.case, str(error))


def stored_portrait(result: Result, rotors: list[str], window: tuple[float, float]) -> Portrait:
    """Return the portrait of a stored result within a window [s], without onsets, which are not stored in a result.

    Sections are interpolated between samples, once per period of the first mesh; there are none without meshes that turn.
    Raises `InputError` where nothing of ``rotors`` (of none, all) moves.
    """
    import xarray as xr

    case = result.case
    free = free_rotors(case)
    speeds = dict(zip(case.rotors, nominal_speeds(case), strict=True))
    held = set(result.held())
    result.runs[0].compute([("omega", rotor) for rotor in case.rotors])
    turning = {rotor for rotor in case.rotors if ("omega", rotor) in held and moves(result, "omega", rotor)}
    signals = [
        f"{rotor}.{name}"
        for rotor in rotors or list(case.rotors)
        for name in ("x", "y", "vx", "vy", "theta", "omega")
        if (name, rotor) in held and (rotor in free if name in ("x", "y", "vx", "vy") else rotor in turning)
    ]
    if not signals:
        rule = "must name a rotor that moves, with x, y, vx, vy or theta, omega kept"
        raise InputError.of("at", ", ".join(rotors) or "none", rule, f"Rotors: {', '.join(case.rotors)}")
    result.runs[0].compute([(name, rotor) for rotor, _, name in (each.rpartition(".") for each in signals)])
    variables: dict[str, Any] = {
        "contact": ("onset_time", np.zeros(0, dtype=object), {"long_name": "contact that begins"})
    }
    rotor, _, name = signals[0].rpartition(".")
    time = cut(result, name, rotor, window)[0]
    frequency = abs(mesh_frequency(case, 0)) if case.meshes else 0.0
    count = int((time[-1] - time[0]) * frequency)
    instants = time[0] + np.arange(count) / frequency if count else np.zeros(0)
    motions = {
        rotor: motion_of(case, rotor, time, lambda name, label: cut(result, name, label, window)[1])
        for rotor in free
        if f"{rotor}.x" in signals
    }
    for signal in signals:
        rotor, _, name = signal.rpartition(".")
        relative = motions.get(rotor, {})
        values = relative[name] if name in relative else cut(result, name, rotor, window)[1]
        if name == "theta":
            values = values - speeds[rotor] * time
            values = values - values[0]
        if name == "omega":
            values = values - speeds[rotor]
        words = signal_words(signal)
        variables[f"path.{signal}"] = ("path_time", values, words)
        variables[f"section.{signal}"] = ("section_time", np.interp(instants, time, values), words)
        variables[f"onset.{signal}"] = ("onset_time", np.zeros(0), words)
    period = 1.0 / frequency if frequency else 0.0
    return Portrait(xr.Dataset(variables, attrs=provenance(case, period=period)))
