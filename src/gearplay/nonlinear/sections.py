"""Sections of a motion: once per period, or at every change of a contact."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.initial import usual_member
from gearplay.model.reading import Source
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.parts.protocol import without_slots
from gearplay.pictures.style import COUPLED, new_axes
from gearplay.pictures.words import plain, shown_in
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.simulate import case_of
from gearplay.solver.flow import Flow
from gearplay.solver.integration import OutOfTimeError
from gearplay.solver.limits import check_work
from gearplay.solver.observables import Observables
from gearplay.vocabulary.errors import InputError

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
        """A variable for each signal over ``time`` [s]; rotations and speeds are relative to the nominal ones."""
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


def section(
    case: Source,
    signals: Sequence[str],
    *,
    keep: int = 1000,
    settle: int = 0,
    period: str | float = "common",
    member: int | None = None,
) -> Section:
    """Return signals of a case once per period.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    signals
        ``ring.x``, ``ring.vx`` ...: those that follow from the state.
    keep, settle
        Periods that are kept, after so many.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Section
        ``times`` [s], shape [instant], and ``values`` [SI], shape [instant, signal].

    Raises
    ------
    InputError
        For a case without a period or signals it does not have.

    Examples
    --------
    >>> section("han2021", ["ring.x", "ring.vx"], keep=3, settle=2, period="mesh").values.shape
    (3, 2)

    """
    base = case_of(case)
    flow = Flow(base)
    step = section_period(flow.packed, period)
    check_work("section", flow.packed, seconds=(settle + keep) * step, numbers=keep * (len(signals) + 20.0))
    start = flow.start(usual_member(base) if member is None else member)
    observe, integration = Observables(flow.packed, signals), flow.begin(start)
    if settle:
        integration.advance(settle * step)
    values, ended = list[Floats](), ""
    try:
        for at in range(keep):
            integration.advance((settle + at) * step)
            values.append(observe(integration.time, integration.state, integration.run.branch))
    except OutOfTimeError as error:
        if not values:
            raise
        ended = str(error)
    times = step * np.arange(settle, settle + len(values), dtype=np.float64)
    return Section(times, np.array(values).reshape(len(values), -1), observe.names, base, ended)


def impacts(
    case: Source,
    signals: Sequence[str],
    contact: str,
    *,
    change: str = "onset",
    duration: float | None = None,
    transient: float | None = None,
    member: int | None = None,
) -> Section:
    """Return signals of a case at every onset or release of a contact, at the instants that the solver located.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    signals
        ``ring.x``, ``ring.vx`` ...: those that follow from the state.
    contact
        A sleeve's name or a flank: ``ring``, ``pinion-ring:drive``.
    change
        "onset" or "release".
    duration, transient
        Record and time before it [s]; the case's if not given.
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Section
        ``values`` [SI], shape [instant, signal], the rate of penetration [m/s] last.

    Raises
    ------
    InputError
        For a contact, change or signals that the case does not have.

    Examples
    --------
    >>> impacts("han2021", ["ring.x"], "pinion-ring:drive", duration=0.2, transient=0.0).names
    ('ring.x', 'pinion-ring:drive.rate')

    """
    base = case_of(case, duration=duration, transient=transient)
    flow = Flow(base)
    labels = flow.packed.contact_labels
    if contact not in labels:
        rule = "must be a contact of this case"
        raise InputError.of("contact", contact, rule, f"Choose from: {', '.join(without_slots(labels))}")
    if change not in CHANGES:
        raise InputError.of("change", change, "must be onset or release", "Choose one")
    end = base.run.transient + base.run.duration
    check_work("impacts", flow.packed, seconds=end)
    start = flow.start(usual_member(base) if member is None else member)
    observe, integration = Observables(flow.packed, signals), flow.begin(start)
    if base.run.transient > 0.0:
        integration.advance(base.run.transient)
    times, values, ended = list[float](), list[Floats](), ""
    try:
        while integration.time < end:
            for t, which, began, rate in integration.advance_to_change(end):
                if int(which) == labels.index(contact) and began == CHANGES[change]:
                    times.append(t)
                    values.append(
                        np.append(observe(integration.time, integration.state, integration.run.branch), rate)
                    )
    except OutOfTimeError as error:
        ended = str(error)
    names = (*observe.names, f"{contact}.rate")
    return Section(np.array(times), np.array(values).reshape(len(times), len(names)), names, base, ended)
