"""Groups of arrays that compiled code takes by address, so that passing one on costs a single word.

A tuple of arrays reaches a kernel by value: each array is seven words on the stack of every call that is not inlined, and a run
has seventy arrays. A group is a table of addresses and shapes instead; how compiled code reads it stands in `compiler`.
"""

import ctypes
import json
from collections.abc import Iterable
from functools import cache
from typing import Any, ClassVar, Final, cast

import numpy as np

FORMS: Final = "gearplay_forms"
"""Symbol of the text with the forms of all groups that a library was compiled for."""
Shapes = tuple[Any, ...]
"""What the types of a group's fields depend on: of an array dtype and dimensions, of a group its class, of a tuple its parts."""


def _describe(values: Iterable[Any], words: list[int]) -> Shapes:
    """Append the words of fields' values to those of a table; return their shapes."""
    found: list[Any] = []
    for value in values:
        if isinstance(value, np.ndarray) and (flags := value.flags).c_contiguous:
            # The address: ``ctypes.data`` takes three times as long. Nobody follows that of an array without numbers.
            if not value.size:
                words.append(0)
            elif flags.writeable:
                words.append(ctypes.addressof(ctypes.c_char.from_buffer(cast(Any, value))))
            else:
                words.append(value.ctypes.data)
            words.extend(value.shape)
            found.append((value.dtype, value.ndim))
        elif isinstance(value, Group):
            words.append(value._address)
            found.append(type(value))
        elif isinstance(value, tuple):
            found.append(("tuple", *_describe(value, words)))
        else:
            raise TypeError("a group holds C-contiguous arrays, groups and tuples of them")
    return tuple(found)


class Group:
    """Base of frozen dataclasses whose fields are C-contiguous arrays, other groups, or tuples of arrays.

    Raises
    ------
    TypeError
        If a field is something else, or not what it was in the first group of the class: compiled code knows one form.

    """

    _shapes: ClassVar[dict[str, Any]]
    """Of every field, as in the first group of the class."""
    _address: int

    def __post_init__(self) -> None:
        words: list[int] = []
        shapes = dict(zip(tuple(self.__dict__), _describe(self.__dict__.values(), words), strict=True))
        if "_shapes" not in type(self).__dict__:
            type(self)._shapes = shapes
        elif shapes != type(self)._shapes:
            raise TypeError(
                f"a field of {type(self).__name__} is not what it was: {type(self)._shapes}, {shapes}"
            )
        table = np.array(words, dtype=np.int64)
        self.__dict__.update(_table=table, _address=table.ctypes.data)  # past the freeze

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by the fields: addresses are of this process."""
        return type(self), tuple(getattr(self, name) for name in type(self)._shapes)


@cache
def compiled_forms(library: ctypes.CDLL) -> dict[str, Any]:
    """Return the forms of the groups that a library was compiled for (`group_forms`)."""
    text = ctypes.string_at(ctypes.addressof(ctypes.c_char.in_dll(library, FORMS)))
    found: dict[str, Any] = json.loads(text)
    return found


def form_of(kind: Any) -> Any:
    """Return how the numbers of a group lie in memory, one of its class having been made, in terms of JSON."""
    return {name: _form_of_field(shape) for name, shape in kind._shapes.items()}


def group_forms() -> dict[str, Any]:
    """Return the form of every class of groups of which one has been made, by the name of the class."""
    return {kind.__name__: form_of(kind) for kind in Group.__subclasses__() if "_shapes" in kind.__dict__}


def _form_of_field(shape: Any) -> Any:
    if isinstance(shape, type):
        return shape.__name__
    if shape[0] == "tuple":
        return [_form_of_field(part) for part in shape[1:]]
    return [repr(shape[0].descr), shape[0].itemsize, shape[1]]
