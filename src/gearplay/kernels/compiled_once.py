"""Kernels compiled separately and called through a function pointer, so that each is compiled only once.

numba puts a copy of all that a kernel calls into the kernel itself, which LLVM then optimises anew: the innermost forces would
be compiled a dozen times. A call of one of these is a call by address instead. The first call asks for the address, so that
nothing is compiled that a case does not need; from then on it is in a word beside the caller's code. Use it where a call is rare
or its body long, and for all that Python calls: it does so by address too. What is on disk is linked without the compiler, which
alone would take longer to load than all the rest of a short run.
"""

import ctypes
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property, partial, update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar, cast

from gearplay.kernels import compiled_files, machine_code
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.from_python import FromPython
from gearplay.kernels.signatures import Signed

P = ParamSpec("P")
R = TypeVar("R")

KERNELS: dict[str, "Once[..., Any]"] = {}
"""All of them, by module and name."""

_ASK = ctypes.CFUNCTYPE(ctypes.c_int64)


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


class Once(Signed, Generic[P, R]):
    """A kernel that is called by address; made by `compiled_once`."""

    def __init__(self, function: Callable[P, R]) -> None:
        self._asked = _ASK(self._answer)  # must live as long as compiled code may ask
        super().__init__(function, ctypes.cast(self._asked, ctypes.c_void_p).value or 0)
        update_wrapper(self, function)
        self._finding = threading.RLock()
        self._address: int | None = None
        KERNELS[self.name] = self

    @property
    def length(self) -> int:
        """How long its source is; its time of compilation grows with it."""
        return len(self.py_func.__code__.co_code)

    @property
    def found(self) -> bool:
        """Whether its compiled code is in this process."""
        return self._address is not None

    def address(self) -> int:
        """Return the address of the compiled code; the first time it is compiled, or linked from its file."""
        with self._finding:  # a thread that waited here finds it
            if self._address is None:
                self._address = self._linked()
            return self._address

    def _linked(self) -> int:
        file = compiled_files.file_of(self.name)
        code = None if file is None else compiled_files.load(file, self.form)
        address = None if code is None else machine_code.link(code, _asking)
        if address is None:
            from gearplay.kernels.compiler import compile_kernel

            code = compile_kernel(self)
            address = machine_code.link(code, _asking)
            if file is not None:
                compiled_files.save(file, code, self.form)
        assert address is not None
        return address

    @cached_property
    def _from_python(self) -> FromPython:
        return FromPython(self, self.address())

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call it from Python, arguments by place (`FromPython`)."""
        if kwargs:
            raise TypeError(f"{self.name} takes arguments by place")
        return cast(R, self._from_python(args))

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


def bound(kernel: Callable[P, R], *args: P.args, **_: P.kwargs) -> Callable[[], R]:
    """Return a function of no arguments that calls a `compiled_once` kernel with these, for many calls on the same arrays."""
    if isinstance(kernel, Once):
        return cast(Callable[[], R], kernel._from_python.bind(args))
    return partial(kernel, *args)


def _asking(name: str) -> int | None:
    """Return the address of what compiled code asks for a kernel; None for another name."""
    return KERNELS[name].asking if name in KERNELS else None


def compiled_once(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that its callers call but do not contain.

    Its annotations are its signature: numbers, groups, arrays, tuples of numbers to return.
    """
    return function if INTERPRETED else cast(Callable[P, R], Once(function))
