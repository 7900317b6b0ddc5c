"""WAV files by SciPy; the sizes of the chunks are compared with the file, which SciPy does not."""

import json
import struct
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.refusing import MOST_NODES, check_samples, damaged, fenced, quoted
from gearplay.files.record import Record

NAMES_CHUNK: Final = b"gear"
"""Chunk of our own that holds names, units and start as JSON; other programs skip it."""


def _chunks(path: Path, size: int) -> dict[bytes, bytes]:
    """Return the first bytes of each chunk; `MeasurementError` where one reaches past the file, or bytes are left."""
    found: dict[bytes, bytes] = {}
    with path.open("rb") as file:
        head = file.read(12)
        order = ">" if head[:4] == b"RIFX" else "<"
        if len(head) < 12 or head[:4] not in (b"RIFF", b"RIFX") or head[8:] != b"WAVE":
            rule = f"must start as RIFF/WAVE, {head[:4]!r} found"
            raise damaged(path, rule, "Save it as WAV (RIFF), up to 4 GiB")
        end = 8 + int(struct.unpack(order + "I", head[4:8])[0])
        if not size - 1 <= end <= size:  # more bytes than declared: a recorder that did not finish its header
            raise damaged(path, f"declares {end} bytes in its RIFF header and holds {size}")
        place = 12
        for _ in range(MOST_NODES):
            if place + 8 > end:
                break
            file.seek(place)
            name, length = struct.unpack(order + "4sI", file.read(8))
            if place + 8 + length > end:
                rule = f"chunk {quoted(name.decode('latin-1'))} declares {length} bytes, {end - place - 8} are left"
                raise damaged(path, rule)
            found.setdefault(name, file.read(min(length, 2**20)))
            place += 8 + length + length % 2  # chunks start at even offsets
    return found


def _names(path: Path, content: bytes | None, channels: int) -> tuple[list[str], list[str], float]:
    """Return names and units of the channels and the start [s] by our own chunk."""
    if content is None:
        return [""] * channels, [""] * channels, 0.0
    try:
        about = json.loads(content)
        names, units = (list(map(str, about[key])) for key in ("names", "units"))
        start = float(about["start"])
    except (ValueError, TypeError, KeyError, RecursionError):
        raise damaged(path, "its chunk of channel names cannot be read") from None
    if len(names) != channels or len(units) != channels:
        raise damaged(path, f"names {len(names)} channels and holds {channels}")
    return names, units, start


def _scaled(samples: NDArray[Any]) -> NDArray[np.float64]:
    """Return samples with integers scaled to +-1; those of other widths lie at the upper end of their container."""
    values = samples.astype(np.float64)
    if samples.dtype.kind == "f":
        return values
    if samples.dtype.kind == "u":
        return (values - 128.0) / 128.0
    return values / 2.0 ** (8 * samples.dtype.itemsize - 1)


def read(request: Request) -> Record:
    """Read a WAV file: integers of 8 to 64 bits or floats of 32 or 64 bits, any number of channels.

    Integers are scaled to +-1 and have no unit. Raises `MeasurementError` where a chunk is larger than the file or
    the header contradicts itself.
    """
    from scipy.io import wavfile

    path = request.path
    chunks = _chunks(path, request.size)
    with fenced(path, "WAV"):
        warnings.filterwarnings("error", category=wavfile.WavFileWarning)
        warnings.filterwarnings("ignore", message="Chunk", category=wavfile.WavFileWarning)
        rate, samples = wavfile.read(path)
    shaped = samples.reshape(samples.shape[0], -1)
    _check_layout(path, chunks, shaped, int(rate))
    names, units, start = _names(path, chunks.get(NAMES_CHUNK), shaped.shape[1])
    check_samples(path, (len(names) if request.channels is None else len(request.channels)) * len(shaped))
    bits = 8 * samples.itemsize
    if samples.dtype.byteorder != ">":
        (bits,) = struct.unpack_from("<H", chunks[b"fmt "], 14)
    encoded = f"{'float' if samples.dtype.kind == 'f' else 'integer'} of {bits} bits"
    declared = [("the header", float(rate))]
    return make_record(
        request,
        names,
        lambda k: Samples(_scaled(shaped[:, k]), declared, units[k], start),
        {"encoding": encoded},
    )


def _check_layout(path: Path, chunks: dict[bytes, bytes], samples: NDArray[Any], rate: int) -> None:
    """Compare the header's byte rate, frame size and sample count with each other."""
    order = ">" if samples.dtype.byteorder == ">" else "<"
    _, channels, _, byte_rate, align, _ = struct.unpack_from(order + "HHIIHH", chunks[b"fmt "])
    if align % channels or byte_rate != rate * align:
        rule = f"contradicts itself: {channels} channels at {rate} Hz, but {align} bytes a frame and {byte_rate} bytes a second"
        raise damaged(path, rule)
    fact = chunks.get(b"fact", b"")
    if len(fact) >= 4:
        (declared,) = struct.unpack_from(order + "I", fact)
        if samples.shape[0] < declared != 0xFFFFFFFF:
            raise damaged(path, f"declares {declared} samples a channel and holds {samples.shape[0]}")
