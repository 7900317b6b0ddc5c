"""How a text table is laid out: its delimiter and decimal sign, its comments, header and unit rows."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Final

from gearplay.files.measurements.building import TIME_UNITS, split_unit
from gearplay.files.measurements.refusing import damaged

COMMENTS: Final = ("#", "%", "//")
"""What lines that are no data begin with."""

PREAMBLE: Final = 200
"""Most lines before the first row of numbers."""

_SAMPLE: Final = 40
_LAYOUTS: Final = (
    (";", ","),
    (";", "."),
    ("\t", ","),
    ("\t", "."),
    (",", "."),
    ("|", "."),
    (" ", "."),
    (" ", ","),
)
_NUMBER = re.compile(
    r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*|\s*[-+]?(nan|inf|infinity)\s*", re.IGNORECASE
)
_DECLARED = re.compile(r"\W*([\w .-]{1,60}?)\s*[=:]\s*(.*)")


@dataclass(frozen=True)
class Layout:
    """Where the numbers of a text table begin and how to read them.

    ``first`` is the line of the first row of numbers, from 0; ``declared`` holds what comments and preamble say.
    """

    delimiter: str
    decimal: str
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    declared: dict[str, str] = field(default_factory=dict)

    @property
    def columns(self) -> int:
        """Number of columns."""
        return len(self.names)


def is_number(text: str) -> bool:
    """Tell whether a text with a decimal point is a number; ``1_000`` is none.

    >>> is_number(" -1.5e3 "), is_number("nan"), is_number("1_000"), is_number("")
    (True, True, False, False)
    """
    return _NUMBER.fullmatch(text) is not None


def is_comment(line: str) -> bool:
    """Tell whether a line holds no row: blank or a comment."""
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
    if decimal == ",":
        return all("." not in text and is_number(text.replace(",", ".")) for text in row)
    return all(is_number(text) for text in row)


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
    numbered = list(
        islice(((k, line) for k, line in enumerate(lines) if not is_comment(line)), PREAMBLE + _SAMPLE)
    )
    texts = [line for _, line in numbered]
    scores = [_score(texts, delimiter, decimal) for delimiter, decimal in _LAYOUTS]
    best = max(scores)
    _, _, count, columns, first = best
    if not count:
        raise damaged(
            path, "must hold rows of numbers, none found", "Check the delimiter and the decimal sign"
        )
    delimiter, decimal = _LAYOUTS[scores.index(best)]
    heads = [row for row in split_rows(texts[:first], delimiter) if len(row) == columns]
    names, units = _header(heads, columns)
    declared = _declarations(lines[: numbered[first][0]])
    return Layout(delimiter, decimal, numbered[first][0], tuple(names), tuple(units), declared)


def _header(heads: Sequence[Sequence[str]], columns: int) -> tuple[list[str], list[str]]:
    """Return names and units from the header rows: one row with units in brackets, or a second row of units."""
    if not heads:
        return [""] * columns, [""] * columns
    if len(heads) >= 2 and _is_unit_row(heads[-1]):
        return [name.strip() for name in heads[-2]], [unit.strip().strip("[]()") for unit in heads[-1]]
    pairs = [split_unit(text) for text in heads[-1]]
    return [name for name, _ in pairs], [unit for _, unit in pairs]


def _is_unit_row(row: Sequence[str]) -> bool:
    """Tell whether a second header row holds units: its first is a unit of time, or all stand in brackets."""
    bare = [text.strip() for text in row]
    bracketed = all(text[:1] + text[-1:] in ("[]", "()", "") for text in bare)
    return bracketed or (bool(bare[0]) and bare[0].strip("[]()") in TIME_UNITS)


def _declarations(lines: Sequence[str]) -> dict[str, str]:
    """Return what the lines before the numbers say as ``key = value`` or ``key: value``, keys in small letters."""
    found: dict[str, str] = {}
    for line in lines[:PREAMBLE]:
        match = _DECLARED.fullmatch(line.strip())
        if match:
            found.setdefault(match[1].strip().lower(), match[2].strip())
    return found
