"""Kernels that are functions of the kernel library: compiled once, called by their symbols.

numba puts a copy of all that a kernel calls into the kernel itself, which LLVM then optimises anew: the innermost forces would be
compiled a dozen times. A call of one of these is a call of a function of the library instead. Use it where a call is rare or its
body long, and for all that Python calls.
"""

from collections.abc import Callable
from functools import cached_property, partial, update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar, cast

from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.from_python import FromPython
from gearplay.kernels.library import library
from gearplay.kernels.signatures import Signed

P = ParamSpec("P")
R = TypeVar("R")

KERNELS: "dict[str, Kernel[..., Any]]" = {}
"""All of them, by module and name."""


class Kernel(Signed, Generic[P, R]):
    """A kernel of the library; made by `compiled_once`."""

    def __init__(self, function: Callable[P, R]) -> None:
        super().__init__(function)
        update_wrapper(self, function)
        KERNELS[self.name] = self

    @cached_property
    def from_python(self) -> FromPython:
        """The function of the library; the first kernel that is called loads it."""
        return FromPython(self, library())

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call it from Python, arguments by place (`FromPython`)."""
        if kwargs:
            raise TypeError(f"{self.name} takes arguments by place")
        return cast(R, self.from_python(args))


def bound(kernel: Callable[P, R], *args: P.args, **_: P.kwargs) -> Callable[[], R]:
    """Return a function of no arguments that calls a `compiled_once` kernel with these, for many calls on the same arrays."""
    if isinstance(kernel, Kernel):
        return cast(Callable[[], R], kernel.from_python.bind(args))
    return partial(kernel, *args)


def compiled_once(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that its callers call but do not contain.

    Its annotations are its signature: numbers, groups, arrays, tuples of numbers to return.
    """
    return function if INTERPRETED else cast(Callable[P, R], Kernel(function))
