"""`simulate`: run one case, one member or many, on threads, with progress, limits and a clean stop."""

import math
import threading
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run as kernel
from gearplay.model.case import Case
from gearplay.model.initial import member_state
from gearplay.model.pack import Packed, pack
from gearplay.solver.carry import End, end_of, go_on_from, start_from
from gearplay.solver.compiling import prepare_packed
from gearplay.solver.course import Course
from gearplay.solver.kept_motion import KeptMotion, KeptSamples
from gearplay.solver.limits import check_estimate, estimate
from gearplay.solver.status import Status
from gearplay.solver.trajectory import (
    Column,
    Counters,
    Samples,
    Trajectory,
    WrittenSamples,
    choose_columns,
    statistics_of,
    wedged_meshes,
)
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.progress import Tick

Floats = NDArray[np.float64]


@dataclass
class _Job:
    """One member to simulate."""

    place: int
    case: Case
    packed: Packed
    member: int
    kept: tuple[tuple[Column, ...], NDArray[np.int64]]
    sampling: float
    duration: float
    transient: float
    origin: End | None = None
    start: Floats | None = None
    keep: bool = False

    def __post_init__(self) -> None:
        # What cannot mesh is refused before anything runs; the other members are drawn when their turn comes.
        if self.member == 0 and self.origin is None:
            self.start = member_state(self.case, self.packed, 0)

    def _own_packed(self) -> Packed:
        """Return the member's own translation where its housing has a record of its own, the common one otherwise."""
        if self.case.base is None or not self.case.base.is_per_member:
            return self.packed
        return pack(self.case, span=self.transient + self.duration, member=self.member)

    def _begin(self, packed: Packed) -> Course:
        start = self.start
        if self.origin is not None:
            start = start_from(self.origin, packed)
        elif start is None:
            start = member_state(self.case, packed, self.member)
        if self.keep:  # signals are computed when they are asked for
            course = Course(self.case, packed, start)
        else:
            samples = max(1, int(self.duration * self.sampling + 0.5))
            course = Course(self.case, packed, start, places=self.kept[1], samples=samples)
        if self.origin is not None:
            go_on_from(course, self.origin)
        return course

    def run(self, watch: "_Watch") -> Trajectory:
        """Run transient and record; return the trajectory whatever happens."""
        started = time.perf_counter()
        packed, end = self._own_packed(), self.transient + self.duration
        course = self._begin(packed)
        motion = KeptMotion(self.case, packed, (self.transient, end)) if self.keep else None

        def asked(course: Course) -> Status | None:
            if motion is not None:
                motion.note(course)
            return watch.reason_to_stop(self.place, course)

        status = Status.DONE
        if self.transient > 0.0:
            status = course.follow(self.transient, keep_log=False, reason_to_stop=asked)
        if status == Status.DONE:
            course.sample_from(self.transient, self.sampling)
            status = course.follow(end, reason_to_stop=asked)
        watch.report(self.place, course.time)
        run, counts, reached = course.run, course.run.counts, course.time
        return Trajectory(
            member=self.member,
            first_sample=self.transient,
            sampling=self.sampling,
            samples=self._samples(course, motion, watch.left(course.case)),
            columns=self.kept[0],
            statistics=statistics_of(packed, run.tallies, reached - self.transient),
            log=course.whole_log,
            status=status,
            counters=Counters(
                *(int(counts[i]) for i in (kernel.STEPS, kernel.REJECTED, kernel.EVENTS, kernel.CALLS))
            ),
            reached=reached,
            wall_time=time.perf_counter() - started,
            final_state=run.y.copy(),
            end=end_of(course),
            wedged=wedged_meshes(packed, run.tallies, reached - self.transient),
        )

    def _samples(self, course: Course, motion: KeptMotion | None, left: float) -> Samples:
        """Return what was sampled, or what will be when it is asked for."""
        if motion is None:
            return WrittenSamples(course.run.rows[:, : int(course.run.counts[kernel.ROWS])].T, left)
        motion.reached, motion.left = course.time, left
        return KeptSamples(motion, self.kept[1], self.sampling)


class _Watch:
    """Shared by the runs of one call: progress, limits, and the wish to stop."""

    def __init__(self, total: float, progress: Tick | None, stop: threading.Event) -> None:
        self.stop, self.total, self.progress = stop, total, progress
        self.started = time.monotonic()
        self.done: dict[int, float] = {}
        self.sum = 0.0
        self.lock = threading.Lock()

    def report(self, run: int, t: float) -> None:
        """Note that a run has reached t [s]."""
        if self.progress is None:
            return
        with self.lock:
            self.sum += t - self.done.get(run, 0.0)
            self.done[run] = t
            self.progress(self.sum, self.total)

    def reason_to_stop(self, place: int, course: Course) -> Status | None:
        """Note how far a run has come; return why it must stop now, or None."""
        self.report(place, course.time)
        run = course.case.run
        if self.stop.is_set():
            return Status.INTERRUPTED
        if run.max_steps is not None and course.steps >= run.max_steps:
            return Status.TOO_MANY_STEPS
        return Status.OUT_OF_TIME if self.left(course.case) < 0.0 else None

    def left(self, case: Case) -> float:
        """Return the time [s] that a case's limit leaves for it, or for its samples."""
        limit = case.run.max_wall_time
        return math.inf if limit is None else self.started + limit - time.monotonic()


def _load(case: Case, packed: Packed) -> None:
    """Compile what the case needs, and load what every run begins with, before threads share it."""
    prepare_packed(packed, fixed=case.run.fixed_step is not None)
    Course(case, packed, np.zeros(packed.state_size)).take_chunk(0.0, 0)


def run_members(
    case: Case,
    members: Iterable[int],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Tick | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
) -> list[Trajectory]:
    """Simulate ensemble members of one case on threads; the result does not depend on their number.

    ``signals`` names what to keep (`choose_columns`), ``duration`` and ``transient`` [s] and ``sampling`` [Hz] default to
    the case's. Setting ``stop`` stops every member at its next chunk and returns what was computed, status INTERRUPTED;
    Ctrl-C sets it.

    Raises `InputError` for an impossible case and `ResourceError` for one that is too large.
    """
    return run_batch(
        [(case, list(members))],
        signals=signals,
        duration=duration,
        transient=transient,
        sampling=sampling,
        progress=progress,
        threads=threads,
        stop=stop,
    )[0]


def run_one(
    case: Case,
    member: int = 0,
    *,
    signals: list[str] | None = None,
    stop: threading.Event | None = None,
    origin: End | None = None,
) -> Trajectory:
    """Simulate one member on the caller's thread, for callers with a pool of their own; see `run_members`.

    ``origin`` is the end of an earlier run of the same mechanism, from which this one goes on.
    The kernels must have been compiled (`prepare`), or threads wait for each other's compilation.
    """
    packed, run = pack(case), case.run
    kept = choose_columns(packed, signals)
    check_estimate(
        estimate(
            case,
            packed,
            columns=len(kept[0]),
            members=1,
            sampling=run.sampling,
            duration=run.duration,
            transient=run.transient,
        )
    )
    one = _Job(0, case, packed, member, kept, run.sampling, run.duration, run.transient, origin)
    return one.run(_Watch(run.duration + run.transient, None, stop or threading.Event()))


def run_batch(
    jobs: Sequence[tuple[Case, Sequence[int]]],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Tick | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
    keep_motion: bool = False,
) -> list[list[Trajectory]]:
    """Simulate several cases, each with its members, on one pool of threads; see `run_members`.

    With ``keep_motion`` nothing is sampled on the way: signals are computed when they are asked for (`KeptSamples`). The
    result has the order of ``jobs`` and does not depend on the number of threads. Every case is checked before any runs.
    """
    runs: list[_Job] = []
    bytes_, steps, total = 0.0, 0.0, 0.0
    for case, members in jobs:
        run = case.run
        span = run.duration if duration is None else duration
        lead = run.transient if transient is None else transient
        rate = run.sampling if sampling is None else sampling
        packed = pack(case, span=lead + span)
        kept = choose_columns(packed, signals)
        cost = estimate(
            case,
            packed,
            columns=len(kept[0]),
            members=len(members),
            sampling=0.0 if keep_motion else rate,
            duration=span,
            transient=lead,
        )
        check_estimate(cost)
        bytes_, steps = bytes_ + cost.bytes, steps + cost.steps
        check_estimate(replace(cost, bytes=bytes_, steps=steps))
        total += (span + lead) * len(members)
        runs += [
            _Job(len(runs) + k, case, packed, m, kept, rate, span, lead, keep=keep_motion)
            for k, m in enumerate(members)
        ]
    if runs:
        _load(runs[0].case, runs[0].packed)
    watch = _Watch(total, progress, stop or threading.Event())
    # Even one member runs off the main thread, so that Ctrl-C reaches Python while the kernel works.
    with ThreadPoolExecutor(max(1, min(threads or worker_count(), len(runs)))) as pool:
        futures = [pool.submit(run.run, watch) for run in runs]
        try:
            done = [f.result() for f in futures]
        except KeyboardInterrupt:
            watch.stop.set()
            done = [f.result() for f in futures]
    ends = np.cumsum([0] + [len(members) for _, members in jobs])
    return [done[first:last] for first, last in pairwise(ends)]
