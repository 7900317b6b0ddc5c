"""Result of `bifurcation`: sections of the settled motion over a field of the case."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.nonlinear.figures import bifurcation_drawing
from gearplay.pictures.words import offset_in, shown_in
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.outcomes import Account
from gearplay.results.provenance import provenance, signal_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
WHY_FAILED = "why a value failed"
BEGAN_WITH = "what a value began with, where not with the plain end of the one before it"


@dataclass(frozen=True, repr=False)
class Diagram(AnalysisResult):
    """A bifurcation diagram over a field: signals once per period, NaN where a value failed.

    ``values`` has shape [direction, parameter, period, signal], SI; ``parameters`` [SI] rise; ``reasons``, shape [direction,
    parameter], says why a value failed; ``starts``, of the same shape, what each value began with where that is not the plain
    end of the one before it: a fresh start and why, or a state that the step of the parameter pressed deeper into a contact.
    ``path`` is the field's, where the family is of one; ``settings`` is how it was made.
    """

    parameters: Floats
    directions: tuple[str, ...]
    values: Floats
    names: tuple[str, ...]
    reasons: tuple[tuple[str, ...], ...]
    starts: tuple[tuple[str, ...], ...]
    case: Case
    path: str
    settings: dict[str, Any]

    result_kind = "bifurcation"

    @property
    def ds(self) -> "xr.Dataset":
        """A variable for each signal over ``direction``, the field's name and ``section``; ``reason`` and ``start`` as text."""
        import xarray as xr

        name = self.path.rpartition(".")[2]
        variables: dict[str, Any] = {
            signal: (("direction", name, "section"), self.values[..., at], signal_words(signal))
            for at, signal in enumerate(self.names)
        }
        for variable, rows, words in (
            ("reason", self.reasons, WHY_FAILED),
            ("start", self.starts, BEGAN_WITH),
        ):
            texts = np.array(rows, dtype=object)
            variables[variable] = (("direction", name), texts, {"long_name": words})
        coordinates = {
            "direction": ("direction", np.array(self.directions, dtype=object)),
            name: (name, self.parameters, {"units": unit_at(self.case, self.path), "long_name": self.path}),
        }
        return xr.Dataset(variables, coords=coordinates, attrs=provenance(self.case, **self.settings))

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the diagram whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        names = tuple(str(name) for name in dataset.data_vars if name not in ("reason", "start"))
        axis = dataset[dataset["reason"].dims[1]]
        reasons, starts = (
            tuple(tuple(map(str, row)) for row in dataset[name].values) for name in ("reason", "start")
        )
        return cls(
            axis.values,
            tuple(str(way) for way in dataset["direction"].values),
            np.stack([dataset[name].values for name in names], axis=-1),
            names,
            reasons,
            starts,
            case_in(dataset),
            str(axis.attrs["long_name"]),
            {name: dataset.attrs[name] for name in ("settle", "keep", "period", "carried")},
        )

    @property
    def account(self) -> Account:
        """Number of computed values, each way, and reasons of failures."""
        reasons = np.array(self.reasons, dtype=object)
        return Account.of(np.array(reasons != "", dtype=np.int64), reasons)

    @property
    def interruptions(self) -> tuple[str, ...]:
        """A text for each value whose start is not the final state of the previous value, or presses a contact deeper."""
        unit = unit_at(self.case, self.path)
        return tuple(
            f"{way} at {value:.6g} {unit}: {start}"
            for way, row in zip(self.directions, self.starts, strict=False)
            for value, start in zip(self.parameters, row, strict=True)
            if start
        )

    @property
    def message(self) -> str:
        """Range of the field, number of failures, and the first value that did not continue from the previous one."""
        unit, factor = shown_in(unit_at(self.case, self.path), float(np.abs(self.parameters).max()))
        low, high = factor * self.parameters[[0, -1]] + offset_in(unit)
        ways = " and ".join(self.directions)
        span = f"{low:.4g} to {high:.4g}" + (f" {unit}" if unit not in ("", "1") else "")
        text = f"{self.path} from {span}, {len(self.parameters)} values {ways}; {self.account}"
        found = self.interruptions
        if found:
            more = f", and at {len(found) - 1} more" if len(found) > 1 else ""
            text += f". {found[0][0].upper()}{found[0][1:]}{more}"
        return text

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the reasons of failures with their counts, and the values that did not continue from the previous one."""
        failed = [(f"{count} failed", reason) for reason, count in self.account.reasons]
        return [*failed, *(("start", each) for each in self.interruptions)]

    def plot(self, *, title: str = "") -> "Figure":
        """Draw every section of each signal over the field, both ways in their colours; returns the figure."""
        drawn: Figure = bifurcation_drawing(self.ds, self.names, title=title)
        return drawn
