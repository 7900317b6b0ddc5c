"""Result of `calibrate`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gearplay.files.atomic import shown_path
from gearplay.pictures.style import CLEARANCE, COUPLED, UNCOUPLED, new_axes
from gearplay.pictures.words import plain
from gearplay.results.base import AnalysisResult, check_kind
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.version import VERSION
from gearplay.work.pieces import read_document, without_digest

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

COLUMNS = {"best": "best value", "low": "lower end of its interval", "high": "upper end of its interval"}


@dataclass(frozen=True, repr=False)
class Calibration(AnalysisResult):
    """Result of a calibration: the parameters that explain the records, and the better model.

    Attributes: ``ds`` (a row for each parameter of each fit), ``document`` (all of ``calibration.json``), ``message`` (the
    intervals against the values of the case, and which model explains the records).
    """

    document: Mapping[str, Any]

    result_kind = "calibration"

    @property
    def message(self) -> str:
        """Summary as text: intervals against the values of the case, and the better model."""
        return " ".join(self.document["answer"][:2])

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Every parameter of every fit: model, reading, name, best value and interval, and the SI unit of these."""
        return [
            {"model": fit["model"], "reading": fit["reading"], **row}
            for fit in self.document["fits"]
            for row in fit["parameters"]
        ]

    @property
    def ds(self) -> xr.Dataset:
        """A row for each parameter of each fit; the whole document is an attribute."""
        import xarray as xr

        rows = self.parameters
        text = {
            name: ("fit", np.array([str(row[name]) for row in rows], dtype=object), {"long_name": name})
            for name in ("model", "reading", "name", "unit")
        }
        numbers = {
            name: ("fit", np.array([_number(row.get(name)) for row in rows]), {"long_name": words})
            for name, words in COLUMNS.items()
        }
        attributes = {
            "title": self.document["title"],
            "document": json.dumps(self.document, allow_nan=False),
            "gearplay_version": VERSION,
        }
        return xr.Dataset(text | numbers, attrs=attributes)

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the calibration whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        if "document" not in dataset.attrs:
            rule = "must be the saved result of a calibration"
            raise InputError.of("dataset", "no document", rule, "Write it again")
        return cls(json.loads(dataset.attrs["document"]))

    @classmethod
    def from_document(cls, path: Path) -> Self:
        """Return the calibration whose ``calibration.json`` a file is.

        Raises `InputError` where it is missing, something else, or was changed after it was written.
        """
        stored = read_document(path)
        if stored is None:
            raise _refusal(path, "must be a calibration.json that gearplay calibrate wrote")
        if (document := without_digest(stored)) is None:
            raise _refusal(path, "must be as gearplay calibrate wrote it; it was changed since")
        return cls(document)

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each parameter of each fit."""
        return [
            (f"{row['name']}, {row['model']}, {row['reading']}", f"{_shown(row, 'best')} {row.get('shown_unit', row['unit'])}"
             f" ({_shown(row, 'low')} to {_shown(row, 'high')})")
            for row in self.parameters
        ]  # fmt: skip

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw each parameter's interval over its best value, 1 where they agree, by model."""
        rows = [row for row in self.parameters if _number(row["best"])]
        drawn = ax if ax is not None else new_axes(7.0, 1.4 + 0.22 * len(rows))
        models = list(dict.fromkeys(row["model"] for row in rows))
        for at, row in enumerate(rows[::-1]):
            best, low, high = (_number(row[name]) for name in COLUMNS)
            color = (COUPLED, UNCOUPLED)[models.index(row["model"]) % 2]
            drawn.plot([low / best, high / best], [at, at], color=color, linewidth=2.0)
            drawn.plot([1.0], [at], "o", color=color, markersize=4)
        drawn.axvline(1.0, color=CLEARANCE, linewidth=0.8)
        names = [plain(f"{row['name']}, {row['model']}, {row['reading']}") for row in rows[::-1]]
        drawn.set_yticks(range(len(rows)), names, fontsize=6.5)
        drawn.set_xlabel("interval of the parameter over its best value [1]", fontsize=8)
        return drawn


def _refusal(path: Path, rule: str) -> InputError:
    return InputError.of("file", shown_path(path), rule, "Run the same calibration again: it writes it anew")


def _shown(row: Mapping[str, Any], key: str) -> str:
    return f"{row.get('shown_factor', 1.0) * _number(row[key]) + row.get('shown_offset', 0.0):.3g}"


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)
