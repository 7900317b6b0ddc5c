"""Runs in datasets: validation, and their members with the samples of the dataset."""

import math
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.run import LOG_COLUMNS
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.model.variables import VARIABLES
from gearplay.solver.continuation import End
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Column, ContactStatistics, Counters, Trajectory
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
EVEN = 1e-6
"""Largest deviation of a time from its even place, in sampling steps."""


def check_run(dataset: "xr.Dataset", case: Case, *, signals: bool = True) -> None:
    """Raise `InputError` where times, status, names or ``signals`` do not fit a run of the case.

    Times must be finite, rising and even, the status known, the names those of the case, the signals finite: NaN only where
    they were not kept, and behind the end of a member that was cut short.
    """
    if "contact" not in dataset.dims or "time" not in dataset.coords:
        _refuse("dataset", str(list(dataset.data_vars))[:60], "must be what simulate returned")
    _check_times(np.asarray(dataset["time"].values, dtype=np.float64))
    several = "member_status" in dataset
    statuses = list(map(str, dataset["member_status"].values if several else [dataset.attrs.get("status")]))
    for status in statuses:
        if status not in Status.__members__:
            _refuse("status", status, f"must be one of {', '.join(Status.__members__)}")
    members = np.atleast_1d(dataset["member"].values if "member" in dataset.coords else 0)
    if members.dtype.kind not in "iu" or members.min() < 0:
        _refuse("member", str(members[0]), "must be whole numbers from 0 on")
    known = {
        "rotor": set(case.rotors),
        "sleeve": set(case.sleeves),
        "mesh": {mesh.label for mesh in case.meshes},
    }
    for dimension, names in known.items():
        for name in map(str, dataset[dimension].values) if dimension in dataset.coords else ():
            if name not in names:
                _refuse(dimension, name, f"must be a {dimension} of the case that the file holds")
    done = [status == Status.DONE.name for status in statuses]
    for signal, variable in dataset.data_vars.items() if signals else ():
        if "time" in variable.dims and variable.dtype.kind == "f":
            _check_signal(str(signal), variable, done)


def _check_times(time: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> None:
    if not np.isfinite(time).all():
        _refuse("time", "nan", "must be finite numbers")
    if time.size < 2:
        return
    steps = np.diff(time)
    if not (steps > 0.0).all():
        place = int((steps <= 0.0).argmax()) + 1
        rule = f"must rise from sample to sample, and does not at sample {place + 1}"
        _refuse("time", float(time[place]), rule)
    step = (time[-1] - time[0]) / (time.size - 1)
    deviation = np.abs(time - time[0] - step * np.arange(time.size))
    worst = int(deviation.argmax())
    if deviation[worst] > EVEN * step + 4.0 * np.spacing(np.abs(time).max()):
        rule = f"must be evenly spaced, and is {deviation[worst]:.3g} s off at sample {worst + 1}"
        _refuse("time", float(time[worst]), rule)


def _check_signal(name: str, variable: "xr.DataArray", done: list[bool]) -> None:
    """Refuse NaN and infinity, but for signals of elements that were not kept and the end of a member that was cut short."""
    rest = [dim for dim in variable.dims if dim not in ("time", "member")]
    several = "member" in variable.dims
    members = variable.transpose(*(["member"] if several else []), "time", *rest).values
    members = members if several else members[None]
    for member, values in enumerate(members):
        table = values.reshape(values.shape[0], -1)
        bad = ~np.isfinite(table[:, ~np.isnan(table).all(axis=0)]).all(axis=1)
        if bad.any() and (done[min(member, len(done) - 1)] or not bad[int(bad.argmax()) :].all()):
            first = int(bad.argmax()) + 1
            rule = f"must be finite numbers; {int(bad.sum())} samples are not (the first at sample {first})"
            _refuse(name, "nan", rule)


def _refuse(path: str, value: object, rule: str) -> None:
    raise InputError.of(path, value, rule, "Simulate the case again")


class DatasetSamples:
    """Samples of one member in a dataset, read on access.

    Parameters
    ----------
    dataset, columns
        The dataset, and those of its signals that are the columns.
    member
        Place of the member; None where there is no such dimension.
    count
        Number of samples before it stopped.

    """

    left = math.inf

    def __init__(
        self, dataset: "xr.Dataset", columns: Sequence[Column], member: int | None, count: int
    ) -> None:
        self.dataset, self.columns, self.member, self.count = dataset, columns, member, count

    @property
    def values(self) -> Floats:
        """All signals, shape [time, column]."""
        return self.some(range(len(self.columns)))

    def keep(self, columns: Sequence[int]) -> None:
        """Do nothing: they are in the dataset."""

    def some(self, columns: Sequence[int], part: slice = slice(None)) -> Floats:
        """Return some signals, shape [time, column]."""
        found = np.empty((len(range(self.count)[part]), len(columns)))
        for at, k in enumerate(columns):
            column = self.columns[k]
            variable = self.dataset[column.signal]
            if column.dimension != "base":  # there is one housing
                variable = variable.sel({column.dimension: column.label})
            if self.member is not None:
                variable = variable.isel(member=self.member)
            flags = variable.dtype.kind == "i"  # -1 where there is none
            values = np.asarray(variable[: self.count][part].values, dtype=np.float64)
            found[:, at] = np.where(values < 0.0, np.nan, values) if flags else values
        return found

    def thinned(self, columns: Sequence[int], stride: int) -> Floats:
        """Return every ``stride``-th sample of some signals, shape [time, column]."""
        return self.some(columns, slice(None, None, stride))

    def blocks(self, size: int, stop: threading.Event) -> Iterator[Floats]:
        """Yield all samples in blocks of ``size`` times, shape [time, column]."""
        every = range(len(self.columns))
        yield from (self.some(every, slice(at, at + size)) for at in range(0, self.count, size))


def runs_in(dataset: "xr.Dataset", case: Case, logs: Sequence[Floats] | None = None) -> list[Trajectory]:
    """Return the members of a dataset of a run, with its samples; of their work the sum, as that of the first.

    Logs are empty and final states NaN unless given: a dataset does not have them.
    """
    packed, attributes = pack(case), dataset.attrs
    time = np.asarray(dataset["time"].values, dtype=np.float64)
    columns = [
        Column(quantity.name, dimension, str(label))
        for dimension, quantities in VARIABLES.items()
        for quantity in quantities
        if quantity.name in dataset
        for label in (["base"] if dimension == "base" else dataset[dimension].values)
    ]
    several = "member_status" in dataset
    statuses = list(map(str, dataset["member_status"].values)) if several else [str(attributes["status"])]
    numbers = np.atleast_1d(dataset["member"].values if "member" in dataset.coords else 0)
    rate, runs = _rate(time, case.run.sampling), []
    for m, (number, name) in enumerate(zip(numbers.tolist(), statuses, strict=True)):
        status, place = Status[name], m if several else None
        count = (
            time.size if status == Status.DONE else _last(DatasetSamples(dataset, columns, place, time.size))
        )
        counters = (
            Counters(*(int(attributes[n]) for n in ("steps", "rejected_steps", "events")))
            if m == 0
            else Counters()
        )
        statistics = {n: np.atleast_2d(dataset[n].values)[m].astype(float) for n in CONTACT_STATISTICS}
        nothing = np.full(packed.state_size, np.nan)
        runs.append(
            Trajectory(
                member=number,
                first_sample=float(time[0]) if time.size else case.run.transient,
                sampling=rate,
                samples=DatasetSamples(dataset, columns, place, count),
                columns=tuple(columns),
                statistics=ContactStatistics(
                    tuple(map(str, dataset["contact"].values)), **statistics, angular=_angular(dataset)
                ),
                log=logs[m] if logs is not None else np.zeros((0, LOG_COLUMNS)),
                status=status,
                counters=counters,
                reached=case.run.transient + case.run.duration
                if status == Status.DONE
                else time[:count].max(initial=0.0),
                wall_time=float(attributes["wall_time"]) if m == 0 else 0.0,
                final_state=nothing,
                end=End(nothing, np.zeros(0), np.zeros(0)),
            )
        )
    return runs


def _angular(dataset: "xr.Dataset") -> "NDArray[np.bool_]":
    if "contact_angular" in dataset:
        return np.asarray(dataset["contact_angular"].values.astype(bool))
    return np.zeros(dataset.sizes["contact"], dtype=bool)


def _rate(time: Floats, sampling: float) -> float:
    """Return the samples per second [Hz] of even times: the record's rate or a divisor of it."""
    if time.size < 2:
        return sampling
    found = float((time.size - 1) / (time[-1] - time[0]))
    nearest = sampling / max(1, round(sampling / found))
    return nearest if abs(found - nearest) <= 1e-6 * nearest else found


def _last(samples: DatasetSamples) -> int:
    """Return the number of samples until the last that is finite."""
    known = np.flatnonzero(np.isfinite(samples.values).any(axis=1)) if samples.columns else np.zeros(0)
    return int(known[-1]) + 1 if known.size else 0
