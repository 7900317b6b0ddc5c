"""Values of REXS attributes: whole numbers, coded arrays, and a budget of them."""

import base64
import binascii
from typing import Any, Final

import numpy as np

from gearplay.rexs.records import refused
from gearplay.vocabulary.errors import shorten

MOST: Final = 2_000_000
"""Most elements, relations, attributes and array values of a model together."""
CODES: Final = {"int32": "<i4", "float32": "<f4", "float64": "<f8"}
_NONE: Final = object()


class Budget:
    """Count of the values read, which refuses a model with more than `MOST`."""

    def __init__(self) -> None:
        self.left = MOST

    def take(self, count: int = 1) -> None:
        """Count values."""
        self.left -= count
        if self.left < 0:
            rule = f"must have at most {MOST} elements and values"
            raise refused("file", rule, "Export the model without results and finite elements")


def whole(value: Any, where: str, default: Any = _NONE) -> int:
    """Return a whole number of the file; a float without decimals counts, since some programs write ids so."""
    if value is None and default is not _NONE:
        return int(default)
    try:
        number = float(value) if not isinstance(value, bool) else None
        if number is None or number != int(number) or abs(number) > 2**53:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise refused(
            f"{where}, id" if where[-1] != "d" else where, "must be a whole number", "Export it again"
        ) from None
    return int(number)


def decoded(text: str, code: str, name: str, budget: Budget) -> list[float]:
    """Return the numbers of an array in base64, little-endian; `InputError` for an unknown code or damaged text."""
    where = f"attribute {shorten(name)}"
    if code not in CODES:
        raise refused(
            where, f"must be coded as {', '.join(CODES)}, not {shorten(code, 20)!r}", "Export it again"
        )
    try:
        content = base64.b64decode("".join(text.split()), validate=True)
    except (binascii.Error, ValueError):
        raise refused(where, "must be valid base64", "Export it again") from None
    kind = np.dtype(CODES[code])
    if len(content) % kind.itemsize:
        rule = f"must be whole numbers of {kind.itemsize} bytes; it has {len(content)} bytes"
        raise refused(where, rule, "Export it again")
    budget.take(len(content) // kind.itemsize)
    return [float(each) for each in np.frombuffer(content, kind)]
