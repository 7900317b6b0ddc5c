"""Reading of data-set plans from files, bundled plans and dictionaries."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from gearplay.datasets.plan import DatasetPlan
from gearplay.files.plan_files import Source, plan_document
from gearplay.model.file_kinds import check_kind
from gearplay.model.wording import translate
from gearplay.vocabulary.errors import InputError

PACKAGE = "gearplay.datasets"


def load_dataset_plan(source: Source | DatasetPlan) -> DatasetPlan:
    """Read a data-set plan: a bundled name, the path of a TOML file, or a dictionary laid out as one.

    Paths of its case and rig count from the plan's folder. Raises `InputError` with every fault found.

    >>> [each.label for each in load_dataset_plan("bearing-dents").classes]
    ['sound', 'inner', 'outer', 'ball']
    """
    if isinstance(source, DatasetPlan):
        return source
    document = plan_document(source, PACKAGE)
    check_kind(document, "plan of a data set", "plan")
    if not isinstance(source, Mapping) and isinstance(rig := document.get("rig"), str):
        document["rig"] = str(Path(os.fspath(source)).parent / Path(rig).expanduser())
    try:
        return DatasetPlan.model_validate(document)
    except ValidationError as error:
        raise InputError(translate(error, document, DatasetPlan)) from None
