"""Sampling rates declared by name, by a time axis or by both; consistency of the declarations."""

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.refusing import damaged, quoted
from gearplay.vocabulary.errors import NO_VALUE, InputError, shorten

Floats = NDArray[np.float64]

LARGEST_JITTER: Final = 0.02
"""Largest deviation of a time from the straight line that counts as even, in sampling steps."""

AGREEMENT: Final = 1e-3
"""Largest relative difference between two declarations of one sampling rate."""

LATEST: Final = 1e11
"""Latest time that can be meant in seconds [s]; clocks that count milliseconds since 1970 are beyond."""

TIME_UNITS: Final = {
    "": 1.0, "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6,
    "µs": 1e-6, "μs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "milliseconds": 1e-3, "microseconds": 1e-6,
    "nanoseconds": 1e-9, "minutes": 60.0, "hours": 3600.0, "days": 86400.0,
}  # fmt: skip
"""Units of a time axis and their size [s]."""

_RATE_UNITS: Final = {
    "": 1.0, "hz": 1.0, "khz": 1e3, "mhz": 1e6, "1/s": 1.0, "s/s": 1.0, "sa/s": 1.0, "ks/s": 1e3, "sps": 1.0, "ksps": 1e3,
    "samples/s": 1.0, "samples/sec": 1.0, "samples/second": 1.0,
}  # fmt: skip
_RATES: Final = {
    "fs", "sr", "sampling", "samplingrate", "samplerate", "samplingfrequency", "samplefrequency", "samplingfreq",
    "samplefreq", "fsamp", "fsample", "fsampling", "samplespersecond", "abtastrate", "abtastfrequenz",
}  # fmt: skip
_STEPS: Final = {
    "dt", "deltat", "wfincrement", "timestep", "timeincrement", "samplingstep", "sampleinterval", "samplinginterval",
    "samplingperiod", "sampleperiod", "sampletime", "samplingtime", "abtastzeit", "xincrement",
}  # fmt: skip
_SUFFIXES: Final = {"hz": "Hz", "khz": "kHz", "s": "s", "ms": "ms", "us": "us"}
_AXES: Final = ("x", "xaxis", "xvalues", "abscissa")
_NUMBER_AND_UNIT = re.compile(
    r"\s*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*\[?([^\d\[\]]*?(?:/s|)?)\]?\s*", re.ASCII
)
# a capital T alone is a temperature or a torque
_TIME_NAME = re.compile(
    r"(?:t|(?i:time|times|zeit|temps|tiempo|tempo|tid|timestamps?|elapsed[ _]time))(?:[ _]([a-zµμ]+))?"
)

Declaration = tuple[str, float]
"""Source of a declared sampling rate, as messages show it, and the rate [Hz]."""


def time_scale(name: str, unit: str) -> float | None:
    """Return the size of a time axis's unit [s]; none where name and unit are not those of a time axis.

    >>> time_scale("Time", "ms"), time_scale("t_us", ""), time_scale("T", ""), time_scale("time", "N")
    (0.001, 1e-06, None, None)
    """
    match = _TIME_NAME.fullmatch(name.strip())
    unit = unit.split(" since ")[0].strip()
    if match is None or (match[1] and unit):
        return None
    return TIME_UNITS.get(match[1] or unit)


def declared_rate(name: str, value: object, parent: str = "") -> float | None:
    """Return the sampling rate [Hz] that a named value declares, a number or text with a unit; none where it declares none.

    Of the name letters and digits count; ``parent`` is the name of the structure that holds it.

    >>> declared_rate("Fs", 1000.0), declared_rate("dt_ms", 1.0), declared_rate("Sample rate", "12.8 kHz")
    (1000.0, 1000.0, 12800.0)
    >>> declared_rate("increment", 0.001, "x_values"), declared_rate("gain", 2.0), declared_rate("fs", "full scale")
    (1000.0, None, None)
    """
    bare, shape = _letters(name), "" if isinstance(value, str) else np.shape(np.asarray(value))
    kind, unit = _kind(bare)
    if not kind and bare in ("increment", "delta") and _letters(parent) in _AXES:
        kind = "step"
    if not kind or (shape and np.size(np.asarray(value)) != 1):
        return None
    number, stated = _number(value)
    unit = stated or unit
    if number is None:
        return None
    if unit.lower() in _RATE_UNITS and (unit or kind == "rate"):
        return number * _RATE_UNITS[unit.lower()]
    if unit in TIME_UNITS and (unit or kind == "step"):
        return float(f"{1.0 / (number * TIME_UNITS[unit]):.12g}") if number else math.nan
    return None


def is_rate_name(name: str) -> bool:
    """Return whether a name declares a sampling rate or step.

    >>> is_rate_name("fs"), is_rate_name("force")
    (True, False)
    """
    return bool(_kind(_letters(name))[0])


def _letters(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


def _kind(bare: str) -> tuple[str, str]:
    """Return whether letters name a rate or a step, and the unit at their end."""
    for suffix in ("", *_SUFFIXES):
        stem = bare.removesuffix(suffix)
        if (stem != bare or not suffix) and stem in _RATES | _STEPS:
            return "rate" if stem in _RATES else "step", _SUFFIXES.get(suffix, "")
    return "", ""


def _number(value: Any) -> tuple[float | None, str]:
    """Return number and unit; a comma before other than three digits is a decimal sign."""
    if not isinstance(value, str):
        array = np.asarray(value)
        return (float(array.ravel()[0]) if array.size == 1 and array.dtype.kind in "fiu" else None), ""
    match = _NUMBER_AND_UNIT.fullmatch(value)
    if match is None:
        return None, ""
    try:
        return float(match[1].replace(",", ".")), match[2].strip()
    except ValueError:
        return None, ""


def even_sampling(path: Path, time: Floats, *, column: str = "time") -> tuple[float, float]:
    """Return the sampling rate [Hz], to 9 digits, and the first of evenly spaced times [s], shape [time].

    Raises `MeasurementError`, which names file and ``column``, where a time is not finite or beyond `LATEST`, the times do not
    rise, or one of them is further from its even place than `LARGEST_JITTER` of a step.

    >>> even_sampling(Path("run.csv"), np.arange(5) / 1000.0)
    (1000.0, 0.0)
    """
    if time.size < 2:
        raise damaged(path, f"must hold at least 2 samples, {time.size} found", "Give a longer record")
    check_finite(path, column, time)
    if abs(time[0]) > LATEST:
        rule = f"the times of {quoted(column)} must be in seconds or state their unit, {time[0]:.6g} found"
        raise damaged(path, rule, "Name the unit, as in time [ms]")
    step = (time[-1] - time[0]) / (time.size - 1)
    if not (step > 0.0 and np.isfinite(1.0 / step)):
        rule = f"the times of {quoted(column)} must rise, from {time[0]:g} to {time[-1]:g} s found"
        raise damaged(path, rule, "Export it again")
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


def check_finite(path: Path, name: str, values: Floats) -> None:
    """Raise `MeasurementError` with the count and the first place of samples that are NaN or infinite."""
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


def agreed_rate(path: Path, name: str, declared: Iterable[Declaration], given: float | None) -> float:
    """Return the one sampling rate [Hz] of a channel by the file's declarations and the rate that the caller gives [Hz].

    The caller's decides between declarations that contradict each other.

    Raises `MeasurementError` where a declared rate is no positive number, or two contradict each other; `InputError` where there
    is none, or the caller's agrees with none of the file's.
    """
    known = list(declared)
    for source, rate in known:
        if not (np.isfinite(rate) and rate > 0.0):
            rule = f"channel {quoted(name)} must have a positive sampling rate, {source} gives {rate:g} Hz"
            raise damaged(path, rule)
    if given is not None:
        for _, rate in known:
            if abs(given - rate) <= AGREEMENT * rate:
                return rate
        if known:
            rule = f"must agree with {known[0][1]:g} Hz, which {shorten(path.name)} states for {quoted(name)}"
            raise InputError.of("sampling", given, rule, "Leave the sampling rate out")
        return float(given)
    if not known:
        rule = f"must be given, since {shorten(path.name)} does not state it for {quoted(name)}"
        raise InputError.of("sampling", NO_VALUE, rule, "Give the sampling rate in Hz")
    first = known[0]
    for source, rate in known[1:]:
        if abs(rate - first[1]) > AGREEMENT * first[1]:
            rule = f"states two sampling rates for {quoted(name)}: {first[1]:g} Hz ({first[0]}) and {rate:g} Hz ({source})"
            raise damaged(path, rule, "Give the sampling rate that is right")
    return first[1]


def declarations(values: Iterable[tuple[str, object]]) -> list[Declaration]:
    """Return the sampling rates that named values declare.

    >>> declarations([("fs", 1000.0), ("gain", 3.0)])
    [('fs', 1000.0)]
    """
    rates = ((name, declared_rate(name, value)) for name, value in values)
    return [(shorten(name, 40), rate) for name, rate in rates if rate is not None]
