"""One point of a sweep, simulated and reduced; the same code in a thread, a process, or on a cluster."""

import threading
import time
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.model.pack import pack
from gearplay.solver.simulate import run_one
from gearplay.solver.status import Status
from gearplay.study.sweeps.plan import SweepPlan
from gearplay.study.sweeps.reduce import Reducer
from gearplay.study.sweeps.template import Template
from gearplay.vocabulary.errors import GearplayError

Floats = NDArray[np.float64]
REFUSED = 100
"""Status of a point whose case or reduction was refused; the others are those of `solver.status`."""


class Outcome(NamedTuple):
    """A finished point: its number, the address of its result, how it ended and what was kept, shape [number]."""

    number: int
    address: bytes
    status: int
    reason: str
    row: Floats
    seconds: float


class Sweep:
    """A plan made ready to run.

    Raises `InputError` for a plan that does not fit its case.
    """

    def __init__(self, plan: SweepPlan) -> None:
        self.plan = plan
        self.template = Template(plan)
        self.reducer = Reducer(plan, self.template.base, pack(self.template.base))

    def evaluate(self, index: int, stop: threading.Event | None = None) -> Outcome | None:
        """Simulate and reduce point ``index``; None once stopped. A point that fails is an outcome with its reason."""
        started = time.perf_counter()
        address = self.template.address_of(index)
        nothing = np.full(self.reducer.size, np.nan)
        try:
            case, member = self.template.case_at(index)
            run = run_one(case, member, signals=self.reducer.signals, stop=stop)
            if run.status == Status.INTERRUPTED:
                return None
            status, reason, row = int(run.status), "", nothing
            if run.success:
                row = self.reducer.row(case, run)
            else:
                reason = run.message
        except GearplayError as error:
            status, reason, row = REFUSED, str(error).splitlines()[0], nothing
        return Outcome(index, address, status, reason, row, time.perf_counter() - started)


@lru_cache(maxsize=4)
def sweep_of(plan: str) -> Sweep:
    """Return the sweep of a plan written as JSON; kept, so that a worker makes it once."""
    return Sweep(SweepPlan.model_validate_json(plan))


def evaluate_many(plan: str, indices: list[int]) -> list[Outcome]:
    """Evaluate points of a plan written as JSON: what leaves the process."""
    sweep = sweep_of(plan)
    found = (sweep.evaluate(index) for index in indices)
    return [outcome for outcome in found if outcome is not None]
