"""Kernels with explicit signatures, taken from their annotations."""

import typing
from collections.abc import Callable
from functools import cache, cached_property
from hashlib import sha256
from types import CodeType
from typing import Any

import numpy as np

from gearplay.kernels.by_address import Group


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
    """A function with a signature, and the address of what compiled code asks for the function's own."""

    def __init__(self, function: Callable[..., Any], asking: int) -> None:
        self.py_func = function
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.asking = asking

    @cached_property
    def hints(self) -> tuple[dict[str, Any], Any]:
        """The annotations of its parameters, by name, and of what it returns."""
        hints = typing.get_type_hints(self.py_func, include_extras=True)
        result = hints.pop("return")
        return hints, result

    @property
    def form(self) -> str:
        """A digest of what its compiled code depends on beside the sources of kernels: the form of its groups, its own code."""
        hints, result = self.hints
        code = self.py_func.__code__
        constants = [each for each in code.co_consts if not isinstance(each, CodeType)]
        kinds = [
            form_of(hint) if isinstance(hint, type) else repr(hint) for hint in (*hints.values(), result)
        ]
        return sha256(repr((kinds, code.co_code, constants, code.co_names)).encode()).hexdigest()[:16]


@cache
def form_of(kind: Any) -> str:
    """Return how the numbers of a type lie in memory: of a group all its fields, one of it having been made."""
    if not issubclass(kind, Group):
        return str(kind.__name__)
    return repr([(name, _form_of_field(shape)) for name, shape in kind._shapes.items()])


def _form_of_field(shape: Any) -> Any:
    if isinstance(shape, type):
        return form_of(shape)
    if shape[0] == "tuple":
        return [_form_of_field(part) for part in shape[1:]]
    return (shape[0].descr, shape[0].itemsize, shape[1])
