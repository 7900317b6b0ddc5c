"""The process that reads files for `apart`: questions on the standard input, answers on the standard output."""

import json
from pathlib import Path
from typing import IO, Any

from gearplay.files.apart import refusal_said, serve
from gearplay.files.measurements import hdf5_vectors, mdf4_signals
from gearplay.files.measurements.building import Request
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import InputError, MeasurementError


def _read(line: bytes) -> Record:
    said = json.loads(line)
    chosen = said["channels"]
    request = Request(
        Path(said["path"]), said["size"], None if chosen is None else tuple(chosen), said["sampling"]
    )
    if said["reader"] == "mdf4":
        return mdf4_signals.read(request)
    return hdf5_vectors.read(request, kind="mat" if said["reader"] == "mat" else "")


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
        record: Record | None = _read(line)
        said: dict[str, Any] = {}
    except (MeasurementError, InputError) as error:
        record, said = None, refusal_said(error)
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


def main() -> None:
    """Answer questions until there are no more."""
    serve(answer)
