"""`Result`, returned by `simulate`."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property, partial
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.files.netcdf import check_ending
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.model.variables import RESULT_VARIABLES, VARIABLES
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.contacts import ContactTable, contact_table, contacts_of
from gearplay.results.output_shaft import OutputShaft, Wanted, output_shaft, shaft_of_runs, stride_of
from gearplay.results.stored import check_run, runs_again
from gearplay.solver.checkpoints import KeptSamples
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, Work, work_of, worst_of
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.results.plots import Plotter
    from gearplay.results.spectra import Spectrum

Floats = NDArray[np.float64]


class Result(AnalysisResult):
    """A finished simulation: every member's trajectory, and the same as one labelled dataset.

    Parameters
    ----------
    case
        What was simulated.
    runs
        One `Trajectory` a member.

    Attributes
    ----------
    case : Case
    ds : xarray.Dataset
        Dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble; SI, docs/conventions.
    runs : sequence of Trajectory
        Members with counters, final states and the log of contacts; computed again for a result read from a file.
    status, message, success
        The worst status of all members as text, and whether every member reached its end.

    Examples
    --------
    >>> import gearplay as gp
    >>> result = gp.simulate("han2021", duration=0.01, transient=0.0)
    >>> result.success, result.message, dict(result.ds.sizes)["contact"]
    (True, 'Done.', 3)

    """

    result_kind = "run"

    def __init__(self, case: Case, runs: Sequence[Trajectory]) -> None:
        self.case, self._runs = case, runs

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the result whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        made = cls(case_in(dataset), [])
        check_run(dataset, made.case)
        made.__dict__["ds"] = dataset
        return made

    def save(
        self, path: str | os.PathLike[str], *, overwrite: bool = False, within: float | None = None
    ) -> None:
        """Write all signals, as `AnalysisResult.save` does; after Ctrl-C nothing is written.

        Compressed where that takes no longer than ``within`` [s]; `ResourceError` beyond ``run.max_wall_time``.
        """
        check_ending(path)
        until = time.monotonic() + min((run.samples.left for run in self._runs), default=math.inf)
        for run in self._runs:
            run.samples.compute(until)
        left = min(math.inf if within is None else within, until - time.monotonic())
        self._write(path, overwrite=overwrite, within=left)

    @cached_property
    def ds(self) -> xr.Dataset:
        """The result as a dataset: dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble."""
        from gearplay.results.dataset import to_dataset

        return to_dataset(self.case, pack(self.case), self._runs)

    @cached_property
    def runs(self) -> Sequence[Trajectory]:
        """One `Trajectory` a member; of a result from a file, the case is integrated again."""
        return self._runs or runs_again(self)

    @property
    def members(self) -> int:
        """Number of runs."""
        return len(self._runs) or int(self.ds.sizes.get("member", 1))

    @property
    def statuses(self) -> list[Status]:
        """How each member ended."""
        if self._runs:
            return [run.status for run in self._runs]
        ended = self.ds["member_status"].values if "member_status" in self.ds else [self.ds.attrs["status"]]
        return [Status[str(name)] for name in ended]

    @property
    def status(self) -> Status:
        """The worst status of all members."""
        return max(self.statuses, key=int)

    @property
    def message(self) -> str:
        """The worst status and the warnings of the run as text."""
        return worst_of(self._runs).message if self._runs else str(self.ds.attrs["message"])

    @property
    def success(self) -> bool:
        """Whether every member reached its end."""
        return all(status == Status.DONE for status in self.statuses)

    @property
    def plot(self) -> Plotter:
        """Pictures: ``.plot()``, ``.plot.orbit("ring")``, ``.plot.history("backlash")``, ``.plot.spectrum("ax", "ring")``."""
        from gearplay.results.plots import Plotter

        return Plotter(self)

    @cached_property
    def contacts(self) -> ContactTable:
        """Statistics of every contact, over all members."""
        if self._runs:
            return contacts_of(self._runs)
        each = {name: np.atleast_2d(self.ds[name].values) for name in CONTACT_STATISTICS}
        spans = np.array([self.time(m).size for m in range(self.members)]) / self.sampling
        angular = self.ds["contact_angular"].values.astype(bool) if "contact_angular" in self.ds else None
        return contact_table([str(c) for c in self.ds["contact"].values], each, spans, angular)

    @cached_property
    def output(self) -> OutputShaft:
        """Key numbers of the output shaft: the loaded rotor, of several the one with the largest load."""
        return self.output_at(None)

    def output_at(self, rotor: str | None) -> OutputShaft:
        """Return the key numbers of one shaft: ripples, transmission error, wind-up, efficiency, rattle.

        Parameters
        ----------
        rotor
            Its name; the loaded one if None.

        Returns
        -------
        OutputShaft
            ``.values`` and ``.spread``, SI by name; ``.rows()`` in display units. Of at most a million samples.

        Raises
        ------
        InputError
            For a rotor that the case does not have.

        Examples
        --------
        >>> import gearplay as gp
        >>> shaft = gp.simulate("two-stage-reducer").output
        >>> shaft.rotor, round(1.0 / shaft.ratio, 9), round(shaft.values["mean_torque"], 3)
        ('output', 5.0, 53.77)

        """
        if self._runs:
            return shaft_of_runs(self.case, rotor, self._runs)
        held, stride = set(self.held()), stride_of([self.time(m).size for m in range(self.members)])

        def samples(member: int, wanted: Wanted) -> Floats:
            nothing = np.full(self.time(member).size, np.nan)
            found = [self.signal(*each, member) if each in held else nothing for each in wanted]
            return np.stack(found, axis=1)[::stride]

        members = [(self.sampling / stride, partial(samples, m)) for m in range(self.members)]
        return output_shaft(self.case, rotor, self.contacts, members)

    @property
    def sampling(self) -> float:
        """Samples per second [Hz]."""
        return self._runs[0].sampling if self._runs else self.case.run.sampling

    def time(self, member: int = 0) -> Floats:
        """Return the times of the samples [s] of the member at a place, shape [time]; fewer where it stopped early."""
        if self._runs:
            return self._runs[member].time
        held, whole = self.held(), self.ds["time"].values
        return np.asarray(whole[: self.signal(held[0][0], held[0][1], member).size] if held else whole)

    def held(self, signal: str | None = None) -> list[tuple[str, str]]:
        """Return the kept signals, as (signal, element); only those of one name if given."""
        if self._runs:
            found = [(c.signal, c.label) for c in self._runs[0].columns]
        else:
            found = [
                (q.name, str(label))
                for dimension, quantities in VARIABLES.items()
                for q in quantities
                if q.name in self.ds
                for label in ([dimension] if dimension == "base" else self.ds[dimension].values)
            ]
        return [each for each in found if signal in (None, each[0])]

    def signal(
        self,
        signal: str,
        label: str | None = None,
        member: int = 0,
        *,
        sampling: float | None = None,
        window: tuple[float, float] | None = None,
    ) -> Floats:
        """Return one signal of one element of the member at a place, computed from the motion on request.

        Parameters
        ----------
        signal
            Its name: ``ax``, ``ring.ax``, ``backlash``.
        label
            The rotor, sleeve or mesh; optional where only one has the signal, or the signal's name includes it.
        member
            Place of the member, 0 for the first.
        sampling
            Samples per second [Hz]; the record's if not given.
        window
            First time and the one that no sample reaches [s], counted from the start of the run; the record if not given.

        Returns
        -------
        numpy.ndarray
            Samples [SI], shape [time]; fewer where the member stopped early.

        Raises
        ------
        InputError
            For a signal or element that the result does not hold, a window outside the run, or another rate or window of a
            file's result that the case does not give again.
        ResourceError
            For more samples than fit into the memory.

        Examples
        --------
        >>> import gearplay as gp
        >>> result = gp.simulate("han2021", duration=0.1, transient=0.0)
        >>> len(result.signal("ring.ax")), len(result.signal("ring.ax", sampling=1e6, window=(0.02, 0.03)))
        (10000, 10000)

        """
        if label is None and "." in signal:
            label, _, signal = signal.rpartition(".")
        signal, label = self.only(signal, label)
        if sampling is not None or window is not None:
            run = self.runs[member]
            if not isinstance(run.samples, KeptSamples):
                rule = "must be absent: only samples were kept, no motion"
                raise InputError(Fault("window", str(window), rule, "Simulate with gearplay.simulate"))
            if sampling is not None and not (0.0 < sampling < np.inf):
                cure = "Give samples per second"
                raise InputError(Fault("sampling", sampling, "must be positive [Hz]", cure))
            at = [(c.signal, c.label) for c in run.columns].index((signal, label))
            return run.samples.at_rate(at, sampling, window)
        if self._runs:
            return self._runs[member].signal(signal, label)
        variable = self.ds[signal]
        dimensions = [str(d) for d in variable.dims if d not in ("member", "time")]
        values = variable.sel({dimensions[0]: label}) if dimensions else variable  # there is one housing
        values = values.isel(member=member) if "member" in values.dims else values
        found = np.asarray(values.values, dtype=np.float64)
        if values.dtype.kind == "i":  # flags, -1 where there is none
            found[found < 0.0] = np.nan
        if self.statuses[member] == Status.DONE:
            return found
        known = np.flatnonzero(np.isfinite(found))
        return found[: known[-1] + 1] if known.size else found[:0]

    def only(self, signal: str, label: str | None) -> tuple[str, str]:
        """Return the one stored signal and element of these names; `InputError` where none or several match."""
        chosen = [each for each in self.held(signal) if label in (None, each[1])]
        if len(chosen) == 1:
            return chosen[0]
        known = sorted({f"{element}.{name}" for name, element in self.held(signal) or self.held()})
        shown = f"{label or ''}.{signal}".lstrip(".")
        cure = f"Choose from: {', '.join(known) or 'none'}"
        raise InputError(Fault("signal", shown, "must name one signal that was kept", cure))

    def spectrum(
        self, signal: str, *, rotor: str | None = None, label: str | None = None, window: str = "hann"
    ) -> Spectrum:
        """Return the one-sided amplitude spectrum of a signal, averaged over the members that reached their end.

        Parameters
        ----------
        signal
            Its name: ``ax``.
        rotor, label
            The element, by either name; may be left out where only one has the signal.
        window
            Name of a window of `scipy.signal`.

        Returns
        -------
        Spectrum
            ``frequency`` [Hz] and ``amplitude`` [unit of the signal], shape [line]; of several members their rms average.

        Raises
        ------
        InputError
            For a signal or element that the result does not hold, a record that is too short, or where no member finished.

        Examples
        --------
        >>> import gearplay as gp
        >>> s = gp.simulate("han2021", duration=0.1, transient=0.0).spectrum("ax", rotor="ring")
        >>> round(s.resolution, 9), s.unit
        (10.0, 'm/s^2')

        """
        from gearplay.results.spectra import ensemble_spectrum

        signal, element = self.only(signal, rotor or label)
        whole = [at for at, status in enumerate(self.statuses) if status == Status.DONE]
        if not whole and self.members > 1:
            rule = "has no member that reached its end, so no spectrum"
            raise InputError(Fault("spectrum", self.status.name, rule, self.message))
        records = [self.signal(signal, element, at) for at in whole or [0]]
        return ensemble_spectrum(records, self.sampling, window=window, unit=RESULT_VARIABLES[signal].unit)

    def __repr__(self) -> str:
        work, title = self.work, self.case.title or "untitled"
        members = f", {self.members} members" if self.members > 1 else ""
        ended = f"{self.status.name}{members}, {self.reached:g} s, {work.steps} steps, {work.events} events"
        return f"<gearplay.Result {title!r}: {ended}>"

    @property
    def work(self) -> Work:
        """Steps, rejected steps, events and seconds on one core, of all members."""
        if self._runs:
            return work_of(self._runs)
        return Work(**{each.name: self.ds.attrs[each.name] for each in fields(Work)})

    @property
    def reached(self) -> float:
        """Simulated time [s] that the first member reached, transient included."""
        if self._runs:
            return self._runs[0].reached
        return self.case.run.transient + self.time().size / self.sampling

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the lines of the table that a notebook shows."""
        work = self.work
        return [
            ("case", self.case.title or "untitled"),
            ("model", f"{self.case.formulation}, {self.case.backlash_model}"),
            ("status", self.message),
            ("members", str(self.members)),
            ("simulated time", f"{self.reached:g} s"),
            ("steps, events", f"{work.steps}, {work.events}"),
            ("core seconds", f"{work.wall_time:.3g} s"),
        ]

    def _repr_html_(self) -> str:
        from html import escape

        from gearplay.pictures.pages import html_table, sparkline

        shaft = self.output
        head = f"<p><b>{escape(shaft.title)}</b></p>{html_table(shaft.rows())}"
        head += f"<p>{escape(shaft.note)}</p>" if shaft.note else ""
        if ("omega", shaft.rotor) in self.held():
            speed = sparkline(self.signal("omega", shaft.rotor), f"speed of {shaft.rotor} over time")
            head += f"<p>{speed} speed of {escape(shaft.rotor)}</p>"
        return head + self.contacts.html() + html_table(self.rows()) + self._picture()
