"""Simulation of many members of one case: compiled, on runs that are reused, in blocks that threads share."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import members as kernel
from gearplay.integrate import run as run_kernel
from gearplay.integrate.run import Run
from gearplay.kernels.housing_motion import KIND
from gearplay.model.pack import Packed
from gearplay.solver.checkpoints import KeptMotion
from gearplay.solver.integration import CHUNK_STEPS, FIRST_STEPS, LOG_CAPACITY, next_steps
from gearplay.solver.job import Ended, Job, Simulation, Watch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BLOCKS_PER_THREAD = 8
MOST_MEMBERS = 256
"""Members of a block at most."""
MOST_NUMBERS = 1 << 22
"""Numbers sampled in a block at most: 32 MB."""


class ReusedRun:
    """A run that serves one member after another of cases of one build."""

    def __init__(self, packed: Packed, places: Ints) -> None:
        made = run_kernel.make_run(
            packed.system,
            np.zeros(packed.state_size),
            packed.natural,
            packed.restart_step,
            packed.stops,
            places,
            np.empty((len(places), 0)),
            LOG_CAPACITY,
            1.0,
        )
        self.run, self.words, _ = kernel.in_one_block(made)
        self.blank, self.build = self.words.copy(), build_of(packed, places)
        self.fresh, self.steps = self.blank, FIRST_STEPS

    def take(self, wanted: Simulation) -> None:
        """Take over the numbers of a case of this build."""
        packed, settings = wanted.packed, wanted.case.run
        self.words[:] = self.blank
        kernel.set_case(
            self.run,
            packed.natural,
            packed.restart_step,
            packed.stops,
            settings.tolerance,
            settings.fixed_step,
        )
        if settings.fixed_step is not None:
            self.run.active_set.forced[0] = 2 if settings.fixed_step_contacts == "stage" else 1
        self.fresh = self.words.copy()


def build_of(packed: Packed, places: Ints) -> tuple[Any, ...]:
    """Return the key of the arrays of a run: all that they depend on except the numbers that `ReusedRun.take` copies."""
    system = packed.system
    tables = (
        system.elements,
        system.contacts["impact_slot"],
        system.rotors["group"],
        system.joined.chains["count"],
    )
    sizes = (packed.state_size, packed.stops.size, system.switches.size, float(system.base[KIND]))
    return (*[table.tobytes() for table in tables], *sizes, places.tobytes())


class Pool:
    """Cache of runs for reuse by threads, of the builds simulated last."""

    def __init__(self) -> None:
        self.idle: list[ReusedRun] = []

    def take(self, wanted: Simulation) -> ReusedRun:
        """Return a run for a simulation, which the caller has alone until it is given back."""
        places = wanted.kept[1] if wanted.sample else np.zeros(0, dtype=np.int64)
        build, found = build_of(wanted.packed, places), None
        while self.idle and found is None:
            try:
                found = self.idle.pop()
            except IndexError:  # another thread was faster
                break
            found = found if found.build == build else None
        found = found or ReusedRun(wanted.packed, places)
        found.take(wanted)
        return found


@dataclass(eq=False)
class Members(Sequence[Trajectory]):
    """The runs of several members of a case: each `Trajectory` is made on first access.

    ``place`` is the number of the first among the runs of one call; a member's is so much higher.
    """

    place: int
    simulation: Simulation
    numbers: Sequence[int]
    pool: Pool = field(default_factory=Pool, repr=False)

    def __post_init__(self) -> None:
        self._blocks: dict[int, _Block] = {}
        self._made: dict[int, Trajectory] = {}
        self._is_long = False

    def __len__(self) -> int:
        return len(self.numbers)

    @overload
    def __getitem__(self, at: int) -> Trajectory: ...

    @overload
    def __getitem__(self, at: slice) -> list[Trajectory]: ...

    def __getitem__(self, at: int | slice) -> Trajectory | list[Trajectory]:
        if isinstance(at, slice):
            return [self[k] for k in range(*at.indices(len(self)))]
        k = range(len(self))[at]
        if k not in self._made:
            first = max(begin for begin in self._blocks if begin <= k)
            self._made[k] = self._blocks[first].trajectory(k - first)
        return self._made[k]

    def calls(self, watch: Watch, threads: int | None = None) -> list[Callable[[], None]]:
        """Return the calls that simulate them, for ``threads`` to share; as few as possible if not given."""
        wanted = self.simulation
        size = len(self) if threads is None else -(-len(self) // (BLOCKS_PER_THREAD * threads))
        numbers = max(1, len(wanted.kept[1]) * wanted.sample_count)
        size = max(1, min(size, MOST_MEMBERS, MOST_NUMBERS // numbers))
        bounds = [*range(0, len(self), size), len(self)]
        return [partial(self._run, first, last, watch) for first, last in pairwise(bounds)]

    def _run(self, first: int, last: int, watch: Watch) -> None:
        """Simulate members ``first`` to ``last`` - 1."""
        wanted = self.simulation
        if not self._is_long:
            block = _Block(wanted, self.numbers[first:last], self.place + first)
            self._blocks[first] = block
            reused = self.pool.take(wanted)
            block.run(reused, watch)
            self.pool.idle.append(reused)
            alone = [first + k for k in block.long]
            self._is_long = bool(alone)
        else:
            alone = list(range(first, last))
        for k in alone:
            self._made[k] = Job(self.place + k, wanted, self.numbers[k]).run(watch)


class _Block:
    """Members that one thread simulates; ``place`` is the number of the first among the runs of one call."""

    def __init__(self, wanted: Simulation, numbers: Sequence[int], place: int) -> None:
        self.wanted, self.numbers, self.place = wanted, numbers, place
        self.starts = wanted.starts.of_members(numbers)
        self.logs: list[Floats] = []
        self.took = np.zeros(len(numbers))
        self.long: list[int] = []
        """Those with so many steps that states on the way are to be kept, from the first on."""

    def run(self, reused: ReusedRun, watch: Watch) -> None:
        """Simulate them on a run."""
        wanted, most = self.wanted, self.wanted.case.run.max_steps or np.iinfo(np.int64).max
        limit = min(most, CHUNK_STEPS) if wanted.keep else most
        self.rows = np.empty((len(wanted.kept[1]), wanted.sample_count * len(self.starts)))
        run = replace(reused.run, rows=self.rows) if wanted.sample else reused.run
        times = np.array([*wanted.ends, 1.0 / wanted.sampling])
        self.batch = batch = kernel.make_batch(
            run, reused.words, reused.fresh, self.starts, times, wanted.sample_count, limit
        )
        status = Status.PAUSED
        while status == Status.PAUSED:
            at = int(batch.place[kernel.MEMBER])
            if (reason := self._reason(run, watch)) is not None:
                self._end_all(run, reason)
                break
            began = time.perf_counter()
            status = Status(kernel.advance_members(wanted.packed.system, run, batch, reused.steps))
            took = time.perf_counter() - began
            self._take_log(run, at)
            end = int(batch.place[kernel.MEMBER])
            self.took[at : end + 1] += took / (end + 1 - at)
            reused.steps = next_steps(reused.steps, took)
            if limit < most and Status.TOO_MANY_STEPS in batch.status[at:end]:
                first = int(np.argmax(batch.status == Status.TOO_MANY_STEPS))
                self.long = list(range(first, len(self.numbers)))
                batch.reached[first:] = 0.0
                break
        watch.report(-1 - self.place, float(np.sum(batch.reached)))
        self.left = watch.left(wanted.case)

    def _reason(self, run: Run, watch: Watch) -> Status | None:
        """Report how far the members have come; return why they must stop, or None."""
        batch = self.batch
        reached = float(np.sum(batch.reached[: batch.place[kernel.MEMBER]]))
        if batch.place[kernel.PHASE] != kernel.UNBEGUN:
            reached += float(run.clock[run_kernel.T])
        return watch.reason_to_stop(-1 - self.place, self.wanted.case, reached, -1)

    def _end_all(self, run: Run, reason: Status) -> None:
        """End the present member and all later ones at their present times."""
        place, at = self.batch.place, int(self.batch.place[kernel.MEMBER])
        while place[kernel.MEMBER] < len(self.numbers):
            if place[kernel.PHASE] == kernel.UNBEGUN:
                kernel.begin_member(run, self.batch)
            kernel.end_member(run, self.batch, int(reason))
        self._take_log(run, at)

    def _take_log(self, run: Run, at: int) -> None:
        """Empty the log: the contact changes of member ``at``, those of before included, and of all that ended after it."""
        place, logged = self.batch.place, int(run.counts[run_kernel.LOGGED])
        rows, end = run.log[:logged].copy(), int(place[kernel.MEMBER])
        bounds = [0, *self.batch.log_ends[at:end].tolist()]
        pieces = [rows[first:last] for first, last in pairwise(bounds)]
        if place[kernel.PHASE] == kernel.RECORDING:
            pieces.append(rows[bounds[-1] :])
        for k, piece in enumerate(pieces, start=at):
            if k == len(self.logs):
                self.logs.append(piece)
            elif len(piece):
                self.logs[k] = np.concatenate([self.logs[k], piece])
        run.counts[run_kernel.LOGGED] = place[kernel.LOG_BEGIN] = 0

    def trajectory(self, k: int) -> Trajectory:
        """Return the `Trajectory` of the k-th member."""
        wanted, batch, count = self.wanted, self.batch, self.wanted.sample_count
        ended = Ended(
            Status(int(batch.status[k])),
            float(batch.reached[k]),
            batch.states[k],
            batch.tallies[k],
            batch.counts[k],
            batch.memory[k],
            batch.impact_speeds[k],
        )
        motion = None
        if wanted.keep:
            motion = KeptMotion(wanted.case, wanted.packed, wanted.ends, start=self.starts[k])
        written = self.rows[:, k * count : max(k * count, int(ended.counts[run_kernel.ROWS]))].T
        samples = wanted.samples(motion, written, ended, self.left)
        return wanted.trajectory(self.numbers[k], ended, self.logs[k], samples, float(self.took[k]))
