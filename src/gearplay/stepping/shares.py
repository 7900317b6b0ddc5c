"""Members of a stepper in memory: one array of their blocks, and the shares of them that threads advance."""

import threading
import time
from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import run as kernel
from gearplay.integrate.members import in_one_block
from gearplay.integrate.step_members import MOST, UNLOADED, StepBatch, step_members
from gearplay.integrate.stepping import set_input
from gearplay.kernels.compiled_once import bound
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.solver.integration import next_steps
from gearplay.stepping.inputs import Input, hold, own_system

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FIRST = 2000
"""Steps of the integrator in the first call of a step: some milliseconds."""
ROOM = 64
"""Contact changes that there is room for between two emptyings of the log, beyond those of one step."""


class Share:
    """A reused run with its own inputs, on which one thread advances members."""

    def __init__(self, case: Case, packed: Packed, inputs: Sequence[Input], places: Ints) -> None:
        self.system = own_system(packed.system)
        self.held = hold(self.system, inputs)
        settings = case.run
        made = kernel.make_run(
            self.system,
            np.zeros(packed.state_size),
            packed.natural,
            packed.restart_step,
            packed.stops,
            places,
            np.zeros((len(places), 1)),
            2 * packed.system.switches.size + 2 + ROOM,
            settings.tolerance,
            settings.fixed_step,
            by_stage=settings.fixed_step_contacts == "stage",
            statistics=False,
        )
        self.run, self.words, (self.quiet, self.size) = in_one_block(made)
        self.fresh = self.words.copy()

    def begin(self, first: int, last: int, arrays: dict[str, Any]) -> None:
        """Take over a share of the members, ``first`` to ``last`` - 1, and the arrays of all."""
        self._place = (first, last, first, 0, UNLOADED, self.quiet, FIRST)
        own = (self.system, self.run, self.held, np.array(self._place, dtype=np.int64), self.words)
        self.batch = StepBatch(*own, **arrays)
        self._call = bound(step_members, self.batch)

    def load(self) -> None:
        """Write the inputs of the only member into the records."""
        for k, value in enumerate(self.batch.values[0].tolist()):
            set_input(self.system, self.held, k, value)

    def take(self, stop: threading.Event | None = None) -> None:
        """Take the steps of all members of the share; leave them where they are once ``stop`` is set."""
        try:
            if self._call() == kernel.DONE:
                return
            self._resume(stop)
        except BaseException:
            self.batch.place[:] = self._place
            raise
        self.batch.place[:] = self._place

    def _resume(self, stop: threading.Event | None) -> None:
        """Take the rest of steps that take longer than one call, in calls of some milliseconds."""
        steps = FIRST
        while stop is None or not stop.is_set():
            began = time.perf_counter()
            if self._call() == kernel.DONE:
                return
            self.batch.place[MOST] = steps = next_steps(steps, time.perf_counter() - began)


class Table:
    """All members: their words and inputs, shape [member, word] and [member, input], shared out among threads."""

    def __init__(self, shares: Sequence[Share], batch: int, inputs: Sequence[Input]) -> None:
        self.shares, words, quiet, size = shares, shares[0].words, shares[0].quiet, shares[0].size
        # One member alone lives in its run.
        self.states = words[None, quiet:size] if batch == 1 else np.empty((batch, size - quiet), np.int64)
        self.implicit = words[None, :quiet] if batch == 1 else np.empty((batch, quiet), np.int64)
        self.values = np.zeros((batch, len(inputs)))
        self.status = np.zeros(batch, dtype=np.int64)
        self._bounds = [batch * n // len(shares) for n in range(len(shares) + 1)]

    def begin(self, steps: int) -> tuple[Floats, Floats]:
        """Allocate a number of steps; return their lengths [s], shape [step], and inputs, shape [step, member, input]."""
        run = self.shares[0].run
        ends, inputs = np.zeros(steps), np.zeros((steps, *self.values.shape))
        self.outputs = np.zeros((steps, len(self.values), run.columns.size))
        arrays = {
            "states": self.states,
            "implicit": self.implicit,
            "values": self.values,
            "inputs": inputs,
            "outputs": self.outputs,
            "ends": ends,
            "status": self.status,
        }
        for share, first, last in zip(self.shares, self._bounds, self._bounds[1:], strict=False):
            share.begin(first, last, arrays)
        return ends, inputs

    def reset(self, starts: Floats, values: Floats) -> None:
        """Bring every member to a start at t = 0, shape [member, state], and its inputs to ``values``."""
        share = self.shares[0]
        self.states[:], self.implicit[:] = share.fresh[share.quiet : share.size], share.fresh[: share.quiet]
        for name in ("y", "y_new", "y_try"):
            self.column(name)[:] = starts
        self.values[:], self.status[:] = values, 0
        if len(self.values) == 1:
            share.load()

    def column(self, name: str, slot: int | None = None) -> Floats:
        """Return an array of the runs of all members, shape [member, ...]: a view."""
        share = self.shares[0]
        array = getattr(share.run, name)
        at = (array.ctypes.data - share.words.ctypes.data) // 8 - share.quiet
        wanted = (
            self.states[:, at : at + array.size]
            if slot is None
            else self.states[:, at + slot : at + slot + 1]
        )
        return wanted.view(array.dtype)

    def take(self, pool: Executor | None) -> None:
        """Take the allocated steps, on all threads."""
        if pool is None:
            self.shares[0].take()
            return
        stop = threading.Event()
        jobs = [pool.submit(share.take, stop) for share in self.shares]
        try:
            for job in jobs:
                job.result()
        except BaseException:
            stop.set()
            raise
