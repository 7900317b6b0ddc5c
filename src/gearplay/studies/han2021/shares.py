"""Claimed patterns over the points, and distances of runs of one model: shares, intervals, sentences."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.studies.han2021 import article
from gearplay.studies.han2021.article import AMPLITUDE, LINE_WORDS, LINES, Floats, conditions, printed
from gearplay.studies.han2021.comparison import holm

Bools = NDArray[np.bool_]
MODELS = ("coupled", "uncoupled", "coupled_as_published", "uncoupled_as_published")
OVERALL = "vibration"
"""The mean of the three lines' logarithms."""
MEASURES = (OVERALL, *LINES)
MEASURE_WORDS = {OVERALL: OVERALL, **LINE_WORDS}
SLOW, MIDDLE, FAST, WIDE_SLEEVE, WIDE_TEETH, WIDE_BOTH = range(6)  # places of the conditions
RARE = 0.05
"""A pattern is rare where even the upper end of its share is below this."""
DRAWS = (1, 2, 3, 5, 8, 12, 20, 32, 48)
"""Numbers of runs of which the best is picked."""


class PointResult(NamedTuple):
    """One point with one model: amplitudes [m/s^2] of f_r, f_m, 2 f_m under the six conditions, in print order.

    ``ensemble`` has shape [condition, line], ``single`` [member, condition, line], of each member by itself; NaN for a member
    that did not finish. ``wedged`` is the share of time with negative backlash, by condition. A point that was dropped has a
    ``reason`` and nothing else.
    """

    model: str
    point: int
    ensemble: Floats = np.empty((0, 0))
    single: Floats = np.empty((0, 0, 0))
    wedged: tuple[float, ...] = ()
    reason: str = ""

    def to_part(self) -> dict[str, Any]:
        """Return the JSON-able form, rounded to six digits."""
        tables = {name: _digits(getattr(self, name), 6) for name in ("ensemble", "single")}
        return {**self._asdict(), **tables, "wedged": _digits(np.array(self.wedged), 4)}

    @classmethod
    def from_part(cls, part: dict[str, Any]) -> "PointResult":
        """Return a point's result from its JSON-able form."""
        tables = {name: np.array(part[name]) for name in ("ensemble", "single")}
        return cls(**{**part, **tables, "wedged": tuple(part["wedged"])})


def _digits(values: Floats, digits: int) -> Any:
    return np.reshape([float(f"{v:.{digits}g}") for v in values.ravel()], values.shape).tolist()


def levels(amplitudes: Floats, measure: str = OVERALL) -> Floats:
    """Return the level [decades] of a measure from amplitudes, shape [..., condition, line] to [..., condition]."""
    logs = np.log10(np.maximum(amplitudes, 1e-300))
    return np.asarray(logs.mean(axis=-1) if measure == OVERALL else logs[..., LINES.index(measure)])


def _largest(first: int, *others: int) -> Callable[[Floats], Bools]:
    return lambda level: np.asarray(np.all([level[..., first] > level[..., k] for k in others], axis=0))


PATTERNS: dict[str, tuple[str, Callable[[Floats], Bools]]] = {
    "peak_120": ("largest at 120 rpm", _largest(MIDDLE, SLOW, FAST)),
    "growth": (
        "grows with the speed",
        lambda level: np.asarray(np.all(np.diff(level[..., [SLOW, MIDDLE, FAST]]) > 0.0, axis=-1)),
    ),
    "peak_200_100": ("largest at 200/100 um", _largest(WIDE_SLEEVE, WIDE_TEETH, WIDE_BOTH)),
    "peak_200_200": ("largest at 200/200 um", _largest(WIDE_BOTH, WIDE_SLEEVE, WIDE_TEETH)),
}
"""Patterns of one model over the conditions: text, and the test on levels of shape [..., condition]."""


def share(present: Bools) -> dict[str, Any]:
    """Return count, number and share, with the 95 % interval after Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    >>> found = share(np.arange(10) < 3)
    >>> found["count"], round(found["low"], 3), round(found["high"], 3)
    (3, 0.108, 0.603)
    """
    from scipy.stats import binomtest

    count, of = int(np.count_nonzero(present)), int(present.size)
    ends = binomtest(count, of).proportion_ci(0.95, method="wilson")
    return {"count": count, "of": of, "share": count / of, "low": float(ends.low), "high": float(ends.high)}


def _good(results: Sequence[PointResult], model: str) -> dict[int, PointResult]:
    return {r.point: r for r in results if r.model == model and not r.reason}


def _ensembles(results: Sequence[PointResult]) -> Floats:
    return np.array([r.ensemble for r in results])


def _singles(results: Sequence[PointResult]) -> Floats:
    """Return the amplitudes of all single runs that finished, shape [run, condition, line]."""
    single = np.concatenate([r.single for r in results])
    return np.asarray(single[np.all(np.isfinite(single), axis=(1, 2))])


def pattern_shares(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return a row for each pattern, model and measure: shares in ensembles and in single runs.

    Single runs of one point and model count as members; the interval is of the points' ensembles.
    """
    table = []
    for pattern, (words, test) in PATTERNS.items():
        for model in MODELS:
            good = list(_good(results, model).values())
            for measure in MEASURES if good else ():
                present = test(levels(_ensembles(good), measure))
                row: dict[str, Any] = {"pattern": pattern, "words": words, "model": model, "measure": measure}
                row |= share(present)
                row["single_runs"] = float(np.mean(test(levels(_singles(good), measure))))
                row["points"] = [good[k].point for k in np.flatnonzero(present)] if measure == OVERALL else []
                table.append(row)
    return table


def share_of(table: Sequence[dict[str, Any]], pattern: str, model: str) -> dict[str, Any]:
    """Return the row of a pattern and a model for the overall measure."""
    return next(r for r in table if (r["pattern"], r["model"], r["measure"]) == (pattern, model, OVERALL))


def coupling_ratios(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return, by formulation and condition, coupled over uncoupled at the same point: median, quartiles, share above 1.

    The last row of a formulation is all six conditions at once: the share of points where coupled is above everywhere.
    """
    table: list[dict[str, Any]] = []
    for formulation, suffix in (("geometric", ""), ("as published", "_as_published")):
        coupled, uncoupled = (_good(results, f"{model}{suffix}") for model in ("coupled", "uncoupled"))
        both = sorted(coupled.keys() & uncoupled.keys())
        if not both:
            continue
        one, other = (levels(_ensembles([each[point] for point in both])) for each in (coupled, uncoupled))
        decades = one - other
        for k, condition in enumerate(conditions()):
            middle, low, high = (10.0**q for q in np.percentile(decades[:, k], [50.0, 25.0, 75.0]).tolist())
            ratios = {"median": middle, "low": low, "high": high}
            above = share(decades[:, k] > 0.0)
            table.append({"formulation": formulation, "condition": condition.label, **ratios, "above": above})
        everywhere = share(np.all(decades > 0.0, axis=1))
        table.append({"formulation": formulation, "condition": "all six", "above": everywhere})
    return table


def wedging(results: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return, by model and condition, the share of points with negative backlash, and its mean share of time."""
    table = []
    for model in MODELS:
        wedged = np.array([r.wedged for r in _good(results, model).values()])
        for condition, times in zip(conditions() if len(wedged) else (), wedged.T, strict=True):
            row = {"model": model, "condition": condition.label, **share(times > 0.0)}
            table.append({**row, "time": float(np.mean(times))})
    return table


def repeated(results: Sequence[PointResult], finer: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return a row for each pattern and model: the number of points that show it in the vibration, at both tolerances.

    The motion is chaotic: at another tolerance a point has other runs, and points near a pattern's limit change sides, ``lost``
    and ``gained``. ``p`` is of the exact test of McNemar, Psychometrika 12 (1947) 153, that both are equally likely; ``agree``
    where it is not significant after Holm's correction for all rows. ``single_runs`` are the shares of single runs at both
    tolerances.
    """
    from scipy.stats import binomtest

    table: list[dict[str, Any]] = []
    for pattern, (words, test) in PATTERNS.items():
        for model in MODELS:
            first, second = (_good(each, model) for each in (results, finer))
            points = sorted(first.keys() & second.keys())
            if not points:
                continue
            pair = [[each[point] for point in points] for each in (first, second)]
            one, other = (test(levels(_ensembles(each))) for each in pair)
            lost, gained = int(np.sum(one & ~other)), int(np.sum(~one & other))
            table.append(
                {
                    "pattern": pattern,
                    "words": words,
                    "model": model,
                    "of": len(points),
                    "first": int(np.sum(one)),
                    "finer": int(np.sum(other)),
                    "lost": lost,
                    "gained": gained,
                    "p": float(binomtest(lost, lost + gained).pvalue) if lost + gained else 1.0,
                    "single_runs": [float(np.mean(test(levels(_singles(each))))) for each in pair],
                }
            )
    apart = holm([row["p"] for row in table])
    return [{**row, "agree": not each} for row, each in zip(table, apart, strict=True)]


def shown_by_the_test() -> dict[str, bool]:
    """Return whether the measured amplitudes, as printed, show each pattern in the vibration."""
    table = levels(printed("test", AMPLITUDE))
    return {name: bool(test(table)) for name, (_, test) in PATTERNS.items()}


def pair_errors(amplitudes: Floats) -> Floats:
    """Return the mean error [%] of each run (second index) as the model of each other (first index), one factor free.

    The diagonal is NaN. ``amplitudes`` has shape [run, condition, line].
    """
    flat = amplitudes.reshape(len(amplitudes), -1)
    errors = np.full((len(flat), len(flat)), np.nan)
    for i, test in enumerate(flat):
        for j, model in enumerate(flat):
            if i != j:
                errors[i, j] = article.mean_error(test, model, article.best_factor(test, model))
    return errors


def condition_errors(amplitudes: Floats) -> Floats:
    """Return the mean error [%] of one condition's three lines, run against run, shape [condition, run, run]; diagonal NaN."""
    test, model = amplitudes[:, None], amplitudes[None, :]
    errors = np.moveaxis(100.0 * np.mean(np.abs(model / test - 1.0), axis=-1), -1, 0)
    errors[:, np.eye(len(amplitudes), dtype=bool)] = np.nan
    return np.asarray(errors)


def best_of(errors: Floats, draws: int) -> float:
    """Return the expected least of ``draws`` entries of each row, drawn without replacement, mean over rows; NaN is no entry.

    With the entries of a row in rising order, the k-th of m is the least of n with probability C(m - k, n - 1) / C(m, n).

    >>> best_of(np.array([[1.0, 2.0, 3.0]]), 2)
    1.3333333333333333
    """
    totals = []
    for row in errors:
        known = np.sort(row[np.isfinite(row)])
        m, all_draws = known.size, math.comb(known.size, draws)
        weights = [math.comb(m - k - 1, draws - 1) / all_draws for k in range(m)]
        totals.append(float(np.dot(known, weights)))
    return float(np.mean(totals))


def floor_of(amplitudes: Floats, duration: float, limit: float) -> dict[str, Any]:
    """Return the distances of single runs of one model: quantiles over pairs, and curves of the best of n.

    ``amplitudes`` has shape [run, condition, line], ``limit`` [%] is the error that the article reports.
    """
    errors, free = pair_errors(amplitudes), condition_errors(amplitudes)
    known = errors[np.isfinite(errors)]
    draws = [n for n in DRAWS if n < len(amplitudes)]
    return {
        "record": duration,
        "runs": len(amplitudes),
        "pairs": int(known.size),
        "limit": limit,
        "within_limit": int(np.count_nonzero(known <= limit)),
        "quantiles": {str(q): float(np.percentile(known, q)) for q in (0, 5, 25, 50, 75, 95)},
        "draws": draws,
        "best_of": [best_of(errors, n) for n in draws],
        "free_per_condition": [float(np.mean([best_of(each, n) for each in free])) for n in draws],
    }


def runs_needed(floor: Mapping[str, Any], curve: str) -> int | None:
    """Return the least number of runs whose best comes within the limit on a curve; None beyond its end."""
    pairs = zip(floor["draws"], floor[curve], strict=True)
    return next((n for n, error in pairs if error <= floor["limit"]), None)


def tolerance_words(document: Mapping[str, Any]) -> str:
    """Return in one or two sentences whether a finer tolerance gives the same shares, naming those that it does not."""
    table, settings = document["repeated"], document["settings"]
    if not table:
        return "No point could be compared with itself at a finer tolerance."
    points = max(row["of"] for row in table)
    words = f"The first {points} points again at a tolerance of {settings['finer_tolerance']:g}"
    apart = [
        f"{article.shown(row['words'])}, {row['model'].replace('_as_published', ' as printed')}:"
        f" {row['first']} and {row['finer']} of {row['of']}"
        for row in table
        if not row["agree"]
    ]
    if apart:
        return f"{words}: {len(apart)} of {len(table)} shares differ ({'; '.join(apart)})."
    most = max(table, key=lambda row: abs(row["first"] - row["finer"]))
    single = 100.0 * max(abs(row["single_runs"][0] - row["single_runs"][1]) for row in table)
    return (
        f"{words}: none of the {len(table)} shares differs significantly (McNemar's test, Holm's correction, 5 %). Points"
        f" at which a pattern comes and goes change sides, at most from {most['first']} to {most['finer']} of {most['of']};"
        f" shares of single runs differ by at most {single:.1f} percentage points."
    )


def favoured_words(document: Mapping[str, Any]) -> str:
    """Return in one sentence whether the interval of the peak at 200/100 um lies higher with the printed, coupled equations."""
    favoured, *controls = (
        share_of(document["shares"], "peak_200_100", model)
        for model in ("coupled_as_published", "uncoupled_as_published", "coupled")
    )
    makes = "the printed, coupled equations make that peak"
    if favoured["low"] <= max(each["high"] for each in controls):
        makes = f"whether {makes} cannot be told"
    return (
        f"Largest at 200/100 µm in {_words(favoured)} of the points with the coupled equations as printed,"
        f" {_words(controls[0])} uncoupled as printed, {_words(controls[1])} with exact flanks: {makes}."
    )


def is_rare(document: Mapping[str, Any]) -> bool:
    """Return whether the peak at 120 rpm with exact flanks is rarer than `RARE`, with 95 % confidence."""
    return bool(share_of(document["shares"], "peak_120", "coupled")["high"] < RARE)


def rare_words(document: Mapping[str, Any]) -> str:
    """Return in one sentence how rare the peak at 120 rpm is with exact flanks, naming the points that show it."""
    row = share_of(document["shares"], "peak_120", "coupled")
    words = f"Largest at 120 rpm in {_words(row)} of the points with exact flanks, coupled"
    if is_rare(document):
        return f"{words}: fewer than {100.0 * RARE:.0f} % with 95 % confidence."
    where = f"; seen at points {', '.join(map(str, row['points']))}" if row["points"] else ""
    return f"{words}, so that {100.0 * RARE:.0f} % cannot be excluded{where}."


def _words(row: dict[str, Any]) -> str:
    return f"{100.0 * row['share']:.0f} % ({100.0 * row['low']:.0f} to {100.0 * row['high']:.0f} %)"
