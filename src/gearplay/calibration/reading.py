"""Reading of calibration plans from files, bundled plans and dictionaries."""

import os
from importlib.resources import files
from pathlib import Path

from gearplay.calibration.plan import Plan
from gearplay.files.plan_files import Source, plan_document
from gearplay.model.bundled import bundled
from gearplay.model.file_kinds import check_kind
from gearplay.model.wording import validated

PACKAGE = "gearplay.calibration"


def plan_folder(source: str | os.PathLike[str]) -> Path:
    """Return the folder of a plan's records: the plan's own, or that of the bundled records."""
    if os.fspath(source) in bundled(PACKAGE, "plans"):
        return Path(str(files(PACKAGE) / "plans"))
    return Path(source).parent


def load_plan(source: Source) -> Plan:
    """Read a calibration plan: a bundled name, the path of a TOML file, or a dictionary laid out as one.

    Parameters
    ----------
    source
        A bundled name, the path of a TOML file, or a dictionary laid out as one.

    Returns
    -------
    Plan
        Validated, in SI.

    Raises
    ------
    InputError
        With every fault found.

    Examples
    --------
    >>> len(load_plan("han2021").conditions)
    6

    """
    document = plan_document(source, PACKAGE)
    check_kind(document, "calibration plan", "plan")
    return validated(Plan, document)
