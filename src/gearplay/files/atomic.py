"""Files that are either whole or absent: written beside, synced, renamed."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr


def shown_path(path: Path) -> str:
    """Return the path as messages show it: of a long one the end, which holds the name."""
    text = str(path)
    return text if len(text) <= 56 else f"...{text[-53:]}"


def check_new(path: Path, *, overwrite: bool) -> None:
    """Raise `InputError` where the file exists and may not be replaced, or its folder cannot be written."""
    if path.exists() and not overwrite:
        raise InputError(
            [Fault("out", shown_path(path), "must not exist yet", "Choose another name, or say --overwrite.")]
        )
    if path.is_dir():
        raise InputError([Fault("out", shown_path(path), "must be a file, not a folder", "Add a file name.")])


def make_folder(path: Path) -> None:
    """Create a folder and its parents; `InputError` where that is not possible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            [
                Fault(
                    "out",
                    shown_path(path),
                    f"must be a folder that can be written ({error.strerror})",
                    "Choose another place.",
                )
            ]
        ) from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary name beside ``path``; on success sync it and rename it to ``path``, else remove it.

    Raises `InputError` where the folder is missing, read-only or full.
    """
    make_folder(path.parent)
    name = ""
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        os.close(handle)
        yield Path(name)
        with open(name, "rb+") as file:
            os.fsync(file.fileno())
        os.chmod(name, 0o644)
        os.replace(name, path)
        _sync_folder(path.parent)
    except OSError as error:
        raise InputError(
            [
                Fault(
                    "out",
                    shown_path(path),
                    f"must be writable ({error.strerror or error})",
                    "Free some space or choose another place.",
                )
            ]
        ) from None
    finally:
        if name and os.path.exists(name):
            os.unlink(name)


def _sync_folder(folder: Path) -> None:
    if not hasattr(os, "O_DIRECTORY"):  # a system whose folders cannot be opened
        return
    handle = os.open(folder, os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_with(path: Path, write: Callable[[Path], Any]) -> None:
    """Write a file through ``write(temporary path)``, atomically."""
    with replacing(path) as temporary:
        write(temporary)


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically, UTF-8, as it is."""
    write_with(path, lambda temporary: temporary.write_text(text, encoding="utf-8", newline=""))


def write_bytes(path: Path, content: bytes) -> None:
    """Write a binary file atomically."""
    write_with(path, lambda temporary: temporary.write_bytes(content))


def write_dataset(dataset: "xr.Dataset", path: Path, *, overwrite: bool = False) -> None:
    """Write a dataset as netCDF-4, atomically and compressed.

    Raises `InputError` where the file exists and ``overwrite`` is false, or cannot be written.
    """
    check_new(path, overwrite=overwrite)
    write_bytes(path, netcdf_bytes(dataset))


def netcdf_bytes(dataset: "xr.Dataset") -> bytes:
    """Return the netCDF-4 file of a dataset, numbers compressed; the same bytes for the same content.

    It is made in memory: HDF5 that meets a full disk prints tracebacks and may bring the process down at its end.
    """
    packed = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.size > 1000
    }
    return bytes(dataset.to_netcdf(engine="h5netcdf", encoding=packed))


def read_dataset(path: Path) -> "xr.Dataset":
    """Read a result file into memory.

    Raises `InputError` where it is missing or damaged.
    """
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            return dataset.load()
    except (OSError, ValueError, KeyError) as error:
        words = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(
            [
                Fault(
                    "file",
                    shown_path(path),
                    f"must be a readable result file ({words})",
                    "Check the path, or write the result again.",
                )
            ]
        ) from None
