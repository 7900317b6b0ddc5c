"""TDMS files by npTDMS; the segments must fill the file, and samples read are compared with those declared."""

import struct
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.rates import Declaration, declarations, even_sampling, time_scale
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

UNITS: Final = ("unit_string", "NI_UnitDescription", "unit", "Unit")
"""Properties that hold a channel's unit."""

_LEAD_IN: Final = 28
_BIG_ENDIAN: Final = 1 << 6


def _check_segments(path: Path, size: int) -> None:
    """Raise `MeasurementError` where the lead-ins do not end with the file, which npTDMS accepts silently."""
    place = 0
    with path.open("rb") as file:
        for number in range(1, MOST_NODES):
            file.seek(place)
            lead = file.read(_LEAD_IN)
            if len(lead) < _LEAD_IN or lead[:4] != b"TDSm":
                rule = f"segment {number} must begin with a lead-in of {_LEAD_IN} bytes at byte {place + 1}"
                raise damaged(path, rule)
            (contents,) = struct.unpack_from("<I", lead, 4)
            (following,) = struct.unpack_from(">Q" if contents & _BIG_ENDIAN else "<Q", lead, 12)
            if following == 2**64 - 1:
                rule = f"segment {number} was never finished: its length is not written"
                raise damaged(path, rule, "Record it again")
            place += _LEAD_IN + following
            if place > size:
                raise damaged(path, f"segment {number} declares to end at byte {place}, the file has {size}")
            if place == size:
                return
    raise damaged(path, f"has more than {MOST_NODES} segments", "Defragment it")


def _unit(properties: dict[str, Any]) -> str:
    return next((str(properties[key]) for key in UNITS if properties.get(key)), "")


def _values(request: Request, channel: Any) -> NDArray[Any]:
    check_samples(request.path, len(channel))
    values = np.asarray(channel[:])
    if values.size != len(channel):
        rule = f"channel {quoted(channel.name)} declares {len(channel)} samples and holds {values.size}"
        raise damaged(request.path, rule)
    return values


def _rates(request: Request, channel: Any, group: list[Any]) -> tuple[list[Declaration], float]:
    """Return the declared rates [Hz] and the start [s]: properties, and the group's time channel."""
    declared = declarations(channel.properties.items())
    start = float(channel.properties.get("wf_start_offset", 0.0))
    for other in group:
        scale = time_scale(other.name, _unit(other.properties))
        fits = other is not channel and len(other) == len(channel) and other.dtype.kind in "fiu"
        if scale is not None and fits:
            times = _values(request, other).astype(np.float64) * scale
            rate, start = even_sampling(request.path, times, column=other.name)
            declared.append((other.name, rate))
    return declared, start


def read(request: Request) -> Record:
    """Read a TDMS file: names, units, sampling and start as the waveform properties state them.

    Of channels with one name in several groups, the name becomes ``group/channel``. Channels of texts or times are
    left out, and so is the time channel of a group. Raises `MeasurementError` where a segment is cut or unfinished, a scaling
    is unknown, or fewer samples are read than declared.
    """
    path = request.path
    _check_segments(path, request.size)
    nptdms = need("nptdms", "npTDMS", path)
    complaints = Complaints("nptdms")
    with fenced(path, "TDMS"), path.open("rb") as stream, nptdms.TdmsFile(stream, keep_open=True) as file:
        groups = {group.name: list(group.channels()) for group in file.groups()}
        found = [
            channel
            for group in groups.values()
            for channel in group
            if channel.dtype.kind in "fiub" and not _is_axis(channel, group) and len(channel)
        ]

        def load(k: int) -> Samples:
            channel = found[k]
            declared, start = _rates(request, channel, groups[channel.group_name])
            values = _values(request, channel)
            complaints.refuse(path, "TDMS")
            return Samples(values, declared, _unit(channel.properties), start, _about(channel))

        plain = [channel.name for channel in found]
        names = [c.name if plain.count(c.name) == 1 else f"{c.group_name}/{c.name}" for c in found]
        everything = [c.path for group in groups.values() for c in group]
        record = make_record(request, names, load, dict(file.properties), found=everything)
        complaints.refuse(path, "TDMS")
    return record


def _about(channel: Any) -> dict[str, object]:
    known = {"wf_increment", "wf_start_offset", "wf_samples", *UNITS}
    return {"group": channel.group_name} | {k: v for k, v in channel.properties.items() if k not in known}


def _is_axis(channel: Any, group: list[Any]) -> bool:
    return time_scale(channel.name, _unit(channel.properties)) is not None and len(group) > 1
