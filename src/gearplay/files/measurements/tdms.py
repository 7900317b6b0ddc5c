"""TDMS: the segments are walked first, npTDMS decodes, and the samples read are compared with those declared."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import (
    TIME_UNITS,
    Request,
    distinct,
    even_sampling,
    is_time,
    make_channel,
    make_record,
)
from gearplay.files.measurements.refusing import check_samples, damaged, fenced, need, quoted
from gearplay.files.measurements.tdms_segments import Declared, walk
from gearplay.files.record import Channel, Record

UNITS = ("unit_string", "NI_UnitDescription", "unit", "Unit")
"""Properties that hold a channel's unit."""


def _unit(properties: dict[str, Any]) -> str:
    return next((str(properties[key]) for key in UNITS if properties.get(key)), "")


def _values(request: Request, channel: Any, declared: Declared) -> NDArray[Any]:
    """Return a channel's samples after comparing their number with the declared one."""
    expected = declared.samples.get(channel.path, 0) if declared.countable else len(channel)
    check_samples(request.path, max(expected, len(channel)))
    values = np.asarray(channel[:])
    if values.size != expected:
        name = quoted(channel.name)
        raise damaged(request.path, f"channel {name} declares {expected} samples and holds {values.size}")
    return values


def _sampling(
    request: Request, channel: Any, group: list[Any], declared: Declared
) -> tuple[float | None, float]:
    """Return the rate [Hz] and start [s]: of the waveform's increment, else of the group's time channel."""
    properties = channel.properties
    if "wf_increment" in properties:
        increment = float(properties["wf_increment"])
        if not (np.isfinite(increment) and increment > 0.0 and np.isfinite(1.0 / increment)):
            rule = f"channel {quoted(channel.name)} must have a positive wf_increment, {increment:g} found"
            raise damaged(request.path, rule)
        return float(f"{1.0 / increment:.12g}"), float(properties.get("wf_start_offset", 0.0))
    for other in group:
        if (
            other is not channel
            and is_time(other.name, _unit(other.properties))
            and len(other) == len(channel)
        ):
            time = _values(request, other, declared)
            if time.dtype.kind in "fiu":
                scale = TIME_UNITS[_unit(other.properties)]
                return even_sampling(request.path, time.astype(np.float64) * scale, column=other.name)
    return None, 0.0


def _about(channel: Any) -> dict[str, object]:
    known = {"wf_increment", "wf_start_offset", "wf_samples", *UNITS}
    return {"group": channel.group_name} | {k: v for k, v in channel.properties.items() if k not in known}


def read(request: Request) -> Record:
    """Read a TDMS file: names, units, sampling and start as the waveform properties state them.

    Of channels with one name in several groups, the name becomes ``group/channel``. Channels of texts or times are
    left out, and so is the time channel of a group. Raises `MeasurementError` where a segment is cut, unfinished or
    contradicts itself, or fewer samples are read than declared.
    """
    path = request.path
    declared = walk(path, request.size)
    nptdms = need("nptdms", "npTDMS", path)
    channels: list[Channel] = []
    with (
        fenced(path, "TDMS", "nptdms"),
        path.open("rb") as stream,
        nptdms.TdmsFile(stream, keep_open=True) as file,
    ):
        groups = {group.name: list(group.channels()) for group in file.groups()}
        found = [
            channel
            for group in groups.values()
            for channel in group
            if channel.dtype.kind in "fiub"
            and not (_is_axis(channel, group))
            and declared_any(channel, declared)
        ]
        plain = [channel.name for channel in found]
        names = distinct([c.name if plain.count(c.name) == 1 else f"{c.group_name}/{c.name}" for c in found])
        for k in request.select(names):
            channel = found[k]
            rate, start = _sampling(request, channel, groups[channel.group_name], declared)
            values = _values(request, channel, declared)
            unit = _unit(channel.properties)
            channels.append(
                make_channel(
                    request,
                    names[k],
                    values,
                    sampling=rate,
                    unit=unit,
                    start=start,
                    attributes=_about(channel),
                )
            )
        said = dict(file.properties)
    return make_record(request, channels, "tdms", said)


def declared_any(channel: Any, declared: Declared) -> bool:
    """Tell whether a channel has samples at all; one without is a name only."""
    return bool(len(channel) or declared.samples.get(channel.path, 0))


def _is_axis(channel: Any, group: list[Any]) -> bool:
    return is_time(channel.name, _unit(channel.properties)) and len(group) > 1
