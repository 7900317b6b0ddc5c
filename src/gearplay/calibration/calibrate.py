"""`calibrate`: a plan, its output folder, and the result document."""

import json
import os
import shutil
import threading
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from gearplay.calibration.objective import measurements_of
from gearplay.calibration.plan import Plan
from gearplay.calibration.procedure import run_calibration
from gearplay.calibration.reading import load_plan, plan_folder
from gearplay.calibration.recovery import recover as run_recovery
from gearplay.calibration.recovery import summary
from gearplay.calibration.report import write_calibration
from gearplay.calibration.result import Calibration
from gearplay.calibration.search import run_even
from gearplay.calibration.store import EVEN, FILE, StudyStore, digest_of
from gearplay.calibration.trials import Problem
from gearplay.files.atomic import write_text
from gearplay.files.json_text import finite
from gearplay.vocabulary.progress import Progress, ticking
from gearplay.work.folder import OutputFolder
from gearplay.work.pieces import PieceStore

RESULTS = ("calibration.json", "recovery.json")
"""Files that a finished calibration has."""


def calibrate(
    plan: Plan | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str],
    *,
    records: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Calibration:
    """Fit the free parameters of every model of a plan to its records, and compare the models.

    Finished trials (``trials.sqlite``) and parts are stored in the folder, so the same call resumes after an interruption, with
    the same trials. The report is written there.

    Parameters
    ----------
    plan
        A `Plan`, a bundled name, a path or a mapping.
    folder
        Where trials, report and document are kept; it is made if it is not there.
    records
        Folder of the plan's records; the plan's folder if not given.
    overwrite
        Whether the result of the folder is replaced; the old one stays until the new one is complete.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Calibration
        ``ds`` has a row for each parameter of each fit, ``message`` the intervals and the better model,
        ``document`` the rest.

    Raises
    ------
    InputError
        For a plan, case or record that does not fit.
    MeasurementError
        For an unreadable record.
    SimulationError
        Where no trial finishes.

    Examples
    --------
    >>> import gearplay as gp
    >>> gp.load_plan("tutorial").title  # gp.calibrate("tutorial", "out/tutorial") takes some minutes
    'Tutorial: three records of a rig with unknown clearances'

    """
    loaded = plan if isinstance(plan, Plan) else load_plan(plan)
    if records is None:
        records = plan_folder(plan) if isinstance(plan, (str, os.PathLike)) else Path()
    work = partial(calibrate_in, loaded, records=Path(records), progress=progress, stop=stop)
    return output_folder(Path(folder)).run(work, identity=digest_of(loaded), overwrite=overwrite)


def calibrate_in(
    plan: Plan, place: Path, *, records: Path, progress: Progress | None, stop: threading.Event | None
) -> Calibration:
    """Calibrate as `calibrate`, in a folder that the caller has locked."""
    digest = digest_of(plan)
    fits = run_calibration(
        plan,
        measurements_of(plan, records),
        trials=lambda model: StudyStore(place, plan, model, digest),
        pieces=PieceStore(place / "parts"),
        report=progress,
        stop=stop,
    )
    return Calibration(write_calibration(plan, fits, place))


def output_folder(folder: Path) -> OutputFolder:
    """Return the output folder of a calibration."""

    def is_complete(place: Path) -> bool:
        return any((place / name).exists() for name in RESULTS)

    return OutputFolder(folder, is_complete, _remove)


def _remove(folder: Path) -> None:
    (folder / FILE).unlink(missing_ok=True)
    shutil.rmtree(folder / "parts", ignore_errors=True)


def recover(
    plan: Plan | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str],
    sets: int,
    *,
    members: int = 16,
    overwrite: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> dict[str, Any]:
    """Test the recovery of known parameters by a plan on ``sets`` synthetic data sets of its first model.

    Evenly spread trials, as many as the plan's evaluations, are stored in ``folder`` and resumed after an interruption; each
    data set has ``members`` fresh members. Returns and writes ``recovery.json``.

    Raises as `calibrate` does.
    """
    loaded = plan if isinstance(plan, Plan) else load_plan(plan)
    model = loaded.models[0]
    problem = Problem(loaded, model)

    def work(place: Path) -> dict[str, Any]:
        store = StudyStore(place, loaded, f"{model.name}{EVEN}", digest_of(loaded))
        trials = run_even(problem, store, report=ticking(progress, "trials"), stop=stop)
        found = run_recovery(
            problem, trials, sets, members=members, report=ticking(progress, "data sets"), stop=stop
        )
        rows = summary(found)
        document: dict[str, Any] = {
            "title": loaded.title,
            "model": model.name,
            "trials": len(trials),
            "data_sets": sets,
            "coverage": sum(row.coverage for row in rows) / len(rows),
            "parameters": [finite(asdict(row)) for row in rows],
            "each": [asdict(each) for each in found],
        }
        write_text(place / "recovery.json", json.dumps(document, indent=1, allow_nan=False))
        return document

    return output_folder(Path(folder)).run(work, identity=digest_of(loaded), overwrite=overwrite)
