"""Trajectories as one labelled `xarray.Dataset`, by the result-file contract."""

import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.provenance import KIND, provenance
from gearplay.solver.limits import check_samples
from gearplay.solver.trajectory import Column, Trajectory, work_of, worst_of
from gearplay.vocabulary.memory import enough_memory
from gearplay.vocabulary.quantities import ANGULAR_UNITS, CONTACT_STATISTICS

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
METHOD = "Dormand-Prince 5(4), located events"
FIXED_METHODS = {
    "step": "Dormand-Prince 5(4) formula, equal steps, events noticed at their ends",
    "stage": "Dormand-Prince 5(4) formula, equal steps, contacts judged at every stage",
}
"""Methods of equal steps by ``fixed_step_contacts``."""
STATES = "not_simulated open drive_flank back_flank both_flanks"


@cache
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


Table = tuple[tuple[str, ...], Any, dict[str, Any]]
"""Dimensions, values and attributes of a variable."""


@dataclass(frozen=True)
class SignalTable:
    """A signal of all elements that have it, as a variable: ``columns`` of the samples are its ``elements``, of ``count``."""

    name: str
    dimension: str
    columns: tuple[int, ...]
    elements: tuple[int, ...]
    count: int

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of `fill`."""
        return ("time",) if self.dimension == "base" else ("time", self.dimension)  # there is one housing

    @property
    def dtype(self) -> Any:
        """Type of the values."""
        return np.dtype(np.int8 if self.name == "contact_state" else np.float64)

    @property
    def attributes(self) -> dict[str, Any]:
        """Unit and long name."""
        quantity = RESULT_VARIABLES[self.name]
        flags = {"flag_values": np.arange(-1, 4, dtype=np.int8), "flag_meanings": STATES}
        words = {"units": quantity.unit, "long_name": quantity.long_name}
        return words | flags if self.name == "contact_state" else words

    def shape(self, length: int) -> tuple[int, ...]:
        """Return the shape of an array of ``count`` samples."""
        return (length, self.count)[: len(self.dims)]

    def fill(self, values: Floats) -> NDArray[Any]:
        """Return the values of samples, shape [time, column], as `dims`; NaN (of flags -1) where an element lacks the signal."""
        block = np.full((len(values), self.count), np.nan)
        block[:, list(self.elements)] = values
        if self.dtype.kind == "i":
            block = np.nan_to_num(block, nan=-1.0)
        return block.reshape(self.shape(len(values))).astype(self.dtype, copy=False)


def signal_tables(packed: Packed, columns: Sequence[Column]) -> list[SignalTable]:
    """Return the variables of sampled signals, the same for every member."""
    places: dict[tuple[str, str], list[int]] = {}
    for at, column in enumerate(columns):
        places.setdefault((column.signal, column.dimension), []).append(at)
    tables = []
    for (signal, dimension), own in places.items():
        names = packed.labels[dimension]
        elements = tuple(names.index(columns[at].label) for at in own)
        tables.append(SignalTable(signal, dimension, tuple(own), elements, len(names)))
    return tables


def statistics_tables(runs: Sequence[Trajectory]) -> dict[str, Table]:
    """Return the statistics of contacts as variables."""
    ensemble = len(runs) > 1
    variables: dict[str, Table] = {}
    for name, quantity in CONTACT_STATISTICS.items():
        table = np.array([getattr(run.statistics, name) for run in runs])
        attributes = {"units": quantity.unit, "long_name": quantity.long_name}
        if quantity.unit in ANGULAR_UNITS:
            attributes["angular_units"] = ANGULAR_UNITS[quantity.unit]
        along = ("member", "contact") if ensemble else ("contact",)
        variables[name] = (along, table if ensemble else table[0], attributes)
    return variables


TIME = {"units": "s", "long_name": "time", "axis": "T"}
"""Attributes of time."""


def coordinate_tables(packed: Packed, runs: Sequence[Trajectory]) -> dict[str, Table]:
    """Return labels and members as coordinates, all but time."""
    labels = {
        "sleeve": (),
        "mesh": (),
        **{name: labels for name, labels in packed.labels.items() if name not in ("base", "rotor")},
        "contact": packed.contact_labels,
    }  # two of them even if empty
    angular = {"long_name": "1 for contacts of couplings, whose statistics have angular_units"}
    found: dict[str, Table] = {
        **{n: ((n,), np.array(names, dtype=object if names else "U1"), {}) for n, names in labels.items()},
        "rotor": (("rotor",), np.array(packed.rotor_names), {}),
        "contact_angular": (("contact",), packed.angular.astype(np.int8), angular),
    }
    if len(runs) > 1:
        found["member"] = (("member",), np.array([run.member for run in runs]), {})
        found["member_status"] = (("member",), np.array([r.status.name for r in runs]), {})
    elif runs[0].member != 0:
        found["member"] = ((), np.array(runs[0].member), {})
    return found


def _block(runs: Sequence[Trajectory], table: SignalTable, length: int) -> NDArray[Any]:
    """Return one signal of all members; members that stopped early are filled up with NaN."""
    parts = []
    for run in runs:
        values = np.full((length, len(table.columns)), np.nan)
        values[: run.samples.count] = run.samples.some(table.columns)
        parts.append(table.fill(values))
    return np.stack(parts) if len(runs) > 1 else parts[0]


def chosen_signals(dataset: "xr.Dataset", columns: Sequence[Column]) -> "xr.Dataset":
    """Return the signals of a run that are ``columns``, each of one element: ``ring.ax``, shape [time] or [member, time].

    Nothing else is left but time and members: neither other elements nor statistics of contacts.
    """
    found = {
        c.signal if c.dimension == "base" else f"{c.label}.{c.signal}": dataset[c.signal]
        if c.dimension == "base"
        else dataset[c.signal].sel({c.dimension: c.label}, drop=True)
        for c in columns
    }
    kept = [name for name in ("time", "member", "member_status") if name in dataset.coords]
    return dataset[kept].assign(found)


@enough_memory()
def to_dataset(case: Case, packed: Packed, runs: Sequence[Trajectory]) -> "xr.Dataset":
    """Return the runs as one dataset: dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble.

    Values are computed on first access. Every variable has ``units`` and ``long_name``; attributes hold the resolved
    case and how it was computed. Statistics of couplings' contacts, where ``contact_angular`` is 1, are in rad/s, N m and rad.
    """
    import xarray as xr

    from gearplay.results.lazy_arrays import lazy_array

    longest = max(runs, key=lambda run: run.samples.count)
    length, own = longest.samples.count, (len(runs),) if len(runs) > 1 else ()
    check_samples(length, len(runs))
    coordinates = {"time": ("time", longest.time, TIME), **coordinate_tables(packed, runs)}
    variables: dict[str, Any] = {}
    for table in signal_tables(packed, runs[0].columns):
        shape = (*own, *table.shape(length))
        block = lazy_array(shape, partial(_block, runs, table, length), table.dtype)
        variables[table.name] = (("member", *table.dims)[-len(shape) :], block, table.attributes)
    variables |= statistics_tables(runs)
    return xr.Dataset(variables, coords=coordinates, attrs=attributes_of(case, runs))
