"""The signals of an MDF 4 file: asammdf decodes raw values, and plain conversions are done here.

`mdf4` walks the blocks first and runs this in a process of its own.

Formula conversions are left out: the library hands their text to an expression evaluator.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, distinct, even_sampling, make_channel, make_record
from gearplay.files.measurements.refusing import check_samples, damaged, fenced, need, quoted
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import shorten

_FIXED_LENGTH: Final = 0
_NUMBERS: Final = range(6)
_AS_IT_IS, _LINEAR, _RATIONAL = 0, 1, 2


def _conversion_kind(channel: Any) -> int:
    return _AS_IT_IS if channel.conversion is None else int(channel.conversion.conversion_type)


def _is_signal(channel: Any, group: Any, index: int) -> bool:
    return (
        channel.channel_type == _FIXED_LENGTH
        and channel.data_type in _NUMBERS
        and not group.channel_dependencies[index]
        and _conversion_kind(channel) in (_AS_IT_IS, _LINEAR, _RATIONAL)
    )


def _converted(raw: NDArray[Any], channel: Any) -> NDArray[np.float64]:
    """Return physical values: as they are, ``a x + b``, or the quotient of two quadratics."""
    x = raw.astype(np.float64)
    kind, rule = _conversion_kind(channel), channel.conversion
    if kind == _LINEAR:
        return np.asarray(rule.a * x + rule.b)
    if kind == _RATIONAL:
        return np.asarray(
            (rule.P1 * x * x + rule.P2 * x + rule.P3) / (rule.P4 * x * x + rule.P5 * x + rule.P6)
        )
    return x


def _unit(channel: Any) -> str:
    own = str(channel.unit or "")
    return own or str(getattr(channel.conversion, "unit", "") or "")


def _load(request: Request, file: Any, name: str, place: tuple[int, int]) -> Channel:
    group, index = place
    block = file.groups[group]
    cycles = int(block.channel_group.cycles_nr)
    check_samples(request.path, cycles)
    signal = file.get(group=group, index=index, raw=True, ignore_invalidation_bits=False)
    raw = np.asarray(signal.samples)
    if raw.size < cycles and block.channel_group.invalidation_bytes_nr:  # which the library leaves out
        rule = f"channel {quoted(name)} marks {cycles - raw.size} of {cycles} samples as invalid"
        raise damaged(request.path, rule, "Choose other channels, or cut the record there")
    if raw.size != cycles:
        raise damaged(request.path, f"channel {quoted(name)} declares {cycles} samples and holds {raw.size}")
    times = np.asarray(signal.timestamps, dtype=np.float64)
    has_time = file.masters_db.get(group) is not None
    rate, start = even_sampling(request.path, times) if has_time else (None, 0.0)
    channel = block.channels[index]
    about = {
        "group": getattr(block.channel_group, "acq_name", "") or "",
        "comment": channel.comment or "",
        "source": getattr(channel.source, "name", "") or "",
    }
    return make_channel(
        request,
        name,
        _converted(raw, channel),
        sampling=rate,
        unit=_unit(channel),
        start=start,
        attributes=about,
    )


def read(request: Request) -> Record:
    """Read an MDF 4 file: channels of numbers with no, a linear or a rational conversion.

    Raises `MeasurementError` where fewer samples are read than declared, samples are marked invalid or the time is
    uneven.
    """
    path = request.path
    asammdf = need("asammdf", "asammdf", path)
    with fenced(path, "MDF 4", "asammdf"), path.open("rb") as stream:
        file = asammdf.MDF(stream, process_bus_logging=False)
        try:
            places, left_out = [], []
            for number, group in enumerate(file.groups):
                for index, channel in enumerate(group.channels):
                    if _is_signal(channel, group, index):
                        places.append((number, index))
                    elif channel.channel_type == _FIXED_LENGTH:
                        left_out.append(str(channel.name))
            names = distinct([str(file.groups[group].channels[index].name) for group, index in places])
            channels = [_load(request, file, names[k], places[k]) for k in request.select(names)]
            comment = str(file.header.comment or "")
            said = {"start": str(file.start_time), "comment": "" if comment.startswith("<") else comment}
        finally:
            file.close()
    if left_out:
        said["left out"] = shorten(", ".join(left_out), 900)
    return make_record(request, channels, "mdf4", said)
