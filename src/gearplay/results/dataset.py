"""Trajectories as one labelled `xarray.Dataset`, by the result-file contract."""

import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.provenance import KIND, provenance
from gearplay.solver.limits import check_samples
from gearplay.solver.trajectory import Trajectory, work_of, worst_of
from gearplay.vocabulary.memory import enough_memory
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

if TYPE_CHECKING:
    import xarray as xr

ANGULAR_UNITS = {"m/s": "rad/s", "N": "N m", "m": "rad"}
"""Units of the statistics of couplings' contacts, ``contact_angular`` true, by the unit of the others."""
METHOD = "Dormand-Prince 5(4), located events"
FIXED_METHODS = {
    "step": "Dormand-Prince 5(4) formula, equal steps, events noticed at their ends",
    "stage": "Dormand-Prince 5(4) formula, equal steps, contacts judged at every stage",
}
"""Methods of equal steps by ``fixed_step_contacts``."""
STATES = "not_simulated open drive_flank back_flank both_flanks"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # run from a source tree
        return "unknown"


def attributes_of(case: Case, runs: Sequence[Trajectory]) -> dict[str, Any]:
    """Return the provenance and status attributes of a result."""
    worst = worst_of(runs)
    return provenance(case) | {
        KIND: "run",
        "python_version": platform.python_version(),
        "numpy_version": _version("numpy"),
        "numba_version": _version("numba"),
        "method": METHOD if case.run.fixed_step is None else FIXED_METHODS[case.run.fixed_step_contacts],
        "tolerance": case.run.tolerance,
        "seed": case.run.seed,
        "status": worst.status.name,
        "message": worst.message,
        **asdict(work_of(runs)),
    }


def _labelled(packed: Packed, runs: Sequence[Trajectory], *, ensemble: bool) -> dict[str, Any]:
    """Return the data variables; members that stopped early are filled up with NaN."""
    from gearplay.results.lazy_arrays import lazy_array

    length = max(run.samples.count for run in runs)
    places: dict[tuple[str, str], list[int]] = {}
    for at, column in enumerate(runs[0].columns):
        places.setdefault((column.signal, column.dimension), []).append(at)
    variables: dict[str, Any] = {}
    for (signal, dimension), columns in places.items():
        quantity = RESULT_VARIABLES[signal]
        names = packed.labels[dimension]
        attributes: dict[str, Any] = {"units": quantity.unit, "long_name": quantity.long_name}
        own = () if dimension == "base" else (dimension,)  # there is one housing
        dims = ("member", "time", *own) if ensemble else ("time", *own)
        sizes = (len(names),) if own else ()
        shape = (len(runs), length, *sizes) if ensemble else (length, *sizes)
        values: Callable[[], NDArray[Any]] = partial(_block, runs, columns, names, shape)
        kind: type = np.float64
        if signal == "contact_state":
            values, kind = partial(_flags, values), np.int8
            attributes |= {"flag_values": np.arange(-1, 4, dtype=np.int8), "flag_meanings": STATES}
        block = lazy_array(shape, values, kind)
        variables[signal] = (dims, block, attributes)
    for name, quantity in CONTACT_STATISTICS.items():
        table = np.array([getattr(run.statistics, name) for run in runs])
        attributes = {"units": quantity.unit, "long_name": quantity.long_name}
        if quantity.unit in ANGULAR_UNITS:
            attributes["angular_units"] = ANGULAR_UNITS[quantity.unit]
        along = ("member", "contact") if ensemble else ("contact",)
        variables[name] = (along, table if ensemble else table[0], attributes)
    return variables


def _block(
    runs: Sequence[Trajectory], columns: list[int], names: Sequence[str], shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """Return one signal, shape [member, time, element] or without members; NaN where one stopped or an element lacks it."""
    block = np.full((len(runs), max(run.samples.count for run in runs), len(names)), np.nan)
    elements = [names.index(runs[0].columns[at].label) for at in columns]
    for m, run in enumerate(runs):
        block[m, : run.samples.count, elements] = run.samples.some(columns).T
    return block.reshape(shape)


def _flags(compute: Callable[[], NDArray[np.float64]]) -> NDArray[np.int8]:
    """Return flags as integers, -1 where there is none."""
    return np.nan_to_num(compute(), nan=-1.0).astype(np.int8)


@enough_memory()
def to_dataset(case: Case, packed: Packed, runs: Sequence[Trajectory]) -> "xr.Dataset":
    """Return the runs as one dataset: dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble.

    Values are computed on first access. Every variable has ``units`` and ``long_name``; attributes hold the resolved
    case and how it was computed. Statistics of couplings' contacts, where ``contact_angular`` is 1, are in rad/s, N m and rad.
    """
    import xarray as xr

    ensemble = len(runs) > 1
    longest = max(runs, key=lambda run: run.samples.count)
    check_samples(longest.samples.count, len(runs))
    time = ("time", longest.time, {"units": "s", "long_name": "time", "axis": "T"})
    coordinates: dict[str, Any] = {"time": time}
    labels = {
        "sleeve": (),
        "mesh": (),
        **{name: labels for name, labels in packed.labels.items() if name != "base"},
        "contact": packed.contact_labels,
    }  # two of them even if empty
    for dimension, names in labels.items():
        coordinates[dimension] = np.array(names, dtype=object if names else "U1")
    coordinates["rotor"] = list(packed.rotor_names)
    coordinates["contact_angular"] = (
        "contact",
        packed.angular.astype(np.int8),
        {"long_name": "1 for contacts of couplings, whose statistics have angular_units"},
    )
    if ensemble or runs[0].member != 0:
        coordinates["member"] = [run.member for run in runs] if ensemble else runs[0].member
    if ensemble:
        coordinates["member_status"] = ("member", [run.status.name for run in runs])
    variables = _labelled(packed, runs, ensemble=ensemble)
    return xr.Dataset(variables, coords=coordinates, attrs=attributes_of(case, runs))
