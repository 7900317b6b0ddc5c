"""Kernels that are compiled once, when something first calls them, and not again within everything that calls them.

numba puts a copy of all that a kernel calls into the kernel itself, which LLVM then optimises anew: the innermost forces would
be compiled a dozen times. A call of one of these is a call by address instead. The first call asks for the address, so that
nothing is compiled that a case does not need; from then on it is in a word beside the caller's code. Use it where a call is rare
or its body long.
"""

import ctypes
import os
import signal
import threading
import traceback
import typing
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import update_wrapper
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, cast

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import config
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_constant
from numba.core.typing.templates import signature
from numba.extending import models, register_model, typeof_impl
from numba.np.numpy_support import from_dtype

from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled

P = ParamSpec("P")
R = TypeVar("R")

INTERPRETED = bool(getattr(config, "DISABLE_JIT"))  # noqa: B009  (numba makes it when it is imported)
"""Whether kernels run as plain Python."""
KERNELS: dict[str, "Once[..., Any]"] = {}
"""All of them, by module and name."""

_ADDRESS = ir.IntType(64)
_ASK = ctypes.CFUNCTYPE(ctypes.c_int64)
_PLAIN: dict[Any, Any] = {int: types.int64, float: types.float64, bool: types.boolean, type(None): types.none}


def _numba_type(hint: Any) -> Any:
    """Return numba's type of an annotation: a number, a group, an array, a tuple of numbers."""
    if hint in _PLAIN:
        return _PLAIN[hint]
    if isinstance(hint, type) and issubclass(hint, Group):
        return hint.known_type()
    if typing.get_origin(hint) is tuple:
        return types.Tuple([_numba_type(part) for part in typing.get_args(hint)])
    dimensions = 1
    if typing.get_origin(hint) is typing.Annotated:
        hint, dimensions = typing.get_args(hint)
    (dtype,) = typing.get_args(typing.get_args(hint)[1])
    return types.Array(from_dtype(np.dtype(dtype)), dimensions, "C")


@contextmanager
def _noting_interrupts() -> Iterator[list[int]]:
    """Note Ctrl-C within the block instead of obeying it; it comes to the main thread only."""
    came: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield came
        return
    before = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        yield came
    finally:
        signal.signal(signal.SIGINT, before)


def _interrupt_soon() -> None:
    """Let Ctrl-C come again once compiled code has been returned to, where it does no harm."""
    again = threading.Timer(0.01, _interrupt)
    again.daemon = True
    again.start()


def _interrupt() -> None:
    """Send Ctrl-C to the main thread."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:  # Windows, where a process cannot send it to itself otherwise
        signal.raise_signal(signal.SIGINT)


class Once(Generic[P, R]):
    """A kernel that is called by address; made by `compiled_once`."""

    def __init__(self, function: Callable[P, R]) -> None:
        self.py_func = function
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.dispatcher: Any = compiled(function)
        update_wrapper(self, function)
        self._asked = _ASK(self._answer)  # must live as long as compiled code may ask
        llvm.add_symbol(self.name, ctypes.cast(self._asked, ctypes.c_void_p).value)
        self.type = OnceType(self)
        KERNELS[self.name] = self
        lower_builtin(self.name, types.VarArg(types.Any))(self._call)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call it from Python."""
        return cast(R, self.dispatcher(*args, **kwargs))

    @property
    def folder(self) -> Path | None:
        """The folder of its compiled code; None where it is not kept."""
        path = self.dispatcher._cache.cache_path
        return None if path is None else Path(path)

    @property
    def length(self) -> int:
        """How long its source is; its time of compilation grows with it."""
        return len(self.py_func.__code__.co_code)

    def signature(self) -> Any:
        """Return numba's signature, from the annotations."""
        hints = typing.get_type_hints(self.py_func, include_extras=True)
        result = _numba_type(hints.pop("return"))
        return signature(result, *(_numba_type(hint) for hint in hints.values()))

    def address(self) -> int:
        """Return the address of the compiled code; the first time it is compiled, or loaded from its cache."""
        wanted = self.signature()
        self.dispatcher.compile(wanted.args)
        entry = self.dispatcher.overloads[wanted.args]
        return int(entry.library.get_pointer_to_function(entry.fndesc.llvm_func_name))

    def _answer(self) -> int:
        """Return the address to compiled code, which can take no exception and cannot go on without: Ctrl-C comes later."""
        interrupted = False
        while True:
            try:
                with _noting_interrupts() as came:
                    address = self.address()
                if came or interrupted:
                    _interrupt_soon()
                return address
            except KeyboardInterrupt:  # before it was noted
                interrupted = True
            except BaseException:
                traceback.print_exc()
                os._exit(70)

    def _call(self, context: Any, builder: Any, sig: Any, args: Any) -> Any:
        """Emit a call by address."""
        word = cgutils.add_global_variable(builder.module, _ADDRESS, f"{self.name}.address")
        word.linkage, word.initializer = "internal", ir.Constant(_ADDRESS, 0)
        known = builder.load(word)
        address = cgutils.alloca_once_value(builder, known)
        with builder.if_then(builder.icmp_unsigned("==", known, ir.Constant(_ADDRESS, 0)), likely=False):
            ask = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_ADDRESS, []), self.name)
            found = builder.call(ask, [])
            builder.store(found, word)
            builder.store(found, address)
        kind = context.call_conv.get_function_type(sig.return_type, sig.args)
        callee = builder.inttoptr(builder.load(address), kind.as_pointer())
        status, result = context.call_conv.call_function(builder, callee, sig.return_type, sig.args, args)
        # An error is an index beyond its bounds, where these are checked.
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return result


class OnceType(types.Callable):
    """How numba knows a kernel that is called by address."""

    def __init__(self, once: Once[..., Any]) -> None:
        self.once = once
        super().__init__(f"once({once.name})")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature, whatever literal numbers a call gives."""
        wanted = self.once.signature()
        if kws or len(args) != len(wanted.args):
            raise TypingError(f"{self.once.name} takes {len(wanted.args)} arguments by place")
        for given, want in zip(args, wanted.args, strict=True):
            if context.can_convert(given, want) is None:
                raise TypingError(f"{self.once.name} takes {wanted.args}, not {args}")
        return wanted

    def get_call_signatures(self) -> Any:
        """Return the only signature."""
        return [self.once.signature()], False

    def get_impl_key(self, sig: Any) -> str:
        """Return what the call is emitted by."""
        return self.once.name


@register_model(OnceType)
class _OnceModel(models.OpaqueModel):
    """Nothing: the call knows its address."""


@typeof_impl.register(Once)
def _typeof(value: Once[..., Any], _: Any) -> OnceType:
    return value.type


@lower_constant(OnceType)
def _constant(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return context.get_dummy_value()


def compiled_once(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that its callers call but do not contain.

    Its annotations are its signature: numbers, groups, arrays, tuples of numbers to return.
    """
    return function if INTERPRETED else cast(Callable[P, R], Once(function))
