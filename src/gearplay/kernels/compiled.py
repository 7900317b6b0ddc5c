"""The one place that says how kernels are compiled and cached."""

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import llvmlite.binding as llvm
import numba
from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


def kernel_digest(folder: Path) -> str:
    """Return a digest of all kernel sources in a folder and below."""
    files = sorted(folder.rglob("*.py"))
    return hashlib.sha256(
        b"".join(str(f.relative_to(folder)).encode() + b"\0" + f.read_bytes() for f in files)
    ).hexdigest()


DIGEST = kernel_digest(Path(__file__).parent)
"""Of the kernels as they are."""


def compiled_from() -> str:
    """Return a digest of all that compiled code depends on: sources, compiler, Python, processor."""
    parts = (DIGEST, numba.__version__, sys.version, llvm.get_host_cpu_name())
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:16]


def _stamped(dispatcher: Any) -> Any:
    """Make a kernel's disk cache depend on every kernel file.

    numba looks only at the file a kernel is written in, so an edit of one that it calls would go unseen.
    """
    cache_file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if cache_file is not None:
        cache_file._source_stamp = DIGEST
    return dispatcher


# IEEE semantics: ``fastmath`` stays off because it deletes NaN guards; ``error_model="numpy"`` lets a division by zero
# give inf, which the stepper's finite check then reports. Without numba's runtime (``_nrt``) no kernel can allocate and
# no array is reference-counted: twice as fast here, fit for a device, and threads have nothing to fight over.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a module-level kernel: cached on disk, without the GIL, without allocation."""
    return cast(Callable[P, R], _stamped(njit(cache=True, **_OPTIONS)(function)))


def compiled_inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that LLVM should always inline into its callers."""
    return cast(Callable[P, R], _stamped(njit(cache=True, forceinline=True, **_OPTIONS)(function)))
