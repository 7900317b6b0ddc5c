"""MAT: vectors or our own structure out of version 5; version 7.3 is HDF5."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements import hdf5
from gearplay.files.measurements.building import (
    Request,
    distinct,
    even_sampling,
    is_time,
    make_channel,
    make_record,
    stated_rate,
)
from gearplay.files.measurements.mat_elements import Variable, read_variables
from gearplay.files.measurements.recognise import HDF5_MARK
from gearplay.files.measurements.refusing import damaged
from gearplay.files.record import Channel, Record

RECORD: Final = "record"
"""Name of the structure array that `write_record` writes: name, unit, sampling, start, values of each channel."""

_FIELDS: Final = (("unit", str), ("sampling", np.ndarray), ("start", np.ndarray), ("values", np.ndarray))
_HDF5_AT: Final = 512


def read(request: Request) -> Record:
    """Read a MAT file: the structure that `write_record` writes, or vectors with a time vector or a rate ``fs``.

    A vector called time or t gives the sampling rate of the vectors as long as it; else a scalar called fs,
    sampling_rate, dt ... or the caller does. Raises `MeasurementError` where the file is cut or damaged; the
    checksums of packed variables tell damaged samples too.
    """
    path = request.path
    with path.open("rb") as file:
        file.seek(_HDF5_AT)
        if file.read(len(HDF5_MARK)) == HDF5_MARK:
            return hdf5.read(request, kind="mat")
    content = path.read_bytes()
    if content.startswith(HDF5_MARK):
        return hdf5.read(request, kind="mat")
    variables = {variable.name: variable.value for variable in read_variables(path, content)}
    ours = variables.get(RECORD)
    if isinstance(ours, list):
        return _from_structure(request, ours)
    return read_vectors(request, variables)


def _from_structure(request: Request, rows: list[dict[str, Variable]]) -> Record:
    """Return the record of a structure array whose rows are channels."""
    names = distinct([str(_field(request, row, "name", str)) for row in rows])
    channels: list[Channel] = []
    for k in request.select(names):
        row = rows[k]
        unit, sampling, start, values = (_field(request, row, name, kind) for name, kind in _FIELDS)
        channels.append(
            make_channel(
                request,
                names[k],
                values.ravel(),
                sampling=float(sampling.ravel()[0]),
                unit=unit,
                start=float(start.ravel()[0]),
            )
        )
    return make_record(request, channels, "mat")


def _field(request: Request, row: dict[str, Variable], name: str, kind: type) -> Any:
    value = row[name].value if name in row else None
    if kind is str and isinstance(value, np.ndarray) and not value.size:
        return ""  # an empty text is saved as no numbers
    if not isinstance(value, kind) or (isinstance(value, np.ndarray) and not value.size):
        raise damaged(
            request.path,
            f"the structure '{RECORD}' must have the field '{name}' in every row",
            "Write it again",
        )
    return value


def read_vectors(request: Request, variables: Mapping[str, object]) -> Record:
    """Return the record of named vectors, of which one may be the time [s]; a scalar may be the rate or the step.

    Parameters
    ----------
    request
        What the caller asked for.
    variables
        Name -> value; vectors of real numbers, of shape [1, time] or [time, 1], are channels.

    """
    vectors: dict[str, NDArray[Any]] = {}
    rate: float | None = None
    for name, value in variables.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiub":
            continue
        if value.size == 1:
            stated = stated_rate(name, float(value.ravel()[0]))
            rate = rate if stated is None else stated
        elif value.size and max(value.shape) == value.size:
            vectors[name] = value.ravel()
    times = {name: vector for name, vector in vectors.items() if is_time(name, "")}
    names = [name for name in vectors if name not in times]
    channels: list[Channel] = []
    for name in (names[k] for k in request.select(names)):
        stated, start = rate, 0.0
        for axis, time in times.items():
            if time.size == vectors[name].size:
                stated, start = even_sampling(request.path, time.astype(np.float64), column=axis)
        channels.append(make_channel(request, name, vectors[name], sampling=stated, start=start))
    return make_record(request, channels, "mat")
