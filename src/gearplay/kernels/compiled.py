"""Decorators of kernels that are compiled into their callers.

From Python such a kernel is called as it is written. What is compiled on its own, and called so from Python too, stands in
`compiled_once`; the compiler is in `gearplay.build` and no part of a run.
"""

import os
from collections.abc import Callable
from typing import Any, Final, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

INTERPRETED: Final = os.environ.get("GEARPLAY_INTERPRETED", "0") not in ("", "0")
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
