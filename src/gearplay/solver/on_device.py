"""Members on a CUDA device: as many at a time as its memory holds, each as it would go on a thread of the processor."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from gearplay.device.fleet import DeviceError, Fleet, Memory, Turn, words_of
from gearplay.device.words import WORD, Words
from gearplay.kernels import run as kernel
from gearplay.kernels.layout import System
from gearplay.kernels.run import Run
from gearplay.model.pack import Packed
from gearplay.solver.job import Job, Watch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, WrittenSamples
from gearplay.vocabulary.errors import Fault, InputError, ResourceError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
DEVICES = ("cpu", "cuda")
TURN_TIME = 0.2
"""About how long [s] a turn lasts: between two the wish to stop is heard and logs are emptied."""
FIRST_STEPS, MOST_STEPS = 16, 1_000_000
LOG = 256
"""Contact changes that a run has room for on a device, at least: its memory holds many runs."""
MOST_RUNS = 65_536
"""On a device at a time: what they come from and go to stands in the memory of the processor."""


@dataclass(frozen=True)
class Devices:
    """A device and how its code is got: replaced where a test has none."""

    memory: Memory
    free: Callable[[], int]
    turn_for: Callable[[Sequence[System], Run], Turn]
    """Of mechanisms, and a run of the form of all."""


@cache
def cuda() -> Devices:
    """Return the CUDA device.

    Raises `InputError` where there is none, or nothing that speaks to one.
    """
    try:
        from gearplay.device.driver import Device

        device = Device()
    except ModuleNotFoundError:
        raise _refusal("needs numba-cuda", "Install it: pip install 'gearplay[cuda]'") from None
    except DeviceError as error:
        raise _refusal(f"must find a CUDA device: {error}", "Leave device out") from None

    @cache
    def turn(without: frozenset[str]) -> Turn:
        from gearplay.device.code import turn_of

        return turn_of(device, without, _tell_compiling)

    def turn_for(systems: Sequence[System], _: Run) -> Turn:
        from gearplay.device.code import unneeded

        device.use()
        return turn(unneeded(systems))

    return Devices(device, device.free_memory, turn_for)


def check_device(device: str) -> None:
    """Raise `InputError` for a device of another name."""
    if device not in DEVICES:
        raise InputError(Fault("device", device, f"must be one of {', '.join(DEVICES)}", "Choose one"))


def _refusal(rule: str, cure: str) -> InputError:
    return InputError(Fault("device", "cuda", rule, cure))


def _tell_compiling() -> None:
    sys.stderr.write("Compiling for the device, which takes some two minutes, once.\n")


def run_together(jobs: Sequence[Job], watch: Watch, on: Devices | None = None) -> list[Trajectory]:
    """Simulate members together; the result has their order, and each is what `Job.run` gives but for rounding.

    Raises `ResourceError` where the device fails, `InputError` where there is none.
    """
    on = cuda() if on is None else on
    found: dict[int, Trajectory] = {}
    try:
        for wave in _waves(jobs, on):
            found |= zip(wave.members, wave.run(watch), strict=True)
    except DeviceError as error:
        cure = "Leave device out, or run fewer members at a time"
        raise ResourceError(f"device: {error}, and what ran there is lost. {cure}.") from None
    return [found[number] for number in range(len(jobs))]


class _Like:
    """Members of one mechanism, kept alike: a course that stands for each of them in turn, and how it lies on a device.

    The first of them has made it; the others differ in their start alone.
    """

    def __init__(self, job: Job, packed: Packed) -> None:
        self.packed = packed
        room = max(LOG, 8 * packed.system.switches.size + 8)
        self.course = job.begin(packed, room)
        run = self.course.run
        self.words = words_of(run)
        self.head = self.words.take(run)
        self.states = [self.words.place(array) for array in (run.y, run.y_new, run.y_try)]
        self.form = (self.words.table.tobytes(), Words(packed.system).table.tobytes(), job.kept[1].tobytes())

    def head_of(self, job: Job) -> Ints:
        """Return the words of a member that has not begun."""
        head, start = self.head.copy(), job.first_state(self.packed).view(np.int64)
        for place in self.states:
            head[place] = start
        return head


def _waves(jobs: Sequence[Job], on: Devices) -> Iterator["_Wave"]:
    """Yield members that run at a time: of one form, and as many as memory holds."""
    open_: dict[tuple[bytes, ...], _Wave] = {}
    like: _Like | None = None
    for number, job in enumerate(jobs):
        packed = job.own_packed()
        if like is None or like.packed is not packed or job.origin is not None:
            like = _Like(job, packed)
        wave = open_.get(like.form)
        if wave is None:
            most = int(0.8 * on.free()) // (WORD * like.words.size)
            if most < 1:
                raise ResourceError(
                    "device: its memory does not hold one run. Shorten run.duration, lower run.sampling, or keep fewer signals."
                )
            wave = open_[like.form] = _Wave(on, min(most, MOST_RUNS))
        wave.add(number, job, like)
        if wave.is_full:
            yield open_.pop(like.form)
    yield from open_.values()


class _Wave:
    """Members that run on a device at a time."""

    def __init__(self, on: Devices, most: int) -> None:
        self.on, self.most = on, most
        self.members: list[int] = []
        self.jobs: list[Job] = []
        self.likes: list[_Like] = []
        self.heads: list[Ints] = []

    def add(self, number: int, job: Job, like: _Like) -> None:
        """Take in a member."""
        self.members.append(number)
        self.jobs.append(job)
        self.likes.append(like)
        self.heads.append(like.head_of(job))

    @property
    def is_full(self) -> bool:
        """Whether no other member has room."""
        return len(self.members) >= self.most

    def run(self, watch: Watch) -> list[Trajectory]:
        """Run transient and record of all members; return their trajectories whatever happens."""
        started = time.perf_counter()
        systems = [like.packed.system for like in self.likes]
        words, run = self.likes[0].words, self.likes[0].course.run
        heads = np.array(self.heads)
        clocks = heads[:, words.place(run.clock)].view(np.float64)
        lead = np.array([job.transient for job in self.jobs])
        clocks[:, kernel.T_END] = lead
        self._record(np.flatnonzero(lead == 0.0), heads)
        statuses = np.full(len(self.jobs), Status.DONE, dtype=np.int64)
        logs: list[list[Floats]] = [[] for _ in self.jobs]
        fleet = Fleet(self.on.memory, self.on.turn_for(systems, run), systems, words, run, heads)
        try:
            if (lead > 0.0).any():
                self._follow(fleet, np.flatnonzero(lead > 0.0), statuses, watch, None)
                fleet.get()
                self._record(np.flatnonzero((lead > 0.0) & (statuses == Status.DONE)), heads)
                fleet.put()
            self._follow(fleet, np.flatnonzero(statuses == Status.DONE), statuses, watch, logs)
            fleet.get()
            took = (time.perf_counter() - started) / fleet.count
            ended = zip(heads, fleet.samples(), statuses.tolist(), logs, strict=True)
            return [self._trajectory(n, *each, watch, took) for n, each in enumerate(ended)]
        finally:
            fleet.close()

    def _trajectory(
        self, n: int, head: Ints, samples: Floats, status: int, log: list[Floats], watch: Watch, took: float
    ) -> Trajectory:
        """Return what came of a member; its course stands for it."""
        job, like = self.jobs[n], self.likes[n]
        run, course = like.course.run, like.course
        like.words.load(head, run.y, run.clock, run.counts, run.tallies, run.branch.memory, run.branch.latch)
        course.log = log
        kept = samples[:, : int(run.counts[kernel.ROWS])].T.copy()
        return job.trajectory(
            like.packed, course, Status(status), WrittenSamples(kept, watch.left(job.case)), took
        )

    def _record(self, members: Ints, heads: Ints) -> None:
        """Let members be sampled from now on, to their end."""
        for n in members.tolist():
            job, like = self.jobs[n], self.likes[n]
            run = like.course.run
            changed = (run.clock, run.counts, run.tallies)
            like.words.load(heads[n], *changed)
            like.course.sample_from(job.transient, job.sampling)
            run.clock[kernel.T_END] = job.transient + job.duration
            like.words.store(heads[n], *changed)

    def _follow(
        self, fleet: Fleet, going: Ints, statuses: Ints, watch: Watch, logs: list[list[Floats]] | None
    ) -> None:
        """Let those that are going come to their end, or to the first reason to stop; their statuses follow."""
        steps = FIRST_STEPS
        while going.size:
            most, stopped = steps, []
            for n in going.tolist():
                job = self.jobs[n]
                reason = watch.reason_to_stop(job.place, job.case, float(fleet.times[n]), int(fleet.steps[n]))
                if reason is not None:
                    statuses[n] = reason
                    stopped.append(n)
                elif (limit := job.case.run.max_steps) is not None:
                    most = min(most, limit - int(fleet.steps[n]))
            going = np.setdiff1d(going, stopped)
            if not going.size:
                break
            began = time.perf_counter()
            fleet.take_turn(most, going)
            took = time.perf_counter() - began
            steps = int(min(MOST_STEPS, max(1.0, most * min(16.0, TURN_TIME / max(took, 1e-4)))))
            self._keep(fleet, fleet.capacity // 4, logs)
            statuses[going] = fleet.status[going]
            paused = fleet.status[going] == Status.PAUSED
            for n in going[~paused].tolist():
                watch.report(self.jobs[n].place, float(fleet.times[n]))
            going = going[paused]
        self._keep(fleet, 1, logs)

    @staticmethod
    def _keep(fleet: Fleet, least: int, logs: list[list[Floats]] | None) -> None:
        """Keep what was logged, or without logs forget it, where it is that much."""
        if logs is None:
            fleet.drop_logs(least)
            return
        for n, log in fleet.take_logs(least):
            logs[n].append(log)
