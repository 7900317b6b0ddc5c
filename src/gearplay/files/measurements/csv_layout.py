"""Layout of a text table: delimiter and decimal sign, comments, header and unit rows, clock times."""

import csv
import datetime
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Final

from gearplay.files.measurements.building import split_unit
from gearplay.files.measurements.rates import TIME_UNITS, is_rate_name
from gearplay.files.measurements.refusing import damaged
from gearplay.schema.units import FACTORS

COMMENTS: Final = ("#", "%", "//")
"""Beginnings of lines without data."""

PREAMBLE: Final = 200
"""Most lines before the first row of numbers."""

_SAMPLE: Final = 40
_LAYOUTS: Final = (
    (";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), ("|", "."), (" ", "."), (" ", ","),
)  # fmt: skip
_NUMBER = re.compile(
    r"\s*[-+]?(\d+\.?\d*|\.\d+)([ed][-+]?\d+)?\s*|\s*[-+]?(nan|inf|infinity)\s*", re.IGNORECASE | re.ASCII
)
_CLOCK = re.compile(
    r"\s*(?:(\d{4}-\d\d-\d\d)[T ])?(\d{1,3}):([0-5]\d):([0-5]\d)(?:[.,](\d{1,9}))?(Z|[+-]\d\d:?\d\d)?\s*",
    re.ASCII,
)
_DECLARED = re.compile(r"\W*([\w .()\[\]/-]{1,60}?)\s*[=:]\s*(.*)")


@dataclass(frozen=True)
class Layout:
    """Layout of a text table.

    ``first`` is the line of the first row of numbers, from 0; ``declared`` holds the keys and values of comments and preamble,
    ``clock`` the column of clock times.
    """

    delimiter: str
    decimal: str
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    declared: dict[str, str] = field(default_factory=dict)
    clock: int | None = None

    @property
    def columns(self) -> int:
        """Number of columns."""
        return len(self.names)


def is_number(text: str) -> bool:
    """Return whether a text with a decimal point is a number, Fortran's ``1.5D+02`` included; ``1_000`` is none.

    >>> is_number(" -1.5e3 "), is_number("nan"), is_number("1_000"), is_number("")
    (True, True, False, False)
    """
    return _NUMBER.fullmatch(text) is not None


def clock_time(text: str) -> tuple[int, bool] | None:
    """Return a clock time [ns] and whether it has a date; None for other text.

    Times are hh:mm:ss with up to nine decimals, dated as ISO 8601 has it; a time zone is ignored.

    >>> clock_time("00:00:01.5"), clock_time("1970-01-02T00:00:00,25Z"), clock_time("1.5")
    ((1500000000, False), (86400250000000, True), None)
    """
    match = _CLOCK.fullmatch(text)
    if match is None:
        return None
    date, hours, minutes, seconds, decimals, _ = match.groups()
    try:
        days = (datetime.date.fromisoformat(date) - datetime.date(1970, 1, 1)).days if date else 0
    except ValueError:
        return None
    whole = ((24 * days + int(hours)) * 60 + int(minutes)) * 60 + int(seconds)
    return whole * 10**9 + int((decimals or "").ljust(9, "0")), bool(date)


def is_comment(line: str) -> bool:
    """Return whether a line holds no row: blank or a comment."""
    bare = line.lstrip()
    return not bare or bare.startswith(COMMENTS)


def split_rows(lines: Sequence[str], delimiter: str) -> list[list[str]]:
    """Split lines into fields, quotes taken off; runs of blanks count as one delimiter.

    A line that ends with the delimiter has no further field.
    """
    if delimiter == " ":
        return [line.split() for line in lines]
    rows = list(csv.reader(lines, delimiter=delimiter))
    return [row[:-1] if len(row) > 1 and not row[-1].strip() else row for row in rows]


def _as_numbers(row: Sequence[str], decimal: str) -> bool:
    """Return whether all fields of a row are numbers, except for at most one clock time."""
    others = [text for text in row if decimal in text or not is_number(text)]
    if decimal == ",":
        wrong = [text for text in others if "." in text or not is_number(text.replace(",", "."))]
        wrong += [text for text in row if text not in others and "." in text]
    else:
        wrong = [text for text in others if not is_number(text)]
    return not wrong or (len(wrong) == 1 and len(row) > 1 and clock_time(wrong[0]) is not None)


def _score(lines: Sequence[str], delimiter: str, decimal: str) -> tuple[bool, bool, int, int, int]:
    """Rate a layout: header as long as the rows, several columns, how many rows, how many columns, first row."""
    rows = split_rows(lines, delimiter)
    numeric = [k for k, row in enumerate(rows) if row and _as_numbers(row, decimal)]
    if not numeric:
        return False, False, 0, 0, 0
    lengths = [len(rows[k]) for k in numeric]
    columns = max(set(lengths), key=lengths.count)
    first = numeric[lengths.index(columns)]
    headed = first == 0 or len(rows[first - 1]) == columns
    return headed, columns > 1, lengths.count(columns), columns, first


def sniff(path: Path, lines: Sequence[str]) -> Layout:
    """Find the layout from the first lines of a text table.

    Delimiters are ``;``, tab, ``,``, ``|`` and blanks; the decimal sign is a point or, except where the comma
    delimits, a comma. Raises `MeasurementError` where no line is a row of numbers.
    """
    rows_of = ((k, line) for k, line in enumerate(lines) if not is_comment(line))
    numbered = list(islice(rows_of, PREAMBLE + _SAMPLE))
    texts = [line for _, line in numbered]
    scores = [_score(texts, delimiter, decimal) for delimiter, decimal in _LAYOUTS]
    best = max(scores)
    _, _, count, columns, first = best
    if not count:
        cure = "Check the delimiter and the decimal sign"
        raise damaged(path, "must hold rows of numbers, none found", cure)
    delimiter, decimal = _LAYOUTS[scores.index(best)]
    rows = split_rows(texts[: first + 2], delimiter)
    if _numbers_columns(rows[first:], decimal):  # a header of 0, 1, 2 ..., as tables without names have
        first += 1
    before = rows[first - 1] if first else []
    if delimiter == "," and len(before) > 1 and columns == 2 * len(before):
        rule = f"names {len(before)} columns and has rows of {columns} fields: decimal commas look like delimiters"
        raise damaged(path, rule, "Export it with decimal points, or with semicolons between the fields")
    names, units = _header([row for row in rows[:first] if len(row) == columns], columns)
    clock = next((k for k, text in enumerate(rows[first]) if clock_time(text) is not None), None)
    declared = _declarations(lines[: numbered[first][0]], delimiter)
    return Layout(delimiter, decimal, numbered[first][0], tuple(names), tuple(units), declared, clock)


def _numbers_columns(rows: Sequence[Sequence[str]], decimal: str) -> bool:
    """Return whether the first row numbers the columns from 0 and the second holds numbers that are not integers."""
    if len(rows) < 2 or len(rows[0]) < 2:
        return False
    counts = [text.strip() for text in rows[0]] == [str(k) for k in range(len(rows[0]))]
    return counts and any(decimal in text for text in rows[1])


def _header(heads: Sequence[Sequence[str]], columns: int) -> tuple[list[str], list[str]]:
    """Return names and units from the header rows: one row with units in brackets, or a second row of units."""
    if not heads:
        return [""] * columns, [""] * columns
    if len(heads) >= 2 and _is_unit_row(heads[-1]):
        return [name.strip() for name in heads[-2]], [unit.strip().strip("[]()") for unit in heads[-1]]
    pairs = [split_unit(text) for text in heads[-1]]
    return [name for name, _ in pairs], [unit for _, unit in pairs]


COMMON_UNITS: Final = frozenset(unit for units in FACTORS.values() for unit in units) | {
    "1",
    "Nm",
    "Ncm",
    "degC",
    "°C",
}
"""Units that a row of units may hold without brackets."""


def _is_unit_row(row: Sequence[str]) -> bool:
    """Return whether a second header row holds units: all in brackets or common ones, or its first a unit of time."""
    bare = [text.strip() for text in row]
    bracketed = all(text[:1] + text[-1:] in ("[]", "()", "") for text in bare)
    known = any(bare) and all(not text or text in COMMON_UNITS for text in bare)
    return bracketed or known or bare[0].strip("[]()") in TIME_UNITS


def _declarations(lines: Sequence[str], delimiter: str) -> dict[str, str]:
    """Return keys and values of the lines before the numbers, keys in small letters.

    Lines are ``key = value`` or ``key: value``; of a sampling rate also ``key;value`` and ``key;value;unit``.
    """
    found: dict[str, str] = {}
    for line in lines[:PREAMBLE]:
        bare = line.strip().lstrip("".join(COMMENTS)).strip()
        fields = [text.strip() for text in split_rows([bare], delimiter)[0]] if bare else []
        match = _DECLARED.fullmatch(bare)
        if match:
            found.setdefault(match[1].strip().lower(), match[2].strip().rstrip(delimiter))
        elif len(fields) in (2, 3) and is_rate_name(split_unit(fields[0])[0]):
            found.setdefault(fields[0].lower(), " ".join(fields[1:]))
    return found
