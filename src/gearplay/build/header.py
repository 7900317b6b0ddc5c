"""The C interface of the kernel library: a header with all groups of arrays and all kernels."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gearplay.kernels.by_address import Group
from gearplay.kernels.signatures import Signed, array_of

_NUMBERS: dict[Any, str] = {int: "int64_t", float: "double", bool: "uint8_t", type(None): "void *"}
_ELEMENTS = {"<f8": "double", "<i8": "int64_t", "<c16": "double", "|b1": "uint8_t"}
_KEYWORDS = {
    "auto", "bool", "case", "char", "class", "const", "default", "double", "enum", "extern", "float", "goto", "inline", "int",
    "long", "new", "operator", "private", "public", "register", "short", "signed", "static", "struct", "switch", "this",
    "typedef", "union", "unsigned", "void", "volatile",
}  # fmt: skip
_HEAD = """\
/* Kernels of gearplay, written by its build.
 *
 * A kernel returns 0, or another number where an index was beyond its array (in libraries that check bounds), and writes its
 * result to the first argument; the second must point to a null pointer. A group is a struct of arrays: the address of the
 * numbers, then the array's extents; arrays are C-contiguous, complex numbers are pairs. An array outside a group takes a
 * null pointer twice, its size, the bytes of a number, its address, its extents and its strides in bytes. A name that is a
 * keyword ends in an underscore.
 */
#ifndef GEARPLAY_H
#define GEARPLAY_H
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif
"""
_TAIL = """
#ifdef __cplusplus
}
#endif
#endif
"""


def header(kernels: Sequence[Signed]) -> str:
    """Return the header of kernels."""
    structs: dict[str, str] = {}
    functions = [_function(kernel, structs) for kernel in kernels]
    return "\n".join([_HEAD, *structs.values(), *functions, _TAIL])


def _function(kernel: Signed, structs: dict[str, str]) -> str:
    """Return the declaration of a kernel; add the structs that it needs."""
    hints, result = kernel.hints
    parts = getattr(result, "__args__", None)
    answer = _NUMBERS[result] if not parts else f"{kernel.symbol}_result"
    if parts:
        fields = "".join(f" {_NUMBERS[part]} at_{n};" for n, part in enumerate(parts))
        structs[answer] = f"typedef struct {{{fields} }} {answer};"
    words = [f"{answer} *result", "void **fault"]
    for name, hint in hints.items():
        array = array_of(hint)
        if array is not None:
            ranks = range(array[1])
            words += [
                f"void *{name}_0",
                f"void *{name}_1",
                f"int64_t {name}_size",
                f"int64_t {name}_itemsize",
            ]
            words += [f"{_element(array[0])} *{name}"]
            words += [f"int64_t {name}_n{k}" for k in ranks] + [f"int64_t {name}_stride{k}" for k in ranks]
        elif issubclass(hint, Group):
            words.append(f"const {_struct(hint, structs)} *{name}")
        else:
            words.append(f"{_NUMBERS[hint]} {name}")
    return f"int32_t {kernel.symbol}({', '.join(words)});"


def _struct(kind: Any, structs: dict[str, str]) -> str:
    """Return the name of a group's struct; add it and those within it."""
    name = f"gearplay_{kind.__name__}"
    if name not in structs:
        lines = [
            line for field, shape in kind.shapes().items() for line in _fields(name, field, shape, structs)
        ]
        structs[name] = "\n    ".join(["typedef struct {", *lines]) + f"\n}} {name};"
    return name


def _fields(group: str, field: str, shape: Any, structs: dict[str, str]) -> Iterator[str]:
    if isinstance(shape, type):
        yield f"const {_struct(shape, structs)} *{field};"
    elif shape[0] == "tuple":
        for n, part in enumerate(shape[1:]):
            yield from _fields(group, f"{field}_{n}", part, structs)
    else:
        element = _record(f"{group}_{field}", shape[0], structs) if shape[0].names else _element(shape[0])
        yield f"{element} *{field};"
        yield from (f"int64_t {field}_n{k};" for k in range(shape[1]))


def _record(name: str, dtype: np.dtype[Any], structs: dict[str, str]) -> str:
    """Add the struct of a record; return its name."""
    assert dtype.names is not None
    fields = []
    for each in dtype.names:
        kind = dtype[each]
        extent = "".join(f"[{n}]" for n in kind.shape)
        fields.append(f"{_element(kind.base)} {each}{'_' * (each in _KEYWORDS)}{extent};")
    structs[name] = "\n    ".join(["typedef struct {", *fields]) + f"\n}} {name};"
    return name


def _element(dtype: np.dtype[Any]) -> str:
    return _ELEMENTS[dtype.str]
