"""UFF 58 and 58b by pyuff; end marks and declared ordinates are compared with the data read."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from gearplay.files.measurements.building import Request, Samples, make_record
from gearplay.files.measurements.rates import Declaration, even_sampling
from gearplay.files.measurements.refusing import check_samples, damaged, decoded, fenced, need
from gearplay.files.record import Record

_MARK: Final = re.compile(rb"^ {4}-1[ ]*\r?$", re.MULTILINE)
_OF: Final = re.compile(r"channel (\d{1,6}) of (\d{1,6})")
_HEADER_LINES: Final = 13
_TIME_RESPONSE: Final = (0, 1)
_TIME_AXES: Final = (0, 1, 17)
_REAL: Final = (2, 4)


@dataclass(frozen=True)
class _DataSet:
    """Header of one data set: its number from 0, its fields by pyuff and its lines of text."""

    number: int
    fields: dict[str, Any]
    lines: tuple[str, ...]

    @property
    def is_time_history(self) -> bool:
        """Whether it is of real ordinates over time."""
        return (
            int(self.fields["func_type"]) in _TIME_RESPONSE
            and int(self.fields["abscissa_spec_data_type"]) in _TIME_AXES
            and int(self.fields["ord_data_type"]) in _REAL
        )

    def text(self, line: int, begin: int, width: int) -> str:
        """Return a text of the header, empty for NONE; pyuff decodes names and units by different rules."""
        text = self.lines[line][begin : begin + width].strip()
        return "" if text.upper() == "NONE" else text

    @property
    def name(self) -> str:
        """First text, else node and direction of the response."""
        return self.text(2, 0, 80) or f"node {self.fields['rsp_node']} direction {self.fields['rsp_dir']}"

    @property
    def unit(self) -> str:
        """Unit of the ordinate."""
        return self.text(10, 46, 21)


def _data_sets(path: Path, file: Any, content: bytes) -> list[_DataSet]:
    """Return the data sets 58; `MeasurementError` where the marks do not enclose as many as pyuff finds."""
    marks = [match.start() for match in _MARK.finditer(content)]
    count = file.get_n_sets()
    if len(marks) != 2 * count or content[marks[-1] :].strip() != b"-1":
        rule = f"must enclose each data set in marks -1, {len(marks)} marks of {count} data sets found"
        raise damaged(path, rule)
    kinds = np.atleast_1d(file.get_set_types())
    found = []
    for number, kind in enumerate(kinds):
        between = content[marks[2 * number - 1] + 6 : marks[2 * number]] if number else content[: marks[0]]
        if between.strip():
            raise damaged(path, f"has text between data sets {number} and {number + 1}")
        if kind == 58:
            head = content[marks[2 * number] :].split(b"\n", _HEADER_LINES)[:_HEADER_LINES]
            lines = tuple(decoded(line) for line in head)
            found.append(_DataSet(number, file.read_sets(number, header_only=True), lines))
    return found


def _sampling(path: Path, number: int, content: dict[str, Any]) -> tuple[Declaration, float]:
    """Return rate [Hz] and start [s]; an increment has 6 digits, so a rate that close to whole hertz is whole."""
    source = f"data set {number}"
    if int(content["abscissa_spacing"]) != 1:
        rate, start = even_sampling(path, np.asarray(content["x"], dtype=np.float64), column=source)
        return (source, rate), start
    increment = float(content["abscissa_inc"])
    if not (np.isfinite(increment) and increment > 0.0 and np.isfinite(1.0 / increment)):
        raise damaged(path, f"{source} must have a positive time increment, {increment:g} found")
    rate = 1.0 / increment
    whole = round(rate)
    near = whole and abs(rate - whole) <= 5e-6 * rate
    return (source, float(whole) if near else float(f"{rate:.6g}")), float(content["abscissa_min"])


def read(request: Request) -> Record:
    """Read the time histories of a universal file, text or binary; other data sets are left out.

    Texts are UTF-8, or Latin-1 where they are not. Raises `MeasurementError` where a data set is cut or holds another number
    of ordinates than it declares.
    """
    path = request.path
    pyuff = need("pyuff", "pyuff", path)
    content = path.read_bytes()
    with fenced(path, "UFF"):
        file = pyuff.UFF(str(path))
        histories = [one for one in _data_sets(path, file, content) if one.is_time_history]
        _check_numbering(path, histories)
        left_out = int(file.get_n_sets()) - len(histories)
        return make_record(
            request,
            [one.name for one in histories],
            lambda k: _samples(request, file, histories[k]),
            {"data sets left out": left_out} if left_out else {},
        )


def _samples(request: Request, file: Any, one: _DataSet) -> Samples:
    number, declared = one.number + 1, int(one.fields["num_pts"])
    check_samples(request.path, declared)
    content = file.read_sets(one.number)
    values = np.asarray(content["data"])
    if values.size != declared:
        rule = f"data set {number} declares {declared} ordinates and holds {values.size}"
        raise damaged(request.path, rule)
    rate, start = _sampling(request.path, number, content)
    texts = {f"id{k}": one.text(k + 1, 0, 80) for k in range(2, 6)}
    texts["ordinate_axis_lab"] = one.text(10, 25, 21)
    texts = {key: text for key, text in texts.items() if not _OF.fullmatch(text)}
    return Samples(values, [rate], one.unit, start, texts)


def _check_numbering(path: Path, sets: list[_DataSet]) -> None:
    """Compare the count with ``channel 1 of 2`` in the fifth text: a file cut between data sets would look complete otherwise."""
    matches = [_OF.fullmatch(one.text(6, 0, 80)) for one in sets]
    declared = max((int(match[2]) for match in matches if match), default=0)
    if declared > len(sets):
        raise damaged(path, f"declares {declared} channels and holds {len(sets)}")
