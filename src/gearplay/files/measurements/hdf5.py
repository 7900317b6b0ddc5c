"""HDF5, netCDF-4 and MAT 7.3 by h5py: arrays with their attributes, axes, packing and checksums."""

import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.named_arrays import UNITS, Entry, NamedArrays
from gearplay.files.measurements.rates import declarations
from gearplay.files.measurements.refusing import DENSEST, MOST_NODES, check_samples, damaged, fenced, quoted
from gearplay.files.record import Record

OURS: Final = "gearplay_channels"
"""Attribute of the file that `write_record` sets: how many channels it holds."""

_KNOWN: Final = (
    "sampling", "start", "sha256", "long_name", "attributes", "DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME",
    "_Netcdf4Dimid", "_Netcdf4Coordinates", "MATLAB_class", "H5PATH", *UNITS,
)  # fmt: skip
_NO_NUMBERS: Final = (
    "function_handle",
    "string",
    "table",
    "timetable",
    "datetime",
    "struct",
    "canonical empty",
)
_DEEPEST: Final = 32
_LONGEST_TEXT: Final = 100_000


def read(request: Request, *, kind: str = "") -> Record:
    """Read the arrays of an HDF5, netCDF-4 or MAT 7.3 file; see `NamedArrays` for rates and units.

    Raises `MeasurementError` where the file is cut, an array holds fewer values than it declares, or a checksum does not match.
    """
    import h5py

    with fenced(request.path, "HDF5"), h5py.File(request.path, "r") as file:
        entries = list(_group(_Walk(request, file), file, ()))
        kind = kind or ("netcdf" if "_NCProperties" in file.attrs else "hdf5")
        if OURS in file.attrs:
            return _ours(request, file, entries, kind)
        arrays = NamedArrays(
            request, entries, lambda entry: _values(request, entry), "." if kind == "mat" else "/"
        )
        return arrays.record(kind, _KNOWN)


def _ours(request: Request, file: Any, entries: list[Entry], kind: str) -> Record:
    """Return the record that `write_record` wrote: every dataset but the axes is a channel."""
    held = [e for e in entries if e.is_numeric and not e.is_axis and hasattr(e.value, "id")]
    declared = _plain(file.attrs[OURS])
    if declared != len(held):
        raise damaged(request.path, f"declares {declared} channels and holds {len(held)}")

    def load(k: int) -> Samples:
        about = held[k].attributes
        return Samples(
            _values(request, held[k]).ravel(),
            declarations([("sampling", about.get("sampling"))]),
            held[k].unit,
            float(str(about.get("start", 0.0))),
            _further(about),
        )

    names = [str(e.attributes.get("long_name") or e.path[-1]) for e in held]
    return make_record(request, names, load, _further(_attributes(file)), kind=kind)


def _further(attributes: Mapping[str, object]) -> dict[str, object]:
    """Return the attributes of a record or a channel, which `write_record` stores as JSON."""
    about = json.loads(str(attributes.get("attributes") or "{}"))
    return about if isinstance(about, dict) else {}


@dataclass
class _Walk:
    """One walk over the objects of a file."""

    request: Request
    file: Any
    seen: set[int] = field(default_factory=set)

    def is_new(self, entry: Any, depth: int) -> bool:
        """Return whether an object was not met before; raise where there are too many, or too deep."""
        import h5py

        if depth > _DEEPEST:
            raise damaged(self.request.path, f"its groups are nested more than {_DEEPEST} deep")
        address = int(h5py.h5o.get_info(entry.id).addr)
        if address in self.seen:
            return False
        self.seen.add(address)
        if len(self.seen) > MOST_NODES:
            raise damaged(self.request.path, f"has more than {MOST_NODES} objects", "Export fewer channels")
        return True


def _group(walk: _Walk, group: Any, path: tuple[str, ...]) -> Iterator[Entry]:
    """Yield the attributes and datasets of a group and its groups, along hard links only: others may leave the file."""
    import h5py

    for key, value in _attributes(group).items():
        if key not in _KNOWN or key in ("sampling", "start"):
            yield Entry((*path, key), value if isinstance(value, str) else np.asarray(value))
    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.HardLink) and name != "#refs#":
            yield from _object(walk, group[name], (*path, name))


def _object(walk: _Walk, entry: Any, path: tuple[str, ...]) -> Iterator[Entry]:
    import h5py

    if not walk.is_new(entry, len(path)):
        return
    if isinstance(entry, h5py.Group):
        yield from _group(walk, entry, path)
        return
    if not isinstance(entry, h5py.Dataset) or entry.shape is None:
        return
    about = _attributes(entry)
    foreign = str(about.get("MATLAB_class", ""))
    if str(about.get("NAME", "")).startswith("This is a netCDF dimension but not"):
        return
    if "MATLAB_empty" in about:
        yield Entry(path, "")
    elif h5py.check_dtype(ref=entry.dtype) is h5py.Reference and entry.size <= MOST_NODES:
        yield from _references(walk, entry, path, cell=foreign == "cell")
    elif foreign == "char" and entry.size <= _LONGEST_TEXT:
        yield Entry(path, "".join(map(chr, np.asarray(entry[()]).ravel(order="F"))))
    elif h5py.check_string_dtype(entry.dtype) is not None and entry.size <= MOST_NODES:
        texts = [_plain(each) for each in np.asarray(entry[()]).ravel()]
        yield Entry(path, str(texts[0]) if len(texts) == 1 else texts)
    elif foreign in _NO_NUMBERS:
        yield Entry(path, None)
    else:
        axes = tuple(tuple(s.name.strip("/").split("/")) for d in entry.dims for s in d.values())
        yield Entry(path, entry, about, axes, bool(h5py.h5ds.is_scale(entry.id)))


def _references(walk: _Walk, entry: Any, path: tuple[str, ...], *, cell: bool) -> Iterator[Entry]:
    """Yield the elements of a cell, or a field of each element of a structure array, numbered from 1 as in version 5."""
    found = []
    for place, reference in enumerate(np.asarray(entry[()]).ravel(), start=1):
        own = (*path[:-1], f"{path[-1]}({place})") if cell else (*path[:-2], f"{path[-2]}({place})", path[-1])
        found += list(_object(walk, walk.file[reference], own)) if reference else []
    if cell and found and all(isinstance(each.value, str) for each in found):
        yield Entry(path, [each.value for each in found])
    else:
        yield from found


def _attributes(entry: Any) -> dict[str, Any]:
    return {str(key): _plain(value) for key, value in itertools.islice(entry.attrs.items(), 200)}


def _plain(value: Any) -> Any:
    """Return a number or text of an attribute as Python has it; of arrays their text."""
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.ndarray):
        return _plain(value.ravel()[0]) if value.size == 1 else str(value)
    if isinstance(value, np.generic):
        return value.item() if value.dtype.kind in "fiub" else str(value)
    return value if isinstance(value, (str, int, float)) else str(value)


def _values(request: Request, entry: Entry) -> NDArray[Any]:
    """Return an array's values; its declared size is compared with the stored size before allocation."""
    dataset, path, name = entry.value, request.path, quoted("/".join(entry.path))
    if isinstance(dataset, np.ndarray):
        return dataset
    count, width = int(dataset.size), int(dataset.dtype.itemsize)
    check_samples(path, count)
    if dataset.external or dataset.is_virtual:
        rule = f"channel {name} lies in another file, which is not read"
        raise damaged(path, rule, "Repack it into one file")
    block = int(np.prod(dataset.chunks, dtype=np.float64)) if dataset.chunks else 0
    largest = max(count, block) * width
    if largest > DENSEST * request.size:
        rule = f"channel {name} declares {largest} bytes, which a file of {request.size} cannot hold"
        raise damaged(path, rule)
    if dataset.chunks:
        due = int(np.prod([-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True)]))
        held = int(dataset.id.get_num_chunks())
        if held != due:
            raise damaged(path, f"channel {name} declares {due} blocks and holds {held}")
    elif dataset.id.get_storage_size() != count * width:
        stored = dataset.id.get_storage_size()
        raise damaged(path, f"channel {name} declares {count * width} bytes and holds {stored}")
    values: NDArray[Any] = np.asarray(dataset[()])
    written = entry.attributes.get("sha256")
    if written and checksum(values.ravel()) != written:
        raise damaged(path, f"channel {name} does not match the checksum it was written with")
    return _unpacked(entry.attributes, values)


def checksum(values: NDArray[Any]) -> str:
    """Return the SHA-256 of samples as little-endian float64, which `write_record` stores with them.

    >>> checksum(np.zeros(1))[:8]
    'af5570f5'
    """
    return hashlib.sha256(np.ascontiguousarray(values, dtype="<f8").tobytes()).hexdigest()


def _unpacked(attributes: Mapping[str, Any], values: NDArray[Any]) -> NDArray[Any]:
    """Apply netCDF's packing: missing values become NaN, then factor and offset (CF conventions 8.1)."""
    missing = [attributes[key] for key in ("_FillValue", "missing_value") if key in attributes]
    if not missing and "scale_factor" not in attributes and "add_offset" not in attributes:
        return values
    samples = values.astype(np.float64)
    for value in missing:
        samples[values == value] = np.nan
    factor, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)
    if isinstance(factor, str) or isinstance(offset, str):
        raise ValueError("scale_factor and add_offset must be numbers")
    return np.asarray(samples * factor + offset)
