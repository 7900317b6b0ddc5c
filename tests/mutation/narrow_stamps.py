"""A pytest plugin that lets a changed kernel compile alone: ``-p narrow_stamps``.

The package keeps compiled code in a folder that is named by a digest of all kernel files, which no edit can escape. Here a file
is named by a digest of what one kernel's machine code is made of: its own bytecode, the kernels compiled into it, and the
constants that these read. A kernel called by address counts by its signature only. A mutant then costs seconds, not a minute.
"""

import hashlib
import importlib
import inspect
import pkgutil
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

import gearplay.integrate
import gearplay.kernels
import gearplay.parts
from gearplay.kernels import compiled_files
from gearplay.kernels.compiled import CONTAINED, INTERPRETED
from gearplay.kernels.compiled_once import KERNELS, Once
from gearplay.solver import compiling

FOLDER = "narrow"
PLAIN = (bool, int, float, complex, str, bytes, tuple, type(None), np.dtype, np.generic)


def _code(code: CodeType) -> str:
    """Describe bytecode, without line numbers."""
    constants = [_code(each) if isinstance(each, CodeType) else repr(each) for each in code.co_consts]
    return f"{code.co_code.hex()} {constants} {code.co_names} {code.co_varnames}"


def _read(function: FunctionType) -> list[tuple[str, Any]]:
    """Return the globals that a function reads, and what it reads of modules among them."""
    names = function.__code__.co_names
    found = [(name, function.__globals__[name]) for name in names if name in function.__globals__]
    for module_name, module in list(found):
        if isinstance(module, ModuleType) and module.__name__.startswith("gearplay"):
            found += [
                (f"{module_name}.{name}", getattr(module, name)) for name in names if hasattr(module, name)
            ]
    return found


def _describe(function: FunctionType, seen: set[str]) -> list[str]:
    """Return what the machine code of a function is made of."""
    name = f"{function.__module__}.{function.__qualname__}"
    if name in seen:
        return []
    seen.add(name)
    parts = [name, _code(function.__code__), repr(function.__defaults__)]
    for called, value in _read(function):
        if isinstance(value, Once):
            parts.append(f"{called} {inspect.signature(value.py_func)}")
        elif isinstance(value, FunctionType) and value in CONTAINED:
            parts += _describe(value, seen)
        elif isinstance(value, np.ndarray):
            parts.append(f"{called} {value.dtype} {value.shape} {value.tobytes().hex()}")
        elif isinstance(value, PLAIN):
            parts.append(f"{called} {value!r}")
    return parts


def pytest_sessionstart() -> None:
    """Keep the code of every kernel by its own stamp, once all are imported; each is compiled or linked by its first call."""
    if INTERPRETED:
        return
    compiling._compile = lambda wanted, progress: None
    for package in (gearplay.kernels, gearplay.integrate, gearplay.parts):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(found.name)
    compiled_files.compiled_from = lambda: FOLDER
    whole = compiled_files.file_of

    def file_of(name: str) -> Path | None:
        digest = hashlib.sha256("\n".join(_describe(KERNELS[name].py_func, set())).encode())
        return whole(f"{name}.{digest.hexdigest()[:16]}")

    compiled_files.file_of = file_of
