"""Image of groups of arrays: their memory in one block, with the places of addresses in it, for a program in C."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.by_address import Group

ALIGNED = 16


class Image:
    """The memory of some groups, as words of 64 bits.

    ``roots`` are the places of the groups [byte], in their order, ``relocations`` the words that hold addresses, as offsets from
    the image's begin.
    """

    def __init__(self, *groups: Group) -> None:
        self._content, self._known = bytearray(), dict[int, int]()
        self.relocations: list[int] = []
        self.roots = [self._add_group(group) for group in groups]
        self._content += bytes(-len(self._content) % ALIGNED)

    @property
    def words(self) -> NDArray[np.uint64]:
        """All words."""
        return np.frombuffer(bytes(self._content), dtype="<u8")

    def place_of(self, array: NDArray[Any]) -> int:
        """Return the first word of an array."""
        return self._known[array.ctypes.data] // 8

    def _add(self, address: int, content: bytes) -> int:
        """Return the place of a piece of memory, which may be part of several groups."""
        if address not in self._known or not content:
            self._content += bytes(-len(self._content) % ALIGNED)
            self._known[address] = len(self._content)
            self._content += content
        return self._known[address]

    def _add_group(self, group: Group) -> int:
        words: list[int] = []
        relative: list[int] = []
        for value in _values(group):
            if isinstance(value, Group):
                relative.append(len(words))
                words.append(self._add_group(value))
            else:
                if value.size:
                    relative.append(len(words))
                words.append(self._add(value.ctypes.data, value.tobytes()) if value.size else 0)
                words.extend(value.shape)
        place = self._add(id(group), np.array(words, dtype="<i8").tobytes())
        self.relocations += [place // 8 + word for word in relative]
        return place


def _values(group: Group) -> Iterator[Any]:
    """Yield the arrays and groups of a group, those of tuples one by one."""
    for name in type(group).shapes():
        value = getattr(group, name)
        yield from value if isinstance(value, tuple) else (value,)
