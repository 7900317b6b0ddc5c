"""Sections of a motion: once per period, or at every contact change; diagrams over a parameter."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.pictures.style import COUPLED, new_axes
from gearplay.pictures.words import plain, shown_in
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import Observables
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
CHANGES = {"onset": 1.0, "release": 0.0}


@dataclass(frozen=True, repr=False)
class Section(AnalysisResult):
    """A motion sampled at some instants: times [s], shape [instant], and signals, shape [instant, signal], SI.

    ``ended`` is the reason for fewer instants than requested, "" if there are all.
    """

    result_kind = "section"

    times: Floats
    values: Floats
    names: tuple[str, ...]
    case: Case
    ended: str = ""

    @property
    def ds(self) -> "xr.Dataset":
        """A variable for each signal over ``time`` [s]; rotations and speeds count from the nominal ones."""
        import xarray as xr

        variables = {
            name: ("time", self.values[:, at], _words_of(name)) for at, name in enumerate(self.names)
        }
        seconds = {"time": ("time", self.times, {"units": "s", "long_name": "time"})}
        return xr.Dataset(
            variables, seconds, provenance(self.case, signals=json.dumps(self.names), ended=self.ended)
        )

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the section whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        names = tuple(json.loads(dataset.attrs["signals"]))
        table = np.column_stack([dataset[name].values for name in names])
        return cls(
            dataset["time"].values, table, names, case_in(dataset), str(dataset.attrs.get("ended", ""))
        )

    @property
    def message(self) -> str:
        """Number of instants, names of the signals, and the reason for an early end, as text."""
        found = f"{len(self.times)} instants of {', '.join(self.names)}"
        return f"{found}. {self.ended}" if self.ended else found

    def plot(self, *, ax: "Axes | None" = None) -> "Axes":
        """Draw the second signal over the first, or one signal over time, in display units."""
        drawn = ax if ax is not None else new_axes(5.0, 4.5)
        shown = [self._shown(at) for at in range(min(2, len(self.names)))]
        (x, across), (y, up) = shown if len(shown) == 2 else ((self.times, "time [s]"), shown[0])
        drawn.plot(x, y, ".", color=COUPLED, markersize=2.5)
        drawn.set_xlabel(across, fontsize=8)
        drawn.set_ylabel(up, fontsize=8)
        return drawn

    def _shown(self, at: int) -> tuple[Floats, str]:
        values = self.values[:, at]
        unit, factor = shown_in(
            _words_of(self.names[at])["units"], float(np.max(np.abs(values), initial=0.0))
        )
        return factor * values, plain(f"{self.names[at]} [{unit}]")


def _words_of(name: str) -> dict[str, str]:
    """Return unit and long name of a signal of a section, the rate of a contact among them."""
    if name.endswith(".rate"):
        return {"units": "m/s", "long_name": f"rate of penetration, {name.removesuffix('.rate')}"}
    return signal_words(name)


def stroboscopic_section(
    case: Case,
    signals: Sequence[str],
    *,
    keep: int,
    settle: int = 0,
    period: str | float = "common",
    member: int = 0,
) -> Section:
    """Return signals once per period, ``keep`` times after ``settle`` periods.

    ``period`` is "common" (after which all that excites begins anew), that of the first "mesh" or of its driver ("shaft"), or a
    time in s. Signals are those that follow from the state (`Observables`).

    Raises `InputError` for a case without a period or signals it does not have.
    """
    for name, number, least in (("keep", keep, 1), ("settle", settle, 0), ("member", member, 0)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Raise it"))
    flow = Flow(case)
    step = section_period(flow.packed, period)
    check_work("section", flow.packed, seconds=(settle + keep) * step, numbers=keep * (len(signals) + 20.0))
    prepare(case)
    observe, course = Observables(flow.packed, signals), flow.begin(flow.start(member))
    if settle:
        course.advance(settle * step)
    values, ended = list[Floats](), ""
    try:
        for at in range(keep):
            course.advance((settle + at) * step)
            values.append(observe(course.time, course.state, course.run.branch))
    except OutOfTimeError as error:
        if not values:
            raise
        ended = str(error)
    times = step * np.arange(settle, settle + len(values), dtype=np.float64)
    return Section(times, np.array(values).reshape(len(values), -1), observe.names, case, ended)


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
    end = transient + _positive("duration", duration)
    check_work("impacts", flow.packed, seconds=end)
    prepare(case)
    observe, course = Observables(flow.packed, signals), flow.begin(flow.start(member))
    if transient > 0.0:
        course.advance(transient)
    times, values, ended = list[float](), list[Floats](), ""
    try:
        while course.time < end:
            for t, which, began, rate in course.advance_to_change(end):
                if int(which) == labels.index(contact) and began == CHANGES[change]:
                    times.append(t)
                    values.append(np.append(observe(course.time, course.state, course.run.branch), rate))
    except OutOfTimeError as error:
        ended = str(error)
    names = (*observe.names, f"{contact}.rate")
    return Section(np.array(times), np.array(values).reshape(len(times), len(names)), names, case, ended)


def _positive(name: str, value: float) -> float:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(Fault(name, value, "must be above 0 s", "Correct it"))
    return float(value)
