"""Portrait: paths of the free coordinates of a settled motion, with sections once per period and at onsets."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.case import Case
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.nonlinear.sections import Section, contact_section, stroboscopic_section
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance, signal_words
from gearplay.solver.compiling import prepare
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.vocabulary.errors import Fault, InputError

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


def portrait_of(
    case: Case, *, settle: int, keep: int, show: int, period: str | float, member: int
) -> Portrait:
    """Return the portrait of a case: ``settle`` periods pass, the path is sampled over ``show`` periods, the rest over ``keep``.

    Raises `InputError` for a case without a period, with nothing free to move, or numbers that cannot be.
    """
    for name, number, least in (("settle", settle, 0), ("keep", keep, 1), ("show", show, 1)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Raise it"))
    flow = Flow(case)
    packed, signals = flow.packed, flow.free_names
    if not signals:
        rule = "must leave a rotor free to move or turn"
        raise InputError(Fault("rotors", ", ".join(packed.rotor_names), rule, "Give one a sleeve or a load"))
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

    prepare(case)
    strobing = partial(stroboscopic_section, case, signals, member=member)
    hitting = partial(
        contact_section, case, signals, duration=keep * step, transient=settle * step, member=member
    )
    with limited(case.run.max_wall_time):
        path = strobing(keep=show * parts + 1, settle=settle * parts, period=step / parts)
        strobe = _until_late(partial(strobing, keep=keep, settle=settle, period=step), path)
        hits = {
            label: _until_late(partial(hitting, contact=label), path, 1) for label in packed.contact_labels
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
    attributes = provenance(case, settle=settle, period=step, late=late)
    return Portrait(xr.Dataset(variables, coords=coordinates, attrs=attributes))


def _until_late(section: Callable[[], Section], like: Section, more: int = 0) -> Section:
    """Return a section; an empty one, with ``more`` signals than another, where no time was left for its first instant."""
    try:
        return section()
    except OutOfTimeError as error:
        nothing = np.zeros((0, len(like.names) + more))
        return Section(np.zeros(0), nothing, like.names, like.case, str(error))
