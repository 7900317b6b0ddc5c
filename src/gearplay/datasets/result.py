"""Result of `make_dataset`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.results.base import OfDataset
from gearplay.results.outcomes import Account
from gearplay.results.provenance import provenance

if TYPE_CHECKING:
    from gearplay.datasets.evaluate import Dataset


@dataclass(frozen=True, repr=False)
class DatasetResult(OfDataset):
    """The table of labels of a data set, with a variable over ``record`` for each column.

    Attributes: ``ds``, SI; ``account``, how many records ended how; ``message``. The records are files in ``folder``.
    """

    result_kind = "dataset"

    @property
    def folder(self) -> str:
        """Folder that the column ``path`` counts from."""
        return str(self.dataset.attrs["folder"])

    @property
    def account(self) -> Account:
        """Number of records by status."""
        return Account.of(self.dataset["status"].values, self.dataset["reason"].values)

    @property
    def message(self) -> str:
        """Title, account and records of each part as text."""
        title = str(self.dataset.attrs.get("title", ""))
        account = str(self.account).replace("case", "record", 1)
        parts = ", ".join(f"{name} {count}" for name, count in self._parts())
        return f"{title + ': ' if title else ''}{account}; {parts}"

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the number of records of each label, and reasons of failures."""
        done = self.dataset["status"].values == 0
        counts = Counter(str(each) for each in self.dataset["label"].values[done])
        return [
            *((label, f"{count} records") for label, count in counts.items()),
            *((f"{count} failed", reason) for reason, count in self.account.reasons),
        ]

    def plot(self) -> Any:
        """Return a figure of the rms values by label and part of the split."""
        from gearplay.datasets.figures import levels_figure

        return levels_figure(self.dataset)

    def _parts(self) -> list[tuple[str, int]]:
        done = self.dataset["status"].values == 0
        counts = Counter(str(each) for each in self.dataset["split"].values[done])
        return [(name, counts[name]) for name in ("train", "validation", "test")]


def result_of(made: Dataset, table: Sequence[Mapping[str, Any]], folder: str) -> DatasetResult:
    """Return the result of a table of labels, row by row."""
    import xarray as xr

    from gearplay.datasets.data_sheet import WORDS
    from gearplay.datasets.folder import numbers_of

    units = made.recipe.columns()
    variables: dict[str, Any] = {}
    for name in [*WORDS, *units, *numbers_of(made.sensors), "status", "reason"]:
        values = [row.get(name, np.nan) for row in table]
        texts = any(isinstance(value, str) for value in values)
        array = np.array([str(v) for v in values], dtype=object) if texts else np.array(values)
        words = {"long_name": WORDS.get(name, name.replace("_", " "))}
        unit = units.get(name, "m/s^2" if name.startswith(("rms", "peak")) else "")
        variables[name] = ("record", array, words | ({"units": unit} if unit else {}))
    number = variables.pop("record")
    about = provenance(made.recipe.base, title=made.plan.title or "Data set", name="base_case", folder=folder)
    return DatasetResult(xr.Dataset(variables, coords={"record": number}, attrs=about))
