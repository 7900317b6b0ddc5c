"""Schema of data-set plans: classes, axes, drawn parameters, recorded channels, split."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gearplay.model.reading import bundled_names, load_case
from gearplay.rig.plan import load_rig
from gearplay.schema.fields import Listed, Measure, Name, Part, Problem, refuse
from gearplay.sweeps.plans.design import Design, Random, Text
from gearplay.sweeps.plans.plan import Axis, Carry, Changes

MOST_RECORDS = 10_000_000
"""Most records of one plan."""
OWN = frozenset(("record", "path", "label", "split", "group", "machine", "member", "status", "reason"))
"""Columns that every table of labels has."""
Share = Annotated[float, Measure(None, "share of the groups", ge=0.0, le=1.0)]


class Class(Part):
    """Records of one label: changes of the case, and parameters that are drawn anew for each of its records."""

    label: Name
    set: Changes = Field(default_factory=dict)
    draws: Annotated[tuple[Random, ...], Listed(0, 64, "drawn parameters, as the severity of a fault")] = ()


class Split(Part):
    """Shares of the groups for training, validation and test; each group is in one of the three.

    A group is all records of one ``machine``, a point of the design, or of one ``condition``, a combination of the axes.
    """

    by: (
        Annotated[
            Literal["machine", "condition"],
            Field(description="what a group is; a machine where the plan has a design, else a condition"),
        ]
        | None
    ) = None
    train: Share = 0.6
    validation: Share = 0.2
    test: Share = 0.2

    @model_validator(mode="after")
    def _check(self) -> Split:
        total = self.train + self.validation + self.test
        if abs(total - 1.0) > 1e-9:
            refuse(
                [
                    Problem(
                        ("train",), f"must be 1 together with the other shares, not {total:g}", "Correct one"
                    )
                ]
            )
        return self

    @property
    def shares(self) -> dict[str, float]:
        """Shares by the names of the column ``split``."""
        return {"train": self.train, "validation": self.validation, "test": self.test}


class DatasetPlan(Part):
    """Records of every class, at every combination of the axes, of every drawn machine, for every member."""

    title: Annotated[str, Field(max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")] = ""
    case: Text | dict[str, Any]
    set: Changes = Field(default_factory=dict)
    rig: Text | dict[str, Any] = Field(default_factory=dict)
    stages: Annotated[
        tuple[Literal["recorded", "voltage", "counts", "acceleration"], ...],
        Listed(1, 4, "channels of each accelerometer"),
    ] = ("recorded",)
    format: Literal["npy", "hdf5", "wav", "mat"] = "npy"
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    classes: Annotated[tuple[Class, ...], Listed(1, 1000, "classes")]
    axes: Annotated[tuple[Axis, ...], Listed(0, 16, "axes")] = ()
    design: Design | None = None
    draws: Annotated[tuple[Random, ...], Listed(0, 64, "parameters that are drawn for each record")] = ()
    members: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    split: Split = Split()

    @model_validator(mode="after")
    def _check(self) -> DatasetPlan:
        problems, common = [], set(OWN)
        drawn = self.design.parameters if self.design else ()
        for place, group in (
            (("axes",), self.axes),
            (("design", "parameters"), drawn),
            (("draws",), self.draws),
        ):
            problems += _names(place, group, common)
        labels: set[str] = set()
        for at, each in enumerate(self.classes):
            problems += _names(("classes", at, "draws"), each.draws, set(common))
            if each.label in labels:
                problems.append(Problem(("classes", at, "label"), "must be a label of its own", "Rename it"))
            labels.add(each.label)
        if self.split.by == "machine" and self.design is None:
            rule = "must be condition where the plan has no [design] of machines"
            problems.append(Problem(("split", "by"), rule, "Add a design, or split by condition"))
        refuse(problems)
        return self

    @property
    def carry(self) -> Carry | None:
        """Axis along which cases are continued: none."""
        return None

    def frozen(self) -> DatasetPlan:
        """Return the plan with the files of case and rig embedded."""
        found: dict[str, Any] = {"rig": load_rig(self.rig).resolved()}
        if isinstance(self.case, str) and self.case not in bundled_names():
            found["case"] = load_case(self.case).resolved()
        return self.model_copy(update=found)


def _names(place: tuple[str | int, ...], group: Any, seen: set[str]) -> list[Problem]:
    """Return the problems with names of varied fields that there are already, and note the names."""
    problems = []
    for at, each in enumerate(group):
        if each.name in seen or each.name.startswith("clipped_"):
            problems.append(Problem((*place, at, "name"), "must be a name of its own", "Rename it"))
        seen.add(each.name)
    return problems
