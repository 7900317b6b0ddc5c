"""Tables of numbers in separate files, referenced by ``file`` in a case."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from gearplay.model.deviation_files import fill_deviations
from gearplay.model.toml_files import rows_of
from gearplay.parts.planetary.names import MEMBERS
from gearplay.vocabulary.errors import InputError, shorten

EQUAL: Final = 1e-6
"""Relative difference of steps that still count as equal."""


SET_POINTS: Final = {
    "torque": "torque",
    "speed": "speed",
    "servo": "speed",
    "position": "angle",
    "cascade": "angle",
    "motor": "voltage",
}
"""Field of the set-point of a drive, by its kind."""

FILLED: Final = ("values", "sampling", "start")
"""Fields of a record that are read from its file."""


def without_replaced(document: dict[str, Any], changes: Iterable[tuple[str, Any]]) -> None:
    """Remove fields that changes (path, value) redefine from a raw case.

    These are the record of a changed ``file`` and the set-point over time of a drive whose constant is changed; a torque over
    time is kept and added to the new constant.
    """
    for path, value in changes:
        *way, last = (part.strip() for part in path.split("."))
        place = _place(document, way)
        if not isinstance(place, dict):
            continue
        if last == SET_POINTS.get(str(place.get("kind"))):
            if last != "torque" or isinstance(value, Mapping) or _is_file(value):
                place.pop("over_time", None)
        elif last == "file":
            for field in ("file", *FILLED):
                place.pop(field, None)


def brings_file(path: str, value: Any) -> bool:
    """Return whether a change of a case names a file, itself or in a table.

    >>> brings_file("base.acceleration.file", "shock.csv"), brings_file("base", {"acceleration": {"file": "shock.csv"}})
    (True, True)
    >>> brings_file("run.seed", 3)
    False
    """
    if path.rpartition(".")[2].strip() == "file" or _is_file(value):
        return True
    return isinstance(value, Mapping) and any(brings_file(str(name), each) for name, each in value.items())


def with_tables(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return a raw case whose records hold their values: those of a ``file``, a path from ``folder``.

    These are the housing's acceleration, the tables of drives and loads, and set-points of drives over time, which go into
    ``over_time``. Raises `InputError` for a file that is no table of time [s] and a value [SI]; steps may differ in set-points
    alone.
    """
    bodies: list[tuple[str, ...]] = []
    rotors = document.get("rotors")
    bodies += [("rotors", str(name)) for name in (rotors if isinstance(rotors, Mapping) else ())]
    sets = document.get("planetary")
    for name in sets if isinstance(sets, Mapping) else ():
        bodies += [("planetary", str(name), member) for member in MEMBERS]
    ways = [
        ("base", "acceleration"),
        *((*body, part, "table") for body in bodies for part in ("drive", "load")),
    ]
    for way in ways:
        place = _place(document, way)
        if isinstance(place, dict) and "file" in place:
            _fill(place, ".".join(way), folder)
    for body in bodies:
        gears = _place(document, (*body, "gears"))
        toothings = [
            body,
            *((*body, "gears", str(name)) for name in (gears if isinstance(gears, dict) else ())),
        ]
        for toothing in toothings:
            given = _place(document, (*toothing, "deviations"))
            if isinstance(given, dict):
                fill_deviations(given, ".".join((*toothing, "deviations")), folder)
        drive = _place(document, (*body, "drive"))
        if isinstance(drive, dict):
            _set_over_time(drive, ".".join((*body, "drive")), folder)
    return document


def _place(document: dict[str, Any], way: Iterable[str]) -> Any:
    place: Any = document
    for part in way:
        place = place.get(part) if isinstance(place, dict) else None
    return place


def _is_file(value: Any) -> bool:
    return isinstance(value, str) and value.strip().lower().endswith(".csv")


def _set_over_time(drive: dict[str, Any], path: str, folder: Path) -> None:
    """Write a set-point over time of a raw drive, a table or the name of a file in place of its number, into ``over_time``."""
    field = SET_POINTS.get(str(drive.get("kind")))
    if field is None:
        return
    given = drive.get(field)
    if isinstance(given, dict) or _is_file(given):
        if "over_time" in drive:
            rule = f"must not be given together with {field} over time, which gives it"
            raise InputError.of(f"{path}.over_time", "given", rule, "Remove one of the two")
        drive["over_time"], drive[field] = {"table": given} if _is_file(given) else given, 0.0
    over_time = drive.get("over_time")
    if isinstance(over_time, dict):
        drive.setdefault(field, 0.0)
        if _is_file(over_time.get("table")):
            times, values = _columns(f"{path}.{field}", folder / over_time["table"].strip())
            over_time["table"] = [list(point) for point in zip(times, values, strict=True)]


def _fill(given: dict[str, Any], path: str, folder: Path) -> None:
    """Put the values of its file into a raw record."""
    at, name = f"{path}.file", given["file"]
    if not isinstance(name, str):
        raise InputError.of(at, name, "must be the path of a file", "Write it in quotes")
    for field in FILLED:
        if field in given:
            rule = "must not be given together with a file, which gives it"
            raise InputError.of(f"{path}.{field}", given[field], rule, "Remove one of the two")
    times, values = _columns(at, folder / name)
    steps = [later - earlier for earlier, later in pairwise(times)]
    step = (times[-1] - times[0]) / len(steps) if steps else 0.0
    if not steps or step <= 0.0 or max(abs(each - step) for each in steps) > EQUAL * len(times) * step:
        rule = "must have times in equal, rising steps"
        raise InputError.of(at, shorten(name), rule, "Resample it, gp.signals.resample does")
    del given["file"]
    given |= {"values": values, "sampling": 1.0 / step, "start": times[0]}


def _columns(at: str, path: Path) -> tuple[list[float], list[float]]:
    """Return the two columns of a text file."""
    rows = rows_of(at, path, 2, "two numbers in each line, time [s] and value [SI]")
    return [time for time, _ in rows], [value for _, value in rows]
