"""The compiler of a CUDA device, which is numba-cuda: what it is told of groups, and kernels translated for it.

A kernel's globals name other kernels, of which the device knows nothing. A translated one is the same code with other globals,
in which every kernel is a function of the device. What a mechanism has no elements for is not compiled: the compiler would take
minutes for it, and nobody calls it.
"""

import re
import types as python
import typing
from functools import cache
from typing import Any

from cuda.core import Linker, LinkerOptions, ObjectCode
from llvmlite import ir
from numba import cuda
from numba.cuda import cgutils, types
from numba.cuda.compiler import compile_cuda, kernel_fixup
from numba.cuda.core.imputils import lower_getattr_generic
from numba.cuda.datamodel import models
from numba.cuda.dispatcher import CUDADispatcher
from numba.cuda.extending import infer_getattr, intrinsic, register_model
from numba.cuda.np.arrayobj import make_array, populate_array
from numba.cuda.np.numpy_support import from_dtype
from numba.cuda.typing.templates import AttributeTemplate

from gearplay.device.turns import make_turn
from gearplay.device.words import LANES, WORD
from gearplay.kernels import stepper
from gearplay.kernels.compiled import CONTAINED
from gearplay.kernels.layout import System
from gearplay.kernels.machine_code import Code
from gearplay.kernels.run import Run
from gearplay.kernels.signed import Signed

_OPTIONS: Any = {"device": True, "debug": False, "opt": True, "fastmath": False}
_EXACT: Any = {
    "opt": 3,
    "fma": 0,
}  # products and sums rounded one by one, as on the processor: the same steps, the same error
_ZEROS: dict[Any, Any] = {int: 0, float: 0.0, bool: False, type(None): None}
_WORD = ir.IntType(64)


def compile_turn(without: frozenset[str], capability: tuple[int, int]) -> Code:
    """Compile a turn for a device of a capability.

    ``without`` names the modules of kernels that no mechanism needs: what calls them gets zeros.
    """
    translation = _Translation(without, capability)
    turn = make_turn(
        translation.of(stepper.advance),
        _group_at(group_type(Run, LANES)),
        _group_at(group_type(System, 1)),
        cuda.grid,
        _word,
        _set_word,
        _set_number,
    )
    words = (types.int64, types.int64, types.int64)
    made = compile_cuda(turn, types.void, words, nvvm_options=_EXACT, cc=capability)
    library = made.library
    kernel_fixup(library.get_function(made.fndesc.llvm_func_name), False)
    # A library has one of each module of another for every way that leads there: some thousand of some hundred.
    library._llvm_strs = [str(module) for module in {id(each): each for each in library.modules}.values()]
    code = library.get_asm_str(cc=capability)
    entry = re.search(r"\.entry\s+(\w+)", code)
    assert entry is not None
    return Code(entry[1], [], _machine_code(code, capability))


def _machine_code(code: str, capability: tuple[int, int]) -> bytes:
    """Return what the device runs, of the portable code that a compiler newer than its driver may have written."""
    major, minor = capability
    linker = Linker(ObjectCode.from_ptx(code.encode()), options=LinkerOptions(arch=f"sm_{major}{minor}"))
    return bytes(linker.link("cubin").code)


# Kernels


class _Function(CUDADispatcher):
    """A kernel as a function of the device: compiled for one capability, contained by its callers or called by them."""

    def __init__(self, function: Any, capability: tuple[int, int], contained: bool | None) -> None:
        super().__init__(function, targetoptions=dict(_OPTIONS))
        self.capability, self.contained = capability, contained

    def compile_device(self, args: Any, return_type: Any = None) -> Any:
        """Compile it for arguments of these types, once."""
        if args not in self.overloads:
            made = compile_cuda(
                self.py_func,
                return_type,
                args,
                forceinline=bool(self.contained),
                nvvm_options=_EXACT,
                cc=self.capability,
            )
            if self.contained is None:  # or each of their callers would be as long as all of them
                made.library.get_function(made.fndesc.llvm_func_name).attributes.add("noinline")
            self.overloads[args] = made
            made.target_context.insert_user_function(made.entry_point, made.fndesc, [made.library])
        return self.overloads[args]


class _Module(python.ModuleType):
    """A module of kernels as the device knows it."""

    def __init__(self, module: python.ModuleType, translation: "_Translation") -> None:
        super().__init__(module.__name__)
        self._read = lambda name: translation.of(getattr(module, name))

    def __getattr__(self, name: str) -> Any:
        return self._read(name)


class _Translation:
    """Kernels translated so far."""

    def __init__(self, without: frozenset[str], capability: tuple[int, int]) -> None:
        self._without, self._capability = without, capability
        self._known: dict[Any, Any] = {}

    def of(self, value: Any) -> Any:
        """Return what stands on the device for something that a kernel names."""
        if isinstance(value, Signed):
            return self._function(value.py_func, None)
        if isinstance(value, python.FunctionType) and value in CONTAINED:
            return self._function(value, CONTAINED[value])
        if isinstance(value, python.ModuleType) and value.__name__.startswith("gearplay."):
            if value not in self._known:
                self._known[value] = _Module(value, self)
            return self._known[value]
        return value

    def _function(self, function: Any, contained: bool | None) -> _Function:
        if function not in self._known:
            names: dict[str, Any] = {}
            copy = python.FunctionType(function.__code__, names, function.__name__, function.__defaults__)
            copy.__module__ = function.__module__
            made = _nothing(function) if self._is_without(function.__module__) else copy
            self._known[function] = _Function(made, self._capability, contained)
            if made is copy:  # what it names may name it
                names.update(self._names(function))
        return self._known[function]

    def _is_without(self, module: str) -> bool:
        return any(module == name or module.startswith(f"{name}.") for name in self._without)

    def _names(self, function: Any) -> dict[str, Any]:
        known = function.__globals__
        names = {name: self.of(known[name]) for name in _names(function.__code__) if name in known}
        return names | {"__builtins__": known["__builtins__"], "__name__": known["__name__"]}


def _names(code: python.CodeType) -> set[str]:
    """Return the names that a function uses, those of functions within it too."""
    found = set(code.co_names)
    for each in code.co_consts:
        if isinstance(each, python.CodeType):
            found |= _names(each)
    return found


def _nothing(function: Any) -> Any:
    """Return a function that returns zeros as an unneeded one would numbers."""
    wanted = typing.get_type_hints(function)["return"]
    parts = typing.get_args(wanted)
    zero = tuple(_ZEROS[part] for part in parts) if parts else _ZEROS[wanted]

    def nothing(*_: Any) -> Any:
        return zero

    nothing.__module__, nothing.__name__ = function.__module__, function.__name__
    return nothing


# Groups


class GroupType(types.Type):
    """How numba-cuda knows a group: the type of each field, its first word in the table, words from a number to the next."""

    def __init__(self, name: str, fields: dict[str, Any], apart: int) -> None:
        self.fields, self.apart = fields, apart
        self.slots: dict[str, int] = {}
        self.length = 0
        for field, kind in fields.items():
            self.slots[field] = self.length
            self.length += _length(kind)
        super().__init__(name=f"{name}{apart}")


@cache
def group_type(kind: Any, apart: int) -> GroupType:
    """Return the type of the groups of a class; one must have been made."""
    return GroupType(
        kind.__name__, {name: _type_of(shape, apart) for name, shape in kind._shapes.items()}, apart
    )


def _type_of(shape: Any, apart: int) -> Any:
    """Return the type of a field."""
    if isinstance(shape, type):
        return group_type(shape, apart)
    if shape[0] == "tuple":
        return types.Tuple([_type_of(part, apart) for part in shape[1:]])
    if apart > 1 and shape[0].itemsize not in (WORD, 2 * WORD):
        raise TypeError(f"what lies interleaved must be numbers, real or complex, not {shape[0]}")
    return types.Array(from_dtype(shape[0]), shape[1], "C" if apart == 1 else "A")


def _length(kind: Any) -> int:
    """Return how many words of the table a field takes."""
    if isinstance(kind, types.BaseTuple):
        return sum(_length(part) for part in kind)
    return kind.length if isinstance(kind, GroupType) else 1 + kind.ndim


@register_model(GroupType)
class _GroupModel(models.StructModel):
    """A group on the device: where its part of the table begins, and where its run or mechanism does."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("table", types.int64), ("base", types.int64)])


@infer_getattr
class _GroupAttributes(AttributeTemplate):
    key = GroupType

    def generic_resolve(self, group: GroupType, field: str) -> Any:
        return group.fields.get(field)


@lower_getattr_generic(GroupType)
def _lower(context: Any, builder: Any, group: GroupType, value: Any, field: str) -> Any:
    """Emit a read of a field."""
    made = cgutils.create_struct_proxy(group)(context, builder, value=value)
    return _field(context, builder, made, group.slots[field], group.fields[field], group.apart)


def _field(context: Any, builder: Any, group: Any, slot: int, kind: Any, apart: int) -> Any:
    """Emit the value of a field of type ``kind`` whose part of the table begins at ``slot``."""
    if isinstance(kind, types.BaseTuple):
        parts = []
        for part in kind:
            parts.append(_field(context, builder, group, slot, part, apart))
            slot += _length(part)
        return context.make_tuple(builder, kind, parts)
    if isinstance(kind, GroupType):
        inner = cgutils.create_struct_proxy(kind)(context, builder)
        inner.table = builder.add(group.table, _WORD(WORD * slot))
        inner.base = group.base
        return inner._getvalue()
    begin, *shape = [_load(builder, group.table, slot + n) for n in range(1 + kind.ndim)]
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    strides = [_WORD(size * apart)]
    for extent in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], extent))
    pointer = context.get_value_type(types.CPointer(kind.dtype))
    base = group.base
    if (
        apart > 1 and size > WORD
    ):  # complex: both parts side by side, so that lanes are twice as far from each other
        base = builder.add(base, builder.and_(base, _WORD(apart * WORD - 1)))
    data = builder.inttoptr(builder.add(base, begin), pointer)
    array = make_array(kind)(context, builder)
    populate_array(array, data=data, shape=shape, strides=strides, itemsize=_WORD(size), meminfo=None)
    return array._getvalue()


def _load(builder: Any, address: Any, slot: int) -> Any:
    """Emit the load of a word that never changes: read once it need not be read again, whatever is written in between."""
    word = builder.load(builder.inttoptr(builder.add(address, _WORD(WORD * slot)), _WORD.as_pointer()))
    word.set_metadata("invariant.load", builder.module.add_metadata([]))
    return word


def _group_at(kind: GroupType) -> Any:
    """Return the device's function that makes a group of a table and of where its words begin."""

    @intrinsic
    def group_at(_: Any, table: Any, base: Any) -> Any:
        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            made = cgutils.create_struct_proxy(kind)(context, builder)
            made.table, made.base = args
            return made._getvalue()

        return kind(types.int64, types.int64), emit

    return group_at


# Words at an address


def _place(builder: Any, address: Any, number: Any, kind: Any) -> Any:
    return builder.inttoptr(builder.add(address, builder.mul(number, _WORD(WORD))), kind.as_pointer())


@intrinsic
def _word(_: Any, address: Any, number: Any) -> Any:
    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_place(builder, args[0], args[1], _WORD))

    return types.int64(types.int64, types.int64), emit


@intrinsic
def _set_word(_: Any, address: Any, number: Any, value: Any) -> Any:
    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _place(builder, args[0], args[1], _WORD))

    return types.void(types.int64, types.int64, types.int64), emit


@intrinsic
def _set_number(_: Any, address: Any, number: Any, value: Any) -> Any:
    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _place(builder, args[0], args[1], ir.DoubleType()))

    return types.void(types.int64, types.int64, types.float64), emit
