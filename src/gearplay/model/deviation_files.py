"""Measured deviations of teeth in separate files."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gearplay.model.toml_files import read_text
from gearplay.parts.planetary.names import MEMBERS
from gearplay.vocabulary.errors import NO_VALUE, InputError, shorten


def raw_gears(document: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
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


def fill_deviations(given: dict[str, Any], path: str, folder: Path) -> None:
    """Put the columns of their files, in um, into raw deviations of teeth: ``pitch``, and slope and form of a ``profile``.

    Raises `InputError` for a file that has not one line of numbers for each tooth.
    """
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
