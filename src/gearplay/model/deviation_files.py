"""Measured deviations of teeth in separate files."""

from pathlib import Path
from typing import Any

from gearplay.model.toml_files import lines_of
from gearplay.vocabulary.errors import NO_VALUE, InputError, shorten


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
                rule = "must not be given together with a profile, which gives it"
                raise InputError.of(f"{path}.{column}", NO_VALUE, rule, "Remove one of the two")
        rows = _numbers(f"{path}.{field}", folder / name, len(names))
        given |= {column: [1e-6 * row[k] for row in rows] for k, column in enumerate(names)}


def _numbers(at: str, path: Path, columns: int) -> list[list[float]]:
    """Return the rows of a text file with a given number of columns; the first line may be a header."""
    rows: list[list[float]] = []
    for number, words in lines_of(at, path):
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
            if not rows and number <= 2:
                continue
        if len(row) != columns:
            rule = f"must have {columns} numbers [um] in each line, one line per tooth, but line {number} has not"
            raise InputError.of(at, shorten(path.name), rule, "Use a point as decimal sign")
        rows.append(row)
    return rows
