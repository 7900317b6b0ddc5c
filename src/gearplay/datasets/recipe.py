"""Cases and labels of the records of a plan, by number."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gearplay.datasets.plan import MOST_RECORDS, Class, DatasetPlan
from gearplay.datasets.split import split_groups
from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.plan_values import changed, value_at
from gearplay.model.reading import load_case, replace
from gearplay.rig.plan import load_rig, placements
from gearplay.sweeps.cases.draws import Limits, limits_of, quantile, try_draw
from gearplay.sweeps.cases.points import points_of
from gearplay.sweeps.cases.template import number_at
from gearplay.sweeps.plans.design import Random, Varied
from gearplay.vocabulary.errors import ResourceError

EDGE = 1e-6
"""Probability of the least and of the largest draw that a case is tried with."""


@dataclass(frozen=True)
class Kind:
    """A class of a plan: its case, and the parameters that are drawn for each record, with their numbers."""

    plan: Class
    base: Case
    draws: tuple[tuple[Random, Limits], ...]


class Recipe:
    """All records of a plan: class after class, in each the axes, the machines, the members.

    Raises `InputError` for a case, rig, path, value or split that does not fit, `ResourceError` for too many records.
    """

    def __init__(self, plan: DatasetPlan) -> None:
        self.plan, self.rig = plan, load_rig(plan.rig)
        self.base = changed(load_case(plan.case), plan.set, "set")
        placements(self.rig, self.base)
        self.points = points_of(plan, self.base)
        if len(self) > MOST_RECORDS:
            raise ResourceError(
                f"dataset: {len(self):.3g} records are more than the limit of {MOST_RECORDS:.0e}."
            )
        self.kinds = [self._kind(at, each) for at, each in enumerate(plan.classes)]
        self.machines = len(self.points.sample) if plan.design else 1
        self.conditions = len(self.points) // (self.machines * plan.members)
        self.by_machine = plan.split.by == "machine" or (plan.split.by is None and plan.design is not None)
        groups = self.machines if self.by_machine else self.conditions
        self.splits = split_groups(groups, plan.split.shares, plan.seed)

    def __len__(self) -> int:
        return len(self.plan.classes) * len(self.points)

    def _kind(self, at: int, each: Class) -> Kind:
        base = changed(self.base, each.set, f"classes.{at}.set")
        found = []
        for prefix, group in (("draws", self.plan.draws), (f"classes.{at}.draws", each.draws)):
            for number, p in enumerate(group):
                limits = limits_of(p, f"{prefix}.{number}", base)
                for reached in quantile(p, limits, np.array([EDGE, 1.0 - EDGE])).tolist():
                    try_draw(p, f"{prefix}.{number}", reached, base)
                found.append((p, limits))
        for varied in (*self.plan.axes, *(self.plan.design.parameters if self.plan.design else ())):
            for path in (varied.path, *varied.also):
                number_at(base, path) if varied.mode == "scale" else value_at(base, path)
        return Kind(each, base, tuple(found))

    def place(self, record: int) -> tuple[int, int, int, int]:
        """Return class, condition, machine and member of a record."""
        kind, point = divmod(record, len(self.points))
        rest, member = divmod(point, self.plan.members)
        condition, machine = divmod(rest, self.machines)
        return kind, condition, machine, member

    def varied(self, record: int) -> dict[str, Any]:
        """Return the values of axes and machine, and those drawn for a record, by name, SI or as factors."""
        kind = self.kinds[self.place(record)[0]]
        found, _ = self.points.at(record % len(self.points))
        unit = np.random.default_rng([self.plan.seed, record]).random(len(kind.draws))
        for (p, limits), u in zip(kind.draws, unit, strict=True):
            found[p.name] = float(quantile(p, limits, np.array([u]))[0])
        return found

    def case_at(self, record: int) -> Case:
        """Return the case of a record; `InputError` where it refuses its values."""
        kind, values = self.kinds[self.place(record)[0]], self.varied(record)
        changes = {}
        for p in self._varied_of(kind):
            for path in (p.path, *p.also):
                scaled = p.mode == "scale"
                changes[path] = values[p.name] * number_at(kind.base, path) if scaled else values[p.name]
        return replace(kind.base, changes)

    def _varied_of(self, kind: Kind) -> list[Varied]:
        drawn = self.plan.design.parameters if self.plan.design else ()
        return [*self.plan.axes, *drawn, *(p for p, _ in kind.draws)]

    def columns(self) -> dict[str, str]:
        """Return the names of all varied values with their units, "1" for factors, in the order of the table."""
        found: dict[str, str] = {}
        for kind in self.kinds:
            for p in self._varied_of(kind):
                unit = "1" if p.mode == "scale" else unit_at(kind.base, p.path)
                found.setdefault(p.name, unit)
        return found

    def labels(self, record: int) -> dict[str, Any]:
        """Return the row of a record in the table of labels, without the results of its simulation."""
        kind, condition, machine, member = self.place(record)
        group = machine if self.by_machine else condition
        return {
            "record": record,
            "label": self.kinds[kind].plan.label,
            "split": self.splits[group],
            "group": group,
            "machine": machine,
            "member": member,
            **self.varied(record),
        }
