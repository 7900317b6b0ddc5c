"""Results read from files: validation of the file, replay for quantities that it does not hold."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from gearplay.model.case import Case
from gearplay.solver.simulate import run_batch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.results.result import Result

EVEN = 1e-6
"""Largest deviation of a time from its even place, in sampling steps."""


def check_run(dataset: "xr.Dataset", case: Case) -> None:
    """Raise `InputError` where times, status, names or signals cannot be those of a run of the case.

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
    for signal, variable in dataset.data_vars.items():
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
    raise InputError([Fault(path, value, rule, "Simulate the case again")])


LARGEST_DIFFERENCE: Final = 1e-9
"""Relative difference, of the largest sample, within which samples are those of the file."""
ENDED: Final = (Status.OUT_OF_TIME, Status.INTERRUPTED)
"""Ends of a run that depend on the clock."""
_CURE: Final = "Simulate the case: gearplay.simulate(result.case)"


def runs_again(result: "Result") -> Sequence[Trajectory]:
    """Return the trajectories of a result that was read from a file: its case, integrated again.

    Raises `InputError` where a member was ended by the clock, or where the file holds other samples than the case gives
    here, and the errors of a run.
    """
    ended = [status.name for status in result.statuses if status in ENDED]
    if ended:
        raise InputError(Fault("status", ended[0], "must not be an end by the clock for a repetition", _CURE))
    kept = [each for each in result.held() if np.isfinite(result.signal(*each)).any()]
    names = [f"{label}.{signal}" if label != "base" else signal for signal, label in kept]
    numbers = np.atleast_1d(result.ds["member"].values).tolist() if "member" in result.ds.coords else [0]
    runs = run_batch([(result.case, numbers)], signals=names, keep_motion=True)[0]
    for member, run in enumerate(runs):
        for signal, label in kept[:3]:
            stored, found = result.signal(signal, label, member), run.signal(signal, label)
            allowed = LARGEST_DIFFERENCE * float(np.nanmax(np.abs(stored), initial=0.0))
            same = stored.shape == found.shape
            if not same or not np.allclose(stored, found, rtol=0.0, atol=allowed, equal_nan=True):
                where = f"{label}.{signal}, member {member}"
                rule = f"must be what the case gives with gearplay {VERSION}, for a repetition of the run"
                raise InputError(Fault("result", where, rule, _CURE))
    return runs
