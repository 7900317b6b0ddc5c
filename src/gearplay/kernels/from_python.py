"""Calls of kernels of the library from Python, with numba's argument layout."""

import ctypes
import operator
import typing
from collections.abc import Callable
from typing import Any

import numpy as np

from gearplay.kernels.by_address import Group, compiled_forms, form_of
from gearplay.kernels.signatures import Signed, array_of

_NUMBERS: dict[Any, Any] = {int: ctypes.c_int64, float: ctypes.c_double, bool: ctypes.c_bool}
_NOTHING = (None, None)
"""The parent of an array and the count of its references, unused by compiled code."""


class _Parameter:
    """How an argument is handed over: the words that it takes."""

    def __init__(self, name: str, hint: Any, library: ctypes.CDLL) -> None:
        self.name, self.hint, self.library, self.array = name, hint, library, array_of(hint)
        self.is_group = isinstance(hint, type) and issubclass(hint, Group)
        self.checked = False
        if self.array is not None:
            pointer, word = ctypes.c_void_p, ctypes.c_int64
            self.words = [pointer, pointer, word, word, pointer, *(2 * self.array[1] * [word])]
        else:
            self.words = [ctypes.c_void_p if self.is_group else _NUMBERS[hint]]

    def _check_form(self) -> None:
        """Raise `TypeError` where the library was compiled for another form of the group."""
        form, compiled = form_of(self.hint), compiled_forms(self.library)[self.hint.__name__]
        if form != compiled:
            raise TypeError(f"{self.name} was compiled for {compiled}, not for {form}")
        self.checked = True

    def append(self, words: list[Any], value: Any) -> None:
        """Append the words of a value."""
        if self.is_group:
            if not isinstance(value, self.hint):
                raise TypeError(f"{self.name} must be {self.hint.__name__}, not {type(value).__name__}")
            if not self.checked:
                self._check_form()
            words.append(value._address)
        elif self.hint is int:
            number = operator.index(value)
            if not -(2**63) <= number < 2**63:
                raise TypeError(f"{self.name} must be an integer of 64 bits, not {number}")
            words.append(number)
        elif self.array is None:
            words.append(self.hint(value))
        else:
            fits = isinstance(value, np.ndarray) and (value.dtype, value.ndim) == self.array
            if not fits or not value.flags.carray:
                raise TypeError(
                    f"{self.name} must be a C-contiguous array that can be written to, {self.array}"
                )
            words += (*_NOTHING, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)


class FromPython:
    """A kernel of the library as Python calls it, without the GIL.

    Raises
    ------
    TypeError, ValueError
        If an argument is not what the kernel was compiled for.
    IndexError
        If an index is beyond its array, where compiled code checks that.

    """

    def __init__(self, signed: Signed, library: ctypes.CDLL) -> None:
        hints, result = signed.hints
        self.name = signed.name
        self.parameters = [
            _Parameter(f"{name} of {signed.name}", hint, library) for name, hint in hints.items()
        ]
        words = [word for parameter in self.parameters for word in parameter.words]
        self.function = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *words)(
            (signed.symbol, library)
        )
        self.one = typing.get_origin(result) is not tuple
        parts = (result,) if self.one else typing.get_args(result)
        self.places = [f"at_{n}" for n in range(len(parts))]
        kinds = [_NUMBERS.get(part, ctypes.c_void_p) for part in parts]  # None is an empty address
        fields = {"_fields_": list(zip(self.places, kinds, strict=True))}
        self.result = type("Result", (ctypes.Structure,), fields)

    def __call__(self, args: tuple[Any, ...]) -> Any:
        """Call it with arguments by place; return its number, or a tuple of them."""
        return self.bind(args)()

    def bind(self, args: tuple[Any, ...]) -> Callable[[], Any]:
        """Return a function of no arguments that calls it with these, converted once; arrays may change their content.

        One thread at a time may call it, as the result has one place in memory.
        """
        if len(args) != len(self.parameters):
            raise TypeError(f"{self.name} takes {len(self.parameters)} arguments")
        words: list[Any] = []
        for parameter, value in zip(self.parameters, args, strict=True):
            parameter.append(words, value)

        function, result, fault = self.function, self.result(), ctypes.c_void_p()
        passed = (ctypes.addressof(result), ctypes.addressof(fault), *words)

        def call() -> Any:
            if function(*passed) != 0:
                raise IndexError(f"{self.name}: beyond the bounds of an array")
            return result.at_0 if self.one else tuple([getattr(result, place) for place in self.places])

        call.arguments = args, fault  # type: ignore[attr-defined] # alive as long as their addresses are used
        return call
