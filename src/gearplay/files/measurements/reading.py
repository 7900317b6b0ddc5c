"""`read_measurement`: one function reads every kind of measurement file into a record."""

import contextlib
import stat
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import shown_path
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.formats import FORMATS, HEAD, recognise
from gearplay.files.measurements.refusing import LARGEST_FILE, LARGEST_TEXT, check_samples, damaged
from gearplay.files.record import Channel, Record
from gearplay.files.sandbox import READER, SandboxError
from gearplay.vocabulary.errors import Fault, InputError, ResourceError, shorten, show_value
from gearplay.vocabulary.suggestions import listed


def read_measurement(
    path: str | PathLike[str],
    *,
    channels: str | Sequence[str] | None = None,
    sampling: float | None = None,
    format: str | None = None,
    calibration: Mapping[str, tuple[float, str]] | None = None,
    units: Mapping[str, str] | None = None,
) -> Record:
    """Read a measured record: CSV, UFF 58, TDMS, MDF 4, WAV, MAT, HDF5 or netCDF.

    The kind is recognised by the content first, by the extension second. All but text is read in a process of its own, with
    limits of time and memory; docs/measurements.md says what damage is detected and what cannot be.

    Parameters
    ----------
    path
        The file, at most 4 GiB, text at most 512 MiB.
    channels
        Names of the channels to read, in that order; without it all that are evenly sampled numbers.
    sampling
        Sampling rate [Hz] for files that do not state it, or state two; must agree with one that is stated.
    format
        One of `FORMATS` where the content and the extension mislead.
    calibration
        Channel name -> (factor, unit): the samples are multiplied and get this unit. A WAV file's integers are
        first scaled to +-1.
    units
        Channel name -> unit, where the file does not state it or states a wrong one; samples stay as they are.

    Returns
    -------
    Record
        Its channels with unit and sampling rate [Hz].

    Raises
    ------
    MeasurementError
        Where the file is cut, damaged, unevenly sampled, too large or not of a known kind, states two sampling rates that
        contradict each other, or its library crashes, hangs or needs too much memory.
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
        rule = f"is a text file of {size} bytes; at most 512 MiB are read"
        raise damaged(place, rule, "Split it, or give it as HDF5")
    request = Request(place.absolute(), size, chosen, sampling, kind)
    try:
        record = read(request) if kind == "csv" else _record_of(*READER.read(__name__, request))
    except SandboxError as reason:
        raise damaged(place, f"{FORMATS[kind].library} {reason}") from None
    except OSError as error:  # the disk, or the file went away
        raise _unreadable(place, error) from None
    except MemoryError:
        rule = "needs more memory than there is. Choose fewer channels."
        raise ResourceError(f"{shorten(place.name)}: {rule}") from None
    scaled = {name: (1.0, unit) for name, unit in (units or {}).items()}
    return _calibrated(record, scaled | dict(calibration or {}), "calibration" if calibration else "units")


def load(request: Request) -> None:
    """Import the libraries for a kind of file; in the child process."""
    import_module(f"gearplay.files.measurements.{FORMATS[request.kind].module}")
    with contextlib.suppress(ImportError), warnings.catch_warnings():  # reading reports which is missing
        warnings.simplefilter("ignore")
        import_module(FORMATS[request.kind].package)


def send(request: Request) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Return the record of a file as a description in JSON and the samples of its channels; in the child process."""
    record = read(request)
    fields = ("name", "sampling", "unit", "start")
    channels = [
        {each: getattr(channel, each) for each in fields} | {"attributes": dict(channel.attributes)}
        for channel in record.channels
    ]
    whole = {"source": record.source, "format": record.format, "attributes": dict(record.attributes)}
    return whole | {"channels": channels}, [channel.values for channel in record.channels]


def _record_of(whole: dict[str, Any], samples: list[bytearray]) -> Record:
    """Return the record that `send` describes."""
    channels = [
        Channel(values=np.frombuffer(values), **fields)
        for values, fields in zip(samples, whole.pop("channels"), strict=True)
    ]
    return Record(tuple(channels), **whole)


def read(request: Request) -> Record:
    """Read a file by the module of its kind; in the child process, but for text."""
    module = import_module(f"gearplay.files.measurements.{FORMATS[request.kind].module}")
    record: Record = module.read(request)
    check_samples(request.path, sum(channel.values.size for channel in record.channels))
    return record


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
        raise _unreadable(path, error) from None
    if not regular:
        what = "folder" if stat.S_ISDIR(status.st_mode) else "device or pipe"
        raise InputError.of("file", str(path), f"must be a regular file, not a {what}", "Name a file")
    if size == 0:
        raise damaged(path, "is empty (0 bytes)")
    if size > LARGEST_FILE:
        rule = f"is {size / 2**30:.1f} GiB large; at most 4 GiB are read"
        raise damaged(path, rule, "Split it, or export part of it")
    return size, head


def _unreadable(path: Path, error: Exception) -> InputError:
    rule = f"must be a file that can be read ({getattr(error, 'strerror', None) or error})"
    return InputError.of("file", shown_path(path), rule, "Check the path")


def _calibrated(record: Record, calibration: Mapping[str, tuple[float, str]], argument: str) -> Record:
    shown = listed(record.names)
    faults = []
    for name, (factor, _) in calibration.items():
        if name not in record.names:
            faults.append(Fault(argument, name, "must be a channel that is read", f"Channels: {shown}"))
        if not isfinite(factor):
            faults.append(
                Fault("calibration", name, f"must have a finite factor, {show_value(factor)} found")
            )
    if faults:
        raise InputError(faults)
    channels = []
    for channel in record.channels:
        factor, unit = calibration.get(channel.name, (1.0, channel.unit))
        channels.append(replace(channel, values=channel.values * factor, unit=unit))
    return replace(record, channels=tuple(channels))
