"""Result of a diagnosis."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.results.base import OfDataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Diagnosis(OfDataset):
    """Ranked hypotheses about a machine, with the evidence of a record.

    ``ds``: ``confidence`` and ``strength`` (hypothesis), the likeliest first; ``evidence_value`` against
    ``evidence_threshold`` (evidence) with ``evidence_words`` and ``evidence_of``, the hypothesis; ``line_frequency`` [Hz],
    ``line_amplitude``, ``line_prominence`` (line) with ``line_name``, ``line_domain``, ``line_expected`` [Hz] and
    ``line_healthy``, the amplitude in the healthy record; ``index_value``, ``index_healthy`` (index) with ``index_name``;
    ``shaft_speed`` [Hz] with its uncertainty; ``spectrum`` (frequency), ``envelope`` (envelope_frequency). Where causes were
    simulated: ``check_deviation``, ``check_spread``, ``check_alike``, ``check_level`` (check), the best agreement first;
    ``feature_record``, ``feature_spread`` (feature) and ``feature_simulated`` (check, feature), decimal logarithms.
    """

    result_kind = "diagnosis"

    @property
    def message(self) -> str:
        """The first hypothesis and its confidence, or that the record cannot decide, as text."""
        return str(self.dataset.attrs["summary"])

    @property
    def told(self) -> bool:
        """Whether a damage has the stated confidence or more."""
        return bool(self.dataset.attrs["told"])

    @property
    def causes(self) -> list[str]:
        """Names of the stated hypotheses, the likeliest first: several occur together."""
        found: list[str] = json.loads(self.dataset.attrs["causes"])
        return found

    @property
    def cannot_be_told(self) -> list[str]:
        """Questions that the record cannot decide, one sentence each."""
        found: list[str] = json.loads(self.dataset.attrs["cannot_be_told"])
        return found

    def hypotheses(self) -> list[dict[str, Any]]:
        """Return the hypotheses, the likeliest first, each with ``confidence`` and its ``evidence``, as plain tables."""
        ds = self.dataset
        every: list[dict[str, Any]] = [
            {"name": str(name), "confidence": float(share), "evidence": []}
            for name, share in zip(ds["hypothesis"].values, ds["confidence"].values, strict=True)
        ]
        for of, words, value, threshold in zip(
            *(ds[f"evidence_{name}"].values for name in ("of", "words", "value", "threshold")), strict=True
        ):
            row = {"words": str(words), "value": float(value), "threshold": float(threshold)}
            every[int(of)]["evidence"].append(row)
        return every

    def checks(self) -> list[dict[str, Any]]:
        """Return the simulated causes as plain tables, the best agreement first; none where nothing was simulated.

        ``deviation`` is the root mean square of the features' deviations from the simulated ones, over spread and allowed error,
        ``spread`` its standard error; ``alike`` is true of those that agree with the record no worse than the best by chance.
        """
        ds = self.dataset
        if "check" not in ds.coords:
            return []
        columns = [
            ds[name].values
            for name in ("check", "check_level", "check_hypothesis", "check_deviation", "check_spread")
        ]
        rows = zip(*columns, ds["check_alike"].values, strict=True)
        return [
            {"name": str(name), "level": str(level), "hypothesis": str(hypothesis), "deviation": float(deviation),
             "spread": float(spread), "alike": bool(alike)}
            for name, level, hypothesis, deviation, spread, alike in rows
        ]  # fmt: skip

    def lines(self, domain: str = "") -> list[dict[str, Any]]:
        """Return the named lines as plain tables, of one ``domain`` where it is given."""
        ds, names = (
            self.dataset,
            ("name", "domain", "expected", "frequency", "amplitude", "prominence", "healthy"),
        )
        rows = zip(*(ds[f"line_{name}"].values for name in names), strict=True)
        found = [
            {n: str(v) if isinstance(v, str) else float(v) for n, v in zip(names, row, strict=True)}
            for row in rows
        ]
        return [row for row in found if domain in ("", row["domain"])]

    def indices(self) -> list[dict[str, Any]]:
        """Return the indices as plain tables."""
        ds = self.dataset
        rows = zip(*(ds[f"index_{name}"].values for name in ("name", "value", "healthy")), strict=True)
        return [
            {"name": str(name), "value": float(value), "healthy": float(healthy)}
            for name, value, healthy in rows
        ]

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a row for each hypothesis that has some confidence, with its evidence."""
        found: list[tuple[str, str]] = []
        for each in self.hypotheses():
            if each["confidence"] < 0.02 and found:
                continue
            words = [
                f"{e['words']} {e['value']:.3g} (counts from {e['threshold']:.3g})" for e in each["evidence"]
            ]
            found.append((each["name"], f"{each['confidence']:.2f}{'; ' if words else ''}{'; '.join(words)}"))
        for check in self.checks():
            level = f" ({check['level']})" if check["level"] else ""
            row = f"deviation {check['deviation']:.2f} ± {check['spread']:.2f}"
            found.append((f"simulated: {check['name']}{level}", row))
        return found

    def plot(self) -> Figure:
        """Draw confidences, the spectrum and the envelope spectrum with their named lines; return the figure."""
        from gearplay.diagnosis.figures import diagnosis_drawing

        drawn: Figure = diagnosis_drawing(self.dataset)
        return drawn


def texts(values: Sequence[str]) -> Any:
    """Return texts as an array for a dataset."""
    found = np.empty(len(values), dtype=object)
    found[:] = list(values)
    return found
