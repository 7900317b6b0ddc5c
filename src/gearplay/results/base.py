"""Base class of all results: dataset, message, figure, file, and construction from that file."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from gearplay.files.netcdf import write_dataset
from gearplay.model.case import Case
from gearplay.model.reading import load_case
from gearplay.results.provenance import KIND, provenance
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.memory import enough_memory

if TYPE_CHECKING:
    import xarray as xr


class AnalysisResult(ABC):
    """Base class of the results of public functions.

    Attributes: ``ds``, the numbers as an `xarray.Dataset` with units and provenance; ``message``, a summary as text;
    ``plot()``, a picture; `save`, whose file `gearplay.read_result` turns into the same object again.
    """

    result_kind: ClassVar[str]

    @property
    @abstractmethod
    def ds(self) -> xr.Dataset:
        """The numbers, SI, every variable with ``units`` and ``long_name``."""

    @property
    @abstractmethod
    def message(self) -> str:
        """Summary of the result as text."""

    @classmethod
    @abstractmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the object whose ``ds`` it was."""

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return further rows of the table in notebooks: name and value as text."""
        return ()

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write ``ds`` as netCDF-4, from which `gearplay.read_result` gives the same object back, or as CSV or MAT for others.

        Parameters
        ----------
        path
            The file, written atomically; its extension sets the format: ``.nc``, ``.csv`` or ``.mat``.
        overwrite
            Whether an existing file may be replaced.

        Raises
        ------
        InputError
            Where the ending is another, the file exists and ``overwrite`` is false, or it cannot be written.

        """
        self._write(path, overwrite=overwrite)

    @enough_memory()
    def _write(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        marked = self.ds.assign_attrs({KIND: self.result_kind})
        write_dataset(marked, Path(path), overwrite=overwrite)

    def __repr__(self) -> str:
        return f"<gearplay {self.result_kind}: {self.message}>"

    def _repr_html_(self) -> str:
        from html import escape

        from gearplay.pictures.pages import html_table

        return f"<p>{escape(self.message)}</p>{html_table(self.rows())}{self._picture()}"

    def _picture(self) -> str:
        """Return the picture of `plot` as HTML."""
        from html import escape

        from gearplay.pictures.canvas import to_png
        from gearplay.pictures.pages import data_uri

        drawn = self.plot()  # type: ignore[attr-defined]
        png = drawn.png if hasattr(drawn, "png") else to_png(getattr(drawn, "figure", drawn))
        return f'<img alt="{escape(self.result_kind)}" style="max-width: 42em" src="{data_uri(png)}">'


@dataclass(frozen=True, repr=False)
class OfDataset(AnalysisResult):
    """A result that consists of its dataset, with a summary and a picture."""

    dataset: xr.Dataset

    @property
    def ds(self) -> xr.Dataset:
        """The numbers, SI."""
        return self.dataset

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the object whose ``ds`` it was; `InputError` for that of another kind."""
        check_kind(dataset, cls.result_kind)
        return cls(dataset)


def case_in(dataset: xr.Dataset) -> Case:
    """Return the case behind a dataset; `InputError` where it names none, or one whose digest differs."""
    return case_of_attributes(dataset.attrs)


def case_of_attributes(attributes: Mapping[Any, Any]) -> Case:
    """Return the case that attributes hold; `InputError` as `case_in`."""
    if "case" not in attributes:
        raise InputError.of("dataset", "no case", "must name its case", "Write it again")
    case = load_case(json.loads(attributes["case"]))
    case = case.with_changed(json.loads(attributes.get("changed", "[]")))
    if attributes.get("case_sha256", case.sha256) != case.sha256:
        rule = f"must be the digest of the case in the file, which is {case.sha256[:12]}...: the case was changed afterwards"
        shown = str(attributes["case_sha256"])[:12] + "..."
        raise InputError.of("case_sha256", shown, rule, "Simulate the case again")
    return case


def check_kind(dataset: xr.Dataset, kind: str) -> None:
    """Raise `InputError` where a dataset is not the ``ds`` of a result of this kind."""
    found = dataset.attrs.get(KIND, kind)
    if found != kind:
        rule = f"must be that of a {kind}"
        raise InputError.of("dataset", str(found), rule, "Read it with read_result")


class Column(NamedTuple):
    """Column of one field in the dataset: its dimensions, unit and long name."""

    dims: tuple[str, ...]
    unit: str
    words: str


class Tabled(AnalysisResult):
    """A result with a ``case``: fields named in ``VARIABLES`` are arrays of its dataset, those in ``SCALARS`` attributes.

    ``SCALARS`` holds for each field the function that makes it of the attribute; fields that are no number or text are written as
    JSON. Complex fields have a last dimension ``part``, real and imaginary.
    """

    VARIABLES: ClassVar[Mapping[str, Column]]
    SCALARS: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}
    case: Case

    @property
    def ds(self) -> xr.Dataset:
        """The numbers as a dataset, SI."""
        import xarray as xr

        variables: dict[str, Any] = {}
        for name, (dims, unit, words) in self.VARIABLES.items():
            values = np.asarray(getattr(self, name))
            if values.dtype.kind == "c":
                values, dims = np.stack([values.real, values.imag], axis=-1), (*dims, "part")
            if values.dtype.kind == "b":
                values = values.astype(np.int8)
            if values.dtype.kind == "U":
                values = values.astype(object)
            attributes = {"units": unit, "long_name": words} if unit else {"long_name": words}
            variables[name] = (dims, values, attributes)
        scalars = {name: _attribute(getattr(self, name)) for name in self.SCALARS}
        return xr.Dataset(variables, attrs=provenance(self.case, **scalars))

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the object whose ``ds`` it was; `InputError` where something is missing."""
        check_kind(dataset, cls.result_kind)
        fields: dict[str, Any] = {}
        try:
            for name in cls.VARIABLES:
                values = dataset[name].values
                is_complex = "part" in dataset[name].dims
                fields[name] = values[..., 0] + 1j * values[..., 1] if is_complex else values
            fields |= {name: make(dataset.attrs[name]) for name, make in cls.SCALARS.items()}
        except (KeyError, ValueError) as error:
            rule = f"must be the saved result of a {cls.result_kind}"
            raise InputError.of("dataset", str(error), rule, "Write it again") from None
        return cls(**fields | {"case": case_in(dataset)})


def _attribute(value: Any) -> Any:
    plain = isinstance(value, (int, float, str)) and not isinstance(value, bool)
    return value if plain else json.dumps(value)
