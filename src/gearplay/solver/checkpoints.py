"""Checkpointed solution: states along a run from which any signal is computed later by a bitwise identical replay.

A step depends on nothing but the state of the kernels' run before it, and sampling leaves no trace in a motion. So a few thousand
of these states say as much as all samples would, at any rate; their distance grows with the steps taken, so that their number
grows like a logarithm: to 3000, or some 15 MB of a gear pair, for 1e9 steps.
"""

import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import implicit
from gearplay.integrate import run as kernel
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.solver.integration import CHUNK_STEPS, FIRST_STEPS, Course, next_steps
from gearplay.solver.status import Status
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import InputError, ResourceError
from gearplay.vocabulary.memory import enough_memory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SHORTEST, SHARE = 256, 256
"""Steps between checkpoints: the least number, and the divisor of all steps taken so far."""
PAUSES = 1e-3
"""Approximate time [s] between two checkpoints while samples are computed block by block."""
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
    "slopes",
    "change",
    "real",
    "complex",
    "k",
    "rest",
    "error_weight",
    "nodes",
    "weights",
    "differences",
    "dense",
    "beside",
    "whole",
    "bodies",
    "right",
    "right_complex",
)


_COMPARED = ("active_set.body_states", "active_set.origin", "branch.modes", "y")
"""Arrays in which a replay must agree with the checkpoints of a file."""


def states(run: Any) -> dict[str, NDArray[Any]]:
    """Return all arrays that a run's next step depends on, by name; shared ones once."""
    found: dict[str, NDArray[Any]] = {}
    for field in fields(run):
        value = getattr(run, field.name)
        if field.name in _ASKED + _MADE:
            continue
        own = states(value) if is_dataclass(value) else {"": value}
        known = {id(array) for array in found.values()}
        found |= {f"{field.name}.{k}".rstrip("."): a for k, a in own.items() if id(a) not in known}
    return found


@dataclass(frozen=True)
class Mark:
    """A checkpoint: time [s], steps taken, copies of the arrays of `states`."""

    time: float
    steps: int
    arrays: tuple[NDArray[Any], ...]

    @classmethod
    def of(cls, course: Course, arrays: Iterable[NDArray[Any]]) -> Self:
        """Return the present checkpoint of a run, whose ``arrays`` are those of `states`."""
        return cls(course.time, course.steps, tuple([array.copy() for array in arrays]))


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
    source
        The file that the checkpoints are from: a replay must arrive at each of them.

    """

    def __init__(
        self,
        case: Case,
        packed: Packed,
        ends: tuple[float, float],
        start: Floats | None = None,
        source: str = "",
    ) -> None:
        self.case, self.packed, self.ends, self.start, self.source = case, packed, ends, start, source
        self._marks: list[Mark] = []
        self._arrays: tuple[NDArray[Any], ...] = ()
        self._due = 0
        self.reached = 0.0
        """Time [s] that the run reached."""
        self.left = math.inf
        """Remaining wall time of the run [s], the limit of each sampling."""

    @property
    def marks(self) -> list[Mark]:
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
    def bytes_each(self) -> int:
        """Memory of a checkpoint [byte]."""
        return sum(array.nbytes for mark in self.marks[:1] for array in mark.arrays)

    def note(self, course: Course) -> None:
        """Store a checkpoint of a run at its begin or a pause, if one is due; set the run's steps until the next pause."""
        if not self._arrays:
            self._arrays = tuple(states(course.run).values())
        if course.steps >= self._due or course.time in self.ends:
            self._marks.append(Mark.of(course, self._arrays))
            self._due = course.steps + max(SHORTEST, course.steps // SHARE)
        course.chunk = min(CHUNK_STEPS, self._due - course.steps)

    def count(self, start: float, sampling: float, end: float) -> int:
        """Return how many samples from ``start`` on lie before ``end`` [s] and were reached."""
        wanted = int((end - start) * sampling + 0.5)
        if self.reached >= self.ends[-1]:
            return max(0, wanted)
        return max(0, min(wanted, math.floor((self.reached - start) * sampling) + 1))

    def sample(
        self,
        places: Ints,
        start: float,
        sampling: float,
        count: int,
        stop: threading.Event | None = None,
    ) -> Floats:
        """Return signals, shape [sample, column], at ``start + k / sampling`` for k < ``count``.

        ``places`` are the columns of a full row. The motion is followed again from the last state kept before ``start``, in
        pieces on several threads; all end soon after Ctrl-C, and once ``stop`` is set.

        Raises `ResourceError` where that takes longer than the case's limit on wall time leaves, and where there is too little
        memory; `InputError` where the checkpoints are those of a file and are not met.
        """
        stop = stop or threading.Event()
        with enough_memory():
            values = np.empty((len(places), count))
        step = 1.0 / sampling
        pieces = self._pieces(start, step, count)
        idle: list[Course] = []
        look = self._watch(stop, count, len(places))

        def fill(piece: tuple[Mark, int, int]) -> None:
            try:
                course = idle.pop()  # to make one takes longer than to follow a short piece
            except IndexError:
                course = self._course(places, values)
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

    def blocks(
        self, places: Ints, start: float, sampling: float, count: int, size: int, stop: threading.Event
    ) -> Iterator[Floats]:
        """Yield the samples of `sample` in blocks of ``size`` times, shape [sample, column], valid until the next one.

        Memory is that of one block. Raises as `sample` does, and once ``stop`` is set.
        """
        rows, step = np.empty((len(places), min(size, count))), 1.0 / sampling
        course, look = self._course(places, rows), self._watch(stop, count, len(places))
        mark = self.marks[self._begin(start)]
        for first in range(0, count, size):
            last = min(first + size, count)
            mark = self._follow(course, (mark, first, last), start, step, look, offset=first)
            yield rows[:, : last - first].T

    def _course(self, places: Ints, rows: Floats) -> Course:
        return Course(self.case, self.packed, np.zeros(self.packed.state_size), places=places, rows=rows)

    def _watch(self, stop: threading.Event, count: int, columns: int) -> Callable[[], None]:
        """Return a function that raises once ``stop`` is set or no time is left."""
        until = time.monotonic() + self.left

        def look() -> None:
            if stop.is_set() or time.monotonic() > until:  # after ``stop`` the message is discarded
                raise out_of_time(count, columns)

        return look

    def _begin(self, start: float) -> int:
        return max(i for i, mark in enumerate(self.marks) if i == 0 or mark.time <= start)

    def _pieces(self, start: float, step: float, count: int) -> list[tuple[Mark, int, int]]:
        """Return the checkpoints to replay from, each with its first sample and the end of its range."""
        if count == 0:
            return []
        begin = self._begin(start)
        least = max(FEWEST_SAMPLES, -(-count // (8 * worker_count())))
        cuts: list[tuple[Mark, int]] = [(self.marks[begin], 0)]
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
        piece: tuple[Mark, int, int],
        start: float,
        step: float,
        look: Callable[[], None],
        offset: int | None = None,
    ) -> Mark:
        """Fill samples ``first`` to ``last`` - 1 of the rows of an integration run, replayed from a checkpoint.

        ``look`` is called about every 50 ms and raises where the request was cancelled or its time is over. With an ``offset``
        rows begin at that sample, and a checkpoint is returned from which sample ``last`` is reached. `InputError` where the
        checkpoints of a file are not met.
        """
        (mark, first, last), run, streams = piece, course.run, offset is not None
        row, forces, arrays = first - (offset or 0), run.counts[kernel.FORCES], states(run)
        for array, kept in zip(arrays.values(), mark.arrays, strict=True):
            array[...] = kept
        run.counts[kernel.FORCES] = forces
        run.implicit.numbers[implicit.FACTORED], run.implicit.sizes[implicit.WEIGHED_H] = 0, 0.0
        run.clock[kernel.SAMPLE_START], run.clock[kernel.SAMPLE_INTERVAL] = start, step
        run.counts[kernel.NEXT_SAMPLE], run.counts[kernel.LAST_SAMPLE] = first, last - 1
        run.counts[kernel.ROWS], run.counts[kernel.LOGGED] = row, 0
        # A run that stopped may have none of the last.
        sure, whole = (
            row + min(last, max(first, int((self.reached - start) / step))) - first,
            row + last - first,
        )
        run.rows[:, sure:whole] = np.nan
        chunk, passed = FIRST_STEPS, self._next_of_file(mark)
        for end in self.ends:
            status = Status.PAUSED
            while status == Status.PAUSED and course.time < end:
                if run.counts[kernel.ROWS] >= whole and (streams or passed is None):
                    break
                look()
                began = time.perf_counter()
                steps = chunk if passed is None else min(chunk, max(1, passed.steps - course.steps))
                status = course.take_chunk(end, steps, keep_log=False)
                took = time.perf_counter() - began
                chunk = next_steps(chunk, took)
                if streams:
                    chunk = chunk if took < PAUSES else max(1, int(steps * PAUSES / took))
                    if course.time < start + (last - 1) * step:
                        mark = Mark.of(course, arrays.values())
                if passed is not None and course.steps >= passed.steps and course.time >= passed.time:
                    self._check(arrays, passed, met=course.time == passed.time)
                    passed = (
                        self._next_of_file(passed) if streams or run.counts[kernel.ROWS] < whole else None
                    )
            if status not in (Status.PAUSED, Status.DONE):
                break
        if self.source and (run.counts[kernel.ROWS] < sure or not (streams or passed is None)):
            raise self._differs(course.time)
        return mark

    def _next_of_file(self, mark: Mark) -> Mark | None:
        """Return the next checkpoint of a file, which a replay must meet."""
        later = (each for each in self.marks if each.steps > mark.steps) if self.source else ()
        return next(iter(later), None)

    def _check(self, arrays: dict[str, NDArray[Any]], mark: Mark, *, met: bool) -> None:
        """Raise `InputError` where a replay does not arrive at a checkpoint of a file."""
        kept = dict(zip(arrays, mark.arrays, strict=True))
        if not met or not all(np.array_equal(arrays[name], kept[name]) for name in _COMPARED):
            raise self._differs(mark.time)

    def _differs(self, t: float) -> InputError:
        rule = (
            f"must hold the motion that this machine computes from its case, and does not near t = {t:.6g} s"
        )
        cure = "Simulate its case again, or run gearplay export where it was written; xarray.open_dataset reads its samples"
        return InputError.of("file", self.source, rule, cure)


def out_of_time(count: int, columns: int) -> ResourceError:
    """Return the error of samples that took too long."""
    return ResourceError(
        f"samples: {count} times of {columns} signals took longer than there was time for; the motion itself is complete."
        " Lower the sampling, ask for one signal, or raise `run.max_wall_time`."
    )
