"""Integration in progress: one run of the kernels, advanced in chunks, with its log and its limits."""

import math
import threading
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import members, stepper, tangent, tangent_state
from gearplay.integrate import run as kernel
from gearplay.kernels.layout import OPEN
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.solver.deadline import deadline_of
from gearplay.solver.status import WORDS, Status
from gearplay.vocabulary.errors import InputError, SimulationError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FIRST_STEPS, CHUNK_STEPS = 8, 20_000
"""Steps between two checks of the clock and of the reasons to stop: initial and largest number."""
CHUNK_TIME = 0.05
"""Approximate time [s] between two checks: signals sampled on the way may make a step a thousand times longer."""
MOST_GROWTH = 16.0
"""Largest growth of the number of steps from one chunk to the next."""
LOG_CAPACITY = 16_384
MOST_STEPS = 50_000_000
"""Steps of one piece from which on a course without a watch counts as run away: some minutes."""


class OutOfTimeError(SimulationError):
    """The limit on wall time of the request was reached: no further run can begin."""


def next_steps(steps: int, took: float) -> int:
    """Return how many steps to take next where ``steps`` of them took a time [s]: no chunk is to last much longer than it should.

    They grow fast: between two chunks a thread waits for others that run Python.

    >>> next_steps(64, 0.0001), next_steps(64, 0.01), next_steps(64, 0.04), next_steps(64, 0.5)
    (1024, 160, 64, 6)
    """
    if took > CHUNK_TIME:
        return max(1, int(steps * CHUNK_TIME / took))
    growth = min(MOST_GROWTH, 0.5 * CHUNK_TIME / max(took, 1e-9))
    return min(int(steps * max(1.0, growth)), CHUNK_STEPS)


def refuse_fixed_steps(case: Case) -> None:
    """Raise `InputError` for a case of fixed steps: they have no exact derivative."""
    if case.run.fixed_step is not None:
        rule = "must not be given where the derivative of the motion is requested: it needs located contacts"
        raise InputError.of("run.fixed_step", case.run.fixed_step, rule, "Remove it")


class Course:
    """A motion from ``state`` at t = 0, to be followed piece by piece.

    Parameters
    ----------
    case, packed
        What moves; ``packed`` is read only and may be shared.
    state
        Start, shape [state].
    places, rows
        Columns of a full row to keep, and where samples of them go, shape [column, sample] (`sample_from`).
    changes
        Small changes of the start that are moved on to first order, shape [change, state + impact speed]; they may be
        replaced in place between pieces.
    divergence
        Whether to sum up the divergence on the way.
    stop
        Once it is set the motion goes no further.
    log
        Contact changes that there is room for in a piece; a piece ends where there might be more.

    Raises `InputError` where the derivative of fixed steps is requested.

    """

    def __init__(
        self,
        case: Case,
        packed: Packed,
        state: Floats,
        *,
        places: Ints | None = None,
        rows: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
        stop: threading.Event | None = None,
        log: int = LOG_CAPACITY,
    ) -> None:
        self.case, self.packed, self.stop = case, packed, stop
        self.chunk = CHUNK_STEPS
        """Largest number of steps between two checks of the reasons to stop; fewer where steps take long."""
        self._paced = FIRST_STEPS
        self.deadline = deadline_of(case.run.max_wall_time)
        self.system, settings = packed.system, case.run
        self._piece_begun = 0
        wanted = np.zeros(0, dtype=np.int64) if places is None else places
        self.run = kernel.make_run(
            packed.system,
            state,
            packed.natural,
            packed.restart_step,
            packed.stops,
            wanted,
            np.empty((len(wanted), 0)) if rows is None else rows,
            log,
            settings.tolerance,
            settings.fixed_step,
            by_stage=settings.fixed_step_contacts == "stage",
        )
        self.tangent: tangent_state.Tangent | None = None
        self.log: list[Floats] = []
        if changes is None and not divergence:
            return
        refuse_fixed_steps(case)
        moved = self._no_changes() if changes is None else changes.copy()
        self.tangent = tangent_state.make_tangent(self.system, self.run, moved, divergence=divergence)

    def _no_changes(self) -> Floats:
        return np.zeros((0, self.run.y.size + self.run.branch.impact_speeds.size))

    def sample_from(self, t: float, sampling: float) -> None:
        """Keep samples from t [s] on, at ``sampling`` [Hz], as many as there is room for; tallies start anew."""
        run = self.run
        run.tallies[:] = 0.0
        run.clock[kernel.SAMPLE_START] = t
        run.clock[kernel.SAMPLE_INTERVAL] = 1.0 / sampling
        run.counts[kernel.LAST_SAMPLE] = run.rows.shape[1] - 1
        self._paced = FIRST_STEPS

    def take_chunk(self, t_end: float, steps: int, *, keep_log: bool = True) -> Status:
        """Advance to t_end [s], by at most ``steps`` steps; return the status."""
        self.run.clock[kernel.T_END] = t_end
        if self.tangent is None:
            status = Status(stepper.advance(self.system, self.run, steps))
        else:
            status = Status(tangent.advance_tangent(self.system, self.run, self.tangent, steps))
        self._empty_log(keep_log=keep_log)
        return status

    def _empty_log(self, *, keep_log: bool) -> None:
        run = self.run
        logged = int(run.counts[kernel.LOGGED])
        if keep_log and logged:
            self.log.append(run.log[:logged].copy())
        run.counts[kernel.LOGGED] = 0

    def follow(
        self,
        t_end: float,
        *,
        keep_log: bool = True,
        reason_to_stop: Callable[["Course"], Status | None] | None = None,
    ) -> Status:
        """Advance to t_end [s] or to the first reason to stop, evaluated before each chunk; return the status."""
        return self._in_chunks(partial(self.take_chunk, t_end, keep_log=keep_log), reason_to_stop)

    def _in_chunks(
        self, take: Callable[[int], Status], reason_to_stop: Callable[["Course"], Status | None] | None = None
    ) -> Status:
        asked, self._piece_begun = reason_to_stop or Course._own_reason, self.steps
        while (reason := asked(self)) is None:
            steps = min(self.chunk, self._paced, CHUNK_STEPS)
            steps = max(0, min(steps, (self.case.run.max_steps or self.steps + steps) - self.steps))
            began = time.perf_counter()
            status = take(steps)
            if status != Status.PAUSED:
                return status
            self._paced = next_steps(steps, time.perf_counter() - began)
        return reason

    def _own_reason(self) -> Status | None:
        if self.stop is not None and self.stop.is_set():
            return Status.INTERRUPTED
        if self.deadline.is_over():
            return Status.OUT_OF_TIME
        most = min(self.case.run.max_steps or math.inf, self._piece_begun + MOST_STEPS)
        return Status.TOO_MANY_STEPS if self.steps >= most else None

    def advance(self, t_end: float) -> None:
        """Advance to t_end [s]; `SimulationError` where the integration fails before."""
        self._check(self.follow(t_end))

    def advance_periods(self, period: float, count: int) -> None:
        """Advance to ``count`` times a period [s], as one call of `advance` for each; no derivative is propagated."""
        passed = np.zeros(1, dtype=np.int64)

        def take(steps: int) -> Status:
            status = Status(members.advance_periods(self.system, self.run, period, passed, count, steps))
            self._empty_log(keep_log=True)
            return status

        self._check(self._in_chunks(take))

    def advance_to_change(self, t_end: float) -> Floats:
        """Advance to the end of the first step with a contact change, at most to t_end [s].

        Returns the changes there as rows (t, contact, 1 onset / 0 release, rate), none at t_end. The motion is that of `advance`.
        """
        run = self.run
        run.clock[kernel.T_END] = t_end
        while True:
            if self.deadline.is_over():
                self._check(Status.OUT_OF_TIME)
            status = Status(stepper.advance(self.system, run, 1))
            rows = run.log[: int(run.counts[kernel.LOGGED])].copy()
            run.counts[kernel.LOGGED] = 0
            if status not in (Status.DONE, Status.PAUSED):
                self._check(status)
            if len(rows) or status == Status.DONE:
                stepper.synchronise(self.system, run)
                return rows

    def _check(self, status: Status) -> None:
        if status == Status.OUT_OF_TIME:
            raise OutOfTimeError(
                f"run.max_wall_time = {self.deadline.limit:g} s: the limit on wall time was reached, in a run at"
                f" t = {self.time:.6g} s. Raise it, or ask for fewer periods, points or seconds."
            )
        if status != Status.DONE:
            raise SimulationError(f"flow: {WORDS[status]} Stopped at t = {self.time:.9g} s.")

    @property
    def time(self) -> float:
        """Present time of the motion [s]."""
        return float(self.run.clock[kernel.T])

    @property
    def state(self) -> Floats:
        """The state now, shape [state]: a view that changes with the motion."""
        return self.run.y

    @property
    def impact_speeds(self) -> Floats:
        """The stored impact speeds now [m/s], shape [impact speed]: a view that changes with the motion."""
        return self.run.branch.impact_speeds

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self.run.counts[kernel.STEPS])

    @property
    def changes(self) -> Floats:
        """The changes as they have moved on."""
        return self._no_changes() if self.tangent is None else self.tangent.changes

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Whether each contact is closed, shape [contact], in the order of `Packed.contact_labels`."""
        return np.asarray(self.run.branch.modes[: self.system.contacts.size] != OPEN)

    @property
    def divergence(self) -> float:
        """The divergence [1] accumulated so far; NaN where it was not requested."""
        if self.tangent is None or self.tangent.totals[1] != 1.0:
            return float("nan")
        return float(self.tangent.totals[0])

    @property
    def whole_log(self) -> Floats:
        """All contact changes logged, rows (t, contact, 1 onset / 0 release, rate), shape [change, 4]."""
        return np.concatenate(self.log) if self.log else np.zeros((0, kernel.LOG_COLUMNS))

    def set_impact_speeds(self, speeds: Floats) -> None:
        """Let contacts that are closed at the start store these impact speeds [m/s], shape [impact speed]."""
        self.impact_speeds[:] = np.nextafter(speeds, np.inf)  # above the floor that means: not stored yet
