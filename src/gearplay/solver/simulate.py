"""`simulate`: run one case, one member or many, on threads, with progress, limits and a clean stop."""

import os
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run_state, stepper
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack
from gearplay.solver.carry import End, end_of, follow, start_from
from gearplay.solver.limits import check_estimate, estimate
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Column, Counters, Trajectory, choose_columns, statistics_of

Floats = NDArray[np.float64]
Progress = Callable[[float, float], None]  # simulated seconds done, of how many

CHUNK_STEPS = 20_000  # between two looks at the clock: some 20 ms
LOG_CAPACITY = 16_384


class _Run:
    """One member in progress: feeds the kernel, empties its buffers, watches the limits."""

    def __init__(
        self,
        place: int,
        case: Case,
        packed: Packed,
        member: int,
        kept: tuple[tuple[Column, ...], NDArray[np.int64]],
        sampling: float,
        duration: float,
        transient: float,
        origin: End | None = None,
    ) -> None:
        self.place, self.case, self.packed, self.member = place, case, packed, member
        self.columns, self.places = kept
        self.duration, self.transient, self.sampling = duration, transient, sampling
        self.samples = max(1, int(duration * sampling + 0.5))
        # Only member 0 can be refused; the others are drawn when their turn comes.
        self.origin = origin
        self.start = initial_state(case, packed, member=0) if member == 0 and origin is None else None
        self.log: list[Floats] = []

    def _begin(self) -> None:
        """Allocate what only a run in progress needs."""
        packed = self.packed
        # Its own copy of what the kernels change: directions of reference as gears orbit, angles known.
        meshes, known = packed.system.meshes.copy(), packed.system.known_angles.copy()
        self.system = packed.system._replace(meshes=meshes, known_angles=known)
        start = self.start
        if self.origin is not None:
            start = start_from(self.origin, packed)
        elif start is None:
            start = initial_state(self.case, packed, member=self.member)
        self.motion = run_state.make_motion(
            self.system,
            start,
            packed.natural,
            packed.restart_step,
            packed.stops,
            self.places,
            np.empty((len(self.columns), self.samples)),
            LOG_CAPACITY,
            self.case.run.tolerance,
            self.case.run.fixed_step,
        )
        if self.origin is not None:
            follow(self.system, self.motion.latch, self.origin)

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
            limit = self.case.run.max_steps
            chunk = CHUNK_STEPS if limit is None else max(0, min(CHUNK_STEPS, limit - taken))
            status = Status(stepper.advance(self.system, self.motion, chunk))
            self._empty_log(keep_log)
            watch.report(self.place, float(self.motion.clock[run_state.T]))
            if status != Status.PAUSED:
                return status
            reason = watch.reason_to_stop(self.case, int(self.motion.counts[run_state.STEPS]))
            if reason is not None:
                return reason

    def run(self, watch: "_Watch") -> Trajectory:
        """Run transient and record; return the trajectory whatever happens."""
        started = time.perf_counter()
        self._begin()
        motion, clock = self.motion, self.motion.clock
        status = Status.DONE
        if self.transient > 0.0:
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
        del self.motion  # its buffers; the trajectory keeps what it needs
        return Trajectory(
            member=self.member,
            first_sample=self.transient,
            sampling=self.sampling,
            values=motion.rows[:, :filled].T,
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
            end=end_of(self.system, motion.y, motion.latch, reached),
        )


class _Watch:
    """Shared by the runs of one call: progress, limits, and the wish to stop."""

    def __init__(self, total: float, progress: Progress | None, stop: threading.Event) -> None:
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

    def reason_to_stop(self, limits: Case, steps: int) -> Status | None:
        """Return why a run must stop now, or None."""
        run = limits.run
        if self.stop.is_set():
            return Status.INTERRUPTED
        if run.max_steps is not None and steps >= run.max_steps:
            return Status.TOO_MANY_STEPS
        if run.max_wall_time is not None and time.monotonic() > self.started + run.max_wall_time:
            return Status.OUT_OF_TIME
        return None


def prepare(case: Case) -> None:
    """Compile the kernels, or load them from their cache: about a minute once after an installation, else 0.3 s.

    `run_members` does it too; calling it before keeps the compilation out of a run's wall time and lets a front door say
    what is going on. Any case will do: all share one compiled signature.
    """
    _compile(pack(case))


def _compile(packed: Packed) -> None:
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
    one = _Run(0, case, packed, member, kept, run.sampling, run.duration, run.transient, origin)
    return one.run(_Watch(run.duration + run.transient, None, stop or threading.Event()))


def run_batch(
    jobs: Sequence[tuple[Case, Sequence[int]]],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
) -> list[list[Trajectory]]:
    """Simulate several cases, each with its members, on one pool of threads; see `run_members`.

    The result has the order of ``jobs`` and does not depend on the number of threads. Every case is checked before any runs.
    """
    runs: list[_Run] = []
    bytes_, steps, total = 0.0, 0.0, 0.0
    for case, members in jobs:
        packed, run = pack(case), case.run
        span = run.duration if duration is None else duration
        lead = run.transient if transient is None else transient
        rate = run.sampling if sampling is None else sampling
        kept = choose_columns(packed, signals)
        cost = estimate(
            case,
            packed,
            columns=len(kept[0]),
            members=len(members),
            sampling=rate,
            duration=span,
            transient=lead,
        )
        check_estimate(cost)
        bytes_, steps = bytes_ + cost.bytes, steps + cost.steps
        check_estimate(replace(cost, bytes=bytes_, steps=steps))
        total += (span + lead) * len(members)
        runs += [_Run(len(runs) + k, case, packed, m, kept, rate, span, lead) for k, m in enumerate(members)]
    if runs:
        _compile(runs[0].packed)
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
