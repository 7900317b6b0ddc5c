"""Decorators of kernels that are compiled into their callers.

From Python such a kernel is called as it is written. What is compiled on its own, and called so from Python too, stands in
`compiled_once`; the compiler itself is loaded only where something has not been compiled before.
"""

import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def _is_disabled() -> bool:
    """Return whether the environment says so, read as numba reads it."""
    with suppress(ValueError):
        return int(os.environ.get("NUMBA_DISABLE_JIT", "0")) != 0
    return False


INTERPRETED = _is_disabled()
"""Whether all kernels run as plain Python."""
CONTAINED: dict[Callable[..., Any], bool] = {}
"""Kernels that are compiled within their callers; True of those that LLVM must inline."""


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Let compiled code call a function that is compiled with it."""
    CONTAINED[function] = False
    return function


def compiled_inline(function: Callable[P, R]) -> Callable[P, R]:
    """Let compiled code contain a function in the place of every call."""
    CONTAINED[function] = True
    return function
