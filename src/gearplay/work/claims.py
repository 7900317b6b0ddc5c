"""Plan of an output folder, written once and checked by all that work there."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from gearplay.files.atomic import shown_path, write_text
from gearplay.vocabulary.errors import Fault, TakenError
from gearplay.work.pieces import read_document, with_digest, without_digest

PLAN = "plan.json"


def claim(folder: Path, document: dict[str, Any], program: str) -> None:
    """Write the plan of a ``program`` into its folder.

    Raises `TakenError` where the folder has another plan, perhaps of a shard that came meanwhile.
    """
    path = folder / PLAN
    if not path.exists():
        with suppress(TakenError):
            write_text(path, json.dumps(with_digest(document), indent=1), overwrite=False)
    if read_claim(folder, program) != document:
        raise _not_ours(folder, "must hold the same plan")


def read_claim(folder: Path, program: str) -> dict[str, Any]:
    """Return the plan in a folder; `TakenError` where it is damaged or no plan."""
    document = read_document(folder / PLAN)
    if document is None:
        raise _not_ours(folder, f"its {PLAN} must be a plan that {program} wrote")
    if (found := without_digest(document)) is None:
        raise _not_ours(folder, f"its {PLAN} was changed after {program} wrote it")
    return found


def _not_ours(folder: Path, rule: str) -> TakenError:
    return TakenError(Fault("out", shown_path(folder), rule, "Choose another folder, or give overwrite=True"))
