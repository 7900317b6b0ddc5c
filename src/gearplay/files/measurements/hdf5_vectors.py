"""The vectors of HDF5, netCDF-4 and MAT 7.3 by h5py, with their units, rates and checksums.

On a damaged file the library may crash or never return, so `hdf5` runs this in a process of its own.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import (
    TIME_UNITS,
    Request,
    distinct,
    even_sampling,
    is_time,
    make_channel,
    make_record,
    stated_rate,
)
from gearplay.files.measurements.refusing import DENSEST, MOST_NODES, check_samples, damaged, fenced, quoted
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import shorten

OURS: Final = "gearplay_channels"
"""Attribute of the file that `write_record` sets: how many channels it holds."""

UNITS: Final = ("units", "unit", "Units", "Unit")
_KNOWN: Final = ("sampling", "start", "sha256", "long_name", "attributes", *UNITS)
_NO_VECTOR_CLASSES: Final = ("char", "cell", "struct", "string", "function_handle")
_DEEPEST: Final = 32


@dataclass(frozen=True)
class Found:
    """A vector of the file: its path without the first slash, and its dataset."""

    name: str
    dataset: Any

    @property
    def group(self) -> str:
        """Path of the group that holds it."""
        return self.name.rpartition("/")[0]


def _datasets(request: Request, group: Any, prefix: str, seen: set[bytes]) -> Iterator[Found]:
    """Yield the datasets of a group and its groups, along hard links only: others may leave the file."""
    import h5py

    if prefix.count("/") > _DEEPEST:
        raise damaged(request.path, f"its groups are nested more than {_DEEPEST} deep")
    for name in group:
        link = group.get(name, getlink=True)
        if not isinstance(link, h5py.HardLink) or name == "#refs#":
            continue
        entry = group[name]
        token = bytes(str(h5py.h5o.get_info(entry.id).addr), "ascii")
        if token in seen:
            continue
        seen.add(token)
        if len(seen) > MOST_NODES:
            raise damaged(request.path, f"has more than {MOST_NODES} objects", "Export fewer channels")
        if isinstance(entry, h5py.Group):
            yield from _datasets(request, entry, f"{prefix}{name}/", seen)
        elif isinstance(entry, h5py.Dataset):
            yield Found(prefix + name, entry)


def _attribute(dataset: Any, names: tuple[str, ...]) -> str:
    for name in names:
        if name in dataset.attrs:
            return _text(dataset.attrs[name])
    return ""


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.ndarray) and value.size == 1:
        return _text(value.ravel()[0])
    return str(value)


def _number(value: Any) -> float | None:
    """Return the number that an attribute or a dataset of one value holds, if it does."""
    array = np.asarray(value)
    return float(array.ravel()[0]) if array.size == 1 and array.dtype.kind in "fiu" else None


def _is_vector(dataset: Any) -> bool:
    numbers = dataset.shape is not None and dataset.dtype.kind in "fiub"
    foreign = _attribute(dataset, ("MATLAB_class",)) in _NO_VECTOR_CLASSES
    bare_dimension = _attribute(dataset, ("NAME",)).startswith("This is a netCDF dimension but not")
    return bool(
        numbers
        and not foreign
        and not bare_dimension
        and dataset.size
        and max((1, *dataset.shape)) == dataset.size
    )


def _unit(dataset: Any) -> str:
    return _attribute(dataset, UNITS).strip()


def _is_axis(found: Found) -> bool:
    import h5py

    unit = _unit(found.dataset).split(" since ")[0]
    return bool(h5py.h5ds.is_scale(found.dataset.id)) or is_time(found.name.rpartition("/")[2], unit)


def _values(request: Request, found: Found) -> NDArray[Any]:
    """Return a vector's samples; what it declares is compared with what is stored before it is allocated."""
    dataset, path, name = found.dataset, request.path, quoted(found.name)
    count, width = int(dataset.size), int(dataset.dtype.itemsize)
    check_samples(path, count)
    if dataset.external or dataset.is_virtual:
        raise damaged(
            path, f"channel {name} lies in another file, which is not read", "Repack it into one file"
        )
    largest = max(
        count * width, int(np.prod(dataset.chunks, dtype=np.float64)) * width if dataset.chunks else 0
    )
    if largest > DENSEST * request.size:
        raise damaged(
            path, f"channel {name} declares {largest} bytes, which a file of {request.size} cannot hold"
        )
    if dataset.chunks:
        due = int(np.prod([-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True)]))
        held = int(dataset.id.get_num_chunks())
        if held != due:
            raise damaged(path, f"channel {name} declares {due} blocks and holds {held}")
    elif dataset.id.get_storage_size() != count * width:
        stored = dataset.id.get_storage_size()
        raise damaged(path, f"channel {name} declares {count * width} bytes and holds {stored}")
    values: NDArray[Any] = np.asarray(dataset[()]).ravel()
    written = _attribute(dataset, ("sha256",))
    if written and checksum(values) != written:
        raise damaged(path, f"channel {name} does not match the checksum it was written with")
    return _unpacked(dataset, values)


def checksum(values: NDArray[Any]) -> str:
    """Return the SHA-256 of samples as little-endian float64, which `write_record` stores with them.

    >>> checksum(np.zeros(1))[:8]
    'af5570f5'
    """
    return hashlib.sha256(np.ascontiguousarray(values, dtype="<f8").tobytes()).hexdigest()


def _unpacked(dataset: Any, values: NDArray[Any]) -> NDArray[Any]:
    """Apply netCDF's packing: missing values become NaN, then factor and offset (CF conventions 8.1)."""
    attributes = dataset.attrs
    missing = [attributes[key] for key in ("_FillValue", "missing_value") if key in attributes]
    if not missing and "scale_factor" not in attributes and "add_offset" not in attributes:
        return values
    samples = values.astype(np.float64)
    for value in missing:
        samples[values == np.asarray(value).ravel()[0]] = np.nan
    factor, offset = _number(attributes.get("scale_factor", 1.0)), _number(attributes.get("add_offset", 0.0))
    if factor is None or offset is None:
        raise ValueError("scale_factor and add_offset must be numbers")
    return np.asarray(samples * factor + offset)


def _rate_beside(found: Found, everything: list[Found], file: Any) -> float | None:
    """Return the rate [Hz] that the vector, a scalar of its group, its group or the file states."""
    scalars = [other for other in everything if other.group == found.group and other.dataset.size == 1]
    stated = [
        *list(found.dataset.attrs.items())[:200],
        *((other.name.rpartition("/")[2], other.dataset[()]) for other in scalars),
        *list(found.dataset.parent.attrs.items())[:200],
        *list(file.attrs.items())[:200],
    ]
    numbers = ((name, _number(value)) for name, value in stated)
    rates = (stated_rate(name, number) for name, number in numbers if number is not None)
    return next((rate for rate in rates if rate is not None), None)


def _sampling(
    request: Request, found: Found, everything: list[Found], file: Any
) -> tuple[float | None, float]:
    """Return rate [Hz] and start [s]: as stated, else of the time axis, else of the time vector beside it."""
    start = _number(found.dataset.attrs.get("start", 0.0)) or 0.0
    rate = _rate_beside(found, everything, file)
    if rate is not None:
        return rate, start
    scales = {scale.name.lstrip("/") for dimension in found.dataset.dims for scale in dimension.values()}
    for other in everything:
        bare, unit = other.name.rpartition("/")[2], _unit(other.dataset).split(" since ")[0]
        attached = other.name in scales and unit in TIME_UNITS
        beside = other.group == found.group and is_time(bare, unit)
        if other.dataset.size == found.dataset.size and (attached or beside):
            time = _values(request, other).astype(np.float64) * TIME_UNITS[unit]
            return even_sampling(request.path, time, column=other.name)
    return None, start


def _label(found: Found, ours: bool) -> str:
    return (_attribute(found.dataset, ("long_name",)) if ours else "") or found.name


def _about(dataset: Any, ours: bool) -> dict[str, object]:
    if ours:
        said = json.loads(_attribute(dataset, ("attributes",)) or "{}")
        return said if isinstance(said, dict) else {}
    skip = (
        *_KNOWN,
        "DIMENSION_LIST",
        "REFERENCE_LIST",
        "CLASS",
        "NAME",
        "_Netcdf4Dimid",
        "_Netcdf4Coordinates",
    )
    return {name: _text(value) for name, value in list(dataset.attrs.items())[:200] if name not in skip}


def read(request: Request, *, kind: str = "") -> Record:
    """Read the vectors of an HDF5, netCDF-4 or MAT 7.3 file.

    Attributes ``units`` and ``sampling`` (or fs, dt ...) are kept; else the time axis of the vector or a vector
    called time in its group gives the rate. Tables and texts are left out. Raises `MeasurementError` where the file
    is cut, a vector holds fewer values than it declares, or a checksum does not match.
    """
    import h5py

    path = request.path
    with fenced(path, "HDF5", "h5py"), h5py.File(path, "r") as file:
        everything = list(_datasets(request, file, "", set()))
        kind = kind or ("netcdf" if "_NCProperties" in file.attrs else "hdf5")
        vectors = [found for found in everything if _is_vector(found.dataset)]
        ours = OURS in file.attrs
        wanted = [found for found in vectors if not _is_axis(found) and (ours or found.dataset.size > 1)]
        if ours and _number(file.attrs[OURS]) != len(wanted):
            raise damaged(path, f"declares {_text(file.attrs[OURS])} channels and holds {len(wanted)}")
        names = distinct([_label(found, ours) for found in wanted])
        channels: list[Channel] = []
        for k in request.select(names):
            found = wanted[k]
            rate, start = _sampling(request, found, vectors, file)
            values = _values(request, found)
            about, unit = _about(found.dataset, ours), _unit(found.dataset)
            channels.append(
                make_channel(
                    request, names[k], values, sampling=rate, unit=unit, start=start, attributes=about
                )
            )
        said = _about(file, ours)
        left_out = (
            []
            if ours
            else [found.name for found in everything if found not in vectors and found.dataset.size]
        )
    if left_out:
        said["left out"] = shorten(", ".join(left_out), 900)
    return make_record(request, channels, kind, said)
