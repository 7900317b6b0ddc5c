"""Kernels with explicit signatures, taken from their annotations."""

import typing
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np


def array_of(hint: Any) -> tuple[np.dtype[Any], int] | None:
    """Return dtype and dimensions of an array's annotation; None for that of something else."""
    dimensions = 1
    if typing.get_origin(hint) is typing.Annotated:
        hint, dimensions = typing.get_args(hint)
    if (meaning := getattr(typing.get_origin(hint), "__value__", None)) is not None:
        hint = meaning[typing.get_args(hint)]  # NumPy 2.5 names its arrays by an alias
    if typing.get_origin(hint) is not np.ndarray:
        return None
    (dtype,) = typing.get_args(typing.get_args(hint)[1])
    return np.dtype(dtype), dimensions


class Signed:
    """A function with a signature, and the symbol of its compiled code."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.py_func = function
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.symbol = self.name.replace(".", "_")

    @cached_property
    def hints(self) -> tuple[dict[str, Any], Any]:
        """Annotations of its parameters and of its return value, by name."""
        hints = typing.get_type_hints(self.py_func, include_extras=True)
        result = hints.pop("return")
        return hints, result
