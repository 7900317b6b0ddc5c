"""Measurements whose libraries crash or hang on damaged files: read in a process of its own."""

from dataclasses import asdict
from functools import partial
from types import MappingProxyType
from typing import IO, Any, Final

import numpy as np

from gearplay.files.apart import PACE, PATIENCE, Reader
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.refusing import check_samples, damaged
from gearplay.files.record import Channel, Record

_READER: Final = Reader("from gearplay.files.measurements.apart_child import main; main()")
"""Its answer's bytes are the samples of all channels as float64."""


def _answer(request: Request, said: dict[str, Any], pipe: IO[bytes]) -> Record:
    """Return the record that the process answers, `EOFError` where it ends."""
    check_samples(request.path, sum(channel["size"] for channel in said["channels"]))
    channels = [_channel(channel, pipe) for channel in said["channels"]]
    return Record(tuple(channels), said["source"], said["format"], MappingProxyType(said["attributes"]))


def _channel(said: dict[str, Any], pipe: IO[bytes]) -> Channel:
    values = np.empty(said.pop("size"))
    attributes = MappingProxyType(said.pop("attributes"))
    view = values.data.cast("B")
    while len(view):
        count = pipe.readinto(view)  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        view = view[count:]
    return Channel(values=values, attributes=attributes, **said)


def read_apart(request: Request, reader: str, library: str) -> Record:
    """Read a file in the other process.

    Parameters
    ----------
    request
        What the caller asked for.
    reader
        ``hdf5``, ``mat`` or ``mdf4``.
    library
        What reads there, for the sentence.

    Raises
    ------
    MeasurementError, InputError
        What reading raises; or where the process crashes, or takes longer than `PATIENCE` and `PACE` allow.

    """
    question = asdict(request) | {"path": str(request.path.absolute()), "reader": reader}
    record = _READER.ask(question, partial(_answer, request), PATIENCE + request.size / PACE)
    if record is None:
        raise damaged(request.path, f"{library} crashes on it or does not return")
    return record
