"""The process that reads HDF5 files for `hdf5`: questions on the standard input, answers on the standard output."""

import json
import os
import sys
from pathlib import Path
from typing import IO, Any

from gearplay.output.measurements.building import Request
from gearplay.output.measurements.hdf5_vectors import read
from gearplay.study.signals.record import Channel, Record
from gearplay.vocabulary.errors import NO_VALUE, InputError, MeasurementError


def _asked(line: bytes) -> tuple[Request, str]:
    said = json.loads(line)
    chosen = said["channels"]
    path = Path(said["path"])
    return Request(path, said["size"], None if chosen is None else tuple(chosen), said["sampling"]), said[
        "kind"
    ]


def _described(channel: Channel) -> dict[str, Any]:
    return {
        "name": channel.name,
        "size": channel.values.size,
        "sampling": channel.sampling,
        "unit": channel.unit,
        "start": channel.start,
        "attributes": dict(channel.attributes),
    }


def answer(line: bytes, pipe: IO[bytes]) -> None:
    """Answer one question: a line that describes the record and its samples, or a line that says why not."""
    try:
        request, kind = _asked(line)
        record: Record | None = read(request, kind=kind)
        said: dict[str, Any] = {}
    except MeasurementError as error:
        record, said = None, {"refused": str(error)}
    except InputError as error:
        faults = [(f.path, f.value, True, f.rule, f.cure) for f in error.faults if f.value is not NO_VALUE]
        faults += [(f.path, None, False, f.rule, f.cure) for f in error.faults if f.value is NO_VALUE]
        record, said = None, {"faults": faults}
    if record is not None:
        said = {
            "source": record.source,
            "format": record.format,
            "attributes": dict(record.attributes),
            "channels": [_described(channel) for channel in record.channels],
        }
    pipe.write(json.dumps(said).encode() + b"\n")
    for channel in record.channels if record is not None else ():
        pipe.write(channel.values.data)
    pipe.flush()


def serve() -> None:
    """Answer questions until there are no more."""
    with os.fdopen(os.dup(1), "wb") as pipe:
        os.dup2(2, 1)  # what a library prints must not reach the answers
        pipe.write(b"ready\n")
        pipe.flush()
        for line in sys.stdin.buffer:
            answer(line, pipe)
