"""MDF 4 files by asammdf: raw values, with plain conversions done here.

Formula conversions are left out: the library hands their text to an expression evaluator.
"""

import struct
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.rates import even_sampling
from gearplay.files.measurements.refusing import (
    MOST_NODES,
    Complaints,
    check_samples,
    damaged,
    fenced,
    need,
    quoted,
)
from gearplay.files.record import Record
from gearplay.vocabulary.errors import shorten

_FIXED_LENGTH: Final = 0
_NUMBERS: Final = range(6)
_AS_IT_IS, _LINEAR, _RATIONAL = 0, 1, 2
_IDENTIFICATION, _BLOCK = 64, 24


def _check_identification(path: Path) -> None:
    """Raise `MeasurementError` where the file is of another version, or its recorder did not finalise it."""
    with path.open("rb") as file:
        head = file.read(_IDENTIFICATION)
    if len(head) < _IDENTIFICATION:
        raise damaged(path, f"must begin with an identification of 64 bytes, {len(head)} found")
    version = head[8:16].decode("latin-1").strip(" \0")
    if head[:8] == b"UnFinMF " or any(struct.unpack("<HH", head[60:64])):
        raise damaged(path, "was never finalised by its recorder", "Finalise it with the recorder's program")
    if head[:8] != b"MDF     " or not version.startswith("4."):
        raise damaged(path, f"must be MDF 4, version {quoted(version)} found", "Convert it to MDF 4")


def _conversion_kind(channel: Any) -> int:
    return _AS_IT_IS if channel.conversion is None else int(channel.conversion.conversion_type)


def _is_signal(channel: Any, group: Any, index: int) -> bool:
    return (
        channel.channel_type == _FIXED_LENGTH
        and channel.data_type in _NUMBERS
        and not group.channel_dependencies[index]
        and _conversion_kind(channel) in (_AS_IT_IS, _LINEAR, _RATIONAL)
    )


def _converted(raw: NDArray[Any], channel: Any) -> NDArray[Any]:
    """Return physical values: as they are, ``a x + b``, or the quotient of two quadratics."""
    kind, rule = _conversion_kind(channel), channel.conversion
    if kind == _AS_IT_IS:
        return raw
    x = raw.astype(np.float64)
    if kind == _LINEAR:
        return np.asarray(rule.a * x + rule.b)
    return np.asarray((rule.P1 * x * x + rule.P2 * x + rule.P3) / (rule.P4 * x * x + rule.P5 * x + rule.P6))


def _held(file: IO[bytes], place: int) -> int | None:
    """Return the number of record bytes in the data block at ``place`` and those it lists; None for column storage.

    A block has a name, its length, the number of its links and these (ASAM MDF 4.1); DZ blocks state their length unpacked.
    """
    file.seek(place)
    name, length, links = struct.unpack("<4s4xQQ", file.read(_BLOCK))
    following = struct.unpack(f"<{links}Q", file.read(8 * links)) if links <= MOST_NODES else ()
    if name in (b"##DT", b"##DV"):
        return int(length) - _BLOCK
    if name == b"##DZ":
        return int(struct.unpack("<8xQ8x", file.read(24))[0])
    held = [_held(file, link) for link in following if link] if name in (b"##DL", b"##HL") else [None]
    return None if None in held else sum(each or 0 for each in held)


def _check_records(path: Path, stream: IO[bytes], group: Any) -> None:
    """Compare the bytes of a group's records with its cycles: the library reads no more than these."""
    about, place = group.channel_group, group.data_group.data_block_addr
    held = _held(stream, place) if group.sorted and place else None
    width = group.data_group.record_id_len + about.samples_byte_nr + about.invalidation_bytes_nr
    declared = about.cycles_nr * width
    if held is not None and held != declared:
        raise damaged(path, f"declares {declared} bytes of records and holds {held}")


def _load(request: Request, file: Any, group: int, index: int) -> Samples:
    block = file.groups[group]
    cycles = int(block.channel_group.cycles_nr)
    check_samples(request.path, cycles)
    signal = file.get(group=group, index=index, raw=True, ignore_invalidation_bits=False)
    raw, channel = np.asarray(signal.samples), block.channels[index]
    name = f"channel {quoted(str(channel.name))}"
    if raw.size < cycles and block.channel_group.invalidation_bytes_nr:  # which the library leaves out
        rule = f"{name} marks {cycles - raw.size} of {cycles} samples as invalid"
        raise damaged(request.path, rule, "Choose other channels, or cut the record there")
    if raw.size != cycles:
        raise damaged(request.path, f"{name} declares {cycles} samples and holds {raw.size}")
    declared, start = [], 0.0
    if file.masters_db.get(group) is not None:
        rate, start = even_sampling(request.path, np.asarray(signal.timestamps, dtype=np.float64))
        declared = [("its time", rate)]
    about = {
        "group": getattr(block.channel_group, "acq_name", "") or "",
        "comment": channel.comment or "",
        "source": getattr(channel.source, "name", "") or "",
    }
    unit = str(channel.unit or "") or str(getattr(channel.conversion, "unit", "") or "")
    return Samples(_converted(raw, channel), declared, unit, start, about)


def read(request: Request) -> Record:
    """Read an MDF 4 file: channels of numbers with no, a linear or a rational conversion.

    Raises `MeasurementError` where the file was never finalised, fewer samples are read than declared, samples are marked
    invalid or the time is uneven.
    """
    path = request.path
    _check_identification(path)
    asammdf = need("asammdf", "asammdf", path)
    complaints = Complaints("asammdf")
    with fenced(path, "MDF 4"), path.open("rb") as stream:
        file = asammdf.MDF(stream, process_bus_logging=False)
        try:
            places, left_out = [], []
            for number, group in enumerate(file.groups):
                _check_records(path, stream, group)
                for index, channel in enumerate(group.channels):
                    if _is_signal(channel, group, index):
                        places.append((number, index))
                    elif channel.channel_type == _FIXED_LENGTH:
                        left_out.append(str(channel.name))
            comment = str(file.header.comment or "")
            about = {"start": str(file.start_time), "comment": "" if comment.startswith("<") else comment}
            if left_out:
                about["left out"] = shorten(", ".join(left_out), 900)
            names = [str(file.groups[group].channels[index].name) for group, index in places]
            record = make_record(
                request, names, lambda k: _load(request, file, *places[k]), about, found=left_out
            )
        finally:
            file.close()
        complaints.refuse(path, "MDF 4")
    return record
