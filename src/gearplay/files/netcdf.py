"""Result files: netCDF-4 with a checksum of every byte at the end."""

import hashlib
import math
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.files.atomic import LENGTH, MARK, check_new, shown_path, with_checksum, write_bytes
from gearplay.files.netcdf_streams import CHECKSUM
from gearplay.files.sandbox import READER, Request, SandboxError
from gearplay.files.stored import Stored
from gearplay.files.tables import dataset_as_csv, dataset_as_mat
from gearplay.vocabulary.background import on_daemon_thread
from gearplay.vocabulary.errors import GearplayError, InputError

if TYPE_CHECKING:
    import xarray as xr

QUICK = 10e6
"""Size [bytes] that is written in well under a second, without a thread."""
MOST_PER_BYTE = 2000
"""Bytes of numbers that one byte of a file can hold: deflate makes of a constant a thousandth."""


def check_ending(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` where the ending of a file names no format that datasets are written in."""
    if Path(path).suffix.lower() not in ("", ".nc", ".nc4", ".csv", ".mat"):
        rule, cure = "must end in .nc, .csv or .mat, which name the format", "Choose one of these endings."
        raise InputError.of("out", shown_path(Path(path)), rule, cure)


def is_table(path: str | os.PathLike[str]) -> bool:
    """Return whether the ending of a file names CSV or MAT.

    >>> is_table("run.csv"), is_table("run.nc")
    (True, False)
    """
    return Path(path).suffix.lower() in (".csv", ".mat")


def write_dataset(dataset: "xr.Dataset", path: Path, *, overwrite: bool = False) -> None:
    """Write a dataset atomically in the format of its extension: netCDF-4, CSV or MAT; Ctrl-C is not delayed meanwhile.

    Raises `InputError` where the ending is another, the file exists and ``overwrite`` is false, or cannot be written.
    """
    check_ending(path)
    check_new(path, overwrite=overwrite)
    make = partial(netcdf_bytes, dataset)
    if is_table(path):
        make = partial(dataset_as_csv if path.suffix.lower() == ".csv" else dataset_as_mat, dataset)
    content = make() if dataset.nbytes < QUICK else on_daemon_thread(make)
    check_new(path, overwrite=overwrite, size=len(content))
    write_bytes(path, content, overwrite=overwrite)


def netcdf_bytes(dataset: "xr.Dataset", *, packed: bool = True) -> bytes:
    """Return the netCDF-4 file of a dataset, numbers compressed or not, a digest at the end; the same bytes for the same content.

    It is made in memory: HDF5 that meets a full disk prints tracebacks and may bring the process down at its end. xarray's
    ``to_netcdf`` would write the same bytes, and load all of dask's cluster first, where that is installed.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    how = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if packed and variable.dtype.kind in "fi" and variable.size > 1000
    }
    held = dataset.compute() if dataset.chunks else dataset
    marked = held.assign_attrs({CHECKSUM: f"sha256 of all bytes before the last {LENGTH}"})
    buffer = BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        marked.dump_to_store(H5NetCDFStore(file), encoding=how)
    return with_checksum(buffer.getvalue())


@dataclass(frozen=True)
class Sound:
    """Result file whose digest is right, or the content of one without a digest, rewritten by a process of its own."""

    path: Path
    source: Path | BytesIO
    size: int  # bytes


def check_file(path: Path) -> Sound:
    """Check the digest at the end of a result file; a file without one is foreign or cut off and is read by a child process.

    Raises `InputError` where it is missing, no plain file, damaged or not a result, or declares more numbers than it can hold.
    """
    with _refusing(path):
        size = _plain_size(path)
        if _check_digest(path, size):
            return Sound(path, path, size)
        try:
            _, (content,) = READER.read(__name__, Request(path.absolute(), size))
        except SandboxError as reason:
            raise _refusal(path, f"the HDF5 library {reason}") from None
        return Sound(path, BytesIO(content), len(content))


def read_dataset(file: Sound) -> "xr.Dataset":
    """Read a checked result file into memory.

    Raises `InputError` where it is not a result, or declares more numbers than it can hold.
    """
    with _refusing(file.path):
        found = load_whole(file.source, file.size)
    found.attrs.pop(CHECKSUM, None)  # of the file, not of what is in it
    return found


def open_dataset(path: Path) -> "xr.Dataset":
    """Return a result file with a right digest (`check_file`) as a dataset whose variables are read on first access."""
    import xarray as xr

    with _refusing(path):
        found = xr.open_dataset(path, engine="h5netcdf")
    found.attrs.pop(CHECKSUM, None)
    return found


@contextmanager
def opened(file: Sound) -> Iterator[Stored]:
    """Open a checked result file for reading arrays by name, without xarray; faults found within the block become `InputError`.

    Raises `InputError` as `read_dataset`.
    """
    import h5py

    with _refusing(file.path):
        _check_declared(file.source, file.size)
        with h5py.File(file.source, "r") as group:
            yield Stored(group)


def load(_: Request) -> None:
    """Import the libraries that `send` needs; in the child process."""
    import_module("xarray")
    import_module("h5netcdf")


def send(request: Request) -> tuple[None, list[bytes]]:
    """Read a file without a digest and return it rewritten, with a digest; in the child process.

    Raises `InputError` as `check_file` does.
    """
    with _refusing(request.path):
        found = load_whole(request.path, request.size)
        if CHECKSUM in found.attrs:
            raise _refusal(request.path, "it was changed or cut off after it was written")
        return None, [netcdf_bytes(found.drop_encoding(), packed=False)]


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Convert any exception of HDF5 and its readers on a damaged file to an `InputError`."""
    try:
        yield
    except (GearplayError, MemoryError):
        raise
    except RecursionError:
        raise _refusal(path, "its groups go round in a circle") from None
    except Exception as error:
        raise _refusal(path, _in_words(error)) from None


def _in_words(error: Exception) -> str:
    """Return why a file cannot be read, without the internals of the HDF5 library."""
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    words = str(error).splitlines()[0] if str(error) else type(error).__name__
    if cut := re.search(r"truncated file: eof = (\d+),.* stored_eof = (\d+)", words):
        return f"it is cut off: {cut[1]} of {cut[2]} bytes are there"
    if "file signature not found" in words:
        return "it is no HDF5 file"
    return "it is damaged" if words.startswith("Unable to ") else words


def load_whole(source: Path | BytesIO, size: int) -> "xr.Dataset":
    """Load a file of a size [bytes]; `ValueError` where it declares more numbers than it can hold."""
    import xarray as xr

    _check_declared(source, size)
    with xr.open_dataset(source, engine="h5netcdf") as dataset:
        return dataset.load()


def _check_declared(source: Path | BytesIO, size: int) -> None:
    declared = _declared_bytes(source)
    if declared > MOST_PER_BYTE * size:
        raise ValueError(f"it declares {declared:.3g} bytes of numbers in {size} bytes of file")


def _plain_size(path: Path) -> int:
    found = os.stat(path)
    if not stat.S_ISREG(found.st_mode):
        raise _refusal(path, "it is no plain file")
    return found.st_size


def _declared_bytes(source: Path | BytesIO) -> float:
    """Return the size in memory [bytes] that an HDF5 file declares for its arrays; a damaged file may declare any."""
    import h5py

    total = 0.0

    def add(_: str, found: object) -> None:
        nonlocal total
        if isinstance(found, h5py.Dataset) and found.shape is not None:
            total += float(found.dtype.itemsize) * math.prod(map(float, found.shape))

    with h5py.File(source, "r") as file:
        file.visititems(add)
    return total


def _check_digest(path: Path, size: int) -> bool:
    """Return whether the file ends with a digest; `InputError` where the digest does not match the content."""
    if size < LENGTH:
        return False
    with open(path, "rb") as file:
        file.seek(size - LENGTH)
        end = file.read(LENGTH)
        if not end.startswith(MARK):
            return False
        file.seek(0)
        digest, left = hashlib.sha256(), size - LENGTH
        while left and (part := file.read(min(left, 1 << 20))):
            digest.update(part)
            left -= len(part)
    if digest.digest() != end[len(MARK) :]:
        raise _refusal(path, "its content is not what was written")
    return True


def _refusal(path: Path, words: str) -> InputError:
    rule, cure = f"must be a readable result file ({words})", "Check the path, or write the result again."
    return InputError.of("file", shown_path(path), rule, cure)
