"""Groups of arrays that compiled code takes by address, so that passing one on costs a single word.

A tuple of arrays reaches a kernel by value: each array is seven words on the stack of every call that is not inlined, and a run
has seventy arrays. A group is a table of addresses and shapes instead; how compiled code reads it stands in `compiler`.
"""

import ctypes
import dataclasses
import json
import typing
from collections.abc import Iterable
from functools import cache
from typing import Any, ClassVar, Final, cast

import numpy as np

from gearplay.kernels.signatures import array_of

FORMS: Final = "gearplay_forms"
"""Symbol of the text with the forms of all groups that a library was compiled for."""
Shapes = Any
"""What a field is: an array's dtype and dimensions, a group's class, a tuple of the arrays of records."""


def _describe(values: Iterable[Any], words: list[int]) -> tuple[Shapes, ...]:
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

    Annotations declare the dtype and the dimensions of each field (`gearplay.kernels.arrays`), those of records by their dtype:
    ``Annotated[NDArray[Any], ROTOR]``. Compiled code knows this form alone.

    Raises
    ------
    TypeError
        If a field is not what its annotation declares.

    """

    _address: int
    _declared: ClassVar[dict[str, Shapes]] = {}
    """Shapes of fields that annotations cannot tell: of `declare`."""

    def __post_init__(self) -> None:
        words: list[int] = []
        shapes = _describe(self.__dict__.values(), words)
        if shapes != tuple(type(self).shapes().values()):
            raise TypeError(f"{type(self).__name__} must have {type(self).shapes()}, not {shapes}")
        table = np.array(words, dtype=np.int64)
        self.__dict__.update(_table=table, _address=table.ctypes.data)  # past the freeze

    @classmethod
    @cache
    def shapes(cls) -> dict[str, Shapes]:
        """Return the shape of each field: dtype and dimensions of an array, class of a group, items of a tuple."""
        hints = typing.get_type_hints(cls, include_extras=True)
        names = [field.name for field in dataclasses.fields(cast(Any, cls))]
        return {name: cls._declared.get(name) or _shape_of(hints[name]) for name in names}

    @classmethod
    def declare(cls, name: str, records: Iterable[np.dtype[Any]]) -> None:
        """Declare the dtypes of the arrays of records in a tuple."""
        cls._declared = {**cls._declared, name: ("tuple", *((dtype, 1) for dtype in records))}

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by the fields: addresses are of this process."""
        return type(self), tuple(getattr(self, name) for name in type(self).shapes())


@cache
def compiled_forms(library: ctypes.CDLL) -> dict[str, Any]:
    """Return the forms of the groups that a library was compiled for (`group_forms`)."""
    text = ctypes.string_at(ctypes.addressof(ctypes.c_char.in_dll(library, FORMS)))
    found: dict[str, Any] = json.loads(text)
    return found


def form_of(kind: type[Group]) -> Any:
    """Return how the numbers of a group lie in memory, in terms of JSON."""
    return {name: _form_of_field(shape) for name, shape in kind.shapes().items()}


def group_forms() -> dict[str, Any]:
    """Return the form of every class of groups that has been defined, by the name of the class."""
    return {kind.__name__: form_of(kind) for kind in Group.__subclasses__()}


def _shape_of(hint: Any) -> Shapes:
    """Return the shape of a field by its annotation."""
    if isinstance(hint, type) and issubclass(hint, Group):
        return hint
    if typing.get_origin(hint) is typing.Annotated:
        _, declared = typing.get_args(hint)
        if isinstance(declared, np.dtype):
            return declared, 1
    found = array_of(hint)
    if found is None:
        raise TypeError(f"a field of a group must be an array, a group or declared records, not {hint}")
    return found


def _form_of_field(shape: Any) -> Any:
    if isinstance(shape, type):
        return shape.__name__
    if shape[0] == "tuple":
        return [_form_of_field(part) for part in shape[1:]]
    return [repr(shape[0].descr), shape[0].itemsize, shape[1]]
