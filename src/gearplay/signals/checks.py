"""Argument checks of signal analysis."""

import inspect
import math
import numbers
from collections.abc import Callable
from functools import wraps
from types import UnionType
from typing import Any, NoReturn, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.vocabulary.arguments import bound_arguments
from gearplay.vocabulary.errors import InputError, join_path

Floats = NDArray[np.float64]

LARGEST = 1e140
"""Largest sample taken; its square and its fourth moment over a record still fit a floating-point number."""

TWO_PI = 2.0 * math.pi


def refuse(path: str, value: object, rule: str, cure: str) -> NoReturn:
    """Raise `InputError` with one fault."""
    raise InputError.of(path, value, rule, cure)


def checked_classes(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that checks, before each call, the classes of arguments such as `Channel` and `Spectrum`.

    It raises `InputError` for an argument of another class than its annotation has, a missing and an unknown one.
    """
    signature, expected = inspect.signature(function), {}
    for name, hint in get_type_hints(function).items():
        kinds = get_args(hint) if isinstance(hint, UnionType) else (hint,)
        ours = any(kind.__module__.startswith("gearplay") for kind in kinds)
        if name != "return" and ours and not any(get_args(kind) for kind in kinds):
            expected[name] = tuple(numbers.Real if kind is float else kind for kind in kinds)

    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        bound = bound_arguments(function.__name__, signature, args, named)
        for name, kinds in expected.items():
            value = bound.arguments.get(name)
            if name in bound.arguments and not isinstance(value, kinds):
                words = " or ".join("None" if kind is type(None) else kind.__name__ for kind in kinds)
                make = 'Make one: gearplay.Channel("acc", samples, sampling)'
                cure = make if Channel in kinds else f"See help(gearplay.signals.{function.__name__})"
                refuse(name, value, f"must be of type {words}", cure)
        return function(*bound.args, **bound.kwargs)

    return call


def check_channel(channel: Channel, least: int = 8) -> Floats:
    """Return the samples of a channel, shape [time], as floats.

    Raises `InputError` for a sampling rate that is not positive, more than one dimension, fewer than ``least`` samples, a
    sample that is no finite number, or one beyond 1e140.

    >>> check_channel(Channel("acc", np.arange(8), 100.0))[:3].tolist()
    [0.0, 1.0, 2.0]
    """
    name = join_path([channel.name or "channel"])
    if not (math.isfinite(channel.sampling) and channel.sampling > 0.0):
        refuse(f"{name}.sampling", channel.sampling, "must be greater than 0 Hz", "Give the sampling rate")
    raw = np.asarray(channel.values)
    if raw.dtype.kind not in "fiub":
        refuse(f"{name}.values", f"type {raw.dtype}", "must be real numbers", "Give one real signal")
    if raw.ndim != 1 or raw.size < least:
        rule = f"must be one signal of at least {least} samples"
        refuse(f"{name}.values", f"shape {raw.shape}", rule, "Take a longer record or one channel of it")
    values = np.asarray(raw, dtype=np.float64)
    bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
    if bad.size:
        found = f"{values[bad[0]]} at sample {bad[0]}, {bad.size} in all"
        refuse(f"{name}.values", found, "must be finite numbers below 1e140", "Cut or repair these samples")
    return values


def check_positive(path: str, value: float, unit: str) -> float:
    """Return ``value``. Raises `InputError` where it is no finite number greater than 0."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        refuse(path, value, f"must be a number greater than 0 {unit}".rstrip(), "Give a positive number")
    if not (math.isfinite(value) and value > 0.0):
        refuse(path, float(value), f"must be greater than 0 {unit}".rstrip(), "Give a positive number")
    return float(value)


def check_real(path: str, value: float, low: float, high: float, cure: str) -> float:
    """Return ``value``. Raises `InputError` where it is no finite number from ``low`` to ``high``."""
    is_real = isinstance(value, (int, float, np.number)) and not isinstance(
        value, (bool, complex, np.complexfloating)
    )
    if not (is_real and low <= value <= high and math.isfinite(value)):
        refuse(path, value, f"must be a number from {low:g} to {high:g}", cure)
    return float(value)


def check_choice(path: str, value: str, choices: tuple[str, ...]) -> str:
    """Return ``value``. Raises `InputError` where it is none of ``choices``."""
    if value not in choices:
        refuse(path, value, "must be a known choice", f"Choose from: {', '.join(choices)}")
    return value


def check_count(path: str, value: int, low: int, high: int, cure: str) -> int:
    """Return ``value``. Raises `InputError` where it is no whole number from ``low`` to ``high``."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        refuse(path, value, f"must be a whole number from {low} to {high}", cure)
    return int(value)


def check_band(channel: Channel, low: float, high: float) -> tuple[float, float]:
    """Return the band [Hz].

    Raises `InputError` where it is empty, narrower than the record's resolution, or reaches above half the sampling rate.
    """
    shown = f"{low} to {high} Hz"
    if not (math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high):
        refuse("band", shown, "must rise from 0 Hz or more", "Give the lower frequency first")
    if high > 0.5 * channel.sampling:
        rule = f"must end at {0.5 * channel.sampling:g} Hz, half the sampling rate, or below"
        refuse("band", shown, rule, "Lower the band or sample faster")
    if (high - low) * channel.duration < 2.0:
        rule = f"must hold at least 2 lines of the record (one each {1.0 / channel.duration:.4g} Hz)"
        refuse("band", shown, rule, "Widen the band or take a longer record")
    return float(low), float(high)


def check_overlap(overlap: float) -> float:
    """Return the overlap of two segments, a share. Raises `InputError` where it is not in [0, 0.95]."""
    if not (isinstance(overlap, (int, float)) and 0.0 <= overlap <= 0.95):
        refuse("overlap", overlap, "must be a share from 0 to 0.95", "0.5 suits a Hann window")
    return float(overlap)


def default_segment(n: int) -> int:
    """Return the power of two nearest below an eighth of ``n`` samples, but at least 256 or all of them.

    >>> default_segment(100), default_segment(3000), default_segment(80_000)
    (100, 256, 8192)
    """
    return min(n, max(256, 1 << (max(n // 8, 1).bit_length() - 1)))
