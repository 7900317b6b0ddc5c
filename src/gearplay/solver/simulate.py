"""`simulate`: run one case, one member or many, on threads, with progress, limits and a clean stop."""

import os
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run_state, stepper
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack
from gearplay.solver.limits import check_estimate, estimate
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Counters, Trajectory, choose_columns, statistics_of

Floats = NDArray[np.float64]
Progress = Callable[[float, float], None]  # simulated seconds done, of how many

CHUNK_STEPS = 20_000  # between two looks at the clock: some 20 ms
LOG_CAPACITY = 16_384


class _Run:
    """One member in progress: feeds the kernel, empties its buffers, watches the limits."""

    def __init__(
        self,
        case: Case,
        packed: Packed,
        member: int,
        wanted: list[str] | None,
        sampling: float,
        duration: float,
        transient: float,
    ) -> None:
        # Its own copy of what the kernels change: directions of reference as gears orbit, angles known.
        system = packed.system
        system = system._replace(meshes=system.meshes.copy(), known_angles=system.known_angles.copy())
        packed = replace(packed, system=system)
        self.case, self.packed, self.member = case, packed, member
        self.columns, places = choose_columns(packed, wanted)
        self.duration, self.transient, self.sampling = duration, transient, sampling
        self.samples = max(1, int(duration * sampling + 0.5))
        self.rows = np.empty((len(self.columns), self.samples))
        self.motion = run_state.make_motion(
            packed.system,
            initial_state(case, packed, member=member),
            packed.natural,
            packed.restart_step,
            packed.stops,
            places,
            self.rows,
            LOG_CAPACITY,
            case.run.tolerance,
        )
        self.log: list[Floats] = []

    def _empty_log(self, keep: bool) -> None:
        logged = int(self.motion.counts[run_state.LOGGED])
        if keep and logged:
            self.log.append(self.motion.log[:logged].copy())
        self.motion.counts[run_state.LOGGED] = 0

    def advance_to(self, t_end: float, keep_log: bool, watch: "_Watch") -> Status:
        """Advance to t_end [s], or to the first reason to stop."""
        self.motion.clock[run_state.T_END] = t_end
        while True:
            taken = int(self.motion.counts[run_state.STEPS])
            chunk = (
                CHUNK_STEPS if watch.max_steps is None else max(0, min(CHUNK_STEPS, watch.max_steps - taken))
            )
            status = Status(stepper.advance(self.packed.system, self.motion, chunk))
            self._empty_log(keep_log)
            watch.report(self.member, float(self.motion.clock[run_state.T]))
            if status != Status.PAUSED:
                return status
            reason = watch.reason_to_stop(int(self.motion.counts[run_state.STEPS]))
            if reason is not None:
                return reason

    def run(self, watch: "_Watch") -> Trajectory:
        """Run transient and record; return the trajectory whatever happens."""
        started = time.perf_counter()
        motion, clock = self.motion, self.motion.clock
        status = Status(stepper.begin(self.packed.system, motion))
        if status == Status.DONE and self.transient > 0.0:
            status = self.advance_to(self.transient, False, watch)
        if status == Status.DONE:
            motion.tallies[:] = 0.0
            clock[run_state.SAMPLE_START] = self.transient
            clock[run_state.SAMPLE_INTERVAL] = 1.0 / self.sampling
            motion.counts[run_state.LAST_SAMPLE] = self.samples - 1
            status = self.advance_to(self.transient + self.duration, True, watch)
        reached = float(clock[run_state.T])
        counts = motion.counts
        filled = int(counts[run_state.ROWS])
        return Trajectory(
            member=self.member,
            time=self.transient + np.arange(filled) / self.sampling,
            values=self.rows[:, :filled].T,
            columns=self.columns,
            statistics=statistics_of(self.packed, motion.tallies, reached - self.transient),
            log=np.concatenate(self.log) if self.log else np.zeros((0, 4)),
            status=status,
            counters=Counters(
                *(
                    int(counts[i])
                    for i in (run_state.STEPS, run_state.REJECTED, run_state.EVENTS, run_state.CALLS)
                )
            ),
            reached=reached,
            wall_time=time.perf_counter() - started,
            final_state=motion.y.copy(),
        )


class _Watch:
    """Shared by the members of one call: progress, limits, and the wish to stop."""

    def __init__(self, case: Case, total: float, progress: Progress | None, stop: threading.Event) -> None:
        self.stop = stop
        self.max_steps = case.run.max_steps
        self.deadline = None if case.run.max_wall_time is None else time.monotonic() + case.run.max_wall_time
        self.total, self.progress = total, progress
        self.done: dict[int, float] = {}
        self.lock = threading.Lock()

    def report(self, member: int, t: float) -> None:
        """Note that a member has reached t [s]."""
        if self.progress is None:
            return
        with self.lock:
            self.done[member] = t
            self.progress(sum(self.done.values()), self.total)

    def reason_to_stop(self, steps: int) -> Status | None:
        """Return why a member must stop now, or None."""
        if self.stop.is_set():
            return Status.INTERRUPTED
        if self.max_steps is not None and steps >= self.max_steps:
            return Status.TOO_MANY_STEPS
        if self.deadline is not None and time.monotonic() > self.deadline:
            return Status.OUT_OF_TIME
        return None


def prepare(case: Case) -> None:
    """Compile the kernels, or load them from their cache: some 25 s once after an installation, else 0.3 s.

    `run_members` does it too; calling it before keeps the compilation out of a run's wall time and lets a front door say
    what is going on. Any case will do: all share one compiled signature.
    """
    packed = pack(case)
    columns = np.arange(1, dtype=np.int64)
    state = np.zeros(packed.state_size)
    motion = run_state.make_motion(
        packed.system,
        state,
        packed.natural,
        packed.restart_step,
        packed.stops,
        columns,
        np.empty((1, 1)),
        LOG_CAPACITY,
        1e-6,
    )
    stepper.begin(packed.system, motion)
    stepper.advance(packed.system, motion, 0)


def worker_count() -> int:
    """Return how many threads to use: the cores this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def run_members(
    case: Case,
    members: Iterable[int],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
) -> list[Trajectory]:
    """Simulate ensemble members of one case on threads; the result does not depend on their number.

    ``signals`` names what to keep (`choose_columns`), ``duration`` and ``transient`` [s] and ``sampling`` [Hz] default to
    the case's. Setting ``stop`` stops every member at its next chunk and returns what was computed, status INTERRUPTED;
    Ctrl-C sets it.

    Raises `InputError` for an impossible case and `ResourceError` for one that is too large.
    """
    packed = pack(case)
    chosen = list(members)
    duration = case.run.duration if duration is None else duration
    transient = case.run.transient if transient is None else transient
    sampling = case.run.sampling if sampling is None else sampling
    columns, _ = choose_columns(packed, signals)
    check_estimate(
        estimate(
            case,
            packed,
            columns=len(columns),
            members=len(chosen),
            sampling=sampling,
            duration=duration,
            transient=transient,
        )
    )
    prepare(case)
    watch = _Watch(case, (duration + transient) * len(chosen), progress, stop or threading.Event())

    def one(member: int) -> Trajectory:
        return _Run(case, packed, member, signals, sampling, duration, transient).run(watch)

    # Even one member runs off the main thread, so that Ctrl-C reaches Python while the kernel works.
    with ThreadPoolExecutor(max(1, min(threads or worker_count(), len(chosen)))) as pool:
        futures = [pool.submit(one, member) for member in chosen]
        try:
            return [f.result() for f in futures]
        except KeyboardInterrupt:
            watch.stop.set()
            return [f.result() for f in futures]
