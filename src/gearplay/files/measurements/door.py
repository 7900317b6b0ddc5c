"""The door: one function reads every kind of measurement file into a record."""

import stat
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Final, cast

from gearplay.files.atomic import shown_path
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.recognise import FORMATS, HEAD, recognise
from gearplay.files.measurements.refusing import LARGEST_FILE, LARGEST_TEXT, damaged
from gearplay.files.record import Record
from gearplay.vocabulary.errors import Fault, InputError, ResourceError, shorten, show_value

Reader = Callable[[Request], Record]

READERS: Final = {
    "csv": "csv_file",
    "uff": "uff",
    "tdms": "tdms",
    "mdf4": "mdf4",
    "wav": "wav",
    "mat": "mat",
    "hdf5": "hdf5",
    "netcdf": "hdf5",
}
"""Module of each kind of file, loaded when it is needed."""


def read_measurement(
    path: str | PathLike[str],
    *,
    channels: str | Sequence[str] | None = None,
    sampling: float | None = None,
    format: str | None = None,
    calibration: Mapping[str, tuple[float, str]] | None = None,
) -> Record:
    """Read a measured record: CSV, UFF 58, TDMS, MDF 4, WAV, MAT, HDF5 or netCDF.

    The kind is recognised by the content first, by the extension second. What a file declares is compared with what
    it holds before anything of that size is allocated; docs/measurements.md says what is found and what cannot be.

    Parameters
    ----------
    path
        The file, at most 4 GiB, text at most 512 MiB.
    channels
        Names of the channels to read, in that order; without it all that are evenly sampled numbers.
    sampling
        Sampling rate [Hz] for files that do not state it; must agree with those that do.
    format
        One of `FORMATS` where the content and the extension mislead.
    calibration
        Channel name -> (factor, unit): the samples are multiplied and get this unit. A WAV file's integers are
        first scaled to +-1.

    Returns
    -------
    Record
        Its channels with unit and sampling rate [Hz].

    Raises
    ------
    MeasurementError
        Where the file is cut, damaged, unevenly sampled, too large or not of a known kind.
    InputError
        Where there is no such file or channel, the sampling rate is missing or contradicts the file, or a package
        is not installed.
    ResourceError
        Where the memory does not suffice.

    Examples
    --------
    >>> import tempfile, numpy as np
    >>> from gearplay.files.record import Channel
    >>> place = tempfile.mkdtemp() + "/run.csv"
    >>> Record((Channel("acc", np.sin(np.arange(100.0)), 1000.0, "m/s^2"),)).save(place)
    >>> read_measurement(place).channel("acc").sampling
    1000.0

    """
    place = Path(path)
    chosen = _check_words(place, channels, sampling, format)
    size, head = _opened(place)
    kind = format or recognise(place, head)
    if kind == "csv" and size > LARGEST_TEXT:
        raise damaged(
            place, f"is a text file of {size} bytes; at most 512 MiB are read", "Split it, or give it as HDF5"
        )
    module = import_module(f"gearplay.files.measurements.{READERS[kind]}")
    read = cast("Reader", module.read)
    try:
        record = read(Request(place, size, chosen, sampling))
    except OSError as error:  # the disk, or the file went away
        raise _unreadable(place, error) from None
    except MemoryError:
        raise ResourceError(
            f"{shorten(place.name)}: needs more memory than there is. Choose fewer channels."
        ) from None
    return _calibrated(record, calibration or {})


def _check_words(
    path: Path, channels: str | Sequence[str] | None, sampling: float | None, format: str | None
) -> tuple[str, ...] | None:
    faults = []
    if sampling is not None and not (isfinite(sampling) and sampling > 0.0):
        faults.append(Fault("sampling", sampling, "must be a positive rate in Hz"))
    if format is not None and format not in FORMATS:
        faults.append(Fault("format", format, f"must be one of {', '.join(FORMATS)}"))
    chosen = (channels,) if isinstance(channels, str) else None if channels is None else tuple(channels)
    if chosen is not None and (not chosen or len(set(chosen)) != len(chosen)):
        faults.append(Fault("channels", channels, "must name at least one channel, and each once"))
    if "\0" in str(path):
        faults.append(Fault("file", str(path), "must be a path without a zero byte"))
    if faults:
        raise InputError(faults)
    return chosen


def _opened(path: Path) -> tuple[int, bytes]:
    """Return the size [bytes] and the first bytes of a regular file; a pipe is refused without waiting."""
    try:
        status = path.stat()
        regular, size = stat.S_ISREG(status.st_mode), status.st_size
        head = b""
        if regular:
            with path.open("rb") as file:
                head = file.read(HEAD)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        fault = Fault(
            "file", shown_path(path), f"must be a file that can be read ({reason})", "Check the path"
        )
        raise InputError([fault]) from None
    if not regular:
        what = "folder" if stat.S_ISDIR(status.st_mode) else "device or pipe"
        raise InputError([Fault("file", str(path), f"must be a regular file, not a {what}", "Name a file")])
    if size == 0:
        raise damaged(path, "is empty (0 bytes)")
    if size > LARGEST_FILE:
        raise damaged(
            path, f"is {size / 2**30:.1f} GiB large; at most 4 GiB are read", "Split it, or export part of it"
        )
    return size, head


def _unreadable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    return InputError(
        [Fault("file", str(path), f"must be a file that can be read ({reason})", "Check the path")]
    )


def _calibrated(record: Record, calibration: Mapping[str, tuple[float, str]]) -> Record:
    faults = [
        Fault(
            "calibration", name, "must be a channel that is read", f"Channels: {', '.join(record.names[:12])}"
        )
        for name in calibration
        if name not in record.names
    ]
    faults += [
        Fault("calibration", name, f"must have a finite factor, {show_value(factor)} found")
        for name, (factor, _) in calibration.items()
        if not isfinite(factor)
    ]
    if faults:
        raise InputError(faults)
    channels = [
        replace(
            channel, values=channel.values * calibration[channel.name][0], unit=calibration[channel.name][1]
        )
        if channel.name in calibration
        else channel
        for channel in record.channels
    ]
    return replace(record, channels=tuple(channels))
