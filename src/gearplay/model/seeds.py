"""Seeds of many random generators at once: NumPy's `SeedSequence` for [seed, member], all members in one pass.

The algorithm is that of `numpy.random.SeedSequence` (M. E. O'Neill's seed_seq_fe128), which NumPy guarantees to stay as it is.
"""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from numpy.random import PCG64, Generator
from numpy.random.bit_generator import ISeedSequence
from numpy.typing import NDArray

FEW = 12
"""Members from which on one pass is faster than NumPy's own seeds."""
_POOL = 4
_WORD = 0xFFFFFFFF


class _Words(ISeedSequence):
    """A seed whose state has been computed."""

    def __init__(self, words: NDArray[np.uint64]) -> None:
        self.words = words

    def generate_state(self, n_words: int, dtype: Any = np.uint64) -> NDArray[np.uint64]:
        """Return the state of a `PCG64`."""
        return self.words


def generators(seed: int, members: Sequence[int]) -> list[Generator]:
    """Return ``numpy.random.default_rng([seed, member])`` of every member below 2^32.

    >>> a, b = generators(3, [1, 7])
    >>> bool(b.random() == np.random.default_rng([3, 7]).random())
    True
    """
    if len(members) < FEW:
        return [np.random.default_rng([seed, member]) for member in members]
    return [Generator(PCG64(cast(Any, _Words(words)))) for words in states_of(seed, members)]


def states_of(seed: int, members: Sequence[int]) -> NDArray[np.uint64]:
    """Return the states of these generators, shape [member, 4]."""
    entropy = [np.full(len(members), word, dtype=np.uint32) for word in _words(seed)]
    entropy.append(np.array(members, dtype=np.uint32))
    hashed = _Hash(0x43B0D7E5, 0x931E8875)
    nothing = np.zeros(len(members), dtype=np.uint32)
    pool = [hashed(each) for each in (entropy + _POOL * [nothing])[:_POOL]]
    for source in range(_POOL):
        for target in range(_POOL):
            if source != target:
                pool[target] = _mixed(pool[target], hashed(pool[source]))
    for each in entropy[_POOL:]:
        for target in range(_POOL):
            pool[target] = _mixed(pool[target], hashed(each))
    hashed = _Hash(0x8B51F9DD, 0x58F38DED)
    found = [hashed(pool[k % _POOL]) for k in range(2 * _POOL)]
    return np.ascontiguousarray(np.stack(found, axis=1)).view(np.uint64)


def _words(number: int) -> list[int]:
    """Return the words of 32 bits of a number, the lowest first."""
    found = [number & _WORD]
    while number := number >> 32:
        found.append(number & _WORD)
    return found


class _Hash:
    """A hash whose constant changes with each use."""

    def __init__(self, constant: int, factor: int) -> None:
        self.constant, self.factor = constant, factor

    def __call__(self, values: NDArray[np.uint32]) -> NDArray[np.uint32]:
        found = values ^ np.uint32(self.constant)
        self.constant = self.constant * self.factor & _WORD
        found *= np.uint32(self.constant)
        found ^= found >> np.uint32(16)
        return found


def _mixed(x: NDArray[np.uint32], y: NDArray[np.uint32]) -> NDArray[np.uint32]:
    found: NDArray[np.uint32] = np.uint32(0xCA01F9DD) * x - np.uint32(0x4973F715) * y
    found ^= found >> np.uint32(16)
    return found
