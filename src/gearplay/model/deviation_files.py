"""Measured deviations of teeth in separate files."""

from pathlib import Path
from typing import Any

from gearplay.model.toml_files import rows_of
from gearplay.vocabulary.errors import NO_VALUE, InputError


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
        what = f"{len(names)} numbers [um] in each line, one line a tooth"
        rows = rows_of(f"{path}.{field}", folder / name, len(names), what)
        given |= {column: [1e-6 * row[k] for row in rows] for k, column in enumerate(names)}
