"""Channels and records out of what a file holds: choice by name, finite samples, even sampling."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.refusing import check_samples, damaged, quoted
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import Fault, InputError, escape_controls, shorten

Floats = NDArray[np.float64]

LARGEST_JITTER: Final = 0.02
"""Largest deviation of a time from the straight line that counts as even, in sampling steps."""

AGREEMENT: Final = 1e-3
"""Largest relative difference between the sampling rate of the caller and that of the file."""

TIME_UNITS: Final = {
    "": 1.0, "s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6,
    "µs": 1e-6, "μs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "milliseconds": 1e-3, "microseconds": 1e-6,
    "minutes": 60.0, "hours": 3600.0,
}  # fmt: skip
"""Units of a time column and their size [s]."""

RATES: Final = ("fs", "sampling", "sampling_rate", "sample_rate", "samplerate", "samplingrate")
"""Names of scalars and attributes that hold the sampling rate [Hz], in small letters."""

STEPS: Final = ("dt", "delta_t", "wf_increment")
"""Names of scalars and attributes that hold the sampling step [s]."""

# a capital T alone is a temperature or a torque
_TIME_NAMES = re.compile(r"t|(?i:time|times|zeit|temps|tiempo|tempo|tid|timestamps?|elapsed[ _]time)")
_NAME_AND_UNIT = re.compile(r"\s*(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*", re.DOTALL)


@dataclass(frozen=True)
class Request:
    """What the caller asks of a file: its path and size [bytes], the channels, the sampling rate [Hz]."""

    path: Path
    size: int
    channels: tuple[str, ...] | None = None
    sampling: float | None = None

    def select(self, names: Sequence[str]) -> list[int]:
        """Return which of the file's channels to read; of one name asked for, the first.

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
            shown = ", ".join(shorten(each, 40) for each in names[:12]) + (", ..." if len(names) > 12 else "")
            cure = f"Did you mean {quoted(close[0])}?" if close else f"Channels: {shown or 'none'}"
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


def is_time(name: str, unit: str) -> bool:
    """Tell whether a column is the time.

    >>> is_time("Time", "ms"), is_time("t", ""), is_time("T", ""), is_time("time", "N")
    (True, True, False, False)
    """
    return unit in TIME_UNITS and _TIME_NAMES.fullmatch(name.strip()) is not None


def stated_rate(name: str, value: float) -> float | None:
    """Return the rate [Hz] that a scalar of this name states; none where the name is another.

    >>> stated_rate("Fs", 1000.0), stated_rate("dt", 0.001), stated_rate("gain", 2.0)
    (1000.0, 1000.0, None)
    """
    if name.lower() in RATES:
        return value
    if name.lower() in STEPS:
        return float(f"{1.0 / value:.12g}") if value else float("nan")
    return None


def distinct(names: Sequence[str]) -> list[str]:
    """Return the names, nameless ones numbered and repeated ones told apart.

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
    return MappingProxyType({key: text for key, text in shown.items() if text})


def even_sampling(path: Path, time: Floats, *, column: str = "time") -> tuple[float, float]:
    """Return the sampling rate [Hz] and the first time [s] of evenly spaced times.

    The rate is that between the first time and the last one, to 9 digits.

    Parameters
    ----------
    path
        The file, for the sentence.
    time
        Times [s], shape [time].
    column
        How the file calls them.

    Raises
    ------
    MeasurementError
        Where a time is not finite, the times do not rise, or one of them is further from its even place than
        `LARGEST_JITTER` of a step.

    Examples
    --------
    >>> even_sampling(Path("run.csv"), np.arange(5) / 1000.0)
    (1000.0, 0.0)

    """
    if time.size < 2:
        raise damaged(path, f"must hold at least 2 samples, {time.size} found", "Give a longer record")
    _check_finite(path, column, time)
    step = (time[-1] - time[0]) / (time.size - 1)
    if not (step > 0.0 and np.isfinite(1.0 / step)):
        raise damaged(
            path,
            f"the times of {quoted(column)} must rise, from {time[0]:g} to {time[-1]:g} s found",
            "Export it again",
        )
    jitter = np.abs(time - (time[0] + step * np.arange(time.size)))
    worst = int(jitter.argmax())
    # a time so far from zero that its last bit is a visible part of the step is not the sensor's fault
    rounding = 4.0 * np.spacing(np.abs(time).max())
    if jitter[worst] > LARGEST_JITTER * step + rounding:
        raise damaged(
            path,
            f"the times of {quoted(column)} must be evenly spaced; the largest jitter is {jitter[worst]:.3g} s, "
            f"{100 * jitter[worst] / step:.3g} % of the mean step of {step:.3g} s, at sample {worst + 1}",
            "Resample the record, or choose channels with even sampling",
        )
    return float(f"{1.0 / step:.9g}"), float(time[0])


def _check_finite(path: Path, name: str, values: Floats) -> None:
    bad = ~np.isfinite(values)
    count = int(np.count_nonzero(bad))
    if count:
        first = int(bad.argmax())
        raise damaged(
            path,
            f"channel {quoted(name)} must hold finite numbers; {count} of {values.size} samples are not "
            f"(the first at sample {first + 1}: {values[first]})",
            "Cut the record there, or repair those samples on purpose",
        )


def make_channel(
    request: Request,
    name: str,
    values: NDArray[Any],
    *,
    sampling: float | None,
    unit: str = "",
    start: float = 0.0,
    attributes: Mapping[str, object] = MappingProxyType({}),
) -> Channel:
    """Check what a file holds of one channel and return it.

    Parameters
    ----------
    request
        What the caller asked for.
    name, unit
        As the file has them.
    values
        Samples, shape [time], of any real type.
    sampling
        Rate that the file states [Hz], or none.
    start
        Time of the first sample [s].
    attributes
        What else the file says; kept as text.

    Raises
    ------
    MeasurementError
        Where the samples are none, or not finite real numbers, or the file's rate is no positive number.
    InputError
        Where the file does not state the rate and the caller neither, or they contradict each other.

    """
    if values.ndim != 1 or values.dtype.kind not in "fiub":
        raise damaged(request.path, f"channel {quoted(name)} must hold real numbers", "Choose other channels")
    if values.size == 0:
        raise damaged(request.path, f"channel {quoted(name)} must hold samples, none found")
    check_samples(request.path, values.size)
    samples = np.ascontiguousarray(values, dtype=np.float64)
    _check_finite(request.path, name, samples)
    if not np.isfinite(start):
        raise damaged(request.path, f"channel {quoted(name)} must start at a finite time, {start} found")
    rate = _agreed(request, name, sampling)
    return Channel(
        escape_controls(name), samples, rate, escape_controls(unit), float(start), as_text(attributes)
    )


def _agreed(request: Request, name: str, stated: float | None) -> float:
    asked = request.sampling
    if stated is not None and not (np.isfinite(stated) and stated > 0.0):
        raise damaged(
            request.path, f"channel {quoted(name)} must have a positive sampling rate, {stated:g} Hz found"
        )
    if stated is None and asked is None:
        rule = f"must be given, since {shorten(request.path.name)} does not state it for {quoted(name)}"
        raise InputError([Fault("sampling", None, rule, "Give the sampling rate in Hz")])
    if stated is None or asked is None:
        return float(asked if stated is None else stated)  # type: ignore[arg-type]
    if abs(asked - stated) > AGREEMENT * stated:
        rule = f"must agree with {stated:g} Hz, which {shorten(request.path.name)} states for {quoted(name)}"
        raise InputError([Fault("sampling", asked, rule, "Leave the sampling rate out")])
    return float(stated)


def make_record(
    request: Request, channels: Sequence[Channel], kind: str, attributes: Mapping[str, object] | None = None
) -> Record:
    """Return the record of a file; `MeasurementError` where it has no channel."""
    if not channels:
        raise damaged(
            request.path, "must hold at least one channel of evenly sampled numbers", "Choose another file"
        )
    return Record(tuple(channels), request.path.name, kind, as_text(attributes or {}))
