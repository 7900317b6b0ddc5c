"""Channels among the named arrays of MAT, HDF5 and netCDF files: vectors, columns of matrices, rates, units, time axes."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.rates import (
    Declaration,
    agreed_rate,
    declarations,
    declared_rate,
    even_sampling,
    is_rate_name,
    time_scale,
)
from gearplay.files.measurements.refusing import damaged, quoted
from gearplay.files.record import Record
from gearplay.vocabulary.errors import InputError, MeasurementError, shorten

MOST_COLUMNS: Final = 4096
"""Most columns of a matrix whose columns are channels."""

UNITS: Final = ("units", "unit", "Units", "Unit")
"""Names of attributes and texts that hold a unit."""

_NAMES: Final = ("names", "labels", "channels", "channelnames", "channellabels", "columns")
_STARTS: Final = ("start", "startvalue", "t0", "starttime")


@dataclass(frozen=True)
class Entry:
    """Named value of a file: a number, a text, a list of texts or an array, then anything with ``shape`` and ``dtype``.

    ``path`` holds the names of its groups or structures and its own, ``attributes`` those of the value and of its group,
    ``axes`` the paths of the time axes attached to it; ``is_axis`` is true for an axis of others.
    """

    path: tuple[str, ...]
    value: Any
    attributes: Mapping[str, object] = field(default_factory=dict)
    axes: tuple[tuple[str, ...], ...] = ()
    is_axis: bool = False

    @property
    def group(self) -> tuple[str, ...]:
        """Path of the group that holds it."""
        return self.path[:-1]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape without axes of length 1; empty for a scalar or a value that is not an array of numbers."""
        if not self.is_numeric:
            return ()
        return tuple(length for length in self.value.shape if length != 1)

    @property
    def is_numeric(self) -> bool:
        """Whether it is a number or an array of real numbers."""
        return getattr(self.value, "dtype", np.dtype("O")).kind in "fiub" and self.value.shape is not None

    @property
    def is_scalar(self) -> bool:
        """Whether it is one number or a text."""
        return isinstance(self.value, str) or (
            self.is_numeric and not self.shape and 0 not in self.value.shape
        )

    @property
    def unit(self) -> str:
        """Unit by its attributes."""
        return next((str(self.attributes[key]).strip() for key in UNITS if key in self.attributes), "")

    def __str__(self) -> str:
        kind = getattr(self.value, "dtype", None)
        if kind is None or self.value.shape is None:
            return f"{'.'.join(self.path)} ({'text' if isinstance(self.value, str) else type(self.value).__name__})"
        shape = " x ".join(map(str, self.value.shape)) or "one"
        return f"{'.'.join(self.path)} ({shape} {'table' if kind.names else kind.name})"


def leaves(path: tuple[str, ...], value: Any) -> Iterator[Entry]:
    """Yield the values within nested structures and cells; elements of cells and structure arrays are numbered from 1."""
    if isinstance(value, dict):
        for name, inside in value.items():
            yield from leaves((*path, str(name)), inside)
        return
    if isinstance(value, np.ndarray) and value.dtype == object:
        value = list(value.ravel(order="F"))
    if isinstance(value, list):
        if value and all(isinstance(each, str) for each in value):
            yield Entry(path, value)
            return
        for place, inside in enumerate(value, start=1):
            yield from leaves((*path[:-1], f"{path[-1]}({place})"), inside)
        return
    if isinstance(value, (int, float, np.generic)):
        value = np.asarray(value)
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        value = list(value.ravel()) if value.size != 1 else str(value.ravel()[0])
    yield Entry(path, value)


Load = Callable[[Entry], NDArray[Any]]


@dataclass(frozen=True)
class _Column:
    """Candidate for a channel: an entry, or a column of one."""

    entry: Entry
    name: str
    index: int | None = None


class NamedArrays:
    """Named values of one file in its order, and the channels among them; ``load`` returns the samples of an entry."""

    def __init__(self, request: Request, entries: Sequence[Entry], load: Load, separator: str = ".") -> None:
        self.request, self.entries, self.separator = request, entries, separator
        self._load = load
        self._loaded: dict[tuple[str, ...], NDArray[Any]] = {}
        self.scalars = [e for e in entries if e.is_scalar]
        self.arrays = [e for e in entries if e.shape and 0 not in e.shape]
        self.axes = [e for e in self.arrays if e.is_axis or self._is_time(e)]

    def is_axis(self, entry: Entry) -> bool:
        """Return whether an entry is an axis of others."""
        return any(entry is axis for axis in self.axes)

    def _is_time(self, entry: Entry) -> bool:
        return len(entry.shape) == 1 and time_scale(entry.path[-1], entry.unit) is not None

    def load(self, entry: Entry) -> NDArray[Any]:
        """Return the samples of an entry without axes of length 1, read once."""
        if entry.path not in self._loaded:  # only the last is kept: files may be large
            self._loaded = {entry.path: np.asarray(self._load(entry)).squeeze()}
        return self._loaded[entry.path]

    def columns(self) -> list[_Column]:
        """Return the channels to be: vectors, and columns along the longer side of matrices."""
        found = []
        for entry in self.arrays:
            name, sides, count = self.separator.join(entry.path), len(entry.shape), min(entry.shape)
            if self.is_axis(entry) or sides > 2 or (sides == 2 and count > MOST_COLUMNS):
                continue
            if is_rate_name(entry.path[-1]):
                rule = f"{quoted(name)} must be one sampling rate, {max(entry.shape)} found"
                raise damaged(self.request.path, rule)
            if sides == 1:
                own = self._text(entry, ("name",)) if entry.group else ""
                found.append(_Column(entry, own or name))
                continue
            names = self._names(entry, count) or [f"{name} {k + 1}" for k in range(count)]
            first = 1 if self._first_is_time(entry) else 0
            found += [_Column(entry, names[k], k) for k in range(first, count)]
        return found

    def values(self, column: _Column) -> NDArray[Any]:
        """Return the samples of a candidate column, shape [time]."""
        values = self.load(column.entry)
        if column.index is None:
            return values
        return values[:, column.index] if values.shape[0] >= values.shape[1] else values[column.index]

    def record(self, kind: str, known: Sequence[str] = ()) -> Record:
        """Return the record of all requested channels; attributes in ``known`` are not repeated as text."""
        columns = self.columns()
        used = {id(e) for e in (*self.scalars, *self.axes, *(column.entry for column in columns))}
        left_out = [
            e for e in self.entries if id(e) not in used and getattr(e.value, "shape", (1,)) is not None
        ]
        about: dict[str, object] = {}
        for e in self.scalars[:100]:
            value = e.value if isinstance(e.value, str) else np.asarray(self._load(e)).item()
            about[self.separator.join(e.path)] = value
        if left_out:
            about["left out"] = shorten(", ".join(self.separator.join(e.path) for e in left_out), 900)
        return make_record(
            self.request,
            [column.name for column in columns],
            lambda k: self.samples(columns[k], known),
            about,
            found=[str(e) for e in self.entries],
            kind=kind,
        )

    def samples(self, column: _Column, known: Sequence[str]) -> Samples:
        """Return the content of one channel."""
        entry = column.entry
        declared, start = self._declared(entry), self._number(entry, _STARTS)
        values = self.values(column)
        if (axis := self._axis(entry)) is not None:
            rate, start = axis
            declared = [*declared, rate]
        about = {key: value for key, value in entry.attributes.items() if key not in known}
        return Samples(values, declared, self._unit(column), start, about)

    def _axis(self, entry: Entry) -> tuple[Declaration, float] | None:
        """Return rate [Hz] and start [s] by the time axis attached to an entry, in its group, or its first column."""
        if len(entry.shape) == 2 and self._first_is_time(entry):
            times = self.values(_Column(entry, "", 0)).astype(np.float64)
            rate, start = even_sampling(self.request.path, times, column=f"{entry.path[-1]} 1")
            return (f"column 1 of {entry.path[-1]}", rate), start
        for other in self.axes:
            near = other.group == entry.group and self._is_time(other)
            attached = other.path in entry.axes
            scale = time_scale(other.path[-1], other.unit)
            if scale is None and attached and other.unit:
                scale = time_scale("time", other.unit)
            if scale is not None and (near or attached) and max(other.shape) == max(entry.shape):
                times = np.asarray(self._load(other)).ravel().astype(np.float64) * scale
                name = self.separator.join(other.path)
                rate, start = even_sampling(self.request.path, times, column=name)
                return (name, rate), start
        return None

    def _first_is_time(self, entry: Entry) -> bool:
        """Return whether the first column of a matrix is its time: uniformly increasing, at the declared rate if there is one."""
        others = [axis for axis in self.axes if axis.group == entry.group]
        if len(entry.shape) != 2 or any(max(axis.shape) == max(entry.shape) for axis in others):
            return False
        times = self.values(_Column(entry, "", 0)).astype(np.float64)
        if not (np.isfinite(times).all() and (np.diff(times) > 0.0).all()):
            return False
        try:
            rate, _ = even_sampling(self.request.path, times)
            declared = self._declared(entry)
            if declared or self.request.sampling is not None:
                stated = agreed_rate(self.request.path, "", declared, self.request.sampling)
                agreed_rate(self.request.path, "", [("", rate)], stated)
        except (MeasurementError, InputError):
            return False
        return rate != 1.0  # whole numbers count the samples

    def _levels(self, entry: Entry) -> Iterator[list[Entry]]:
        """Yield scalars from near to far: of the entry's group, of header groups in it, then of the groups around it."""
        holding = {other.group for other in self.arrays if not self.is_axis(other)}
        for depth in range(len(entry.group), -1, -1):
            prefix = entry.group[:depth]
            yield [s for s in self.scalars if s.group == prefix]
            yield [s for s in self.scalars if s.group[:depth] == prefix and s.group not in holding]

    def _declared(self, entry: Entry) -> list[Declaration]:
        """Return the nearest declarations of the sampling rate [Hz]: attributes, scalars of the same group, headers."""
        own = declarations(entry.attributes.items())
        if own:
            return own
        for level in self._levels(entry):
            found = []
            for scalar in level:
                value = scalar.value if isinstance(scalar.value, str) else self._load(scalar)
                rate = declared_rate(scalar.path[-1], value, scalar.group[-1] if scalar.group else "")
                if rate is not None:
                    found.append((self.separator.join(scalar.path), rate))
            if found:
                return found
        return []

    def _number(self, entry: Entry, keys: Sequence[str]) -> float:
        """Return the number of an attribute, or of a scalar in the entry's group, under one of the names; else 0."""
        for key, value in entry.attributes.items():
            if key in keys and isinstance(value, (int, float)):
                return float(value)
        for scalar in self.scalars:
            named = scalar.path[-1].replace("_", "").lower() in keys
            if scalar.group == entry.group and named and scalar.is_numeric:
                return float(np.asarray(self._load(scalar)).ravel()[0])
        return 0.0

    def _text(self, entry: Entry, keys: Sequence[str], *, inside: bool = False) -> str:
        """Return the text in an entry's group, or in a group below, under one of the names; the entry must be alone there."""
        alone = sum(other.group == entry.group and not self.is_axis(other) for other in self.arrays) == 1
        for scalar in self.scalars:
            near = scalar.group == entry.group or (inside and scalar.group[: len(entry.group)] == entry.group)
            if alone and near and isinstance(scalar.value, str) and scalar.path[-1].lower() in keys:
                return scalar.value.strip()
        return ""

    def _names(self, entry: Entry, count: int, keys: Sequence[str] = _NAMES) -> list[str]:
        """Return the list of texts in the group of a matrix, one for each of its columns."""
        for other in self.entries:
            near = other.group == entry.group and other.path[-1].replace("_", "").lower() in keys
            if near and isinstance(other.value, list) and len(other.value) == count:
                return [str(text) for text in other.value]
        return []

    def _unit(self, column: _Column) -> str:
        entry = column.entry
        if column.index is not None:
            units = self._names(entry, min(entry.shape), UNITS)
            if units:
                return units[column.index]
        named = {f"{entry.path[-1]}_{word}".lower() for word in ("unit", "units")}
        for scalar in self.scalars:
            near = scalar.group == entry.group and scalar.path[-1].lower() in named
            if near and isinstance(scalar.value, str):
                return scalar.value.strip()
        return entry.unit or self._text(entry, ("unit", "units"), inside=True)
