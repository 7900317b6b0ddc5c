"""Comparison with the printed test: amplitudes and frequencies of each model, and tests of their differences."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.studies.han2021 import article
from gearplay.studies.han2021.article import (
    AMPLITUDE,
    FREQUENCY,
    LINE_WORDS,
    LINES,
    MODELS,
    Floats,
    conditions,
    printed,
)
from gearplay.studies.han2021.simulation import SWITCHED, ConditionResult, SimulatedLine

RESAMPLES = 400
LASTING = 1.5
"""Factor by which the amplitude of f_r may change later on and still count as lasting."""
REPRODUCED, EXPLAINED, CONTRADICTED, OPEN = GROUPS = ("reproduced", "explained", "contradicted", "open")
"""Verdicts on a claim."""
CLEAR = 2.0  # standard errors
VERDICT_WORDS = {REPRODUCED: "yes", CONTRADICTED: "no", OPEN: "cannot be told"}


@dataclass(frozen=True)
class ModelResult:
    """Results of one variant under the six conditions, in print order; arrays have shape [condition, line]."""

    results: tuple[ConditionResult, ...]

    def line(self, condition: article.Condition, line: int) -> SimulatedLine:
        """Return one line under one condition."""
        return self.results[conditions().index(condition)].lines[line]

    def table(self, name: str) -> Floats:
        """Return a property of the lines: frequency [Hz], amplitude [m/s^2], displacement [m], spread [decades], prominence."""
        return np.array([[getattr(line, name) for line in r.lines] for r in self.results])

    @cached_property
    def amplitude(self) -> Floats:
        """Amplitudes [m/s^2]."""
        return self.table("amplitude")

    @cached_property
    def factor(self) -> float:
        """Common factor of an un-normalised FFT, printed = factor x acceleration: the geometric mean of their ratios."""
        return log_factor(printed("test", AMPLITUDE).ravel(), self.amplitude.ravel())

    def amplitude_error(self, *, as_displacement: bool = False) -> float:
        """Return the mean error [%] of the 18 amplitudes, times the common factor or as displacement [um]."""
        ours = 1e6 * self.table("displacement") if as_displacement else self.factor * self.amplitude
        return article.mean_error(printed("test", AMPLITUDE).ravel(), ours.ravel())

    def radial_error(self) -> float:
        """Return the mean error [%] of the six radial frequencies f_r."""
        test = printed("test", FREQUENCY)[:, 0]
        return float(np.mean(100.0 * np.abs(self.table("frequency")[:, 0] - test) / test))

    @property
    def lasting_shares(self) -> list[float]:
        """Shares of f_r's amplitude that are left later on, for each condition in which they were computed."""
        return [r.lasting for r in self.results if r.lasting is not None]

    @property
    def swing_lasts(self) -> bool:
        """Whether f_r is as strong later on: by geometric mean over the conditions, within a factor `LASTING`.

        Under one condition a swing that a floor excites may be half as strong or twice, by chance.
        """
        shares = self.lasting_shares
        return not shares or bool(abs(np.mean(np.log(shares))) < math.log(LASTING))

    @property
    def shaking(self) -> float:
        """Rms acceleration of the floor [mm/s^2], the same under every condition; 0 at rest."""
        return 1e3 * self.results[0].floor


Models = Mapping[str, ModelResult]


def by_model(results: Sequence[ConditionResult]) -> dict[str, ModelResult]:
    """Return the results by variant; each must have all six conditions."""
    found = {r.model: [each for each in results if each.model == r.model] for r in results}
    for each in found.values():
        each.sort(key=lambda result: conditions().index(result.condition))
        assert [result.condition for result in each] == list(conditions())
    return {name: ModelResult(tuple(each)) for name, each in found.items()}


def log_factor(test: Floats, simulated: Floats) -> float:
    """Return the common factor between two sets of amplitudes: the geometric mean of test over simulated."""
    return float(np.exp(np.mean(np.log(test / simulated))))


def log_error(test: Floats, simulated: Floats) -> float:
    """Return the mean |log10| of test over simulated, with their common factor [decades]; it does not favour small values."""
    return float(np.mean(np.abs(np.log10(log_factor(test, simulated) * simulated / test))))


def table_rows(models: Models, *, calibrated: bool) -> list[dict[str, Any]]:
    """Return every row of Tables 3-6 with the simulated values, recomputed errors [%], spreads and marks.

    Amplitude rows have the simulated acceleration [m/s^2], the same times the fitted factor (the un-normalised reading), and the
    displacement [um] (the displacement reading). ``spread`` is the members' standard deviation in decades. With ``calibrated``
    parameters each row also has the error of a fit without its condition.
    """
    found = []
    for row in article.rows():
        test = row.values["test"]
        entry: dict[str, Any] = {"table": row.table, **row.condition._asdict()}
        entry |= {"line": row.line, "quantity": row.quantity, "test": test}
        for model in MODELS:
            ours = models[model]
            theirs = f"article_{model}"
            entry[theirs] = row.values[model]
            entry[f"{theirs}_error_printed_pct"] = row.printed_errors[model]
            entry[f"{theirs}_error_recomputed_pct"] = row.error(model)
            entry[f"{theirs}_error_follows"] = row.follows(model)
            line = ours.line(row.condition, row.place[1])
            if row.quantity == FREQUENCY:
                entry[f"ours_{model}"] = line.frequency
                entry[f"ours_{model}_error_pct"] = article.percent(line.frequency, test)
            else:
                scaled, micrometres = ours.factor * line.amplitude, 1e6 * line.displacement
                entry[f"ours_{model}_m_per_s2"] = line.amplitude
                entry[f"ours_{model}"] = scaled
                entry[f"ours_{model}_error_pct"] = article.percent(scaled, test)
                entry[f"ours_{model}_um"] = micrometres
                entry[f"ours_{model}_um_error_pct"] = article.percent(micrometres, test)
                entry[f"ours_{model}_spread_decades"] = line.spread
            if calibrated:
                error = article.left_out_error(model, row.condition, row.line, row.quantity)
                entry[f"ours_{model}_left_out_error_pct"] = error
            entry[f"ours_{model}_prominence"] = line.prominence
        entry["note"] = row.note
        found.append(entry)
    return found


def holm(p_values: Sequence[float]) -> list[bool]:
    """Return which tests are significant at 5 % after Holm's correction, Scand. J. Stat. 6 (1979) 65; NaN never is.

    >>> holm([0.04, 0.001, math.nan, 0.02])
    [True, True, False, True]
    >>> holm([0.04, 0.001, 0.03])
    [False, True, False]
    """
    p = np.asarray(p_values, dtype=np.float64)
    order = np.argsort(p)[: np.count_nonzero(~np.isnan(p))]
    passed = np.logical_and.accumulate(p[order] <= 0.05 / np.arange(order.size, 0, -1))
    found = np.zeros(p.size, dtype=bool)
    found[order] = passed
    return list(map(bool, found))


class LineDifference(NamedTuple):
    """Coupled against uncoupled at one line: log10 ratio of levels, its standard error [decades], two-sided p of Welch's test."""

    condition: article.Condition
    line: str
    decades: float
    standard_error: float
    p: float
    significant: bool = False


def line_differences(models: Models) -> list[LineDifference]:
    """Test at each line whether the two models' members differ: Welch's t on log10 of the members' levels, Holm's correction.

    Both have the same parameters: the uncoupled model is the switched one where there is one. Needs at least two members a
    model; otherwise p is NaN and nothing is significant.
    """
    from scipy.stats import ttest_ind

    coupled, uncoupled = models["coupled"], models.get(SWITCHED, models["uncoupled"])
    found: list[LineDifference] = []
    for at, condition in enumerate(conditions()):
        for k, line in enumerate(LINES):
            one, other = (model.results[at].lines[k] for model in (coupled, uncoupled))
            (level_a, error_a), (level_b, error_b) = one.log_level(), other.log_level()
            a, b = (np.log10(np.maximum(each.levels, 1e-300)) for each in (one, other))
            p = math.nan
            if min(a.size, b.size) > 1:
                p = float(ttest_ind(a, b, equal_var=False).pvalue) if np.ptp(a) + np.ptp(b) > 0.0 else 1.0
            error = math.nan if math.isnan(p) else math.hypot(error_a, error_b)
            found.append(LineDifference(condition, line, level_a - level_b, error, p))
    marks = holm([each.p for each in found])
    return [each._replace(significant=mark) for each, mark in zip(found, marks, strict=True)]


def amplitude_difference(models: Models) -> tuple[float, float, float, float]:
    """Return the mean log errors [decades] of both models' 18 amplitudes, each with its own factor, and their difference's ends.

    The 95 % interval comes from resampling members with replacement; it holds the ensemble's size, not other parameters.
    """
    generator, test = np.random.default_rng(0), printed("test", AMPLITUDE).ravel()

    def resampled(model: ModelResult) -> Floats:
        found = []
        for line in (line for r in model.results for line in r.lines):
            squares = np.square(line.levels)
            drawn: NDArray[np.int64] = generator.integers(0, squares.size, squares.size)
            found.append(line.amplitude * math.sqrt(float(np.mean(squares[drawn]) / np.mean(squares))))
        return np.array(found)

    errors = [[log_error(test, resampled(models[model])) for model in MODELS] for _ in range(RESAMPLES)]
    low, high = np.percentile([coupled - uncoupled for coupled, uncoupled in errors], [2.5, 97.5])
    whole = [log_error(test, models[model].amplitude.ravel()) for model in MODELS]
    return whole[0], whole[1], float(low), float(high)


def _verdict(margins: Sequence[float]) -> str:
    """Return the verdict on differences in standard errors that a claim has positive."""
    return REPRODUCED if min(margins) > CLEAR else CONTRADICTED if min(margins) < -CLEAR else OPEN


def _joined(parts: Sequence[tuple[str, str]]) -> tuple[str, str]:
    verdicts = {verdict for verdict, _ in parts}
    words = "; ".join(f"{text} ({VERDICT_WORDS[verdict]})" for verdict, text in parts) + "."
    if verdicts == {REPRODUCED}:
        return REPRODUCED, words
    return (CONTRADICTED if CONTRADICTED in verdicts else OPEN), words


def _margin(one: tuple[float, float], other: tuple[float, float]) -> float:
    return (one[0] - other[0]) / math.hypot(one[1], other[1])


def largest_at(
    model: ModelResult, top: article.Condition, rivals: Sequence[article.Condition]
) -> tuple[str, str]:
    """Return the verdict on a model's lines being higher at ``top`` than at the others, with the numbers."""
    parts = []
    for k, line in enumerate(LINES):
        level, *others = (model.line(c, k).log_level() for c in (top, *rivals))
        words = ", ".join(f"{10.0 ** other[0]:.3g}" for other in others)
        verdict = _verdict([_margin(level, other) for other in others])
        parts.append((verdict, f"{LINE_WORDS[line]}: {10.0 ** level[0]:.3g} against {words} m/s²"))
    return _joined(parts)


def peak_at_120(model: ModelResult) -> tuple[str, str]:
    """Return the verdict on a model's lines being highest at 120 rpm, with the numbers."""
    slow, middle, fast = (article.Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0))
    return largest_at(model, middle, (slow, fast))


def grows_with_speed(models: Models) -> tuple[str, str]:
    """Return the verdict on the uncoupled model's lines growing with speed, with the numbers, also of the article's table."""
    speeds = [article.Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0)]
    parts = []
    for k, line in enumerate(LINES):
        levels = [models["uncoupled"].line(c, k).log_level() for c in speeds]
        numbers = ", ".join(f"{10.0**v:.3g}" for v, _ in levels)
        verdict = _verdict([_margin(b, a) for a, b in pairwise(levels)])
        parts.append((verdict, f"{LINE_WORDS[line]}: {numbers} m/s² at 60, 120, 180 rpm"))
    verdict, words = _joined(parts)
    grows = np.all(np.diff(_in_its_table("uncoupled", speeds), axis=0) > 0.0, axis=0)
    return verdict, f"{words} {_article_shows('uncoupled', grows)}"


def largest_clearance(models: Models, name: str, top: tuple[float, float]) -> tuple[str, str]:
    """Return whether a model has its highest lines at ``top`` (clearance, backlash [um]), of three conditions."""
    sets = [article.Condition(120.0, c, b) for c, b in ((200.0, 100.0), (100.0, 200.0), (200.0, 200.0))]
    first = article.Condition(120.0, *top)
    rivals = [c for c in sets if c != first]
    verdict, words = largest_at(models[name], first, rivals)
    table = _in_its_table(name, [first, *rivals])
    return verdict, f"{words} {_article_shows(name, table[0] == table.max(axis=0))}"


def _in_its_table(model: str, sets: Sequence[article.Condition]) -> Floats:
    """Return the amplitudes that the article prints for its own model under some conditions, shape [condition, line]."""
    return printed(model, AMPLITUDE)[[conditions().index(c) for c in sets]]


def _article_shows(model: str, lines: NDArray[np.bool_]) -> str:
    names = [LINE_WORDS[line] for line, shows in zip(LINES, lines, strict=True) if shows]
    return f"The article's own table of its {model} model shows it for {' and '.join(names) or 'none of the lines'}."
