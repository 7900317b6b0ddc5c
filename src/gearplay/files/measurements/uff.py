"""UFF 58 and 58b: the data sets are walked, declared ordinates compared with read ones; pyuff decodes."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.measurements.building import Request, distinct, even_sampling, make_channel, make_record
from gearplay.files.measurements.refusing import MOST_NODES, check_samples, damaged, fenced, need, quoted
from gearplay.files.record import Channel, Record

HEADER_LINES: Final = 13
"""Lines before the ordinates: the mark, the kind, five texts and six records."""

_MARK = re.compile(rb"^ {4}-1[ ]*\r?$", re.MULTILINE)
_AFTER_BINARY = re.compile(rb"\s{0,2} {4}-1[ ]*(\r?\n|\r?$)")
_OF = re.compile(r"channel (\d{1,6}) of (\d{1,6})")
_SIZES: Final = {
    2: (4, 1),
    4: (8, 1),
    5: (4, 2),
    6: (8, 2),
}  # ordinate type -> bytes of a number, numbers each
_TIME_RESPONSE: Final = (0, 1)
_TIME, _UNKNOWN, _GENERAL = 17, 0, 1


@dataclass(frozen=True)
class DataSet:
    """One data set of a universal file: its kind, whether binary, and where its lines are [bytes]."""

    kind: int
    binary: bool
    begin: int
    header: tuple[bytes, ...] = ()

    def field(self, record: int, begin: int, width: int) -> str:
        """Return a field of a header record, 1 is the first text line."""
        return self.header[record + 1][begin : begin + width].decode("latin-1").strip()


def _line(content: bytes, place: int) -> tuple[bytes, int]:
    end = content.find(b"\n", place)
    return (content[place:], len(content)) if end < 0 else (content[place:end], end + 1)


def walk(path: Path, content: bytes) -> list[DataSet]:
    """Return the data sets of a universal file.

    Raises `MeasurementError` where a data set has no end mark or holds fewer bytes than it declares.
    """
    found: list[DataSet] = []
    place = 0
    while place < len(content):
        line, after = _line(content, place)
        if not line.strip():
            place = after
            continue
        if line.strip() != b"-1" or len(found) >= MOST_NODES:
            raise damaged(path, f"data set {len(found) + 1} must begin with the mark -1 at byte {place + 1}")
        one = _data_set(path, content, place, len(found) + 1)
        found.append(one)
        place = _end(path, content, one, len(found))
    return found


def _data_set(path: Path, content: bytes, begin: int, number: int) -> DataSet:
    lines, place = [], begin
    for _ in range(HEADER_LINES):
        line, place = _line(content, place)
        lines.append(line)
    kind = lines[1][:6].strip()
    if not kind.isdigit():
        raise damaged(path, f"data set {number} must state its kind as a number")
    return DataSet(int(kind), lines[1][6:7].lower() == b"b", begin, tuple(lines))


def _end(path: Path, content: bytes, one: DataSet, number: int) -> int:
    """Return the byte after the end mark of a data set."""
    _, second = _line(content, one.begin)
    if one.kind == 58 and one.binary:
        second = one.begin + sum(len(line) + 1 for line in one.header)
        length = _binary_length(path, one, number)
        if second + length > len(content):
            left = max(len(content) - second, 0)
            raise damaged(path, f"data set {number} declares {length} bytes of ordinates, {left} are left")
        match = _AFTER_BINARY.match(content, second + length)
    else:
        match = _MARK.search(content, second)
    if match is None:
        raise damaged(path, f"data set {number} has no end mark -1")
    return match.end()


def _whole(path: Path, text: str, number: int, what: str) -> int:
    if not text.removeprefix("-").isdecimal():
        raise damaged(
            path, f"data set {number} must state its {what} as a whole number, {quoted(text)} found"
        )
    return int(text)


def _binary_length(path: Path, one: DataSet, number: int) -> int:
    """Return the bytes of the ordinates of a binary data set, which two of its fields declare."""
    kind = _whole(path, one.field(7, 0, 10), number, "ordinate type")
    count = _whole(path, one.field(7, 10, 10), number, "number of ordinates")
    even = _whole(path, one.field(7, 20, 10), number, "abscissa spacing") == 1
    stated = _whole(path, one.header[1][31:43].decode("latin-1").strip(), number, "number of bytes")
    if kind not in _SIZES or count < 1:
        raise damaged(path, f"data set {number} declares {count} ordinates of type {kind}")
    size, parts = _SIZES[kind]
    length = count * size * (parts if even else parts + 1)
    if stated not in (length, count * size):  # writers leave abscissas and imaginary parts out of the count
        raise damaged(
            path, f"data set {number} declares {count} ordinates, but {stated} bytes where {length} are due"
        )
    return length


def _is_time_history(one: DataSet) -> bool:
    function, abscissa = one.field(6, 0, 5), one.field(8, 0, 10)
    return (
        one.kind == 58
        and function in {str(kind) for kind in _TIME_RESPONSE}
        and abscissa in {str(kind) for kind in (_TIME, _UNKNOWN, _GENERAL)}
        and one.field(7, 0, 10) in ("2", "4")
    )


def _text(value: object) -> str:
    text = str(value).strip()
    return "" if text.upper() == "NONE" else text


def _name(one: DataSet) -> str:
    told = _text(one.field(1, 0, 80))
    return told or f"node {one.field(6, 41, 10)} direction {one.field(6, 51, 4)}"


def _check_numbering(path: Path, sets: list[DataSet]) -> None:
    """Compare with ``channel 1 of 2`` where the fifth text says so: a file cut between data sets looks whole else."""
    matches = [_OF.fullmatch(one.field(5, 0, 80)) for one in sets]
    declared = max((int(match[2]) for match in matches if match), default=0)
    if declared > len(sets):
        raise damaged(path, f"declares {declared} channels and holds {len(sets)}")


def _sampling(path: Path, number: int, content: dict[str, Any]) -> tuple[float, float]:
    """Return rate [Hz] and start [s]; an increment has 6 digits, so a rate that close to whole hertz is whole."""
    if int(content["abscissa_spacing"]) != 1:
        return even_sampling(path, np.asarray(content["x"], dtype=np.float64), column=f"data set {number}")
    increment = float(content["abscissa_inc"])
    if not (np.isfinite(increment) and increment > 0.0 and np.isfinite(1.0 / increment)):
        raise damaged(path, f"data set {number} must have a positive time increment, {increment:g} found")
    rate = 1.0 / increment
    whole = round(rate)
    return (float(whole) if abs(rate - whole) <= 5e-6 * rate else float(f"{rate:.6g}")), float(
        content["abscissa_min"]
    )


def read(request: Request) -> Record:
    """Read the time histories of a universal file, text or binary; other data sets are left out.

    Raises `MeasurementError` where a data set is cut or holds another number of ordinates than it declares.
    """
    path = request.path
    sets = walk(path, path.read_bytes())
    histories = [number for number, one in enumerate(sets) if _is_time_history(one)]
    _check_numbering(path, [sets[number] for number in histories])
    names = distinct([_name(sets[number]) for number in histories])
    pyuff = need("pyuff", "pyuff", path)
    channels: list[Channel] = []
    with fenced(path, "UFF", "pyuff"):
        file = pyuff.UFF(str(path))
        if file.get_n_sets() != len(sets):
            raise damaged(path, f"declares {len(sets)} data sets, {file.get_n_sets()} can be read")
        for k in request.select(names):
            number = histories[k]
            declared = _whole(path, sets[number].field(7, 10, 10), number + 1, "number of ordinates")
            check_samples(path, declared)
            content = file.read_sets(number)
            values: NDArray[Any] = np.asarray(content["data"])
            if values.size != declared:
                rule = f"data set {number + 1} declares {declared} ordinates and holds {values.size}"
                raise damaged(path, rule)
            rate, start = _sampling(path, number + 1, content)
            texts = {key: _text(content[key]) for key in ("id2", "id3", "id4", "id5", "ordinate_axis_lab")}
            texts = {key: text for key, text in texts.items() if not _OF.fullmatch(text)}
            unit = _text(content["ordinate_axis_units_lab"])
            channels.append(
                make_channel(
                    request, names[k], values, sampling=rate, unit=unit, start=start, attributes=texts
                )
            )
    left_out = len(sets) - len(histories)
    return make_record(request, channels, "uff", {"data sets left out": left_out} if left_out else {})
