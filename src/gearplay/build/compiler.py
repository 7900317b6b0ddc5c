"""Extensions of numba's compiler: groups of arrays passed by address, kernels called by their symbols.

numba's decorators are for functions that Python calls; here compiled code calls, so that its wrappers for Python are left out.
What is private of numba is used in this module alone.
"""

import hashlib
import typing
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any, cast
from unittest.mock import patch

import llvmlite.binding as llvm
from llvmlite import ir
from numba import njit
from numba.core import cgutils, types
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock
from numba.core.datamodel import models
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_constant
from numba.core.registry import cpu_target
from numba.core.typing.templates import AttributeTemplate, signature
from numba.extending import infer_getattr, lower_getattr_generic, register_model, typeof_impl
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import from_dtype

from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import CONTAINED
from gearplay.kernels.signatures import Signed, array_of

# IEEE semantics: ``fastmath`` stays off because it deletes NaN guards; ``error_model="numpy"`` lets a division by zero
# give inf, which the stepper's finite check then reports. Without numba's runtime (``_nrt``) no kernel can allocate and
# no array is reference-counted: twice as fast here, and threads have nothing to fight over.
_OPTIONS: Any = {"nogil": True, "error_model": "numpy", "_nrt": False}
_WITHIN = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_TUPLE: Any = types.BaseTuple
_PLAIN: dict[Any, Any] = {int: types.int64, float: types.float64, bool: types.boolean, type(None): types.none}


def jitted(function: Callable[..., Any], **more: Any) -> Any:
    """Return numba's dispatcher of a function, compiled as kernels are."""
    return njit(**_OPTIONS, **more)(function)


class _Library(JITCodeLibrary):
    """numba's library of a function, as LLVM's intermediate code alone."""

    def _finalize_specific(self) -> None:
        """Make no machine code: a build runs nothing of what it compiles."""


class _Codegen(JITCPUCodegen):
    """numba's code generator, which loads nothing into this process: a tenth of the time of a build."""

    _library_class = _Library

    def _add_module(self, module: Any) -> None:
        """Leave the engine that runs code without it."""

    def set_env(self, env_name: str, env: Any) -> None:
        """Set nothing: there is no code whose globals these would be."""


@cache
def _codegen() -> _Codegen:
    return _Codegen("gearplay")


@global_compiler_lock
def compile_kernel(kernel: Signed) -> llvm.ModuleRef:
    """Return the LLVM module of a kernel, which exports one function: the kernel's symbol."""
    wanted = signature_of(kernel)
    dispatcher = jitted(kernel.py_func, **_WITHIN)
    with patch.object(cpu_target.target_context, "_internal_codegen", _codegen()):
        dispatcher.compile(wanted)
    entry = dispatcher.overloads[wanted.args]
    module = entry.library._final_module.clone()
    for function in module.functions:
        if function.name == entry.fndesc.llvm_func_name:
            function.name = kernel.symbol
        elif not function.is_declaration:
            function.linkage = "internal"
    for variable in module.global_variables:
        variable.linkage = "internal"
    return module


@cache
def contained(function: Callable[..., Any]) -> Any:
    """Return numba's dispatcher of a kernel that its callers contain."""
    return jitted(function, forceinline=CONTAINED[function], **_WITHIN)


@typeof_impl.register(FunctionType)
def _typeof_function(value: Any, _: Any) -> Any:
    return types.Dispatcher(contained(value)) if value in CONTAINED else None


# Groups


class GroupType(types.Type):
    """numba's type of a group: the type of each field, and its first word in the table."""

    def __init__(self, name: str, fields: dict[str, Any]) -> None:
        self.fields = fields
        self.slots: dict[str, int] = {}
        end = 0
        for field, kind in fields.items():
            self.slots[field] = end
            end += _words(kind)
        digest = hashlib.sha256(repr(fields).encode()).hexdigest()[:8]
        super().__init__(name=f"{name}.{digest}")


@cache
def group_type(kind: Any) -> GroupType:
    """Return numba's type of the groups of a class."""
    return GroupType(kind.__name__, {name: _type_of(each) for name, each in kind.shapes().items()})


@typeof_impl.register(Group)
def _typeof_group(value: Any, _: Any) -> GroupType:
    kind: Any = type(value)
    return group_type(kind)


def _type_of(shape: Any) -> Any:
    """Return numba's type of a field."""
    if isinstance(shape, type):
        return group_type(shape)
    if shape[0] == "tuple":
        return types.Tuple([_type_of(part) for part in shape[1:]])
    return types.Array(from_dtype(shape[0]), shape[1], "C")


def _words(kind: Any) -> int:
    """Return how many words a field takes in the table: an array its address and shape, a group its address."""
    if isinstance(kind, _TUPLE):
        return sum(_words(part) for part in kind)
    return 1 + kind.ndim if isinstance(kind, types.Array) else 1


@register_model(GroupType)
class _GroupModel(models.OpaqueModel):
    """A group in compiled code: the address of its table."""


@infer_getattr
class _GroupAttributes(AttributeTemplate):
    key = GroupType

    def generic_resolve(self, group: GroupType, field: str) -> Any:  # type: ignore[override]
        return group.fields.get(field)


def _load(builder: Any, table: Any, slot: int, kind: Any) -> Any:
    """Emit the load of a constant word, marked as invariant: stores in between do not force it to be read again."""
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


# Kernels that are called by their symbols


def _hinted(hint: Any) -> Any:
    """Return numba's type of an annotation: a number, a group, an array, a tuple of numbers."""
    if hint in _PLAIN:
        return _PLAIN[hint]
    if isinstance(hint, type) and issubclass(hint, Group):
        return group_type(cast(Any, hint))
    if typing.get_origin(hint) is tuple:
        return types.Tuple([_hinted(part) for part in typing.get_args(hint)])
    array = array_of(hint)
    assert array is not None, hint
    return types.Array(from_dtype(array[0]), array[1], "C")


@cache
def signature_of(kernel: Signed) -> Any:
    """Return numba's signature of a kernel, from its annotations."""
    hints, result = kernel.hints
    return signature(_hinted(result), *map(_hinted, hints.values()))


class KernelType(types.Callable):
    """numba's type of a kernel of the library."""

    def __init__(self, kernel: Signed) -> None:
        self.kernel = kernel
        super().__init__(f"kernel({kernel.name})")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature; literal arguments do not change it."""
        wanted = signature_of(self.kernel)
        if kws or len(args) != len(wanted.args):
            raise TypingError(f"{self.kernel.name} takes {len(wanted.args)} arguments by place")
        for given, want in zip(args, wanted.args, strict=True):
            if context.can_convert(given, want) is None:
                raise TypingError(f"{self.kernel.name} takes {wanted.args}, not {args}")
        return wanted

    def get_call_signatures(self) -> Any:
        """Return the only signature."""
        return [signature_of(self.kernel)], False

    def get_impl_key(self, sig: Any) -> str:
        """Return the key of the code generator of the call."""
        return self.kernel.name


@register_model(KernelType)
class _KernelModel(models.OpaqueModel):
    """Data model without a value: the linker resolves the address."""


@cache
def _kernel_type(kernel: Signed) -> KernelType:
    @lower_builtin(kernel.name, types.VarArg(types.Any))
    def call(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        """Emit a call by the kernel's symbol."""
        kind = context.call_conv.get_function_type(sig.return_type, sig.args)
        callee = cgutils.get_or_insert_function(builder.module, kind, kernel.symbol)
        status, result = context.call_conv.call_function(builder, callee, sig.return_type, sig.args, args)
        # An error is an index beyond its bounds, where these are checked.
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return result

    return KernelType(kernel)


@typeof_impl.register(Signed)
def _typeof(value: Signed, _: Any) -> KernelType:
    return _kernel_type(value)


@lower_constant(KernelType)
def _constant(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return context.get_dummy_value()
