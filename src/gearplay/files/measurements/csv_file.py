"""CSV and other text tables: every row and field is checked, the time column gives the sampling rate."""

import csv
import re
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.csv_layout import (
    Layout,
    clock_time,
    is_comment,
    is_number,
    sniff,
    split_rows,
)
from gearplay.files.measurements.rates import declarations, even_sampling, time_scale
from gearplay.files.measurements.refusing import check_samples, damaged, decoded, quoted
from gearplay.files.record import Record

_ROWS_AT_ONCE: Final = 50_000
_ADD_A_LINE_END: Final = "If the file is complete, add a line end after the last number; else export it again"


def _text(path: Path) -> str:
    """Return the text: UTF-8, UTF-16 with its mark, else Latin-1, in which any byte is a letter."""
    content = path.read_bytes()
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        try:
            return content.decode("utf-16")
        except UnicodeDecodeError:
            raise damaged(path, "starts as UTF-16 text and does not end as such") from None
    if b"\0" in content:
        raise damaged(path, f"must be text, byte {content.index(0) + 1} is zero")
    return decoded(content)


def _fault(path: Path, row: list[str], line: int, layout: Layout) -> Exception:
    """Return the error that names the first bad field of a row."""
    if len(row) != layout.columns:
        return damaged(path, f"line {line} must have {layout.columns} fields, {len(row)} found")
    for column, text in enumerate(row, start=1):
        if not is_number(text) and not (column - 1 == layout.clock and clock_time(text)):
            found = quoted(text) if text.strip() else "nothing"
            return damaged(path, f"line {line}, field {column} must be a number, {found} found")
    return damaged(path, f"line {line} cannot be read")


def _clock_column(rows: list[list[str]], columns: int, place: int) -> list[tuple[int, bool]]:
    """Return the clock times of a column, which is set to zeros."""
    found = []
    for row in rows:
        time = clock_time(row[place]) if len(row) == columns else None
        if time is not None:
            found.append(time)
            row[place] = "0"
    return found


def _numbers(path: Path, lines: list[str], layout: Layout) -> NDArray[np.float64]:
    """Return the rows of numbers, shape [time, column]; dated clock times count from the first one [s]."""
    kept = [k for k in range(layout.first, len(lines)) if not is_comment(lines[k])]
    check_samples(path, len(kept) * layout.columns)
    values = np.empty((len(kept), layout.columns))
    clock: list[tuple[int, bool]] = []
    for begin in range(0, len(kept), _ROWS_AT_ONCE):
        places = kept[begin : begin + _ROWS_AT_ONCE]
        texts = [lines[k] for k in places]
        try:
            rows = split_rows(texts, layout.delimiter)
        except csv.Error as error:
            raise damaged(path, f"must be a table ({error})") from None
        if layout.clock is not None:
            clock += _clock_column(rows, layout.columns, layout.clock)
        if layout.decimal == ",":
            rows = [[text.replace(",", ".") for text in row] for row in rows]
        for place, row in zip(places, rows, strict=False):
            if len(row) != layout.columns or not all(map(is_number, row)):
                raise _fault(path, row, place + 1, layout)
        if len(rows) != len(places):  # an open quote swallowed line ends
            raise damaged(path, f"holds an open quotation mark after line {places[0] + 1}")
        try:
            values[begin : begin + len(rows)] = np.array(rows, dtype=np.float64)
        except ValueError:  # exponents of Fortran
            plain = [[re.sub("[dD]", "e", text) for text in row] for row in rows]
            values[begin : begin + len(rows)] = np.array(plain, dtype=np.float64)
    if layout.clock is not None:
        if len(clock) != len(kept) or len({dated for _, dated in clock}) > 1:
            rule = f"must hold a clock time of one form in field {layout.clock + 1} of every line"
            raise damaged(path, rule)
        first = clock[0][0] if clock[0][1] else 0
        values[:, layout.clock] = [(time - first) * 1e-9 for time, _ in clock]
    return values


def _check_end(path: Path, lines: list[str], rows: int, layout: Layout) -> None:
    """Compare the rows declared and found; refuse a last line without an end whose last number may be cut.

    That is where the file declares its rows, as its writer then ends each, or where other rows have more decimals.
    """
    declared = layout.declared.get("rows", "")
    if declared.isdecimal() and len(declared) < 16 and int(declared) != rows:
        raise damaged(path, f"declares {int(declared)} rows and holds {rows}")
    if not lines[-1]:
        return
    ends = [line.rpartition(layout.decimal)[2] for line in lines[layout.first : layout.first + 200]]
    widths = {len(end) for end in ends[:-1]}
    if declared or (len(widths) == 1 and len(ends[0]) > len(lines[-1].rpartition(layout.decimal)[2])):
        raise damaged(path, "its last line has no end, so its last number may be cut", _ADD_A_LINE_END)


def _time_column(layout: Layout, values: NDArray[np.float64], sampling: float | None) -> int | None:
    if layout.clock is not None:
        return layout.clock
    for place, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True)):
        if time_scale(name, unit) is not None:
            return place
    if any(layout.names) or layout.columns < 2 or sampling is not None or values.shape[0] < 2:
        return None
    steps = np.diff(values[:, 0])
    return 0 if (steps > 0).all() and not (steps == 1.0).all() else None  # steps of 1 count the rows


def read(request: Request) -> Record:
    """Read a text table: delimiter and decimal sign are found, names and units kept, the time checked.

    A column called time (or t, Zeit, temps ...) in a unit of time, or one of clock times, gives the sampling rate; of a table
    without any header, the first of several columns does where it rises and does not count the rows. Other declarations are
    lines before the numbers, ``# sampling = 1000`` or ``Sample rate: 12.8 kHz``. Raises `MeasurementError` for a row with
    another number of fields, text where a number should be, or another number of rows than ``# rows = 100`` declares.
    """
    path = request.path
    text = _text(path)
    lines = re.split("\r\n|\r|\n", text)
    try:
        layout = sniff(path, lines)
    except csv.Error as error:
        raise damaged(path, f"must be a table ({error})") from None
    values = _numbers(path, lines, layout)
    _check_end(path, lines, values.shape[0], layout)
    time = _time_column(layout, values, request.sampling)
    words = layout.declared.get("start", "").removesuffix("s").strip()
    declared, start = declarations(layout.declared.items()), float(words) if is_number(words) else 0.0
    if time is not None:
        column = layout.names[time] or f"column {time + 1}"
        scale = time_scale(layout.names[time], layout.units[time]) or 1.0
        rate, start = even_sampling(path, values[:, time] * scale, column=column)
        declared.append((column, rate))
    places = [k for k in range(layout.columns) if k != time]
    if not places:
        rule = f"must hold a column in addition to the time {quoted(layout.names[time or 0])}"
        raise damaged(path, rule, "Export it again")
    about = {key: text for key, text in layout.declared.items() if key not in ("rows", "sampling", "start")}
    return make_record(
        request,
        [layout.names[k] for k in places],
        lambda k: Samples(values[:, places[k]], declared, layout.units[places[k]], start),
        about,
    )
