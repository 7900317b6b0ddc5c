"""Tables of numbers in separate files, referenced by ``file`` in a case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from gearplay.model.toml_files import read_text
from gearplay.parts.planetary.names import MEMBERS
from gearplay.vocabulary.errors import NO_VALUE, InputError, shorten

EQUAL: Final = 1e-6
"""Relative difference of steps that still count as equal."""


FILLED: Final = ("values", "sampling", "start")
"""Fields of a record that are read from its file."""


def without_replaced(document: dict[str, Any], paths: Iterable[str]) -> None:
    """Remove the fields that a changed ``file`` defines from the records of a raw case; ``paths`` are those of all changes."""
    for path in paths:
        *way, last = (part.strip() for part in path.split("."))
        place: Any = document
        for part in way:
            place = place.get(part) if isinstance(place, dict) else None
        if last == "file" and isinstance(place, dict):
            for field in ("file", *FILLED):
                place.pop(field, None)


def brings_file(path: str, value: Any) -> bool:
    """Return whether a change of a case names a file, itself or in a table.

    >>> brings_file("base.acceleration.file", "shock.csv"), brings_file("base", {"acceleration": {"file": "shock.csv"}})
    (True, True)
    >>> brings_file("run.seed", 3)
    False
    """
    if path.rpartition(".")[2].strip() == "file":
        return True
    return isinstance(value, Mapping) and any(brings_file(str(name), each) for name, each in value.items())


def with_tables(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return a raw case whose records hold their values: those of a ``file``, a path from ``folder``.

    These are the housing's acceleration and the tables of drives and loads. Raises `InputError` for a file that is no table of
    time [s] and a value [SI] in equal steps.
    """
    ways: list[tuple[str, ...]] = [("base", "acceleration")]
    rotors = document.get("rotors")
    for name in rotors if isinstance(rotors, Mapping) else ():
        ways += [("rotors", str(name), part, "table") for part in ("drive", "load")]
    sets = document.get("planetary")
    for name in sets if isinstance(sets, Mapping) else ():
        for member in MEMBERS:
            ways += [("planetary", str(name), member, part, "table") for part in ("drive", "load")]
    for way in ways:
        place: Any = document
        for part in way:
            place = place.get(part) if isinstance(place, dict) else None
        if isinstance(place, dict) and "file" in place:
            _fill(place, ".".join(way), folder)
    for path, gear in _raw_gears(document):
        if isinstance(given := gear.get("deviations"), dict):
            _fill_deviations(given, f"{path}.deviations", folder)
    return document


def _raw_gears(document: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the raw tables of a case that may be gears, with their paths."""
    rotors, sets = document.get("rotors"), document.get("planetary")
    for name, rotor in rotors.items() if isinstance(rotors, Mapping) else ():
        if isinstance(rotor, dict):
            yield f"rotors.{name}", rotor
            gears = rotor.get("gears")
            for gear, each in gears.items() if isinstance(gears, Mapping) else ():
                if isinstance(each, dict):
                    yield f"rotors.{name}.gears.{gear}", each
    for name, given in sets.items() if isinstance(sets, Mapping) else ():
        for member in MEMBERS:
            if isinstance(given, Mapping) and isinstance(each := given.get(member), dict):
                yield f"planetary.{name}.{member}", each


def _fill_deviations(given: dict[str, Any], path: str, folder: Path) -> None:
    """Put the columns of their files, in um, into raw deviations of teeth: ``pitch``, and slope and form of a ``profile``."""
    for field, names in (("pitch", ("pitch",)), ("profile", ("slope", "form"))):
        if not isinstance(name := given.get(field), str):
            continue
        del given[field]
        for column in names:
            if column in given:
                rule = "must not be given beside a profile, which says it"
                raise InputError.of(f"{path}.{column}", NO_VALUE, rule, "Remove one of the two")
        rows = _numbers(f"{path}.{field}", folder / name, len(names))
        given |= {column: [1e-6 * row[k] for row in rows] for k, column in enumerate(names)}


def _numbers(at: str, path: Path, columns: int) -> list[list[float]]:
    """Return the rows of a text file of so many columns, apart by commas, semicolons, tabs or blanks; heads may be first."""
    rows: list[list[float]] = []
    for number, line in enumerate(read_text(path, what=at).splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if not words or words[0].startswith("#"):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
            if not rows and number <= 2:
                continue
        if len(row) != columns:
            rule = (
                f"must have {columns} numbers [um] in each line, one line a tooth, but line {number} has not"
            )
            raise InputError.of(at, shorten(path.name), rule, "Use a point as decimal sign")
        rows.append(row)
    return rows


def _fill(given: dict[str, Any], path: str, folder: Path) -> None:
    """Put the values of its file into a raw record."""
    at, name = f"{path}.file", given["file"]
    if not isinstance(name, str):
        raise InputError.of(at, name, "must be the path of a file", "Write it in quotes")
    for field in FILLED:
        if field in given:
            rule = "must not be given beside a file, which says it"
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
    """Return the two columns of a text file, apart by commas, semicolons, tabs or blanks; a line of heads may be first."""
    times: list[float] = []
    values: list[float] = []
    for number, line in enumerate(read_text(path, what=at).splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if not words or words[0].startswith("#"):
            continue
        try:
            time, value = (float(word) for word in words)
        except ValueError:
            if not times and number <= 2:  # heads
                continue
            rule = f"must have two numbers in each line, time [s] and value [SI], but line {number} has not"
            raise InputError.of(at, shorten(path.name), rule, "Use a point as decimal sign") from None
        times.append(time)
        values.append(value)
    return times, values
