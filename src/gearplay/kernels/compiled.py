"""The one place that says how kernels are compiled and cached."""

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import llvmlite.binding as llvm
import numba
from numba import njit

from gearplay.kernels.compiled_files import NAME, CompiledFiles, note

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


FOLDER = f"{NAME}{compiled_from()}"
"""Of this version's compiled code, in the folder where numba keeps that of a module."""


def _kept(dispatcher: Any) -> Any:
    """Keep a kernel's compiled code on disk, by all kernel files, wherever a folder can be written to.

    numba looks only at the file a kernel is written in, so an edit of one that it calls would go unseen; and it raises where it
    finds no folder.
    """
    if not hasattr(dispatcher, "enable_caching"):  # plain Python
        return dispatcher
    try:
        dispatcher.enable_caching()
    except RuntimeError:
        note("no folder that could be written to")
        return dispatcher
    cache = dispatcher._cache
    cache._cache_file = CompiledFiles(Path(cache.cache_path) / FOLDER, cache._impl.filename_base)
    return dispatcher


# IEEE semantics: ``fastmath`` stays off because it deletes NaN guards; ``error_model="numpy"`` lets a division by zero
# give inf, which the stepper's finite check then reports. Without numba's runtime (``_nrt``) no kernel can allocate and
# no array is reference-counted: twice as fast here, fit for a device, and threads have nothing to fight over.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a module-level kernel: cached on disk, without the GIL, without allocation."""
    return cast(Callable[P, R], _kept(njit(**_OPTIONS)(function)))


def compiled_inline(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that LLVM should always inline into its callers."""
    return cast(Callable[P, R], _kept(njit(forceinline=True, **_OPTIONS)(function)))
