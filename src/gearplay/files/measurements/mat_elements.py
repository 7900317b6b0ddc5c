"""The elements of a MAT file of version 5: sizes checked against the file, numbers, texts and structures decoded.

MathWorks, "MAT-File Format": a header of 128 bytes, then elements of a tag (type, size) and content. A matrix holds
flags, dimensions, a name and its content, which for cells and structures are matrices again. Decoded here, since
SciPy's reader crashes the interpreter where flags and content contradict each other (seen with 1.17).
"""

import struct
import zlib
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.refusing import DENSEST, LARGEST_FILE, MOST_NODES, damaged

HEADER: Final = 128
_MATRIX, _PACKED, _UTF8 = 14, 15, 16
_CELL, _STRUCT, _CHAR, _NUMBERS, _OTHERS = 1, 2, 4, range(6, 16), (3, 5, 16, 17)
_COMPLEX: Final = 0x08
_FLAGS: Final = 0x0E
_DEEPEST: Final = 16
_TYPES: Final = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8", _UTF8: "u1", 17: "u2", 18: "u4",
}  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """One variable: its name and numbers of shape ``dims``, a text, the rows of a structure, or none of these."""

    name: str
    value: NDArray[Any] | str | list[dict[str, "Variable"]] | None


class Walk:
    """Walks the elements of one file; raises `MeasurementError` where one reaches past the content that holds it."""

    def __init__(self, path: Path, order: str) -> None:
        self.path, self.order, self.nodes = path, order, 0

    def file(self, content: bytes) -> list[Variable]:
        """Walk the top level, unpack what is packed, and return the variables."""
        place, allowed = HEADER, LARGEST_FILE
        found = []
        while place < len(content):
            kind, begin, end, place = self.tag(content, place)
            inside = content[begin:end]
            if kind == _PACKED:
                place = end  # packed elements are not padded
                unpacked = self.unpacked(inside, allowed)
                allowed -= len(unpacked)
                kind, begin, end, _ = self.tag(unpacked, 0)
                inside = unpacked[begin:end]
            if kind != _MATRIX:
                raise damaged(self.path, f"a variable must be a matrix, an element of type {kind} found")
            found.append(self.matrix(inside))
        return found

    def tag(self, content: bytes, place: int) -> tuple[int, int, int, int]:
        """Return type, begin and end of an element's content and the place of the next element."""
        self.nodes += 1
        if self.nodes > MOST_NODES:
            raise damaged(self.path, f"has more than {MOST_NODES} elements", "Save fewer variables")
        if place + 8 > len(content):
            raise damaged(
                self.path, f"an element must have a tag of 8 bytes, {len(content) - place} are left"
            )
        kind, size = struct.unpack(self.order + "II", content[place : place + 8])
        if kind >> 16:  # a small element: size, type and up to four bytes in one tag
            size, kind = kind >> 16, kind & 0xFFFF
            if size > 4:
                raise damaged(self.path, f"a small element declares {size} bytes, at most 4 fit")
            return kind, place + 4, place + 4 + size, place + 8
        end = place + 8 + size
        if end > len(content):
            raise damaged(self.path, f"an element declares {size} bytes, {len(content) - place - 8} are left")
        return kind, place + 8, end, end + -end % 8

    def unpacked(self, packed: bytes, allowed: int) -> bytes:
        """Return the content of a packed element; its checksum tells damaged bytes."""
        engine = zlib.decompressobj()
        try:
            content = engine.decompress(packed, min(DENSEST * len(packed) + 64, allowed))
        except zlib.error:
            raise damaged(self.path, "a packed element is damaged: its checksum or code is wrong") from None
        if not engine.eof:
            raise damaged(self.path, "a packed element ends early or is larger than 4 GiB")
        return content

    def matrix(self, content: bytes, depth: int = 0) -> Variable:
        """Return a variable after checking that it holds as much as its dimensions declare, and so do its parts."""
        if not content:
            return Variable("", None)  # an empty cell
        if depth > _DEEPEST:
            raise damaged(
                self.path, f"its variables are nested more than {_DEEPEST} deep", "Save plain vectors"
            )
        parts, place = [], 0
        while place < len(content):
            kind, begin, end, place = self.tag(content, place)
            parts.append((kind, content[begin:end]))
        if len(parts) < 3 or [part[0] for part in parts[:3]] != [6, 5, 1] or len(parts[0][1]) != 8:
            raise damaged(self.path, "a variable must hold flags, dimensions and a name")
        flags = int(struct.unpack(self.order + "II", parts[0][1])[0])
        held = flags & 0xFF
        dims, name = self._dims(parts[1][1]), parts[2][1].decode("latin-1")
        if held in _OTHERS:
            return Variable(name, None)
        if held in _NUMBERS or held == _CHAR:
            return Variable(name, self._numbers(parts[3:], dims, flags))
        if held == _STRUCT:
            return Variable(name, self._rows(parts[3:], dims, depth))
        if held != _CELL:
            raise damaged(self.path, f"a variable declares an unknown class {held}")
        for kind, inside in parts[3:]:
            if kind == _MATRIX:
                self.matrix(inside, depth + 1)
        return Variable(name, None)

    def _dims(self, content: bytes) -> tuple[int, ...]:
        if len(content) < 8 or len(content) % 4 or len(content) > 128:
            raise damaged(self.path, f"a variable's dimensions take {len(content)} bytes, 8 to 128 are due")
        dims = struct.unpack(f"{self.order}{len(content) // 4}i", content)
        if min(dims) < 0:
            raise damaged(self.path, f"a variable declares a negative dimension {min(dims)}")
        return dims

    def _numbers(
        self, parts: list[tuple[int, bytes]], dims: tuple[int, ...], flags: int
    ) -> NDArray[Any] | str | None:
        """Return numbers or a text after comparing their declared count with that of each part."""
        due = 2 if flags >> 8 & _COMPLEX else 1
        if flags >> 8 & 0xFF & ~_FLAGS or len(parts) != due:
            raise damaged(self.path, f"a variable must hold {due} parts of numbers, {len(parts)} found")
        count = prod(dims)
        for kind, content in parts:
            if kind not in _TYPES:
                raise damaged(self.path, f"numbers of unknown type {kind} found")
            width = int(_TYPES[kind][1])
            held = len(content) // width
            several = kind == _UTF8 and flags & 0xFF == _CHAR and held > count  # bytes of one letter
            if len(content) % width or (held != count and not several):
                raise damaged(self.path, f"a variable declares {count} numbers and holds {held}")
        kind, content = parts[0]
        if flags & 0xFF == _CHAR:
            coding = "utf-8" if width == 1 else f"utf-{8 * width}-{'le' if self.order == '<' else 'be'}"
            return content.decode(coding, errors="replace")
        values = np.frombuffer(content, np.dtype(self.order + _TYPES[kind]))
        return values.reshape(dims, order="F") if due == 1 else None

    def _rows(
        self, parts: list[tuple[int, bytes]], dims: tuple[int, ...], depth: int
    ) -> list[dict[str, Variable]]:
        """Return the rows of a structure array: its fields by name."""
        if len(parts) < 2 or len(parts[0][1]) != 4:
            raise damaged(self.path, "a structure must hold the names of its fields")
        (width,) = struct.unpack(self.order + "i", parts[0][1])
        text = parts[1][1]
        names = [
            text[k : k + width].split(b"\0")[0].decode("latin-1") for k in range(0, len(text), max(width, 1))
        ]
        held = parts[2:]
        if width < 1 or len(held) != prod(dims) * len(names) or any(kind != _MATRIX for kind, _ in held):
            rule = (
                f"a structure declares {prod(dims)} rows of {len(names)} fields and holds {len(held)} values"
            )
            raise damaged(self.path, rule)
        values = [self.matrix(inside, depth + 1) for _, inside in held]
        return [
            dict(zip(names, values[k : k + len(names)], strict=True))
            for k in range(0, len(values), max(len(names), 1))
        ]


def read_variables(path: Path, content: bytes) -> list[Variable]:
    """Return the variables of a MAT file of version 5.

    Raises `MeasurementError` where the header is wrong, an element reaches past the file, a packed element is
    damaged, or a variable holds another number of values than it declares.
    """
    if len(content) < HEADER:
        raise damaged(path, f"must begin with a header of {HEADER} bytes, {len(content)} found")
    mark = content[126:128]
    if mark not in (b"IM", b"MI"):
        raise damaged(
            path, f"must be a MAT file of version 5 or 7.3, byte order mark {mark!r} found", "Save as -v7"
        )
    order = "<" if mark == b"IM" else ">"
    version = struct.unpack(order + "H", content[124:126])[0]
    if version >> 8 != 1:
        raise damaged(
            path, f"must be a MAT file of version 5 or 7.3, {version:#x} found", "Save it as -v7 or -v7.3"
        )
    return Walk(path, order).file(content)
