"""Parsing and limits of a job: case, axes, numbers; heading of its result."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gearplay.model.case import Case
from gearplay.model.initial import usual_member
from gearplay.model.reading import load_case, replace
from gearplay.vocabulary.errors import InputError

Job = Mapping[str, Any]
LIMITS = {"run.max_steps": 20_000_000, "run.max_wall_time": 120.0}
LONGEST_DIAGRAM = 570.0
"""Limit [s] on all values of a diagram, before the pool ends its worker: what was reached is shown."""
MODELS = ("coupled", "uncoupled")
MOST_MEMBERS = 16
MOST_SAMPLES = 2_000_000
LONGEST_NOTE = 300


def limited_case(job: Job, *, longest: float = LIMITS["run.max_wall_time"]) -> Case:
    """Return the case of a job, its limits those of the server; ``longest`` is that on wall time [s].

    Raises `InputError` for an invalid case, or one that keeps more samples than a page can use.
    """
    given = job.get("case")
    if not isinstance(given, Mapping):
        raise InputError.of("case", given, "must be a table", "Send the case as a table of JSON")
    case = load_case(given)
    run = case.run
    limits = {
        path: limit
        for path, limit in (LIMITS | {"run.max_wall_time": longest}).items()
        if (now := getattr(run, path[4:])) is None or now > limit
    }
    if run.ensemble > MOST_MEMBERS:
        rule = f"must be at most {MOST_MEMBERS} on the page"
        raise InputError.of("run.ensemble", run.ensemble, rule, "Lower it, or use gearplay run")
    samples = run.duration * run.sampling * run.ensemble
    if samples > MOST_SAMPLES:
        rule = f"must give at most {MOST_SAMPLES} samples on the page, not {samples:.3g}"
        raise InputError.of(
            "run.duration x run.sampling x run.ensemble", samples, rule, "Shorten it, or use gearplay run"
        )
    return replace(case, limits) if limits else case


def averaged_case(job: Job) -> tuple[Case, int]:
    """Return the case of the members that an average is taken over, and their number.

    With ``members`` in the job they are drawn where the first would start exactly centred, and run for its ``duration`` and
    ``transient``; without, it is one member, as specified by the case.
    """
    case = replace(limited_case(job), {"run.ensemble": 1})
    if "members" not in job:
        return case, 1
    times = {f"run.{name}": number_of(job[name]) for name in ("duration", "transient") if name in job}
    drawn = {"run.start": "drawn"} if usual_member(case) else {}
    members = whole(job, "members", 1, MOST_MEMBERS)
    return limited_case({"case": replace(case, times | drawn).resolved()}), members


def models_of(job: Job, case: Case) -> list[Case]:
    """Return a case with each of the models requested by a job; the unchanged case where it requests none."""
    given = job.get("models")
    models = [model for model in MODELS if isinstance(given, list) and model in given]
    return [replace(case, {"backlash_model": model}) for model in models] or [case]


def heading(kind: str, job: Job, case: Case) -> dict[str, Any]:
    """Return the first entries of a result: its kind, the case, and the user's note, the changes in the page's wording."""
    note = job.get("note")
    return {
        "kind": kind,
        "title": case.title,
        "note": note[:LONGEST_NOTE] if isinstance(note, str) else "",
        "sha256": case.sha256,
        "case": case.resolved(),
    }


def failures_of(reasons: Any) -> list[list[Any]]:
    """Return the indices of a table where a case failed, each followed by its reason."""
    return [
        [*map(int, place), str(reasons[tuple(place)])] for place in np.argwhere(reasons.astype(str) != "")
    ]


def axis_of(job: Job, name: str = "axis") -> tuple[str, float, float]:
    """Return the path of a varied field and the ends of its range [SI]."""
    given = job.get(name)
    if not isinstance(given, Mapping) or not isinstance(given.get("path"), str):
        raise InputError.of(name, str(given), "must have a path, low and high", "Choose a field")
    path, low, high = given["path"], number_of(given.get("low")), number_of(given.get("high"))
    if not low < high:
        rule = f"must be a number below high, {high:g}"
        raise InputError.of(f"{name}.low", f"{low:g}", rule, "Correct it")
    if path.split(".")[0] == "run":
        raise InputError.of(
            f"{name}.path", path, "must not be a field of run", "Choose a field of the mechanism"
        )
    return path, low, high


def number_of(value: Any) -> float:
    """Return a finite number as such, NaN for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1e300 < value < 1e300:
        return math.nan
    return float(value)


def whole(job: Job, name: str, least: int, most: int) -> int:
    """Return a whole number of a job within its bounds; `InputError` for anything else."""
    value = job.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError.of(name, value, f"must be a whole number from {least} to {most}", "Correct it")
    return value
