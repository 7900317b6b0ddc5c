"""Samples of a checkpointed motion, computed on request."""

import threading
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.solver.checkpoints import KeptMotion
from gearplay.solver.limits import check_samples
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SHORT_RECORD: Final = 8_000_000
"""Size of all samples of a short record [bytes]."""


class KeptSamples:
    """Samples of a checkpointed motion, computed on request: one signal alone, or all at once.

    Parameters
    ----------
    motion
        What they are of.
    places
        Columns of a full row.
    sampling
        Samples per second [Hz], from the end of the transient to that of the run.
    written
        The samples, shape [time, column], where they were written during the run.

    """

    def __init__(
        self, motion: KeptMotion, places: Ints, sampling: float, written: Floats | None = None
    ) -> None:
        self.motion, self.places, self.sampling = motion, places, sampling
        self.start, end = motion.ends
        self.count = motion.count(self.start, sampling, end)
        self.left = motion.left
        self._columns: dict[int, Floats] = {}
        if written is not None:
            self.__dict__["values"] = written

    @cached_property
    def values(self) -> Floats:
        """All of them, shape [time, column].

        Raises `ResourceError` where they are too many.
        """
        return self._all()

    def _all(self) -> Floats:
        check_samples(self.count, len(self.places))
        return self.motion.sample(self.places, self.start, self.sampling, self.count)

    def chosen(self, places: Ints, sampling: float) -> "KeptSamples":
        """Return the samples of other columns of a full row, at another rate [Hz]."""
        return KeptSamples(self.motion, places, sampling)

    def some(self, columns: Sequence[int]) -> Floats:
        """Return some signals, shape [time, column]; they are kept."""
        self.keep(columns)
        if "values" in self.__dict__:
            return self.values[:, list(columns)]
        return np.stack([self._columns[at] for at in columns], axis=1)

    def keep(self, columns: Sequence[int]) -> None:
        """Compute some signals by one replay and keep them; all signals of a short record, which takes hardly longer."""
        lacking = [at for at in columns if at not in self._columns]
        if not lacking or "values" in self.__dict__:
            return
        if 8 * self.count * len(self.places) <= SHORT_RECORD:
            self.__dict__["values"] = self._all()
        else:
            check_samples(self.count, len(lacking))
            found = self.motion.sample(self.places[lacking], self.start, self.sampling, self.count)
            self._columns |= {at: found[:, k] for k, at in enumerate(lacking)}

    def thinned(self, columns: Sequence[int], stride: int) -> Floats:
        """Return every ``stride``-th sample of some signals, shape [time, column]; not kept."""
        if "values" in self.__dict__:
            return self.values[::stride, list(columns)]
        count = -(-self.count // stride)
        return self.motion.sample(self.places[list(columns)], self.start, self.sampling / stride, count)

    def blocks(self, size: int, stop: threading.Event) -> Iterator[Floats]:
        """Yield all samples in blocks of ``size`` times, shape [time, column], each valid until the next; not kept.

        Raises once ``stop`` is set.
        """
        if "values" in self.__dict__:
            yield from (self.values[at : at + size] for at in range(0, self.count, size))
        elif self.count <= size:
            yield self.motion.sample(self.places, self.start, self.sampling, self.count, stop)
        else:
            yield from self.motion.blocks(self.places, self.start, self.sampling, self.count, size, stop)

    def at_rate(self, at: int, sampling: float | None, window: tuple[float, float] | None) -> Floats:
        """Return one signal at another rate [Hz], or from another window [s], shape [time]; `InputError` for an empty one."""
        sampling, window = sampling or self.sampling, window or self.motion.ends
        start, end = window
        count = self.motion.count(start, sampling, end)
        if not (0.0 <= start < end <= self.motion.ends[-1] * (1.0 + 1e-12)) or count == 0:
            rule = f"must be a start and a later end [s] within 0 and {min(self.motion.reached, self.motion.ends[-1]):g}"
            raise InputError.of("window", str(window), rule, "Choose a window within the run")
        check_samples(count, 1)
        return self.motion.sample(self.places[at : at + 1], start, sampling, count)[:, 0]
