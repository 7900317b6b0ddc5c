"""Simulation of one record of a data set, in a thread, a process, or on a cluster."""

import hashlib
import threading
import time
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from gearplay.datasets.plan import DatasetPlan
from gearplay.datasets.recipe import Recipe
from gearplay.files.record import Record
from gearplay.rig.measurement import measure
from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.memory import enough_memory
from gearplay.vocabulary.version import VERSION
from gearplay.work.pieces import digest_of
from gearplay.work.rows import Outcome

FAILED = 1
"""Status of a record whose case was refused or did not reach its end."""
PER_SENSOR = ("rms", "peak", "saturated", "clipped")
"""Numbers of each accelerometer in a row: rms and largest magnitude of what is recorded [m/s^2], shares of samples cut off."""


class Recorded(NamedTuple):
    """A finished record: its row, and its channels, None where it failed."""

    outcome: Outcome
    record: Record | None


class Dataset:
    """Executable plan: the `Task` whose pieces are records.

    Raises `InputError` for a plan that does not fit its case.
    """

    def __init__(self, plan: DatasetPlan) -> None:
        self.plan, self.recipe = plan, Recipe(plan)
        self.sensors = tuple(self.recipe.rig.accelerometers)
        self.identity = digest_of([VERSION, plan.model_dump(mode="json")])

    @cached_property
    def remake(self) -> tuple[Callable[[str], "Dataset"], str]:
        """Function and argument with which another process makes the same data set."""
        return dataset_of, self.plan.model_dump_json()

    @property
    def channels(self) -> list[str]:
        """Names of a record's channels in their order: the stages of each accelerometer, as the plan lists them."""
        return [f"{name}.{stage}" for name in self.sensors for stage in self.plan.stages]

    @property
    def size(self) -> int:
        """Numbers of a row."""
        return len(self.sensors) * len(PER_SENSOR)

    def address_of(self, record: int) -> bytes:
        """Return the address of a record's row, 32 bytes."""
        return hashlib.sha256(f"{self.identity} {record}".encode()).digest()

    def evaluate(self, job: int, stop: threading.Event | None = None) -> list[Recorded]:
        """Simulate a record; a failed one has a row with its reason. Returns nothing once stopped."""
        started, recipe = time.perf_counter(), self.recipe
        try:
            with enough_memory():
                case = recipe.case_at(job)
                taken = measure(case, recipe.rig, member=1 + job, seed=self.plan.seed, stop=stop)
        except KeyboardInterrupt:
            return []
        except GearplayError as error:
            reason = " ".join(str(error).split())
            nothing = np.full(self.size, np.nan)
            return [Recorded(self._outcome(job, FAILED, reason, nothing, started), None)]
        kept = tuple(taken.channel(name) for name in self.channels)
        labels = recipe.labels(job)
        about = {**taken.attributes, "record": str(job)} | {
            name: str(labels[name]) for name in ("label", "member")
        }
        record = Record(kept, taken.source, attributes=about)
        return [Recorded(self._outcome(job, 0, "", self._numbers(taken), started), record)]

    def _outcome(self, job: int, status: int, reason: str, row: "np.ndarray", started: float) -> Outcome:
        return Outcome(job, self.address_of(job), status, reason, row, time.perf_counter() - started)

    def _numbers(self, taken: Record) -> "np.ndarray":
        found = []
        for name in self.sensors:
            channel = taken.channel(f"{name}.recorded")
            shares = [
                channel.attributes[f"{what}_share"] for what in ("sensor_saturated", "converter_clipped")
            ]
            rms = float(np.sqrt(np.mean(channel.values**2)))
            found += [rms, float(np.max(np.abs(channel.values))), *map(float, shares)]
        return np.array(found)


@lru_cache(maxsize=4)
def dataset_of(plan: str) -> Dataset:
    """Return the data set of a plan written as JSON; kept, so that a worker makes it once."""
    return Dataset(DatasetPlan.model_validate_json(plan))
