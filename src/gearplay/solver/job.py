"""Simulation of one ensemble member, and the limits and cancellation shared by the runs of one call."""

import threading
import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import run as kernel
from gearplay.model.case import Case
from gearplay.model.initial import Starts
from gearplay.model.pack import Packed, pack
from gearplay.solver.checkpoints import KeptMotion
from gearplay.solver.continuation import End, end_of, go_on_from, start_from
from gearplay.solver.deadline import Deadline, deadline_of
from gearplay.solver.housing import HousingMotion
from gearplay.solver.integration import Course
from gearplay.solver.kept_samples import KeptSamples
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


@dataclass(frozen=True)
class Ended:
    """End of a run: status, time [s], state, tallies, counts, memory of the elements, stored impact speeds [m/s]."""

    status: Status
    reached: float
    state: Floats
    tallies: Floats
    counts: NDArray[np.int64]
    memory: Floats
    impact_speeds: Floats


@dataclass(frozen=True)
class Simulation:
    """Data common to the runs of all members of a case."""

    case: Case
    packed: Packed
    kept: tuple[tuple[Column, ...], NDArray[np.int64]]
    sampling: float
    duration: float
    transient: float
    keep: bool = False  # the motion, for signals that are requested later
    sample: bool = True  # the signals, during the run

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the transient and of the run [s]."""
        return self.transient, self.transient + self.duration

    @property
    def sample_count(self) -> int:
        """Number of samples that are written during the run."""
        return max(1, int(self.duration * self.sampling + 0.5)) if self.sample else 0

    @cached_property
    def starts(self) -> Starts:
        """Initial states of the members."""
        return Starts(self.case, self.packed)

    @property
    def differs_by_member(self) -> bool:
        """Whether the mechanism differs between members (`Case.differs_by_member`)."""
        return self.case.differs_by_member

    def of_member(self, member: int) -> "Simulation":
        """Return the simulation with the member's own mechanism, or this one where that is common to all."""
        if not self.differs_by_member:
            return self
        return replace(self, packed=pack(self.case, span=self.ends[-1], member=member))

    def samples(self, motion: KeptMotion | None, written: Floats, ended: Ended, left: float) -> Samples:
        """Return the samples, shape [time, column]: written during the run, computed on request, or both after a complete run."""
        if motion is None:
            return WrittenSamples(written, left)
        motion.reached, motion.left = ended.reached, left
        whole = self.sample and ended.status == Status.DONE
        return KeptSamples(motion, self.kept[1], self.sampling, written if whole else None)

    def trajectory(self, member: int, ended: Ended, log: Floats, samples: Samples, took: float) -> Trajectory:
        """Return the `Trajectory` of a finished or stopped run; ``took`` is its wall time [s]."""
        packed, counts, span = self.packed, ended.counts, ended.reached - self.transient
        where = (ended.reached, ended.state, ended.memory)
        return Trajectory(
            member=member,
            first_sample=self.transient,
            sampling=self.sampling,
            samples=samples,
            columns=self.kept[0],
            statistics=statistics_of(packed, ended.tallies, span),
            log=log,
            status=ended.status,
            counters=Counters(
                *(int(counts[i]) for i in (kernel.STEPS, kernel.REJECTED, kernel.EVENTS, kernel.CALLS))
            ),
            reached=ended.reached,
            wall_time=took,
            final_state=ended.state.copy(),
            end=end_of(packed.system, *where, ended.impact_speeds),
            wedged=wedged_meshes(packed, ended.tallies, span),
            housing=HousingMotion.of(packed.system),
            left_mesh=mesh_that_left(packed, *where) if ended.status == Status.CANNOT_MESH else "",
        )


@dataclass
class Job:
    """One member to simulate; ``place`` is its number among the runs of one call."""

    place: int
    simulation: Simulation
    member: int
    origin: End | None = None

    def __post_init__(self) -> None:
        # What cannot mesh is refused before anything runs; the other members are drawn when their turn comes.
        self.start = self.simulation.starts.of_member(0) if self.member == 0 and self.origin is None else None

    def begin(self, own: Simulation) -> Course:
        """Return the integration run in its initial state."""
        if self.origin is not None:
            start = start_from(self.origin, own.packed)
        else:
            start = own.starts.of_member(self.member) if self.start is None else self.start
        wanted: dict[str, Any] = {}
        if own.sample:
            wanted = {"places": own.kept[1], "rows": np.empty((len(own.kept[1]), own.sample_count))}
        course = Course(own.case, own.packed, start, **wanted)
        if self.origin is not None:
            go_on_from(course, self.origin)
        return course

    def run(self, watch: "Watch") -> Trajectory:
        """Run transient and record; return the trajectory, also of a run that failed."""
        started = time.perf_counter()
        own = self.simulation.of_member(self.member)
        course = self.begin(own)
        motion = KeptMotion(own.case, own.packed, own.ends) if own.keep else None

        def asked(course: Course) -> Status | None:
            if motion is not None:
                motion.note(course)
            return watch.reason_to_stop(self.place, course.case, course.time, course.steps)

        status = Status.DONE
        if own.transient > 0.0:
            status = course.follow(own.transient, keep_log=False, reason_to_stop=asked)
        if status == Status.DONE:
            course.sample_from(own.transient, own.sampling)
            status = course.follow(own.ends[-1], reason_to_stop=asked)
        watch.report(self.place, course.time)
        run = course.run
        ended = Ended(
            status, course.time, run.y, run.tallies, run.counts, run.branch.memory, course.impact_speeds
        )
        written = run.rows[:, : int(run.counts[kernel.ROWS])].T
        samples = own.samples(motion, written, ended, watch.left(own.case))
        return own.trajectory(self.member, ended, course.whole_log, samples, time.perf_counter() - started)


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
        """Note that a run has reached t [s], and its number of steps; return why it must stop now, or None."""
        self.report(place, t)
        if self.stop.is_set():
            return Status.INTERRUPTED
        if case.run.max_steps is not None and steps >= case.run.max_steps:
            return Status.TOO_MANY_STEPS
        return Status.OUT_OF_TIME if self.deadline(case).is_over() else None

    def left(self, case: Case) -> float:
        """Return the remaining time [s] within a case's limit of wall time."""
        return self.deadline(case).left()

    def deadline(self, case: Case) -> Deadline:
        """Return the deadline of a case: the request's, or that of all runs here with the same limit."""
        limit = case.run.max_wall_time
        with self.lock:
            return self.deadlines.setdefault(limit, deadline_of(limit))
