"""Members on a CUDA device: as many at a time as its memory holds, each as it would go on a thread of the processor."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run as kernel
from gearplay.kernels.device.fleet import Fleet, Memory, Turn, form_of
from gearplay.kernels.layout import System
from gearplay.model.pack import Packed
from gearplay.solver.course import Course
from gearplay.solver.job import Job, Watch, written
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import Fault, InputError, ResourceError

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
    turn_for: Callable[[Sequence[System]], Turn]


@cache
def cuda() -> Devices:
    """Return the CUDA device.

    Raises `InputError` where there is none, or nothing that speaks to one.
    """
    try:
        from gearplay.kernels.device.driver import Device, DeviceError

        device = Device()
    except ModuleNotFoundError:
        raise _refusal("needs numba-cuda", "Install it: pip install 'gearplay[cuda]'") from None
    except DeviceError as error:
        raise _refusal(f"must find a CUDA device: {error}", "Leave device out") from None

    @cache
    def turn(without: frozenset[str]) -> Turn:
        from gearplay.kernels.device.code import turn_of

        return turn_of(device, without, _tell_compiling)

    def turn_for(systems: Sequence[System]) -> Turn:
        from gearplay.kernels.device.code import unneeded

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
    """Simulate members together; the result has their order, and each is what `Job.run` gives but for rounding."""
    on = cuda() if on is None else on
    found: dict[int, Trajectory] = {}
    for wave in _waves(jobs, on):
        for member, trajectory in zip(wave.members, wave.run(watch), strict=True):
            found[member] = trajectory
    return [found[number] for number in range(len(jobs))]


def _waves(jobs: Sequence[Job], on: Devices) -> Iterator["_Wave"]:
    """Yield members that run at a time: one form, and what memory holds."""
    open_: dict[tuple[bytes, bytes], _Wave] = {}
    for number, job in enumerate(jobs):
        packed = job.own_packed()
        room = max(LOG, 8 * packed.system.switches.size + 8)
        course = job.begin(packed, room)
        form = form_of(packed.system, course.run)
        wave = open_.get(form)
        if wave is None:
            most = int(0.8 * on.free()) // max(1, Fleet.size_of(course.run))
            if most < 1:
                raise ResourceError(
                    "device: its memory does not hold one run. Shorten run.duration, lower run.sampling, or keep fewer signals."
                )
            wave = open_[form] = _Wave(on, min(most, MOST_RUNS))
        wave.add(number, job, packed, course)
        if wave.is_full:
            yield open_.pop(form)
    yield from open_.values()


class _Wave:
    """Members that run on a device at a time."""

    def __init__(self, on: Devices, most: int) -> None:
        self.on, self.most = on, most
        self.members: list[int] = []
        self.jobs: list[Job] = []
        self.packed: list[Packed] = []
        self.courses: list[Course] = []

    def add(self, number: int, job: Job, packed: Packed, course: Course) -> None:
        """Take in a member."""
        self.members.append(number)
        self.jobs.append(job)
        self.packed.append(packed)
        self.courses.append(course)

    @property
    def is_full(self) -> bool:
        """Whether no other member has room."""
        return len(self.members) >= self.most

    def run(self, watch: Watch) -> list[Trajectory]:
        """Run transient and record of all members; return their trajectories whatever happens."""
        started = time.perf_counter()
        for job, course in zip(self.jobs, self.courses, strict=True):
            course.run.clock[kernel.T_END] = job.transient
        systems = [packed.system for packed in self.packed]
        fleet = Fleet(
            self.on.memory, self.on.turn_for(systems), systems, [course.run for course in self.courses]
        )
        try:
            statuses = np.full(fleet.count, Status.DONE, dtype=np.int64)
            going = np.array([n for n, job in enumerate(self.jobs) if job.transient > 0.0], dtype=np.int64)
            if going.size:
                self._follow(fleet, going, statuses, watch, keep_log=False)
                fleet.get()
            going = np.flatnonzero(statuses == Status.DONE)
            for n in going.tolist():
                self.courses[n].sample_from(self.jobs[n].transient, self.jobs[n].sampling)
                self.courses[n].run.clock[kernel.T_END] = self.jobs[n].transient + self.jobs[n].duration
            fleet.put()
            self._follow(fleet, going, statuses, watch, keep_log=True)
            fleet.get()
        finally:
            fleet.close()
        took = (time.perf_counter() - started) / fleet.count
        return [
            job.trajectory(packed, course, Status(status), written(course, watch.left(job.case)), took)
            for job, packed, course, status in zip(
                self.jobs, self.packed, self.courses, statuses.tolist(), strict=True
            )
        ]

    def _follow(self, fleet: Fleet, going: Ints, statuses: Ints, watch: Watch, *, keep_log: bool) -> None:
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
            self._keep_logs(fleet, fleet.capacity // 4, keep_log=keep_log)
            statuses[going] = fleet.status[going]
            going = going[fleet.status[going] == Status.PAUSED]
        self._keep_logs(fleet, 1, keep_log=keep_log)

    def _keep_logs(self, fleet: Fleet, least: int, *, keep_log: bool) -> None:
        if not keep_log:
            fleet.drop_logs(least)
            return
        for n, log in fleet.take_logs(least):
            self.courses[n].log.append(log)
