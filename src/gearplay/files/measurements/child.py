"""Reading of one measurement file in the process that `gearplay.files.sandbox` runs."""

import contextlib
import warnings
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any

from gearplay.files.measurements.building import Request
from gearplay.files.measurements.formats import FORMATS
from gearplay.files.record import Channel, Record


def load(question: dict[str, Any]) -> None:
    """Import the libraries for a kind of file."""
    import_module(f"gearplay.files.measurements.{FORMATS[question['kind']].module}")
    with contextlib.suppress(ImportError), warnings.catch_warnings():  # reading reports which is missing
        warnings.simplefilter("ignore")
        import_module(FORMATS[question["kind"]].package)


def read(request: Request, kind: str) -> Record:
    """Read a file by the module of its kind."""
    record: Record = import_module(f"gearplay.files.measurements.{FORMATS[kind].module}").read(request)
    return record


def answer(question: dict[str, Any]) -> tuple[dict[str, Any], Iterable[memoryview]]:
    """Return the description of a record and the samples of its channels as float64; raises as reading does."""
    chosen = question["channels"]
    request = Request(
        Path(question["path"]),
        question["size"],
        None if chosen is None else tuple(chosen),
        question["sampling"],
    )
    record = read(request, question["kind"])
    said = {
        "source": record.source,
        "format": record.format,
        "attributes": dict(record.attributes),
        "channels": [_described(channel) for channel in record.channels],
    }
    return said, (channel.values.data for channel in record.channels)


def _described(channel: Channel) -> dict[str, Any]:
    return {
        "name": channel.name,
        "size": channel.values.size,
        "sampling": channel.sampling,
        "unit": channel.unit,
        "start": channel.start,
        "attributes": dict(channel.attributes),
    }
