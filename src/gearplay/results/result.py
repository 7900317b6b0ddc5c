"""`Result`, returned by `simulate`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import shown_path
from gearplay.files.netcdf import check_ending, is_table, open_dataset, write_dataset
from gearplay.files.stored import Stored
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.results.base import case_in, case_of_attributes, check_kind
from gearplay.results.contacts import ContactTable, contacts_of
from gearplay.results.member_signals import MemberSignals
from gearplay.results.output_shaft import OutputShaft, shaft_of_runs
from gearplay.results.plain_samples import Lack, samples_to_write
from gearplay.results.stored import check_run, runs_in
from gearplay.solver.status import Status
from gearplay.solver.trajectory import (
    Trajectory,
    Work,
    work_of,
    worst_of,
)
from gearplay.vocabulary.memory import enough_memory

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.results.plots import Plotter

Floats = NDArray[np.float64]


class Result(MemberSignals):
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
        Members with counters, final states and the log of contacts.
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
        self.case, self.runs = case, runs
        self._said = ""
        self._lack = Lack()

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the result of a dataset of a run: its samples, without a motion, contact logs and final states."""
        check_kind(dataset, cls.result_kind)
        case = case_in(dataset)
        check_run(dataset, case)
        return cls._of_samples(case, dataset, None)

    @classmethod
    def _of_samples(cls, case: Case, dataset: xr.Dataset, logs: Sequence[Floats] | None) -> Self:
        made = cls(case, runs_in(dataset, case, logs))
        made.__dict__["ds"] = dataset
        made._said = str(dataset.attrs["message"])
        return made

    @classmethod
    def from_file(cls, file: Stored, path: Path) -> Self:
        """Return the saved result in an open file: with its motion where these kernels can replay it, else with its samples."""
        from gearplay.results.run_files import KERNELS, can_replay, log_of, read_motions

        attributes = file.attributes()
        case = case_of_attributes(attributes)
        if can_replay(file):
            return cls(case, read_motions(file, case, shown_path(path)))
        logs, dataset = log_of(file, case), open_dataset(path)
        check_run(dataset, case, signals=False)
        made = cls._of_samples(case, dataset, logs)
        wrote = (
            f"gearplay {attributes.get('gearplay_version', '')}, kernels {str(attributes.get(KERNELS))[:8]}"
        )
        stored = f"{len(made.held())} signals at {made.sampling:g} Hz are stored in it"
        made._said += f" Read from a file of {wrote}, whose motion these kernels cannot replay; {stored}."
        made._lack = Lack(
            f"must be one of those stored: the file is of {wrote}, whose motion these kernels cannot replay",
            "Simulate its case again, or run gearplay export with the version that wrote it",
        )
        return made

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        overwrite: bool = False,
        signals: list[str] | None = None,
        sampling: float | None = None,
        full: bool = False,
    ) -> None:
        """Write the motion, from which `gearplay.read_result` computes every signal again, bit for bit, and some samples.

        Parameters
        ----------
        path
            The file, written atomically; its extension sets the format: ``.nc``, or ``.csv`` or ``.mat`` with samples alone.
        overwrite
            Whether an existing file may be replaced.
        signals
            Signals to write as samples, ``ax`` or ``ring.ax``. By default those that `simulate` was given; else all of them, at
            so low a rate that they take 4 kB per simulated second. Tables have a column for each, and no statistics of contacts.
        sampling
            Rate of these samples [Hz]; that of the record if not given.
        full
            Write all signals at the rate of the record, for other programs; block by block, in little memory.

        Raises
        ------
        InputError
            For another ending, an unknown signal, an existing file where ``overwrite`` is false, or one that cannot be written.
        ResourceError
            Where samples take longer than ``run.max_wall_time``.

        Examples
        --------
        >>> import tempfile, gearplay as gp
        >>> place = tempfile.mkdtemp() + "/run.nc"
        >>> gp.simulate("han2021", duration=0.01, transient=0.0).save(place)
        >>> gp.read_result(place).signal("ring.ax").size
        1000

        """
        from gearplay.results.run_files import write_run

        check_ending(path)
        full = full or (is_table(path) and signals is None and sampling is None)
        plain = samples_to_write(pack(self.case), self.runs, signals, sampling, self._lack, full=full)
        if is_table(path):
            from gearplay.results.dataset import chosen_signals

            made = Result(self.case, plain).ds
            made = made if signals is None else chosen_signals(made, plain[0].columns)
            write_dataset(made, Path(path), overwrite=overwrite)
        else:
            with enough_memory():
                write_run(self.case, self.runs, plain, Path(path), overwrite=overwrite)

    @cached_property
    def ds(self) -> xr.Dataset:
        """The result as a dataset: dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble."""
        from gearplay.results.dataset import to_dataset

        return to_dataset(self.case, pack(self.case), self.runs)

    @property
    def message(self) -> str:
        """The worst status and the warnings of the run as text."""
        return self._said or worst_of(self.runs).message

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
        return contacts_of(self.runs)

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
        return shaft_of_runs(self.case, pack(self.case), rotor, self.runs)

    def __repr__(self) -> str:
        work, title = self.work, self.case.title or "untitled"
        members = f", {self.members} members" if self.members > 1 else ""
        ended = f"{self.status.name}{members}, {self.reached:g} s, {work.steps} steps, {work.events} events"
        return f"<gearplay.Result {title!r}: {ended}>"

    @property
    def work(self) -> Work:
        """Steps, rejected steps, events and seconds on one core, of all members."""
        return work_of(self.runs)

    @property
    def reached(self) -> float:
        """Simulated time [s] that the first member reached, transient included."""
        return self.runs[0].reached

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
