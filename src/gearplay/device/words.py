"""How the arrays of a group lie in the memory of a device: word behind word, where a table says.

A thread that reads a word of its run stands beside 31 that read the same word of theirs: where those lie side by side, the device
reads them at once. So the words of `LANES` runs are interleaved: word w of lane l stands at ``w * LANES + l`` of their tile. A
complex number keeps its two words together, beside those of the next lane. Records of a mechanism are not interleaved: all
threads read the same ones.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.arrays import Ints
from gearplay.kernels.by_address import Group

LANES = 32
"""Runs that lie interleaved: as many as threads that go in step."""
WORD = 8
"""Bytes of a word: all that kernels keep is made of such."""


def _arrays(value: Any) -> Iterator[NDArray[Any]]:
    """Yield the arrays of a group in the order of its fields, those of groups and tuples in it where they stand."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Group):
        for name in type(value)._shapes:
            yield from _arrays(getattr(value, name))
    else:
        for part in value:
            yield from _arrays(part)


class Words:
    """How a group lies in memory, and every other one of the same form and sizes.

    Parameters
    ----------
    group
        One of them. An array that stands in several fields lies there once.
    apart
        Words from one number to the next: 1, or `LANES` where runs lie interleaved.
    last
        Fields whose arrays come behind all others: long ones that only come back.

    Attributes
    ----------
    table
        For each array, in the order of fields, where it begins [bytes] and its shape.
    head, size
        Words of all arrays but the last ones, and of all.

    """

    def __init__(self, group: Group, apart: int = 1, last: tuple[str, ...] = ()) -> None:
        behind = {id(getattr(group, name)) for name in last}
        found = list(_arrays(group))
        self._places: list[int] = []  # among the arrays in the order of fields, of those that lie there
        self._of = group  # must live as long as its arrays are told apart by where they are
        begins: dict[int, int] = {}
        at = self.head = 0
        self._complex: list[slice] = []
        for tail in (False, True):
            for place, array in enumerate(found):
                if (id(array) in behind) == tail and id(array) not in begins:
                    begins[id(array)] = at
                    at += array.nbytes // WORD
                    if array.dtype.kind == "c" and array.size:
                        self._complex.append(slice(begins[id(array)], at))
                    if not tail:
                        self._places.append(place)
            if not tail:
                self.head = at
        self.size = at
        self._begins = begins
        table: list[int] = []
        for array in found:
            table += [begins[id(array)] * WORD * apart, *array.shape]
        self.table: Ints = np.array(table, dtype=np.int64)

    def place(self, array: NDArray[Any]) -> slice:
        """Return where among the words an array of the group lies that this was made of."""
        begin = self._begins[id(array)]
        return slice(begin, begin + array.nbytes // WORD)

    def load(self, words: Ints, *arrays: NDArray[Any]) -> None:
        """Set arrays of the group that this was made of to what ``words``, shape [head], says."""
        for array in arrays:
            array.reshape(-1).view(np.int64)[:] = words[self.place(array)]

    def store(self, words: Ints, *arrays: NDArray[Any]) -> None:
        """Set ``words``, shape [head], to what arrays of the group that this was made of say."""
        for array in arrays:
            words[self.place(array)] = array.reshape(-1).view(np.int64)

    def to_tile(self, heads: Ints) -> Ints:
        """Return a tile, shape [word, lane], of the words of `LANES` runs at most, shape [run, word]."""
        tile: Ints = np.zeros((self.head, LANES), dtype=np.int64)
        tile[:, : len(heads)] = heads.T
        for place in self._complex:
            tile[place] = tile[place].reshape(-1, 2, LANES).swapaxes(1, 2).reshape(-1, LANES)
        return tile

    def from_tile(self, tile: Ints, heads: Ints) -> None:
        """Fill the words of runs, shape [run, word], from their tile."""
        heads[:] = tile.T[: len(heads)]
        for place in self._complex:
            apart = tile[place].reshape(-1, LANES, 2).swapaxes(1, 2).reshape(-1, LANES)
            heads[:, place] = apart.T[: len(heads)]

    def take(self, group: Group) -> Ints:
        """Return the numbers of a group but for its last fields as words, shape [head]."""
        found = list(_arrays(group))
        return np.concatenate([found[place].reshape(-1).view(np.int64) for place in self._places])

    def put(self, words: Ints, group: Group) -> None:
        """Set the numbers of a group but for its last fields to words, shape [head]."""
        found, at = list(_arrays(group)), 0
        for place in self._places:
            array = found[place]
            count = array.nbytes // WORD
            array.reshape(-1).view(np.int64)[:] = words[at : at + count]
            at += count
