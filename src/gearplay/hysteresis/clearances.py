"""Clearances of a case: their places in the packed system, their share in the lost motion, their drawn tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from gearplay.hysteresis.balance_path import Train
from gearplay.hysteresis.cycle import lost_motion_of
from gearplay.model.case import Case
from gearplay.model.plan_values import value_at
from gearplay.model.reading import replace
from gearplay.model.wording import validated
from gearplay.parts.planetary.paths import settable_path
from gearplay.parts.registry import BEARING, COUPLING, MESH, SLEEVE
from gearplay.sweeps.cases.draws import check_draws, draw, sample_size
from gearplay.sweeps.plans.design import Design, Random
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.vocabulary.errors import InputError, ResourceError

SPREAD = 0.2
"""Part of each clearance by which it is drawn, either way, where no tolerances are given."""
MOST = 10_000
"""Most members or positions."""


class Clearance(NamedTuple):
    """One clearance: its name, and its field in the records of the packed system."""

    name: str
    kind: int
    place: int
    field: str


def clearances_of(train: Train) -> list[Clearance]:
    """Return the clearances of a train above 0: backlash of meshes, clearance of sleeves and bearings, play of couplings."""
    found, labels = [], train.linear.smooth.packed.labels
    for kind, table, field in (
        (MESH, "mesh", "backlash"),
        (SLEEVE, "sleeve", "clearance"),
        (BEARING, "bearing", "half_clearance"),
        (COUPLING, "coupling", "half_play"),
    ):
        for index, value in enumerate(train.linear.system.records[kind][field].tolist()):
            if value > 0.0:
                found.append(Clearance(f"{table} {labels[table][index]}", kind, index, field))
    return found


def parts_of(train: Train, rated: float) -> dict[str, float]:
    """Return by how much the lost motion [rad] shrinks with each clearance set to 0 in turn, the others as they are.

    Parts of clearances in series add up; of those in parallel, as of several planets, each alone may matter little.
    """
    whole = lost_motion_of(train, rated)
    found = {}
    for each in clearances_of(train):
        values = train.linear.system.records[each.kind][each.field]
        given = float(values[each.place])
        values[each.place] = 0.0
        found[each.name] = whole - lost_motion_of(train, rated)
        values[each.place] = given
    train.reset()
    return found


def check_count(field: str, count: int | None) -> None:
    """Raise `ResourceError` for more than `MOST` systems."""
    if count is not None and count > MOST:
        raise ResourceError(f"{field}: {count}, {count / MOST:.3g} times the limit of {MOST}. Give fewer.")


def design_of(tolerances: Any, case: Case, members: int | None) -> Design | None:
    """Return the drawn parameters: of a sweep plan, of a table ``[design]``, or each clearance of the case within `SPREAD`.

    None where neither tolerances nor members are given, or the case has no clearance. Raises `InputError` for a plan without
    drawn parameters.
    """
    check_count("members", members)
    if tolerances is None:
        parameters = _clearance_draws(case)
        if members is None or members == 1 or not parameters:
            return None
        return Design(count=members, parameters=parameters)
    if isinstance(tolerances, Mapping) and "parameters" in tolerances:
        design = validated(Design, {"count": members or 64, **tolerances})
    else:
        plan = load_sweep(tolerances)
        if plan.design is None:
            rule = "must be a plan with drawn parameters"
            raise InputError.of("tolerances", plan.title, rule, "Add a [design] of parameters")
        design = plan.design
    check_count("members", sample_size(design) if members is None else members)
    return design if members is None else design.model_copy(update={"count": members})


def _clearance_draws(case: Case) -> tuple[Random, ...]:
    paths = [f"meshes.{j}.backlash" for j in range(len(case.meshes))]
    paths += [f"sleeves.{name}.radial_clearance" for name in case.sleeves]
    paths += [f"bearings.{name}.internal_clearance" for name in case.bearings]
    paths += [f"couplings.{j}.play" for j in range(len(case.couplings))]
    once = dict.fromkeys(settable_path(case, path) for path in paths)
    return tuple(
        Random(name=f"clearance_{k}", path=path, mode="scale", low=1.0 - SPREAD, high=1.0 + SPREAD)
        for k, path in enumerate(path for path in once if _is_open(value_at(case, path)))
    )


def _is_open(value: Any) -> bool:
    """Return whether a value of a case is a clearance: a bearing with preload has none."""
    return value is not None and value > 0.0


def drawn_cases(design: Design, base: Case) -> list[Case]:
    """Return the case of each draw; `InputError` where the case refuses the values."""
    sample = draw(design, base)
    check_draws(design, sample, base)
    fields = [
        (path, at, float(value_at(base, path)) if p.mode == "scale" else 1.0)
        for at, p in enumerate(design.parameters)
        for path in (p.path, *p.also)
    ]
    return [replace(base, {path: scale * float(row[at]) for path, at, scale in fields}) for row in sample]
