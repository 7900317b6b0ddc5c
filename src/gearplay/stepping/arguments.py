"""Arguments of a stepper."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.vocabulary.arguments import Whole
from gearplay.vocabulary.errors import InputError

LONGEST: Final = 1e6
"""Longest step [s]."""


def checked_time(dt: Any) -> float:
    """Return the length of a step [s]; `InputError` for any other value."""
    if type(dt) is float and 0.0 <= dt <= LONGEST:
        return dt
    fits = isinstance(dt, (int, float, np.floating, np.integer)) and not isinstance(dt, bool)
    if not fits or not 0.0 <= dt <= LONGEST:
        raise InputError.of("dt", dt, f"must be a time of 0 to {LONGEST:g} s", "Give the step in seconds")
    return float(dt)


def check_names(name: str, given: Any) -> None:
    """Raise `InputError` unless the value is a list of texts."""
    listed = isinstance(given, Sequence) and not isinstance(given, (str, bytes))
    if not listed or not all(isinstance(each, str) for each in given):
        raise InputError.of(name, given, "must be a list of texts", f"Write {name}=[...]")


def check_count(name: str, given: Any, most: int, low: int = 1) -> None:
    """Raise `InputError` unless the value is a whole number from ``low`` to ``most``."""
    if rule := Whole(low, most).fault(given):
        raise InputError.of(name, given, rule, "Change it")


FEW: Final = 16
"""Values that Python's own sum is faster for than an array of flags."""
_DOUBLE: Final = np.dtype(np.float64)


def plain_numbers(given: Any, count: int) -> list[float] | None:
    """Return a few finite numbers that need no conversion, a list of floats or an array of shape [count]; None for all else."""
    if count > FEW:
        return None
    if type(given) is np.ndarray:
        if given.dtype is not _DOUBLE or given.shape != (count,):
            return None
        values = given.tolist()
    elif type(given) is list and len(given) == count and all(type(value) is float for value in given):
        values = given
    else:
        return None
    return values if math.isfinite(sum(values)) else None


def checked_inputs(u: Any, shapes: Sequence[tuple[int, ...]]) -> NDArray[np.float64]:
    """Return values of inputs, of one of some shapes; `InputError` for other shapes and numbers that are not finite."""
    try:
        given = np.asarray(u, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError.of("u", u, "must be numbers", "Give an array") from None
    if given.shape not in shapes:
        wanted = " or ".join(str(list(shape)) for shape in shapes)
        raise InputError.of("u", f"shape {list(given.shape)}", f"must have shape {wanted}", "Reshape it")
    if not np.isfinite(given).all():
        raise InputError.of("u", float("nan"), "must be finite numbers", "Check the controller")
    return given
