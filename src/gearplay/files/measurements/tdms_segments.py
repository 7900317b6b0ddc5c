"""The segments of a TDMS file, walked from lead-in to lead-in: what they declare and what the file holds.

A segment is a lead-in of 28 bytes (tag, contents, version, offset of the next segment, offset of the raw data), the
description of its objects, and chunks of raw data. NI, "TDMS File Format Internal Structure".
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from typing import Final

from gearplay.files.measurements.refusing import MOST_NODES, damaged, quoted

LEAD_IN: Final = 28
UNKNOWN: Final = 0xFFFFFFFFFFFFFFFF
"""Offset of the next segment while a segment is being written."""

META, NEW_LIST, RAW, INTERLEAVED, BIG_ENDIAN, DAQMX = 1 << 1, 1 << 2, 1 << 3, 1 << 5, 1 << 6, 1 << 7
_CONTENTS: Final = META | NEW_LIST | RAW | INTERLEAVED | BIG_ENDIAN | DAQMX
_SIZES: Final = {
    1: 1, 2: 2, 3: 4, 4: 8, 5: 1, 6: 2, 7: 4, 8: 8, 9: 4, 10: 8, 0x19: 4, 0x1A: 8, 0x21: 1, 0x44: 16,
    0x08000C: 8, 0x10000D: 16,
}  # fmt: skip
_STRING: Final = 0x20
_NO_DATA, _AS_BEFORE = 0xFFFFFFFF, 0
_DAQMX_INDEX: Final = (0x00001269, 0x00001369)


@dataclass
class Declared:
    """What the segments declare: samples of each object, by path; ``countable`` is false with DAQmx raw data."""

    samples: dict[str, int] = field(default_factory=dict)
    countable: bool = True


@dataclass
class _Index:
    """Samples and bytes that an object has in each chunk."""

    count: int
    bytes: int


class _Bounded:
    """Reads the description of one segment and never past its end."""

    def __init__(self, path: Path, content: bytes, order: str, number: int) -> None:
        self.path, self.content, self.order, self.number, self.place = path, content, order, number, 0

    def take(self, length: int) -> bytes:
        if self.place + length > len(self.content):
            rule = f"the description of segment {self.number} needs {length} bytes more than its {len(self.content)}"
            raise damaged(self.path, rule)
        self.place += length
        return self.content[self.place - length : self.place]

    def integer(self, code: str = "I") -> int:
        return int(struct.unpack(self.order + code, self.take(struct.calcsize(self.order + code)))[0])

    def text(self) -> str:
        return self.take(self.integer()).decode("utf-8", errors="replace")


def walk(path: Path, size: int) -> Declared:
    """Walk all segments and return the samples they declare.

    Parameters
    ----------
    path
        The file.
    size
        Its size [bytes].

    Raises
    ------
    MeasurementError
        Where a segment does not begin with its tag, was never finished, reaches past the end of the file, or its
        raw data is no whole number of chunks.

    """
    declared = Declared()
    indices: dict[str, _Index] = {}
    listed: list[str] = []
    with path.open("rb") as file:
        for number, (place, contents, raw, following) in enumerate(_lead_ins(path, file, size), start=1):
            if contents & META:
                file.seek(place + LEAD_IN)
                order = ">" if contents & BIG_ENDIAN else "<"
                bounded = _Bounded(path, file.read(raw - place - LEAD_IN), order, number)
                listed = _described(bounded, [] if contents & NEW_LIST else listed, indices)
            if contents & DAQMX or any(indices[name].bytes < 0 for name in listed):
                declared.countable = False
            elif contents & RAW or following > raw:
                _count(path, number, following - raw, listed, indices, declared)
    return declared


def _lead_ins(path: Path, file: BufferedReader, size: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield start, contents, raw data and end of each segment [bytes from the file's start]."""
    place = number = 0
    while place < size:
        number += 1
        if number > MOST_NODES:
            raise damaged(path, f"has more than {MOST_NODES} segments", "Defragment it")
        file.seek(place)
        lead = file.read(LEAD_IN)
        if len(lead) < LEAD_IN:
            raise damaged(
                path, f"segment {number} must have a lead-in of {LEAD_IN} bytes, {len(lead)} are left"
            )
        if lead[:4] != b"TDSm":
            raise damaged(
                path, f"segment {number} must begin with TDSm at byte {place + 1}, {lead[:4]!r} found"
            )
        contents = struct.unpack("<I", lead[4:8])[0]
        version, following, raw = struct.unpack((">" if contents & BIG_ENDIAN else "<") + "IQQ", lead[8:])
        if contents & ~_CONTENTS or version not in (4712, 4713):
            raise damaged(
                path, f"segment {number} has an unknown lead-in (contents {contents:#x}, version {version})"
            )
        if following == UNKNOWN:
            raise damaged(
                path, f"segment {number} was never finished: its length is not written", "Record it again"
            )
        end, data = place + LEAD_IN + following, place + LEAD_IN + raw
        if end > size:
            raise damaged(path, f"segment {number} declares to end at byte {end}, the file has {size}")
        if data > end or (end > data and not contents & RAW):
            raise damaged(path, f"segment {number} contradicts itself: raw data from byte {data} to {end}")
        yield place, contents, data, end
        place = end


def _described(bounded: _Bounded, listed: list[str], indices: dict[str, _Index]) -> list[str]:
    """Read the objects of a segment; return the paths of those with raw data, in order."""
    result = list(listed)
    objects = bounded.integer()
    if objects > MOST_NODES:
        raise damaged(bounded.path, f"segment {bounded.number} declares {objects} objects")
    for _ in range(objects):
        name = bounded.text()
        header = bounded.integer()
        if header == _NO_DATA:
            result = [each for each in result if each != name] if name in result else result
        else:
            if header != _AS_BEFORE:
                indices[name] = _index(bounded, name, header)
            elif name not in indices:
                raise damaged(
                    bounded.path, f"object {quoted(name)} refers to an earlier index, there is none"
                )
            if name not in result:
                result.append(name)
        for _ in range(bounded.integer()):
            bounded.text()
            _skip_value(bounded)
    return result


def _index(bounded: _Bounded, name: str, header: int) -> _Index:
    """Read the raw data index of an object; of DAQmx data only its length is known."""
    if header in _DAQMX_INDEX:
        bounded.take(4 + 4 + 8)  # type, dimension, samples
        scalers = bounded.integer()
        bounded.take(scalers * (20 if header == _DAQMX_INDEX[0] else 17))
        bounded.take(4 * bounded.integer())
        return _Index(0, -1)
    kind, dimension, count = bounded.integer(), bounded.integer(), bounded.integer("Q")
    if kind == _STRING:
        length = bounded.integer("Q")
    elif kind in _SIZES:
        length = count * _SIZES[kind]
    else:
        raise damaged(
            bounded.path, f"object {quoted(name)} has an unknown type {kind:#x}", "Choose another export"
        )
    if dimension != 1 or header not in (20, 28):
        raise damaged(bounded.path, f"object {quoted(name)} must have one dimension, {dimension} found")
    return _Index(count, length)


def _skip_value(bounded: _Bounded) -> None:
    kind = bounded.integer()
    if kind == _STRING:
        bounded.text()
    elif kind in _SIZES:
        bounded.take(_SIZES[kind])
    else:
        raise damaged(bounded.path, f"segment {bounded.number} has a property of unknown type {kind:#x}")


def _count(
    path: Path, number: int, raw: int, listed: list[str], indices: dict[str, _Index], declared: Declared
) -> None:
    """Add the samples of a segment's chunks, of which there must be a whole number."""
    chunk = sum(indices[name].bytes for name in listed)
    if chunk == 0 and raw == 0:
        return
    if chunk == 0 or raw % chunk:
        rule = f"segment {number} declares chunks of {chunk} bytes and holds {raw}, no whole number of them"
        raise damaged(path, rule)
    for name in listed:
        declared.samples[name] = declared.samples.get(name, 0) + indices[name].count * (raw // chunk)
