"""`calibrate`: a plan, a folder that keeps finished work, and the document of what was found."""

import os
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearplay.output.calibration_report import write_calibration
from gearplay.output.measured_conditions import measurements_of
from gearplay.output.study_report import FolderStore
from gearplay.output.trial_store import StudyStore, digest_of
from gearplay.study.calibration.calibrate import Report, run_calibration
from gearplay.study.calibration.plan import Plan
from gearplay.study.calibration.reading import load_plan, plan_folder


def calibrate(
    plan: Plan | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str],
    *,
    records: str | os.PathLike[str] | None = None,
    progress: Report | None = None,
    stop: threading.Event | None = None,
) -> dict[str, Any]:
    """Run or go on with a calibration in ``folder``, write its report there and return its document.

    ``plan`` is a `Plan`, a bundled name, a path or a mapping; ``records`` is the folder of its records, beside
    the plan if not given. Finished trials
    (``trials.sqlite``) and parts are kept, so the same call goes on after an interruption, to the same trials.

    Raises `InputError` for a plan, case or record that does not fit, `MeasurementError` for an unreadable record,
    `SimulationError` where no trial finishes.
    """
    loaded = plan if isinstance(plan, Plan) else load_plan(plan)
    place, digest = Path(folder), digest_of(loaded)
    if records is None:
        records = plan_folder(plan) if isinstance(plan, (str, os.PathLike)) else Path()
    fits = run_calibration(
        loaded,
        measurements_of(loaded, Path(records)),
        trials=lambda model: StudyStore(place, loaded, model, digest),
        parts=FolderStore(place / "parts"),
        report=progress,
        stop=stop,
    )
    return write_calibration(loaded, fits, place)
