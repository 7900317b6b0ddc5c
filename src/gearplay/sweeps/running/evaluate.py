"""Evaluation of one point of a sweep: simulation and reduction, in a thread, a process, or on a cluster."""

import threading
import time
from collections.abc import Callable
from functools import cached_property, lru_cache

import numpy as np

from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.model.reading import replace
from gearplay.solver.continuation import End
from gearplay.solver.members import Pool
from gearplay.solver.simulate import run_few, run_one
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.sweeps.cases.template import Template
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.running.reduce import Reducer
from gearplay.vocabulary.errors import GearplayError, ResourceError
from gearplay.vocabulary.memory import enough_memory
from gearplay.work.rows import Outcome

LARGEST = 4e9
"""Largest product that is made in one piece [bytes]."""
REFUSED, REDUCED = 100, 101
"""Status of a point whose case was refused, and of one that was simulated but lacks a reduction; the others are those of
`solver.status`."""


class Sweep:
    """Executable plan: the `Task` whose pieces are outcomes.

    Raises `InputError` for a plan that does not fit its case.
    """

    def __init__(self, plan: SweepPlan) -> None:
        self.plan = plan
        self.template = Template(plan)
        self.reducer = Reducer(plan, self.template.base, pack(self.template.base))
        self.pool = Pool()

    @cached_property
    def remake(self) -> tuple[Callable[[str], "Sweep"], str]:
        """Arguments with which another process rebuilds the sweep."""
        return sweep_of, self.plan.model_dump_json()

    @property
    def bytes(self) -> float:
        """Size of the product in memory."""
        return float(len(self.template.points)) * (8.0 * self.reducer.size + 10.0)

    @property
    def is_large(self) -> bool:
        """Whether the product is too large for one piece."""
        return self.bytes > LARGEST

    def check_size(self) -> None:
        """Raise `ResourceError` for a product too large for one piece."""
        if self.is_large:
            raise ResourceError(
                f"sweep: a product of {self.bytes / 1e9:.2g} GB is more than the limit of {LARGEST / 1e9:.0f} GB. "
                "Write it piece by piece (zarr), keep fewer numbers per case, or coarsen an axis."
            )

    def evaluate(self, job: int, stop: threading.Event | None = None) -> list[Outcome]:
        """Simulate and reduce the points of a job; nothing once stopped. A point that fails is an outcome with its reason."""
        outcomes: list[Outcome] = []
        points = self.template.points.job(job)
        try:
            if self.template.carried is None:
                return self._members(points, stop)
            origin, failed = self._lead(points[0], stop)
            if failed is not None:
                status, reason = failed
                words = f"what runs before the first case did not finish: {reason}"
                return [self._failed(i, status, words, 0.0) for i in points]
            for index in points:
                outcome, origin = self._point(index, origin, stop)
                outcomes.append(outcome)
                if outcome.status not in (0, REDUCED):
                    reason = f"the case before it did not finish: {outcome.reason}"
                    rest = points[len(outcomes) :]
                    return outcomes + [self._failed(i, outcome.status, reason, 0.0) for i in rest]
        except _StoppedError:
            return []
        return outcomes

    def _members(self, points: list[int], stop: threading.Event | None) -> list[Outcome]:
        """Simulate and reduce members of one case."""
        started = time.perf_counter()
        try:
            with enough_memory():
                case, member = self.template.case_at(points[0])
                members = range(member, member + len(points))
                runs = run_few(case, members, self.pool, signals=self.reducer.signals, stop=stop)
                took = (time.perf_counter() - started) / len(points)
                return [
                    self._reduced(i, case, run, time.perf_counter() - took)[0]
                    for i, run in zip(points, runs, strict=True)
                ]
        except GearplayError as error:
            took = (time.perf_counter() - started) / len(points)
            return [self._refused(i, error, took) for i in points]

    def _lead(self, index: int, stop: threading.Event | None) -> tuple[End | None, tuple[int, str] | None]:
        """Simulate the lead-in of a sequence, if any; return its final state, or status and reason where it failed."""
        carried, (values, member) = self.template.carried, self.template.points.at(index)
        changes = carried.lead(values["direction"]) if carried is not None else None
        if changes is None:
            return None, None
        try:
            case = replace(self.template.base, {**self.template.changes(values), **changes, **self._steady()})
            run = run_one(case, member, signals=[], stop=stop)
        except GearplayError as error:
            return None, (REFUSED, str(error).splitlines()[0])
        if run.status == Status.INTERRUPTED:
            raise _StoppedError
        return run.end, None if run.success else (int(run.status), run.message)

    def _steady(self) -> dict[str, float]:
        carried = self.template.carried
        return {} if carried is None else {f"{carried.drive}.ramp": 0.0, f"{carried.drive}.start_speed": 0.0}

    def _point(
        self, index: int, origin: End | None, stop: threading.Event | None
    ) -> tuple[Outcome, End | None]:
        started = time.perf_counter()
        try:
            with enough_memory():
                case, member = self.template.case_at(index)
                run = run_one(case, member, signals=self.reducer.signals, stop=stop, origin=origin)
                outcome, ended = self._reduced(index, case, run, started)
        except GearplayError as error:
            return self._refused(index, error, time.perf_counter() - started), None
        return outcome, ended if self.template.carried else None

    def _reduced(self, index: int, case: Case, run: Trajectory, started: float) -> tuple[Outcome, End | None]:
        """Return the outcome of a simulated point, and its final state if it was reached."""
        if run.status == Status.INTERRUPTED:
            raise _StoppedError
        if not run.success:
            return self._failed(index, int(run.status), run.message, time.perf_counter() - started), None
        try:
            row, lacking = self.reducer.row(case, run, slowness=self._slowness(index))
        except GearplayError as error:
            return self._refused(index, error, time.perf_counter() - started), run.end
        status, address = REDUCED if lacking else 0, self.template.address_of(index)
        return Outcome(index, address, status, lacking, row, time.perf_counter() - started), run.end

    def _refused(self, index: int, error: GearplayError, seconds: float) -> Outcome:
        return self._failed(index, REFUSED, str(error).splitlines()[0], seconds)

    def _failed(self, index: int, status: int, reason: str, seconds: float) -> Outcome:
        nothing = np.full(self.reducer.size, np.nan)
        return Outcome(index, self.template.address_of(index), status, reason, nothing, seconds)

    def _slowness(self, index: int) -> float:
        carried = self.template.carried
        if carried is None:
            return 1.0
        values = self.template.points.at(index)[0]
        return carried.slowness(values[carried.carry.axis], values["direction"])


class _StoppedError(Exception):
    """A run was cancelled."""


@lru_cache(maxsize=4)
def sweep_of(plan: str) -> Sweep:
    """Return the sweep of a plan written as JSON; cached, so that a worker builds it once."""
    return Sweep(SweepPlan.model_validate_json(plan))
