"""Groups of arrays that compiled code takes by address, so that passing one on costs a single word.

A tuple of arrays reaches a kernel by value: each array is seven words on the stack of every call that is not inlined, and a run
has seventy arrays. A group is a table of addresses and shapes instead. Its fields never change, which the loads from the table
say to the compiler (``invariant.load``): what it has read once it need not read again, whatever is written in between.
"""

import ctypes
import hashlib
from collections.abc import Hashable, Iterable
from functools import lru_cache
from typing import Any, ClassVar, cast

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    register_model,
    unbox,
)
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import from_dtype

_TUPLE: Any = types.BaseTuple


class GroupType(types.Type):
    """How numba knows a group: the type of each field, and its first word in the table."""

    def __init__(self, name: str, fields: dict[str, Any]) -> None:
        self.fields = fields
        self.slots: dict[str, int] = {}
        end = 0
        for field, kind in fields.items():
            self.slots[field] = end
            end += _words(kind)
        digest = hashlib.sha256(repr(fields).encode()).hexdigest()[:8]
        super().__init__(name=f"{name}.{digest}")


def _words(kind: Any) -> int:
    """Return how many words a field takes in the table: an array its address and shape, a group its address."""
    if isinstance(kind, _TUPLE):
        return sum(_words(part) for part in kind)
    return 1 + kind.ndim if isinstance(kind, types.Array) else 1


def _describe(values: Iterable[Any], words: list[int]) -> tuple[Hashable, ...]:
    """Append the words of fields' values to those of a table; return what their types depend on."""
    found: list[Hashable] = []
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
            found.append(value._numba_type_)
        elif isinstance(value, tuple):
            found.append(("tuple", *_describe(value, words)))
        else:
            raise TypeError("a group holds C-contiguous arrays, groups and tuples of them")
    return tuple(found)


def _type_of(description: Any) -> Any:
    """Return numba's type of what `_describe` describes."""
    if isinstance(description, GroupType):
        return description
    if description[0] == "tuple":
        return types.Tuple([_type_of(part) for part in description[1:]])
    return types.Array(from_dtype(description[0]), description[1], "C")


@lru_cache
def _group_type(group: str, names: tuple[str, ...], descriptions: tuple[Hashable, ...]) -> GroupType:
    return GroupType(group, {name: _type_of(each) for name, each in zip(names, descriptions, strict=True)})


class Group:
    """Base of frozen dataclasses whose fields are C-contiguous arrays, other groups, or tuples of arrays.

    Raises
    ------
    TypeError
        If a field is something else.

    """

    _numba_type_: GroupType
    _last_type: ClassVar[GroupType]
    _address: int

    @classmethod
    def known_type(cls) -> GroupType:
        """Return numba's type of the groups of this class; one must have been made."""
        return cls._last_type

    def __post_init__(self) -> None:
        words: list[int] = []
        names = tuple(self.__dict__)
        descriptions = _describe(self.__dict__.values(), words)
        table = np.array(words, dtype=np.int64)
        self.__dict__.update(  # past the freeze
            _table=table,
            _address=table.ctypes.data,
            _numba_type_=_group_type(type(self).__name__, names, descriptions),
        )
        type(self)._last_type = self._numba_type_

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by the fields: addresses are of this process."""
        return type(self), tuple(getattr(self, name) for name in self._numba_type_.fields)


@register_model(GroupType)
class _GroupModel(models.OpaqueModel):
    """A group in compiled code: the address of its table."""


@infer_getattr
class _GroupAttributes(AttributeTemplate):
    key = GroupType

    def generic_resolve(self, group: GroupType, field: str) -> Any:  # type: ignore[override]
        return group.fields.get(field)


@unbox(GroupType)
def _unbox(kind: GroupType, value: Any, c: Any) -> NativeValue:
    number = c.pyapi.object_getattr_string(value, "_address")
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return NativeValue(address)


def _load(builder: Any, table: Any, slot: int, kind: Any) -> Any:
    """Emit the load of a word that never changes."""
    place = builder.gep(table, [ir.Constant(ir.IntType(64), 8 * slot)], source_etype=ir.IntType(8))
    word = builder.load(place, typ=kind)
    word.set_metadata("invariant.load", builder.module.add_metadata([]))
    return word


def _field(context: Any, builder: Any, table: Any, slot: int, kind: Any) -> Any:
    """Emit the value of a field of type ``kind`` whose words begin at ``slot``."""
    if isinstance(kind, _TUPLE):
        parts = []
        for part in kind:
            parts.append(_field(context, builder, table, slot, part))
            slot += _words(part)
        return context.make_tuple(builder, kind, parts)
    if isinstance(kind, GroupType):
        return _load(builder, table, slot, cgutils.voidptr_t)
    word = context.get_value_type(types.intp)
    data = _load(builder, table, slot, context.get_value_type(types.CPointer(kind.dtype)))
    shape = [_load(builder, table, slot + 1 + axis, word) for axis in range(kind.ndim)]
    itemsize = ir.Constant(word, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides = [itemsize]
    for extent in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], extent))
    array = make_array(kind)(context, builder)
    populate_array(array, data=data, shape=shape, strides=strides, itemsize=itemsize, meminfo=None)
    return array._getvalue()


@lower_getattr_generic(GroupType)
def _lower(context: Any, builder: Any, group: GroupType, table: Any, field: str) -> Any:
    """Emit a read of a field."""
    return _field(context, builder, table, group.slots[field], group.fields[field])
