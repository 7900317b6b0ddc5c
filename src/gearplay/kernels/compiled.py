"""The one place that says how kernels are compiled."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a module-level kernel: cached on disk, without the GIL, IEEE semantics kept.

    ``fastmath`` stays off because it deletes NaN guards; ``error_model="numpy"`` lets a division by zero
    give inf, which the stepper's finite check then reports.
    """
    return cast(Callable[P, R], njit(cache=True, nogil=True, error_model="numpy")(function))


def compiled_inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small kernel that LLVM should always inline into its caller."""
    return cast(
        Callable[P, R],
        njit(cache=True, nogil=True, error_model="numpy", forceinline=True)(function),
    )
