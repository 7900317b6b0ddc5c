"""Claimed patterns, and the share of points that show each, with Wilson's intervals."""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.published.article import LINE_WORDS, LINES, Condition, conditions, printed
from gearplay.published.claims.points import MODELS, PointResult

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Z_95 = 1.959964
OVERALL = "vibration"
"""The mean of the three lines' logarithms: how strongly the driven gear vibrates."""
MEASURES = (OVERALL, *LINES)
_AT = {condition: k for k, condition in enumerate(conditions())}


def _at(speed: float, clearance: float, backlash: float) -> int:
    return _AT[Condition(speed, clearance, backlash)]


SLOW, MIDDLE, FAST = (_at(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0))
WIDE_SLEEVE, WIDE_TEETH, WIDE_BOTH = (
    _at(120.0, 200.0, 100.0),
    _at(120.0, 100.0, 200.0),
    _at(120.0, 200.0, 200.0),
)


def levels(amplitudes: Floats, measure: str) -> Floats:
    """Return the level [decades] of a measure from amplitudes, shape [..., condition, line] to [..., condition]."""
    logs = np.log10(np.maximum(amplitudes, 1e-300))
    return np.asarray(logs.mean(axis=-1) if measure == OVERALL else logs[..., LINES.index(measure)])


def _largest(level: Floats, first: int, others: Sequence[int]) -> Bools:
    return np.asarray(np.all([level[..., first] > level[..., k] for k in others], axis=0))


PATTERNS: dict[str, tuple[str, Callable[[Floats], Bools]]] = {
    "peak_120": ("largest at 120 rpm", lambda v: _largest(v, MIDDLE, (SLOW, FAST))),
    "growth": ("grows with the speed", lambda v: _largest(v, FAST, (MIDDLE,)) & _largest(v, MIDDLE, (SLOW,))),
    "peak_200_100": ("largest at 200/100 um", lambda v: _largest(v, WIDE_SLEEVE, (WIDE_TEETH, WIDE_BOTH))),
    "peak_200_200": ("largest at 200/200 um", lambda v: _largest(v, WIDE_BOTH, (WIDE_SLEEVE, WIDE_TEETH))),
}
"""Patterns of one model over the conditions: words, and the test on levels of shape [..., condition]."""


@dataclass(frozen=True)
class Share:
    """How often something was seen, with its 95 % interval after Wilson, J. Am. Stat. Assoc. 22 (1927) 209."""

    count: int
    of: int

    @property
    def share(self) -> float:
        """The observed share; NaN of none."""
        return self.count / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Return both ends.

        >>> tuple(round(end, 3) for end in Share(3, 10).interval)
        (0.108, 0.603)
        """
        n, p, z = self.of, self.share, Z_95
        if n == 0:
            return 0.0, 1.0
        middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n)
        half = z / (1.0 + z * z / n) * math.sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def to_dict(self) -> dict[str, Any]:
        """Return count, share and interval."""
        low, high = self.interval
        return {**asdict(self), "share": self.share, "low": low, "high": high}


def _share(seen: Bools) -> Share:
    return Share(int(np.count_nonzero(seen)), int(seen.size))


def pattern_shares(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return a row for each pattern, model and measure: shares in ensembles and in single runs.

    Single runs of one point and model count as members; the interval is of the points' ensembles.
    """
    rows = []
    for pattern, (words, test) in PATTERNS.items():
        for model in MODELS:
            good = [r for r in results if r.model == model and not r.reason]
            if not good:
                continue
            ensemble = np.array([r.ensemble for r in good])
            single = np.concatenate([r.single for r in good])
            single = single[np.all(np.isfinite(single), axis=(1, 2))]
            for measure in MEASURES:
                seen = test(levels(ensemble, measure))
                rows.append(
                    {
                        "pattern": pattern,
                        "words": words,
                        "model": model,
                        "measure": measure,
                        **_share(seen).to_dict(),
                        "single_runs": float(np.mean(test(levels(single, measure)))),
                        "points": [good[k].point for k in np.flatnonzero(seen)] if measure == OVERALL else [],
                    }
                )
    return rows


def coupling_ratios(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return, by formulation and condition, coupled over uncoupled at the same point: median, quartiles, share above 1.

    The last row of a formulation is all six conditions at once: the share of points where coupled is above everywhere.
    """
    found = {(r.model, r.point): r for r in results if not r.reason}
    rows = []
    for formulation, suffix in (("geometric", ""), ("as published", "_as_published")):
        pairs = [
            (found[f"coupled{suffix}", p].ensemble, found[f"uncoupled{suffix}", p].ensemble)
            for p in sorted({point for _, point in found})
            if (f"coupled{suffix}", p) in found and (f"uncoupled{suffix}", p) in found
        ]
        if not pairs:
            continue
        decades = levels(np.array([a for a, _ in pairs]), OVERALL) - levels(
            np.array([b for _, b in pairs]), OVERALL
        )
        for k, condition in enumerate(conditions()):
            low, middle, high = np.percentile(decades[:, k], [25.0, 50.0, 75.0])
            rows.append(
                {
                    "formulation": formulation,
                    "condition": condition.label,
                    "median": float(10.0**middle),
                    "low": float(10.0**low),
                    "high": float(10.0**high),
                    "above": _share(decades[:, k] > 0.0).to_dict(),
                }
            )
        everywhere = _share(np.all(decades > 0.0, axis=1)).to_dict()
        rows.append({"formulation": formulation, "condition": "all six", "above": everywhere})
    return rows


def share_of(
    rows: Sequence[dict[str, Any]], pattern: str, model: str, measure: str = OVERALL
) -> dict[str, Any]:
    """Return the row of one pattern, model and measure."""
    return next(r for r in rows if (r["pattern"], r["model"], r["measure"]) == (pattern, model, measure))


def is_favoured(rows: Sequence[dict[str, Any]], pattern: str, model: str, controls: Sequence[str]) -> bool:
    """Return whether a model's interval lies above those of all its controls."""
    return all(share_of(rows, pattern, model)["low"] > share_of(rows, pattern, c)["high"] for c in controls)


def wedging(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return, by model and condition, the share of points in which the backlash turns negative, and for how much of the time."""
    rows = []
    for model in MODELS:
        good = [r for r in results if r.model == model and not r.reason]
        for k, condition in enumerate(conditions() if good else ()):
            shares = np.array([r.wedged[k] for r in good])
            rows.append(
                {
                    "model": model,
                    "condition": condition.label,
                    **_share(shares > 0.0).to_dict(),
                    "time": float(np.mean(shares)),
                }
            )
    return rows


def dropped(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return the points that were dropped, each with its reason."""
    return [{"model": r.model, "point": r.point, "reason": r.reason} for r in results if r.reason]


def shown_by_the_test() -> dict[str, bool]:
    """Return whether the measured amplitudes, as printed, show each pattern in the vibration."""
    table = np.array(
        [[printed(c, line, "amplitude_as_printed").test for line in LINES] for c in conditions()]
    )
    return {name: bool(test(levels(table, OVERALL))) for name, (_, test) in PATTERNS.items()}


MEASURE_WORDS = {OVERALL: "vibration", **LINE_WORDS}
