"""Torque and rotation of a measured hysteresis curve, from two columns of a text table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import shown_path
from gearplay.files.measurements.building import split_unit
from gearplay.files.measurements.csv_layout import Layout, is_comment, is_number, sniff, split_rows
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError, ResourceError
from gearplay.vocabulary.suggestions import did_you_mean

Floats = NDArray[np.float64]

LARGEST = 200_000_000
"""Largest file [bytes]."""
FEWEST = 20
"""Fewest rows with both numbers."""


class Measured(NamedTuple):
    """Samples in the order of the file: torque [N m], rotation [rad], shape [sample]; rows without numbers were left out."""

    torque: Floats
    angle: Floats
    left_out: int


def read_curve(path: str | os.PathLike[str], columns: Sequence[str] | None) -> Measured:
    """Return two columns of a text table, named or numbered from 1, the first two if not given.

    Each unit stands in brackets behind the given name, or in the file's header. Rows whose numbers are missing or NaN are left
    out. Raises `InputError` for a missing file or column and for a column without a unit, `MeasurementError` for a file without
    rows of numbers.
    """
    place = Path(path)
    lines = _lines(place)
    layout = sniff(place, lines)
    wanted = list(columns) if columns is not None else ["1", "2"]
    if len(wanted) != 2:
        rule = "must name two columns, torque and rotation"
        raise InputError.of("columns", ", ".join(wanted), rule, "Name two, as TORQUE,ROTATION")
    places = [_place(name, layout) for name in wanted]
    factors = [
        _factor(name, layout.names[at], layout.units[at], quantity)
        for name, at, quantity in zip(wanted, places, (q.TORQUE, q.ANGLE), strict=True)
    ]
    rows = split_rows([line for line in lines[layout.first :] if not is_comment(line)], layout.delimiter)
    torque, angle = (
        factor * np.array([_number(row, at, layout.decimal) for row in rows])
        for at, factor in zip(places, factors, strict=True)
    )
    known = np.isfinite(torque) & np.isfinite(angle)
    if int(known.sum()) < FEWEST:
        rule = f"must have {FEWEST} rows or more with both numbers, it has {int(known.sum())}"
        raise InputError.of("file", shown_path(place), rule, "Name the columns of torque and rotation")
    return Measured(torque[known], angle[known], int((~known).sum()))


def _lines(place: Path) -> list[str]:
    try:
        size = place.stat().st_size
        if size > LARGEST:
            raise ResourceError(
                f"{shown_path(place)}: {size:.3g} bytes, more than the limit of {LARGEST:.3g}. Thin it."
            )
        return place.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        rule = f"must be a file that can be read ({reason})"
        raise InputError.of("file", shown_path(place), rule, "Check its path") from None


def _number(row: Sequence[str], at: int, decimal: str) -> float:
    """Return the number of a field, NaN where there is none."""
    text = row[at].replace(decimal, ".").strip() if at < len(row) else ""
    return float(text) if is_number(text) and "d" not in text.lower() else np.nan


def _place(name: str, layout: Layout) -> int:
    """Return the index of a column given by name, with or without its unit, or by number."""
    bare = split_unit(name)[0].strip().casefold()
    names = [each.strip() for each in layout.names]
    for at, each in enumerate(names):
        if name.strip() == each or bare == each.casefold():
            return at
    if bare.isdecimal() and bare.isascii() and 1 <= int(bare) <= layout.columns:
        return int(bare) - 1
    numbers = f"Give numbers from 1 to {layout.columns}"
    cure = did_you_mean(name, [each for each in names if each], "Columns") if any(names) else numbers
    raise InputError.of("columns", name, "must be a column of the file", cure)


def _factor(name: str, heading: str, unit: str, quantity: q.Quantity) -> float:
    """Return the factor to SI of the unit behind a given name, or of that in the file."""
    given = split_unit(name)[1] or unit
    if not given:
        cure = "Write torque and rotation with the unit of each, as in 'T [N m],phi [deg]'"
        raise InputError.of("columns", heading or name, "must have a unit", cure)
    try:
        return parse_quantity(f"1 {given}", quantity)
    except UnitError as error:
        raise InputError.of("columns", f"{name} [{given}]", error.rule, error.cure) from None
