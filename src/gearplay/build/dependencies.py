"""Key of a kernel's machine code: a digest of its dependencies, so that an edit recompiles only the kernels that it affects.

A kernel depends on its own code and that of the functions compiled into it, on constants that these name, on the signatures of
kernels that they call, and on the form of the groups that it takes.
"""

import hashlib
from collections.abc import Callable, Iterator
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba import config

from gearplay.kernels.by_address import Group, form_of
from gearplay.kernels.compiled import CONTAINED
from gearplay.kernels.signatures import Signed


def key_of(kernel: Signed, *options: object) -> str:
    """Return the key of a kernel's machine code under given compiler options."""
    found: dict[str, str] = {}
    _follow(kernel.py_func, found)
    compiler = (numba.__version__, llvmlite.__version__, config.BOUNDSCHECK)  # type: ignore[attr-defined]
    parts = (sorted(found.items()), _signature(kernel), compiler, options)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def _follow(function: Callable[..., Any], found: dict[str, str]) -> None:
    """Add a function and all that it refers to, each by its name."""
    name = f"{function.__module__}.{function.__qualname__}"
    if name in found:
        return
    code = function.__code__
    found[name] = _digest(code)
    for place, value in _globals_of(code, function.__globals__):
        if isinstance(value, Signed):
            found[value.name] = found.get(value.name, _signature(value))
        elif isinstance(value, FunctionType) and value in CONTAINED:
            _follow(value, found)
            found[f"{name}:{place}"] = f"{value.__module__}.{value.__qualname__}"
        else:
            found[f"{name}:{place}"] = _constant(value)


def _digest(code: CodeType) -> str:
    """Return a digest of code without its documentation and line numbers."""
    constants = [_digest(each) if isinstance(each, CodeType) else repr(each) for each in code.co_consts]
    if code.co_flags & 0x4000000 or (code.co_consts and isinstance(code.co_consts[0], str)):
        constants[0] = ""  # the docstring
    parts = (code.co_code, constants, code.co_names, code.co_varnames, code.co_argcount)
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _globals_of(code: CodeType, names: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the names and values of the globals that code refers to; of a module those of its attributes that the code names."""
    for name in code.co_names:
        if name in names:
            yield from _members(name, names[name], code)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _globals_of(constant, names)


def _members(place: str, value: Any, code: CodeType) -> Iterator[tuple[str, Any]]:
    if isinstance(value, ModuleType) and value.__name__.startswith("gearplay"):
        for name in code.co_names:
            if name in value.__dict__:
                yield from _members(f"{place}.{name}", value.__dict__[name], code)
    else:
        yield place, value


def _constant(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return repr((value.dtype.str, value.shape, value.tobytes()))
    if isinstance(value, type | FunctionType | ModuleType):
        return f"{getattr(value, '__module__', '')}.{value.__name__}"
    return repr(value)


def _signature(kernel: Signed) -> str:
    """Return the types of a kernel's arguments and result: of a group the form of all its fields."""
    hints, result = kernel.hints
    return repr([_form(hint) for hint in (*hints.values(), result)])


@cache
def _form(hint: Any) -> str:
    """Return the memory layout of an annotated type."""
    if not (isinstance(hint, type) and issubclass(hint, Group)):
        return str(hint)
    inner = [_form(shape) for shape in hint.shapes().values() if isinstance(shape, type)]
    return repr((form_of(hint), inner))
