"""CSV and other text tables: rows counted, every field checked, the time column turned into a sampling rate."""

import csv
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import (
    TIME_UNITS,
    Request,
    distinct,
    even_sampling,
    is_time,
    make_channel,
    make_record,
)
from gearplay.files.measurements.csv_layout import Layout, is_comment, is_number, sniff, split_rows
from gearplay.files.measurements.refusing import check_samples, damaged, quoted
from gearplay.files.record import Record

_ROWS_AT_ONCE: Final = 50_000
_ADD_A_LINE_END: Final = "If the file is whole, add a line end after the last number; else export it again"


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
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _fault(path: Path, row: list[str], line: int, layout: Layout) -> Exception:
    """Return the error that names the first bad field of a row."""
    if len(row) != layout.columns:
        return damaged(path, f"line {line} must have {layout.columns} fields, {len(row)} found")
    for column, text in enumerate(row, start=1):
        if not is_number(text):
            what = quoted(text) if text.strip() else "nothing"
            return damaged(path, f"line {line}, field {column} must be a number, {what} found")
    return damaged(path, f"line {line} cannot be read")


def _numbers(path: Path, lines: list[str], layout: Layout) -> NDArray[np.float64]:
    """Return the rows of numbers, shape [time, column]."""
    kept = [k for k in range(layout.first, len(lines)) if not is_comment(lines[k])]
    check_samples(path, len(kept) * layout.columns)
    values = np.empty((len(kept), layout.columns))
    for begin in range(0, len(kept), _ROWS_AT_ONCE):
        places = kept[begin : begin + _ROWS_AT_ONCE]
        texts = [lines[k] for k in places]
        try:
            rows = split_rows(texts, layout.delimiter)
        except csv.Error as error:
            raise damaged(path, f"must be a table ({error})") from None
        if layout.decimal == ",":
            rows = [[text.replace(",", ".") for text in row] for row in rows]
        for place, row in zip(places, rows, strict=False):
            if len(row) != layout.columns or not all(map(is_number, row)):
                raise _fault(path, row, place + 1, layout)
        if len(rows) != len(places):  # an open quote swallowed line ends
            raise damaged(path, f"holds an open quotation mark after line {places[0] + 1}")
        values[begin : begin + len(rows)] = np.array(rows, dtype=np.float64)
    return values


def _check_end(path: Path, text: str, rows: int, layout: Layout) -> None:
    """Compare the rows declared and found; refuse a last line without an end, whose last number may be cut."""
    declared = layout.declared.get("rows", "")
    if declared.isdecimal() and len(declared) < 16 and int(declared) != rows:
        raise damaged(path, f"declares {int(declared)} rows and holds {rows}")
    if not text.endswith(("\n", "\r")):
        raise damaged(path, "its last line has no end, so its last number may be cut", _ADD_A_LINE_END)


def _time_column(layout: Layout, values: NDArray[np.float64], sampling: float | None) -> int | None:
    for place, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True)):
        if is_time(name, unit):
            return place
    headless = not any(layout.names) and layout.columns > 1 and sampling is None
    if headless and values.shape[0] > 1 and bool((np.diff(values[:, 0]) > 0).all()):
        return 0
    return None


def _declared_number(layout: Layout, key: str) -> float | None:
    words = layout.declared.get(key, "").removesuffix("Hz").removesuffix("s").strip()
    return float(words) if is_number(words) else None


def read(request: Request) -> Record:
    """Read a text table: delimiter and decimal sign are found, names and units kept, the time checked.

    A column called time (or t, Zeit, temps ...) in a unit of time gives the sampling rate; of a table without any
    header, the first of several columns does where it rises. Else the rate comes from a comment ``# sampling = 1000``
    or from the caller. Raises `MeasurementError` for a row with another number of fields, text where a number should
    be, another number of rows than a comment ``# rows = 100`` declares, or a last line without its end.
    """
    path = request.path
    text = _text(path)
    lines = text.splitlines()
    try:
        layout = sniff(path, lines)
    except csv.Error as error:
        raise damaged(path, f"must be a table ({error})") from None
    values = _numbers(path, lines, layout)
    _check_end(path, text, values.shape[0], layout)
    time = _time_column(layout, values, request.sampling)
    sampling, start = _declared_number(layout, "sampling"), _declared_number(layout, "start") or 0.0
    if time is not None:
        column = layout.names[time] or "column 1"
        scale = TIME_UNITS[layout.units[time]]
        sampling, start = even_sampling(path, values[:, time] * scale, column=column)
    places = [k for k in range(layout.columns) if k != time]
    if not places:
        raise damaged(
            path, f"must hold a column beside the time {quoted(layout.names[time or 0])}", "Export it again"
        )
    names = distinct([layout.names[k] for k in places])
    channels = [
        make_channel(
            request,
            names[k],
            values[:, places[k]],
            sampling=sampling,
            unit=layout.units[places[k]],
            start=start,
        )
        for k in request.select(names)
    ]
    said = {key: words for key, words in layout.declared.items() if key not in ("rows", "sampling", "start")}
    return make_record(request, channels, "csv", said)
