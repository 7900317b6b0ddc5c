"""Simulation of one ensemble member, and the limits and cancellation shared by the runs of one call."""

import threading
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import run as kernel
from gearplay.model.case import Case
from gearplay.model.initial import Starts
from gearplay.model.pack import Packed, pack
from gearplay.solver.checkpoints import KeptMotion, KeptSamples
from gearplay.solver.continuation import End, end_of, go_on_from, start_from
from gearplay.solver.deadline import Deadline, deadline_of
from gearplay.solver.housing import HousingMotion
from gearplay.solver.integration import Course
from gearplay.solver.status import Status
from gearplay.solver.trajectory import (
    Column,
    Counters,
    Samples,
    Trajectory,
    WrittenSamples,
    mesh_that_left,
    statistics_of,
    wedged_meshes,
)
from gearplay.vocabulary.progress import Tick

Floats = NDArray[np.float64]


@dataclass
class Job:
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
    keep: bool = False  # the motion, for signals that are requested later
    sample: bool = True  # the signals, during the run
    starts: Starts | None = None  # of all members of the case, where these are several

    def __post_init__(self) -> None:
        # What cannot mesh is refused before anything runs; the other members are drawn when their turn comes.
        if self.member == 0 and self.origin is None:
            self.draw()

    def draw(self) -> None:
        """Draw the start now. `InputError` where teeth cannot mesh."""
        self.start = self.first_state(self.packed)

    def own_packed(self) -> Packed:
        """Return the member's own translation where its housing has a record of its own, the common one otherwise."""
        if self.case.base is None or not self.case.base.is_per_member:
            return self.packed
        return pack(self.case, span=self.transient + self.duration, member=self.member)

    def first_state(self, packed: Packed) -> Floats:
        """Return the state that the motion begins with, shape [state]."""
        if self.origin is not None:
            return start_from(self.origin, packed)
        if self.start is not None:
            return self.start
        starts = self.starts if packed is self.packed else None
        return (starts or Starts(self.case, packed)).of_member(self.member)

    def begin(self, packed: Packed) -> Course:
        """Return the integration run in its initial state."""
        start = self.first_state(packed)
        if self.sample:
            samples = max(1, int(self.duration * self.sampling + 0.5))
            rows = np.empty((len(self.kept[1]), samples))
            course = Course(self.case, packed, start, places=self.kept[1], rows=rows)
        else:
            course = Course(self.case, packed, start)
        if self.origin is not None:
            go_on_from(course, self.origin)
        return course

    def run(self, watch: "Watch") -> Trajectory:
        """Run transient and record; return the trajectory whatever happens."""
        started = time.perf_counter()
        packed, end = self.own_packed(), self.transient + self.duration
        course = self.begin(packed)
        motion = KeptMotion(self.case, packed, (self.transient, end)) if self.keep else None

        def asked(course: Course) -> Status | None:
            if motion is not None:
                motion.note(course)
            return watch.reason_to_stop(self.place, course.case, course.time, course.steps)

        status = Status.DONE
        if self.transient > 0.0:
            status = course.follow(self.transient, keep_log=False, reason_to_stop=asked)
        if status == Status.DONE:
            course.sample_from(self.transient, self.sampling)
            status = course.follow(end, reason_to_stop=asked)
        watch.report(self.place, course.time)
        samples = self._samples(course, motion, watch.left(course.case), whole=status == Status.DONE)
        return self.trajectory(packed, course, status, samples, time.perf_counter() - started)

    def trajectory(
        self, packed: Packed, course: Course, status: Status, samples: Samples, took: float
    ) -> Trajectory:
        """Return the `Trajectory` of a finished or stopped run; ``took`` is its wall time [s]."""
        run, counts, reached = course.run, course.run.counts, course.time
        return Trajectory(
            member=self.member,
            first_sample=self.transient,
            sampling=self.sampling,
            samples=samples,
            columns=self.kept[0],
            statistics=statistics_of(packed, run.tallies, reached - self.transient),
            log=course.whole_log,
            status=status,
            counters=Counters(
                *(int(counts[i]) for i in (kernel.STEPS, kernel.REJECTED, kernel.EVENTS, kernel.CALLS))
            ),
            reached=reached,
            wall_time=took,
            final_state=run.y.copy(),
            end=end_of(course),
            wedged=wedged_meshes(packed, run.tallies, reached - self.transient),
            housing=HousingMotion.of(packed.system),
            left_mesh=mesh_that_left(packed, run) if status == Status.CANNOT_MESH else "",
        )

    def _samples(self, course: Course, motion: KeptMotion | None, left: float, *, whole: bool) -> Samples:
        """Return the samples: written during the run, computed on request, or both where the run is ``whole``."""
        written = course.run.rows[:, : int(course.run.counts[kernel.ROWS])].T
        if motion is None:
            return WrittenSamples(written, left)
        motion.reached, motion.left = course.time, left
        return KeptSamples(motion, self.kept[1], self.sampling, written if self.sample and whole else None)


class Watch:
    """State shared by the runs of one call: progress, limits and cancellation."""

    def __init__(self, total: float, progress: Tick | None, stop: threading.Event) -> None:
        self.stop, self.total, self.progress = stop, total, progress
        self.deadlines: dict[float | None, Deadline] = {}
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

    def reason_to_stop(self, place: int, case: Case, t: float, steps: int) -> Status | None:
        """Note that a run has reached t [s] in so many steps; return why it must stop now, or None."""
        self.report(place, t)
        if self.stop.is_set():
            return Status.INTERRUPTED
        if case.run.max_steps is not None and steps >= case.run.max_steps:
            return Status.TOO_MANY_STEPS
        return Status.OUT_OF_TIME if self.deadline(case).is_over() else None

    def left(self, case: Case) -> float:
        """Return the time [s] that a case's limit leaves for it, or for its samples."""
        return self.deadline(case).left()

    def deadline(self, case: Case) -> Deadline:
        """Return the deadline of a case: the request's, or that of all runs here with the same limit."""
        limit = case.run.max_wall_time
        with self.lock:
            return self.deadlines.setdefault(limit, deadline_of(limit))
