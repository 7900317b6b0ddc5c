"""Result files: netCDF-4 with a digest of every byte at its end, so that a damaged one is never taken for whole."""

import hashlib
import math
import os
import stat
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.files.atomic import check_new, shown_path, write_bytes
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr

MARK = b"gearplay sha256:"
"""Stands at the end of a file before the SHA-256 of all before; HDF5 does not look beyond its own end."""
SEAL = "digest"
"""Attribute that says that a file has a digest at its end."""
MOST_PER_BYTE = 2000
"""Bytes of numbers that one byte of a file can hold: deflate makes of a constant a thousandth."""


def write_dataset(dataset: "xr.Dataset", path: Path, *, overwrite: bool = False) -> None:
    """Write a dataset as netCDF-4, atomically and compressed.

    Raises `InputError` where the file exists and ``overwrite`` is false, or cannot be written.
    """
    check_new(path, overwrite=overwrite)
    content = netcdf_bytes(dataset)
    check_new(path, overwrite=overwrite, size=len(content))
    write_bytes(path, content, overwrite=overwrite)


def netcdf_bytes(dataset: "xr.Dataset") -> bytes:
    """Return the netCDF-4 file of a dataset, numbers compressed, a digest at the end; the same bytes for the same content.

    It is made in memory: HDF5 that meets a full disk prints tracebacks and may bring the process down at its end.
    """
    packed = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.size > 1000
    }
    sealed = dataset.assign_attrs({SEAL: "sha256 of all bytes before the last 48"})
    content = bytes(sealed.to_netcdf(engine="h5netcdf", encoding=packed))
    return content + MARK + hashlib.sha256(content).digest()


def read_dataset(path: Path) -> "xr.Dataset":
    """Read a result file into memory; a digest at its end is checked.

    Raises `InputError` where it is missing, no plain file, damaged or not a result, or declares more numbers than it can hold.
    """
    import xarray as xr

    try:
        size = _plain_size(path)
        sealed = _check_digest(path, size)
        declared = _declared_bytes(path)
        if declared > MOST_PER_BYTE * size:
            raise _refusal(path, f"it declares {declared:.3g} bytes of numbers in {size} bytes of file")
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            if SEAL in dataset.attrs and not sealed:
                raise _refusal(path, "it was changed or cut off after it was written")
            found = dataset.load()
            found.attrs.pop(SEAL, None)  # of the file, not of what is in it
    except InputError:
        raise
    except RecursionError:
        raise _refusal(path, "its groups go round in a circle") from None
    except Exception as error:  # of a damaged file HDF5 and its readers raise errors of any kind
        words = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise _refusal(path, words) from None
    found.attrs.pop(SEAL, None)
    return found


def _plain_size(path: Path) -> int:
    found = os.stat(path)
    if not stat.S_ISREG(found.st_mode):
        raise _refusal(path, "it is no plain file")
    return found.st_size


def _declared_bytes(path: Path) -> float:
    """Return how many bytes the arrays of an HDF5 file take in memory by its own account; it may lie."""
    import h5py

    total = 0.0

    def add(_: str, found: object) -> None:
        nonlocal total
        if isinstance(found, h5py.Dataset) and found.shape is not None:
            total += float(found.dtype.itemsize) * math.prod(map(float, found.shape))

    with h5py.File(path, "r") as file:
        file.visititems(add)
    return total


def _check_digest(path: Path, size: int) -> bool:
    """Return whether the file ends with a digest; `InputError` where that is not of what stands before."""
    length = len(MARK) + hashlib.sha256().digest_size
    if size < length:
        return False
    with open(path, "rb") as file:
        file.seek(size - length)
        end = file.read(length)
        if not end.startswith(MARK):
            return False
        file.seek(0)
        digest, left = hashlib.sha256(), size - length
        while left and (part := file.read(min(left, 1 << 20))):
            digest.update(part)
            left -= len(part)
    if digest.digest() != end[len(MARK) :]:
        raise _refusal(path, "its content is not what was written")
    return True


def _refusal(path: Path, words: str) -> InputError:
    rule, cure = f"must be a readable result file ({words})", "Check the path, or write the result again."
    return InputError([Fault("file", shown_path(path), rule, cure)])
