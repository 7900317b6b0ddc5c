"""Channels and records from the content of a file: selection by name, checks of samples, units and rates."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.files import sandbox
from gearplay.files.measurements.rates import Declaration, agreed_rate, check_finite
from gearplay.files.measurements.refusing import check_samples, damaged, quoted
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import Fault, InputError, escape_controls, shorten
from gearplay.vocabulary.suggestions import listed

_NAME_AND_UNIT = re.compile(r"\s*(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*", re.DOTALL)


@dataclass(frozen=True)
class Request(sandbox.Request):
    """Request to read a file: also the channels, the sampling rate [Hz], the kind of file."""

    channels: tuple[str, ...] | None = None
    sampling: float | None = None
    kind: str = "csv"

    def select(self, names: Sequence[str]) -> list[int]:
        """Return the indices of the channels to read; of a requested name that is repeated, the first.

        Raises `InputError` for a name the file does not hold.
        """
        if self.channels is None:
            return list(range(len(names)))
        faults, chosen = [], []
        for name in self.channels:
            if name in names:
                chosen.append(names.index(name))
                continue
            close = get_close_matches(name, names, 1)
            cure = f"Did you mean {quoted(close[0])}?" if close else f"Channels: {listed(names)}"
            faults.append(Fault("channels", name, f"must be a channel of {shorten(self.path.name)}", cure))
        if faults:
            raise InputError(faults)
        return chosen


def split_unit(text: str) -> tuple[str, str]:
    """Split a header such as ``acc [m/s^2]`` or ``acc (m/s^2)`` into name and unit.

    >>> split_unit("acc [m/s^2]"), split_unit("force (N)"), split_unit("speed")
    (('acc', 'm/s^2'), ('force', 'N'), ('speed', ''))
    """
    match = _NAME_AND_UNIT.fullmatch(text)
    if match is None or not match[1]:
        return text.strip(), ""
    return match[1], (match[2] or match[3] or "").strip()


def distinct(names: Sequence[str]) -> list[str]:
    """Return unique names: empty ones are numbered, repeated ones get a suffix.

    >>> distinct(["a", "", "a"])
    ['a', 'channel 2', 'a (2)']
    """
    taken: set[str] = set()
    result = []
    for place, name in enumerate(names, start=1):
        base = new = name.strip() or f"channel {place}"
        count = 1
        while new in taken:
            count += 1
            new = f"{base} ({count})"
        taken.add(new)
        result.append(new)
    return result


def as_text(attributes: Mapping[str, object]) -> Mapping[str, str]:
    """Return attributes as text: at most 200, each at most 1000 characters, empty ones left out."""
    shown = {
        escape_controls(str(key)): shorten(str(value), 1000) for key, value in list(attributes.items())[:200]
    }
    return {key: text for key, text in shown.items() if text}


class Samples(NamedTuple):
    """Content of one channel as the file has it.

    ``values``, shape [time], are of any real type; ``declared`` are sampling rates [Hz], see `agreed_rate`; ``start`` is the time
    of the first sample [s]; ``attributes`` are kept as text.
    """

    values: NDArray[Any]
    declared: Sequence[Declaration]
    unit: str = ""
    start: float = 0.0
    attributes: Mapping[str, object] = MappingProxyType({})


def make_channel(request: Request, name: str, content: Samples) -> Channel:
    """Return a channel after checking samples, start and sampling rate.

    Raises `MeasurementError` where there are no samples, they are not finite real numbers or whole numbers beyond 2^53, or the
    file's rates are not positive or contradict each other; `InputError` where neither the file nor the caller states the rate, or
    they contradict each other.
    """
    values, declared, unit, start, attributes = content
    channel = f"channel {quoted(name)}"
    if values.ndim != 1 or values.dtype.kind not in "fiub":
        raise damaged(request.path, f"{channel} must hold real numbers", "Choose other channels")
    if values.size == 0:
        raise damaged(request.path, f"{channel} must hold samples, none found")
    check_samples(request.path, values.size)
    samples = np.ascontiguousarray(values, dtype=np.float64)
    check_finite(request.path, name, samples)
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8 and np.abs(samples).max() > 2.0**53:
        rule = f"{channel} must hold whole numbers up to 2^53, {np.abs(samples).max():.6g} found"
        raise damaged(request.path, rule, "Choose other channels")
    if not np.isfinite(start):
        raise damaged(request.path, f"{channel} must start at a finite time, {start} found")
    rate = agreed_rate(request.path, name, declared, request.sampling)
    return Channel(
        escape_controls(name), samples, rate, escape_controls(unit), float(start), as_text(attributes)
    )


def make_record(
    request: Request,
    names: Sequence[str],
    load: Callable[[int], Samples],
    attributes: Mapping[str, object],
    *,
    found: Sequence[str] = (),
    kind: str = "",
) -> Record:
    """Return the record of a file.

    ``names`` are those of all channels in the file, made distinct here; ``load(k)`` returns the content of the k-th. ``found``
    are the names of other content, for the message; ``kind`` is the kind of file, by default the requested one.

    Raises `MeasurementError` where there is no channel, `InputError` for a requested name that the file does not hold, and both
    as `make_channel`.
    """
    names = distinct(names)
    channels = [make_channel(request, names[k], load(k)) for k in request.select(names)]
    if not channels:
        shown = ", ".join(shorten(each, 60) for each in found[:6]) + (", ..." if len(found) > 6 else "")
        rule = "must hold at least one channel of evenly sampled numbers"
        raise damaged(request.path, f"{rule}; found: {shown}" if found else rule, "Choose another file")
    return Record(tuple(channels), request.path.name, kind or request.kind, as_text(attributes))
