"""Reading of sweep plans from files, bundled plans, dictionaries, or a case with axes."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from gearplay.files.plan_files import Source, plan_document
from gearplay.model.case import Case
from gearplay.model.file_kinds import check_kind
from gearplay.model.wording import validated
from gearplay.sweeps.plans.plan import SweepPlan

PACKAGE = "gearplay.sweeps"


def load_sweep(source: Source) -> SweepPlan:
    """Read a sweep plan: a bundled name, the path of a TOML file, or a dictionary laid out as one.

    Raises `InputError` with every fault found.

    >>> [axis.name for axis in load_sweep("han2021-map").axes]
    ['model', 'speed', 'radial_clearance', 'backlash']
    """
    document = plan_document(source, PACKAGE)
    check_kind(document, "sweep plan", "plan")
    return validated(SweepPlan, document)


def make_plan(
    case: str | Mapping[str, Any] | Case,
    axes: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]],
    reduce: Sequence[Mapping[str, Any]],
    **more: Any,
) -> SweepPlan:
    """Return the plan of a case and its axes: values by path, or tables as in a plan file.

    An axis by path gets the last part of its path as name, longer where that is taken.

    >>> plan = make_plan("han2021", {"meshes.0.backlash": ["50 um", 1e-4]}, [
    ...     {"kind": "contact", "name": "hits", "contact": "ring", "statistic": "impacts_per_second"}])
    >>> plan.axes[0].name, len(plan.axes[0].values)
    ('backlash', 2)
    """
    tables: list[dict[str, Any]] = []
    if isinstance(axes, Mapping):
        for path, values in axes.items():
            parts = [re.sub(r"\W", "_", part) for part in str(path).split(".") if not part.isdecimal()]
            taken, take = {table["name"] for table in tables}, 1
            while "_".join(parts[-take:]) in taken and take < len(parts):
                take += 1
            tables.append({"name": "_".join(parts[-take:])[-32:], "path": path, "values": list(values)})
    else:
        tables = [dict(table) for table in axes]
    source = case.resolved() if isinstance(case, Case) else case
    return load_sweep({"case": source, "axes": tables, "reduce": [dict(each) for each in reduce], **more})
