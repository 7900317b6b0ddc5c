"""NumPy files: one array (`.npy`) or several in an archive (`.npz`); objects of Python in them are refused, not executed."""

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.lib import format as numpy_format

from gearplay.files.measurements.building import Request
from gearplay.files.measurements.named_arrays import Entry, NamedArrays, leaves
from gearplay.files.measurements.refusing import DENSEST, MOST_NODES, damaged, fenced, quoted
from gearplay.files.record import Record

_HEADERS: Final = {
    (1, 0): numpy_format.read_array_header_1_0,
    (2, 0): numpy_format.read_array_header_2_0,
}


def read(request: Request) -> Record:
    """Read a NumPy file: vectors, columns of matrices, fields of records; see `NamedArrays` for rates and units.

    Raises `MeasurementError` where the file is cut or damaged, holds objects, or two arrays have one name; the checksums of an
    archive also detect damaged samples.
    """
    with fenced(request.path, "NumPy"):
        entries = [entry for name, array in _arrays(request) for entry in _entries(name, array)]
    return NamedArrays(request, entries, lambda entry: np.asarray(entry.value)).record("numpy")


def _arrays(request: Request) -> Iterator[tuple[str, Any]]:
    """Yield the arrays of a file with their names."""
    path = request.path
    with path.open("rb") as file:
        if file.read(len(numpy_format.MAGIC_PREFIX)) == numpy_format.MAGIC_PREFIX:
            file.seek(0)
            yield path.stem, _array(path, file, request.size, path.stem)
            return
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        names = [member.filename.removesuffix(".npy") for member in members]
        if len(members) > MOST_NODES or sum(m.file_size for m in members) > DENSEST * request.size:
            rule = f"declares more numbers than a file of {request.size} bytes can hold"
            raise damaged(path, rule)
        for member, name in zip(members, names, strict=True):
            if names.count(name) > 1:
                raise damaged(
                    path, f"holds {names.count(name)} arrays named {quoted(name)}", "Name each differently"
                )
            with archive.open(member) as inner:
                yield name, _array(path, inner, member.file_size, name)


def _array(path: Path, file: IO[bytes], size: int, name: str) -> Any:
    """Return the array in ``size`` bytes of a file."""
    version = numpy_format.read_magic(file)
    if version not in _HEADERS:
        raise damaged(
            path, f"{quoted(name)} has format {version}; 1.0 and 2.0 are read", "Save it by numpy.save"
        )
    shape, by_columns, dtype = _HEADERS[version](file)
    if dtype.hasobject:
        rule = f"{quoted(name)} holds objects of Python, which a measurement file must not"
        raise damaged(path, rule, "Save arrays of numbers")
    declared, held = int(np.prod(shape, dtype=object)) * dtype.itemsize, size - file.tell()
    if declared != held:
        raise damaged(path, f"{quoted(name)} declares {declared} bytes of numbers and holds {held}")
    values = np.frombuffer(file.read(declared), dtype=dtype)
    return values.reshape(shape, order="F" if by_columns else "C")


def _entries(name: str, array: Any) -> Iterator[Entry]:
    """Yield an array, or the fields of its records."""
    if array.dtype.names is None:
        yield from leaves((name,), array)
        return
    for field in array.dtype.names:
        yield from leaves((name, field), np.ascontiguousarray(array[field]))
