"""Checkpointed solution: states along a run from which any signal is computed later by a bitwise identical replay.

A step depends on nothing but the state of the kernels' run before it, and sampling leaves no trace in a motion. So a few thousand
of these states say as much as all samples would, at any rate; their distance grows with the steps taken, so that their number
grows like a logarithm: to 3000, or some 15 MB of a gear pair, for 1e9 steps.
"""

import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import implicit
from gearplay.integrate import run as kernel
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.solver.integration import CHUNK_STEPS, FIRST_STEPS, Course, next_steps
from gearplay.solver.limits import check_samples
from gearplay.solver.status import Status
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import Fault, InputError, ResourceError
from gearplay.vocabulary.memory import enough_memory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SHORTEST, SHARE = 256, 256
"""Steps between checkpoints: the least number, and the divisor of all steps taken so far."""
FEWEST_SAMPLES = 20_000
"""Least number of samples of a piece for a separate thread."""
# Fields that hold requests and outputs of a run, not its state.
_ASKED = (
    "columns",
    "wanted_rotors",
    "wanted_elements",
    "row",
    "needed",
    "times",
    "free_states",
    "scratch_memory",
    "shown",
    "rows",
    "log",
    "tallies",
    "scale",
    "natural",
    "stops",
)
# What an implicit step makes of the rest: factors, and work in between.
_MADE = (
    "real",
    "complex",
    "real_swaps",
    "complex_swaps",
    "k",
    "rest",
    "v",
    "error_weight",
    "nodes",
    "weights",
    "beside",
    "whole",
    "right",
    "right_complex",
)


def _states(run: Any) -> Iterator[NDArray[Any]]:
    """Yield all arrays that a run's next step depends on."""
    for field in fields(run):
        value = getattr(run, field.name)
        if field.name not in _ASKED + _MADE:
            yield from _states(value) if is_dataclass(value) else (value,)


@dataclass(frozen=True)
class _Mark:
    """A state on the way: time [s], copies of the arrays."""

    time: float
    arrays: tuple[NDArray[Any], ...]


class KeptMotion:
    """Checkpointed motion of a run, from which signals are computed on request.

    Parameters
    ----------
    case, packed
        What moves.
    ends
        Times [s] that no step passed: the end of the transient, the end of the run.
    start
        Initial state of a run so short that its states were not stored on the way, shape [state]; they are when requested.

    """

    def __init__(
        self, case: Case, packed: Packed, ends: tuple[float, float], start: Floats | None = None
    ) -> None:
        self.case, self.packed, self.ends, self.start = case, packed, ends, start
        self._marks: list[_Mark] = []
        self._arrays: tuple[NDArray[Any], ...] = ()
        self._due = 0
        self.reached = 0.0
        """How far [s] the run came."""
        self.left = math.inf
        """What the run has left of the case's limit on wall time [s]: no sampling may take longer."""

    @property
    def marks(self) -> list[_Mark]:
        """The stored states, in the order of time."""
        if not self._marks and self.start is not None:
            course = Course(self.case, self.packed, self.start)

            def asked(course: Course) -> Status | None:
                self.note(course)
                return Status.INTERRUPTED if course.time >= self.reached else None

            lead, end = self.ends
            if lead <= 0.0 or course.follow(lead, keep_log=False, reason_to_stop=asked) == Status.DONE:
                course.follow(end, keep_log=False, reason_to_stop=asked)
        return self._marks

    @property
    def bytes(self) -> int:
        """Memory taken [byte]."""
        return sum(array.nbytes for mark in self._marks[:1] for array in mark.arrays) * len(self._marks)

    def note(self, course: Course) -> None:
        """Store a checkpoint of a run at its begin or a pause, if one is due; set the run's steps until the next pause."""
        if not self._arrays:
            self._arrays = tuple(_states(course.run))
        if course.steps >= self._due or course.time in self.ends:
            self._marks.append(_Mark(course.time, tuple([array.copy() for array in self._arrays])))
            self._due = course.steps + max(SHORTEST, course.steps // SHARE)
        course.chunk = min(CHUNK_STEPS, self._due - course.steps)

    def count(self, start: float, sampling: float, end: float) -> int:
        """Return how many samples from ``start`` on lie before ``end`` [s] and were reached."""
        wanted = int((end - start) * sampling + 0.5)
        if self.reached >= self.ends[-1]:
            return max(0, wanted)
        return max(0, min(wanted, math.floor((self.reached - start) * sampling) + 1))

    def sample(
        self, places: Ints, start: float, sampling: float, count: int, until: float = math.inf
    ) -> Floats:
        """Return signals, shape [sample, column], at ``start + k / sampling`` for k < ``count``.

        ``places`` are the columns of a full row. The motion is followed again from the last state kept before ``start``, in
        pieces on several threads; all end soon after Ctrl-C.

        Raises `ResourceError` where that takes longer than the case's limit on wall time leaves, or than ``until`` [s], by the
        clock of `time.monotonic`, and where there is too little memory.
        """
        until = min(until, time.monotonic() + self.left)
        stop = threading.Event()
        with enough_memory():
            values = np.empty((len(places), count))
        step = 1.0 / sampling
        pieces = self._pieces(start, step, count)
        idle: list[Course] = []

        def look() -> None:
            if stop.is_set() or time.monotonic() > until:  # after ``stop`` the message is discarded
                raise out_of_time(count, len(places))

        def fill(piece: tuple[_Mark, int, int]) -> None:
            try:
                course = idle.pop()  # to make one takes longer than to follow a short piece
            except IndexError:
                course = Course(
                    self.case, self.packed, np.zeros(self.packed.state_size), places=places, rows=values
                )
            self._follow(course, piece, start, step, look)
            idle.append(course)

        if len(pieces) == 1:
            fill(pieces[0])
        elif pieces:
            with ThreadPoolExecutor(min(worker_count(), len(pieces))) as pool:
                try:
                    for done in [pool.submit(fill, piece) for piece in pieces]:
                        done.result()
                except BaseException:
                    stop.set()
                    raise
        return values.T

    def _pieces(self, start: float, step: float, count: int) -> list[tuple[_Mark, int, int]]:
        """Return the states to go on from, each with its first sample and the one behind its last."""
        if count == 0:
            return []
        begin = max(i for i, mark in enumerate(self.marks) if i == 0 or mark.time <= start)
        least = max(FEWEST_SAMPLES, -(-count // (8 * worker_count())))
        cuts: list[tuple[_Mark, int]] = [(self.marks[begin], 0)]
        for mark in self.marks[begin + 1 :]:
            # A sample at the very time of a mark is written by the step that leads to it.
            first = math.floor((mark.time - start) / step + 1e-9) + 1
            if first - cuts[-1][1] >= least and first < count:
                cuts.append((mark, first))
        ends = [first for _, first in cuts[1:]] + [count]
        return [(mark, first, last) for (mark, first), last in zip(cuts, ends, strict=True)]

    def _follow(
        self,
        course: Course,
        piece: tuple[_Mark, int, int],
        start: float,
        step: float,
        look: Callable[[], None],
    ) -> None:
        """Fill samples ``first`` to ``last`` - 1 of the rows of an integration run, replayed from a checkpoint.

        ``look`` is called about every 50 ms and raises where the request was cancelled or its time is over.
        """
        (mark, first, last), run = piece, course.run
        forces = run.counts[kernel.FORCES]
        for array, kept in zip(_states(run), mark.arrays, strict=True):
            array[...] = kept
        run.counts[kernel.FORCES] = forces
        run.implicit.numbers[implicit.FACTORED], run.implicit.sizes[implicit.WEIGHED_H] = 0, 0.0
        run.clock[kernel.SAMPLE_START], run.clock[kernel.SAMPLE_INTERVAL] = start, step
        run.counts[kernel.NEXT_SAMPLE], run.counts[kernel.LAST_SAMPLE] = first, last - 1
        run.counts[kernel.ROWS], run.counts[kernel.LOGGED] = first, 0
        # A run that stopped may have none of the last.
        run.rows[:, min(last, max(first, int((self.reached - start) / step))) : last] = np.nan
        chunk = FIRST_STEPS
        for end in self.ends:
            status = Status.PAUSED
            while status == Status.PAUSED and run.counts[kernel.ROWS] < last and course.time < end:
                look()
                began = time.perf_counter()
                status = course.take_chunk(end, chunk, keep_log=False)
                chunk = next_steps(chunk, time.perf_counter() - began)
            if status not in (Status.PAUSED, Status.DONE):
                break


def out_of_time(count: int, columns: int) -> ResourceError:
    """Return the error of samples that took too long."""
    return ResourceError(
        f"samples: {count} times of {columns} signals took longer than there was time for; the motion itself is complete."
        " Lower the sampling, ask for one signal, or raise `run.max_wall_time`."
    )


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

    def compute(self, until: float) -> None:
        """Compute all of them, as `values` does; `ResourceError` where that would last until a time of the monotonic clock."""
        if "values" not in self.__dict__:
            self.__dict__["values"] = self._all(until)

    def _all(self, until: float = math.inf) -> Floats:
        check_samples(self.count, len(self.places))
        return self.motion.sample(self.places, self.start, self.sampling, self.count, until)

    def some(self, columns: Sequence[int]) -> Floats:
        """Return some signals, shape [time, column]; they are kept."""
        if "values" in self.__dict__:
            return self.values[:, list(columns)]
        lacking = [at for at in columns if at not in self._columns]
        if lacking:
            check_samples(self.count, len(lacking))
            found = self.motion.sample(self.places[lacking], self.start, self.sampling, self.count)
            self._columns |= {at: found[:, k] for k, at in enumerate(lacking)}
        return np.stack([self._columns[at] for at in columns], axis=1)

    def thinned(self, columns: Sequence[int], stride: int) -> Floats:
        """Return every ``stride``-th sample of some signals, shape [time, column]; not kept."""
        if "values" in self.__dict__:
            return self.values[::stride, list(columns)]
        count = -(-self.count // stride)
        return self.motion.sample(self.places[list(columns)], self.start, self.sampling / stride, count)

    def at_rate(self, at: int, sampling: float | None, window: tuple[float, float] | None) -> Floats:
        """Return one signal at another rate [Hz], or from another window [s], shape [time]; `InputError` for an empty one."""
        sampling, window = sampling or self.sampling, window or self.motion.ends
        start, end = window
        count = self.motion.count(start, sampling, end)
        if not (0.0 <= start < end <= self.motion.ends[-1] * (1.0 + 1e-12)) or count == 0:
            rule = f"must be a start and a later end [s] within 0 and {min(self.motion.reached, self.motion.ends[-1]):g}"
            raise InputError(Fault("window", str(window), rule, "Choose a window within the run"))
        check_samples(count, 1)
        return self.motion.sample(self.places[at : at + 1], start, sampling, count)[:, 0]
