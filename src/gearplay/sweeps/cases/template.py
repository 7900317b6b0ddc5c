"""Case of a point of a sweep and the key of its stored result; sequences of cases along a continued axis."""

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.plan_values import changed, value_at
from gearplay.model.policy import LIMITS
from gearplay.model.reading import load_case, replace
from gearplay.sweeps.cases.points import Points, points_of
from gearplay.sweeps.plans.plan import Carry, SweepPlan
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.version import VERSION
from gearplay.work.pieces import digest_of

Floats = NDArray[np.float64]


class CarriedAxis:
    """The axis of a plan along which cases are continued: the changes of each case in addition to the varied fields.

    Raises `InputError` where the ramp does not fit into the transient.
    """

    def __init__(self, carry: Carry, path: str, values: tuple[float, ...], base: Case) -> None:
        self.carry, self.drive = carry, path.removesuffix(".speed")
        self.values, self.run = np.array(values), base.run
        if carry.mode == "steps" and carry.ramp > base.run.transient:
            rule = f"must fit into the transient of each case, {base.run.transient:g} s, where nothing is recorded"
            raise InputError.of(
                "carry.ramp", f"{carry.ramp:g} s", rule, "Lengthen run.transient, or shorten it"
            )

    def way(self, direction: str) -> Floats:
        """Return the speeds in the order in which a direction passes them [rad/s]."""
        return self.values if direction == "up" else self.values[::-1]

    def edges(self, direction: str) -> Floats:
        """Return the speeds between the windows of a run-up [rad/s]: half-way, and as far beyond the ends.

        >>> from gearplay.model.reading import load_case
        >>> carry = Carry(axis="speed", mode="run-up")
        >>> carried = CarriedAxis(carry, "rotors.pinion.drive.speed", (1.0, 2.0, 4.0), load_case("han2021"))
        >>> carried.edges("down").tolist()
        [5.0, 3.0, 1.5, 0.5]
        """
        way = self.way(direction)
        middles = 0.5 * (way[1:] + way[:-1])
        return np.concatenate([[2.0 * way[0] - middles[0]], middles, [2.0 * way[-1] - middles[-1]]])

    def changes(self, speed: float, direction: str) -> dict[str, Any]:
        """Return the changes of the case at a speed, by path."""
        at = int(np.argmin(np.abs(self.way(direction) - speed)))
        if self.carry.mode == "run-up":
            low, high = self.edges(direction)[at : at + 2]
            return {**self._ramp(float(low), float(high), self.run.duration), "run.transient": 0.0}
        if at == 0:
            return {}
        return self._ramp(float(self.way(direction)[at - 1]), speed, self.carry.ramp)

    def _ramp(self, low: float, high: float, time: float) -> dict[str, Any]:
        return {f"{self.drive}.speed": high, f"{self.drive}.start_speed": low, f"{self.drive}.ramp": time}

    def lead(self, direction: str) -> dict[str, Any] | None:
        """Return the changes for the lead-in run of a run-up: its first speed, held for the transient; None without one."""
        if self.carry.mode == "steps" or self.run.transient == 0.0:
            return None
        start = float(self.edges(direction)[0])
        return {
            f"{self.drive}.speed": start,
            "run.transient": 0.0,
            "run.duration": self.run.transient,
            "run.sampling": 1.0,
        }

    def slowness(self, speed: float, direction: str) -> float:
        """Return the mean speed of a case over its nominal one, which is that at its end."""
        if self.carry.mode == "steps":
            return 1.0
        at = int(np.argmin(np.abs(self.way(direction) - speed)))
        low, high = self.edges(direction)[at : at + 2]
        return float(0.5 * (low + high) / high)


class Template:
    """A plan's base case and points.

    The address of a point is a digest of the base case with its limits, the changed fields, the member, what is kept, what runs
    before it along a carried axis, and the version of gearplay.

    Raises `InputError` for a case, path or value that does not fit.
    """

    def __init__(self, plan: SweepPlan) -> None:
        self.plan = plan
        self.base: Case = changed(load_case(plan.case), plan.set, "set")
        self.points: Points = points_of(plan, self.base)
        drawn = plan.design.parameters if plan.design else ()
        self.fields: list[tuple[str, str, float | None]] = [  # path, name, base value of scaled fields
            (path, each.name, number_at(self.base, path) if each.mode == "scale" else None)
            for each in (*plan.axes, *drawn)
            for path in (each.path, *each.also)
        ]
        self.carried: CarriedAxis | None = None
        if plan.carry is not None:
            axis = plan.axes[self.points.carried]
            self.carried = CarriedAxis(
                plan.carry, axis.path, self.points.values[self.points.carried], self.base
            )
        self.identity = digest_of(
            [
                VERSION,
                self.base.sha256,
                {name: getattr(self.base.run, name) for name in LIMITS},
                plan.model_dump(mode="json", include={"reduce", "carry"}),
                None if self.carried is None else self.carried.values.tolist(),
            ]
        )

    def changes(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the changes of the base case, by path, at varied values by name."""
        found = {
            path: values[name] if base is None else base * values[name] for path, name, base in self.fields
        }
        if self.carried is not None and self.plan.carry is not None:
            found |= self.carried.changes(values[self.plan.carry.axis], values["direction"])
        return found

    def case_at(self, index: int) -> tuple[Case, int]:
        """Return the case and the member of a point; `InputError` where the case refuses its values."""
        values, member = self.points.at(index)
        return replace(self.base, self.changes(values)), member

    def address_of(self, index: int) -> bytes:
        """Return the storage key of a point's result, 32 bytes."""
        values, member = self.points.at(index)
        words = (
            f"{self.identity} {member} {values.get('direction', '')} {sorted(self.changes(values).items())}"
        )
        return hashlib.sha256(words.encode()).digest()


def number_at(case: Case, path: str) -> float:
    """Return the number that factors multiply; `InputError` if the field has none."""
    value = value_at(case, path)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        rule = "must be a number in the case, to be multiplied"
        raise InputError.of(path, value, rule, 'Take mode = "set", or correct the path')
    return float(value)
