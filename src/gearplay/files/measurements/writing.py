"""Records into files: HDF5 and netCDF with checksums, and CSV, WAV, UFF 58 and MAT for other programs."""

import csv
import io
import json
import re
import struct
from collections.abc import Callable
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np

from gearplay.files.atomic import check_new, write_with
from gearplay.files.measurements.formats import FORMATS
from gearplay.files.measurements.hdf5 import OURS, checksum
from gearplay.files.measurements.mat import RECORD
from gearplay.files.measurements.refusing import need
from gearplay.files.measurements.wav import NAMES_CHUNK
from gearplay.files.record import Channel, Record
from gearplay.files.tables import mat_bytes
from gearplay.vocabulary.errors import InputError

_PACKED_FROM: Final = 1000


def write_record(record: Record, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write a record in the format of the extension: HDF5, netCDF, CSV, WAV, UFF 58 or MAT.

    The file is written atomically. HDF5 and netCDF keep everything and carry a SHA-256 of each channel; CSV and
    WAV need channels of one length, rate and start; UFF keeps 80 letters of a name, 20 of a unit, 13
    digits of a sample and 6 of the sampling step. The same record gives the same bytes at any hour.

    Parameters
    ----------
    record
        Channels to write.
    path
        The file, with one of the extensions of `FORMATS`.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        Where the extension is unknown or cannot be written, the file exists, or the record does not fit the kind.

    Examples
    --------
    >>> import tempfile
    >>> place = tempfile.mkdtemp() + "/run.h5"
    >>> write_record(Record((Channel("acc", np.zeros(100), 1000.0, "m/s^2"),)), place)
    >>> Path(place).exists()
    True

    """
    place = Path(path)
    kind = check_record_path(place, overwrite=overwrite)
    if not record.channels:
        raise InputError.of("record", "no channels", "must hold at least one channel")
    write_with(place, lambda temporary: _WRITERS[kind](record, temporary), overwrite=overwrite)


def check_record_path(path: Path, *, overwrite: bool = False) -> str:
    """Return the format of a record by its path, checked before the computation; raises as `write_record`."""
    kind = next((kind for kind, known in FORMATS.items() if path.suffix.lower() in known.suffixes), "")
    if kind not in _WRITERS:
        known = ", ".join(FORMATS[kind].suffixes[0] for kind in _WRITERS)
        raise InputError.of("out", path.name, f"must end in one of {known}", "Choose another extension")
    check_new(path, overwrite=overwrite)
    return kind


def _common(record: Record) -> tuple[int, float, float]:
    """Return length, rate [Hz] and start [s] that all channels share."""
    shared = {(channel.values.size, channel.sampling, channel.start) for channel in record.channels}
    if len(shared) > 1:
        rule = "must have channels of one length, sampling rate and start for this kind of file"
        shown = f"{len(record.channels)} channels"
        raise InputError.of("record", shown, rule, "Write it as HDF5 or netCDF")
    return shared.pop()


def _labels(record: Record) -> list[str]:
    """Return a name for each channel that is a plain word, as HDF5 and netCDF require."""
    labels: list[str] = []
    for place, channel in enumerate(record.channels, start=1):
        word = re.sub(r"\W+", "_", channel.name, flags=re.ASCII).strip("_") or f"channel_{place}"
        if not word[0].isalpha() or word.startswith("time"):  # which is the axis
            word = f"channel_{word}"
        labels.append(f"{word}_{place}" if word in labels else word)
    return labels


def _attributes(channel: Channel) -> dict[str, Any]:
    return {
        "long_name": channel.name,
        "units": channel.unit,
        "sampling": channel.sampling,
        "start": channel.start,
        "sha256": checksum(channel.values),
        "attributes": json.dumps(dict(channel.attributes)),
    }


def _packing(channel: Channel) -> dict[str, Any]:
    if channel.values.size < _PACKED_FROM:
        return {}
    return {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}


def _root(record: Record) -> dict[str, Any]:
    return {
        OURS: len(record.channels),
        "source": record.source,
        "attributes": json.dumps(dict(record.attributes)),
    }


def _write_hdf5(record: Record, path: Path) -> None:
    import h5py

    made = BytesIO()  # on a disk that is full HDF5 brings the process down
    # from 1.10 on, the library keeps checksums of the file's own structure
    with h5py.File(made, "w", libver=("v110", "v110"), track_order=True) as file:
        file.attrs.update(_root(record))
        for label, channel in zip(_labels(record), record.channels, strict=True):
            dataset = file.create_dataset(label, data=channel.values, **_packing(channel))
            dataset.attrs.update(_attributes(channel))
    path.write_bytes(made.getbuffer())


def _write_netcdf(record: Record, path: Path) -> None:
    import h5netcdf

    made = BytesIO()
    with h5netcdf.File(made, "w") as file:
        file.attrs.update(_root(record))
        axes: dict[tuple[int, float, float], str] = {}
        for label, channel in zip(_labels(record), record.channels, strict=True):
            key = (channel.values.size, channel.sampling, channel.start)
            if key not in axes:
                axes[key] = "time" if not axes else f"time_{len(axes) + 1}"
                file.dimensions[axes[key]] = channel.values.size
                axis = file.create_variable(axes[key], (axes[key],), np.float64, data=channel.time)
                axis.attrs["units"] = "s"
            variable = file.create_variable(
                label, (axes[key],), np.float64, data=channel.values, **_packing(channel)
            )
            variable.attrs.update(_attributes(channel))
    path.write_bytes(made.getbuffer())


def _write_csv(record: Record, path: Path) -> None:
    length, sampling, start = _common(record)
    text = io.StringIO()
    text.write(f"# sampling = {sampling!r}\n# start = {start!r}\n# rows = {length}\n")
    heads = [
        " ".join(channel.name.split()) + (f" [{channel.unit}]" if channel.unit else "")
        for channel in record.channels
    ]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time [s]", *heads])
    table = np.column_stack([record.channels[0].time, *(channel.values for channel in record.channels)])
    for row in table.tolist():
        writer.writerow([repr(value) for value in row])
    path.write_text(text.getvalue(), encoding="utf-8", newline="")


def _write_wav(record: Record, path: Path) -> None:
    length, sampling, start = _common(record)
    rate, count = round(sampling), len(record.channels)
    if rate != sampling or rate >= 2**32 or count >= 2**16 or length * count * 8 > 2**32 - 2**20:
        rule = "must have a sampling rate in whole hertz and less than 4 GiB of samples for a WAV file"
        raise InputError.of("record", sampling, rule, "Write it as HDF5")
    about = {"names": record.names, "units": [channel.unit for channel in record.channels], "start": start}
    samples = np.column_stack([channel.values for channel in record.channels]).astype("<f8").tobytes()
    frame = 8 * count
    chunks = {
        b"fmt ": struct.pack("<HHIIHH", 3, count, rate, rate * frame, frame, 64),
        b"fact": struct.pack("<I", length),
        NAMES_CHUNK: json.dumps(about).encode(),
        b"data": samples,
    }
    body = b"".join(name + struct.pack("<I", len(c)) + c + b"\0" * (len(c) % 2) for name, c in chunks.items())
    path.write_bytes(b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WAVE" + body)


def _check_several(channel: Channel, kind: str) -> None:
    if channel.values.size < 2:
        raise InputError.of("record", channel.name, f"must have 2 samples or more for a {kind} file")


def _write_uff(record: Record, path: Path) -> None:
    pyuff = need("pyuff", "pyuff", path)
    sets = []
    for place, channel in enumerate(record.channels, start=1):
        _check_several(channel, "UFF")
        sets.append(
            {
                "type": 58,
                "binary": 0,
                "func_type": 1,
                "abscissa_spacing": 1,
                "abscissa_spec_data_type": 17,
                "rsp_node": place,
                "rsp_dir": 0,
                "ref_node": 0,
                "ref_dir": 0,
                "ordinate_spec_data_type": 1,
                "orddenom_spec_data_type": 0,
                "abscissa_axis_lab": "time",
                "abscissa_axis_units_lab": "s",
                "ordinate_axis_units_lab": channel.unit[:20] or "NONE",
                "x": channel.start + np.arange(2) / channel.sampling,
                "data": channel.values,
                "id1": channel.name[:80] or "NONE",
                "id5": f"channel {place} of {len(record.channels)}",
            }
        )
    # as text, added to the empty file that waits there: binary data it writes over their own header, or leaves open
    pyuff.UFF(str(path)).write_sets(sets, mode="add")


def _write_mat(record: Record, path: Path) -> None:
    fields = [(name, object) for name in ("name", "unit", "sampling", "start", "values")]
    rows = np.empty((1, len(record.channels)), dtype=fields)
    for place, channel in enumerate(record.channels):
        _check_several(channel, "MAT")
        rows[0, place] = (channel.name, channel.unit, channel.sampling, channel.start, channel.values)
    path.write_bytes(mat_bytes({RECORD: rows}))


_WRITERS: Final[dict[str, Callable[[Record, Path], None]]] = {
    "hdf5": _write_hdf5,
    "netcdf": _write_netcdf,
    "csv": _write_csv,
    "wav": _write_wav,
    "uff": _write_uff,
    "mat": _write_mat,
}
