"""Case of a point of a sweep, and the key of its stored result."""

import hashlib
from typing import Any

from gearplay.model.case import Case
from gearplay.model.plan_values import changed, value_at
from gearplay.model.policy import LIMITS
from gearplay.model.reading import load_case, replace
from gearplay.sweeps.cases.points import Points, points_of
from gearplay.sweeps.cases.sequences import Chain
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.version import VERSION
from gearplay.work.pieces import digest_of


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
        self.fields: list[tuple[str, str, float | None]] = [  # path, name, base value of what scales
            (path, each.name, _number_at(self.base, path) if each.mode == "scale" else None)
            for each in (*plan.axes, *drawn)
            for path in (each.path, *each.also)
        ]
        self.chain: Chain | None = None
        if plan.carry is not None:
            axis = plan.axes[self.points.carried]
            self.chain = Chain(plan.carry, axis.path, self.points.values[self.points.carried], self.base)
        self.identity = digest_of(
            [
                VERSION,
                self.base.sha256,
                {name: getattr(self.base.run, name) for name in LIMITS},
                plan.model_dump(mode="json", include={"reduce", "carry"}),
                None if self.chain is None else self.chain.values.tolist(),
            ]
        )

    def changes(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the changes of the base case, by path, at varied values by name."""
        found = {
            path: values[name] if base is None else base * values[name] for path, name, base in self.fields
        }
        if self.chain is not None and self.plan.carry is not None:
            found |= self.chain.changes(values[self.plan.carry.axis], values["direction"])
        return found

    def case_at(self, index: int) -> tuple[Case, int]:
        """Return the case and the member of a point; `InputError` where the case does not take its values."""
        values, member = self.points.at(index)
        return replace(self.base, self.changes(values)), member

    def address_of(self, index: int) -> bytes:
        """Return the address of a point's result, 32 bytes."""
        values, member = self.points.at(index)
        words = (
            f"{self.identity} {member} {values.get('direction', '')} {sorted(self.changes(values).items())}"
        )
        return hashlib.sha256(words.encode()).digest()


def _number_at(case: Case, path: str) -> float:
    """Return the number that factors multiply; `InputError` where there is none."""
    value = value_at(case, path)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        rule = "must be a number in the case, to be multiplied"
        raise InputError(Fault(path, value, rule, 'Take mode = "set", or correct the path'))
    return float(value)
