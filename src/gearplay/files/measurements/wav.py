"""WAV: the chunks are walked and their sizes compared with the file before the samples are taken."""

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, distinct, make_channel, make_record
from gearplay.files.measurements.refusing import MOST_NODES, check_samples, damaged, quoted
from gearplay.files.record import Record

NAMES_CHUNK: Final = b"gear"
"""Chunk of our own that holds names, units and start as JSON; other programs skip it."""

_SAMPLES: Final = {
    (1, 8): "u1",
    (1, 16): "<i2",
    (1, 24): "u1",
    (1, 32): "<i4",
    (3, 32): "<f4",
    (3, 64): "<f8",
}
_EXTENSIBLE: Final = 0xFFFE


def _chunks(path: Path, size: int) -> dict[bytes, tuple[int, int]]:
    """Return chunk name -> (offset, length) [bytes]; of repeated names the first."""
    found: dict[bytes, tuple[int, int]] = {}
    with path.open("rb") as file:
        head = file.read(12)
        if len(head) < 12 or head[:4] != b"RIFF" or head[8:] != b"WAVE":
            raise damaged(
                path, f"must start as RIFF/WAVE, {head[:4]!r} found", "Save it as WAV (RIFF), up to 4 GiB"
            )
        end = 8 + struct.unpack("<I", head[4:8])[0]
        if not size - 1 <= end <= size:  # more bytes than declared: a recorder that did not finish its header
            raise damaged(path, f"declares {end} bytes in its RIFF header and holds {size}")
        place = 12
        for _ in range(MOST_NODES):
            if place + 8 > end:
                break
            file.seek(place)
            name, length = struct.unpack("<4sI", file.read(8))
            if place + 8 + length > end:
                rule = f"chunk {quoted(name.decode('latin-1'))} declares {length} bytes, {end - place - 8} are left"
                raise damaged(path, rule)
            found.setdefault(name, (place + 8, length))
            place += 8 + length + length % 2  # chunks start at even offsets
    return found


def _content(path: Path, place: tuple[int, int]) -> bytes:
    with path.open("rb") as file:
        file.seek(place[0])
        return file.read(min(place[1], 2**20))


def _layout(path: Path, content: bytes) -> tuple[int, int, int, int]:
    """Return encoding (1 integers, 3 floats), channels, rate [Hz] and bits per sample, checked for consistency."""
    if len(content) < 16:
        raise damaged(path, f"chunk 'fmt ' must have 16 bytes or more, {len(content)} found")
    encoding, channels, rate, byte_rate, align, bits = struct.unpack("<HHIIHH", content[:16])
    if encoding == _EXTENSIBLE and len(content) >= 26:
        encoding = struct.unpack("<H", content[24:26])[0]
    if (encoding, bits) not in _SAMPLES:
        rule = f"must hold integers of 8 to 32 bits or floats, encoding {encoding} with {bits} bits found"
        raise damaged(path, rule, "Export it as PCM or float")
    if not channels or not rate or align != channels * bits // 8 or byte_rate != rate * align:
        rule = (
            f"contradicts itself: {channels} channels of {bits} bits at {rate} Hz, but {align} bytes a frame "
            f"and {byte_rate} bytes a second"
        )
        raise damaged(path, rule)
    return encoding, channels, rate, bits


def _names(path: Path, content: bytes | None, channels: int) -> Mapping[str, Any]:
    if content is None:
        return {"names": [""] * channels, "units": [""] * channels, "start": 0.0}
    try:
        said = json.loads(content)
        names, units, start = (
            [str(n) for n in said["names"]],
            [str(u) for u in said["units"]],
            float(said["start"]),
        )
    except (ValueError, TypeError, KeyError, RecursionError):
        raise damaged(path, "its chunk of channel names cannot be read") from None
    if len(names) != channels or len(units) != channels:
        raise damaged(path, f"names {len(names)} channels and holds {channels}")
    return {"names": names, "units": units, "start": start}


def _scaled(raw: NDArray[Any], encoding: int, bits: int) -> NDArray[np.float64]:
    """Return one channel's samples, integers scaled to +-1; 24 bits come as three bytes in the last axis."""
    if encoding == 3:
        return raw.astype(np.float64)
    if bits == 8:
        return (raw.astype(np.float64) - 128.0) / 128.0
    if bits == 24:
        wide = raw.astype(np.int32)
        whole = wide[:, 0] | (wide[:, 1] << 8) | (wide[:, 2] << 16)
        return (whole - ((whole & 0x800000) << 1)) / 8388608.0
    return raw.astype(np.float64) / 2.0 ** (bits - 1)


def read(request: Request) -> Record:
    """Read a WAV file: integers of 8, 16, 24 or 32 bits or floats of 32 or 64 bits, any number of channels.

    Integers are scaled to +-1 and have no unit. Raises `MeasurementError` where a chunk is larger than the file or
    the header contradicts itself.
    """
    path = request.path
    chunks = _chunks(path, request.size)
    for name in (b"fmt ", b"data"):
        if name not in chunks:
            raise damaged(path, f"has no chunk {quoted(name.decode())}")
    encoding, count, rate, bits = _layout(path, _content(path, chunks[b"fmt "]))
    offset, length = chunks[b"data"]
    frame = count * bits // 8
    if length == 0 or length % frame:
        raise damaged(
            path, f"declares {length} bytes of samples, which is no whole number of frames of {frame} bytes"
        )
    if b"fact" in chunks and chunks[b"fact"][1] >= 4:
        (declared,) = struct.unpack("<I", _content(path, chunks[b"fact"])[:4])
        if declared > length // frame and declared != 0xFFFFFFFF:
            raise damaged(path, f"declares {declared} samples a channel and holds {length // frame}")
    said = _names(path, _content(path, chunks[NAMES_CHUNK]) if NAMES_CHUNK in chunks else None, count)
    names = distinct(said["names"])
    chosen = request.select(names)
    check_samples(path, len(chosen) * (length // frame))
    raw = np.fromfile(
        path,
        _SAMPLES[encoding, bits],
        length // (3 if bits == 24 else bits // 8) * (3 if bits == 24 else 1),
        offset=offset,
    )
    shaped = raw.reshape((-1, count, 3) if bits == 24 else (-1, count))
    channels = [
        make_channel(
            request,
            names[k],
            _scaled(shaped[:, k], encoding, bits),
            sampling=float(rate),
            unit=said["units"][k],
            start=said["start"],
        )
        for k in chosen
    ]
    encoded = f"{'float' if encoding == 3 else 'integer'} of {bits} bits"
    return make_record(request, channels, "wav", {"encoding": encoded})
