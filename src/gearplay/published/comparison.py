"""Comparison with the published test: tables, readings of the ordinate, difference of the two models."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.published.article import LINES, Condition, PrintedRow, printed, printed_rows
from gearplay.published.audit import mean_error
from gearplay.published.calibrated import left_out_error
from gearplay.published.han2021 import ConditionResult
from gearplay.published.settings import MODELS, SWITCHED
from gearplay.published.significance import holm

Floats = NDArray[np.float64]
RESAMPLES = 400
LASTING = 1.5
"""Factor by which the swing may be weaker or stronger later on and still count as lasting."""


def by_condition(results: Sequence[ConditionResult], model: str) -> dict[Condition, ConditionResult]:
    """Return one model's results by condition."""
    return {r.condition: r for r in results if r.model == model}


def log_factor(test: Floats, simulated: Floats) -> float:
    """Return the one common factor between two sets of amplitudes: the geometric mean of test over simulated."""
    return float(np.exp(np.mean(np.log(test / simulated))))


@dataclass(frozen=True)
class ModelAmplitudes:
    """The 18 amplitudes of one model in print order, in both readings of the article's ordinate."""

    test: Floats  # as printed
    acceleration: Floats  # m/s^2
    displacement: Floats  # um
    levels: list[Floats]  # per line: each member's level, m/s^2
    factor: float  # un-normalised FFT: printed = factor x acceleration

    def mean_error(self, reading: str) -> float:
        """Mean error [%] of the 18 amplitudes in one reading."""
        ours = self.factor * self.acceleration if reading == "unnormalised" else self.displacement
        return mean_error(self.test, ours)

    def log_error(self) -> float:
        """Mean |log10 (factor x simulated / test)| [decades], the error that does not favour small values."""
        return float(np.mean(np.abs(np.log10(self.factor * self.acceleration / self.test))))


def lasting_shares(results: Sequence[ConditionResult], model: str) -> list[float]:
    """Return the share of f_r's amplitude that one model has later on, for each condition in which that was looked at."""
    return [r.lasting for r in by_condition(results, model).values() if r.lasting is not None]


def swing_lasts(results: Sequence[ConditionResult], model: str) -> bool:
    """Return whether f_r is as strong later on: by geometric mean over the conditions, within a factor `LASTING`.

    Under one condition a swing that a floor keeps up may be half as strong or twice, by chance.
    """
    shares = lasting_shares(results, model)
    return not shares or bool(abs(np.mean(np.log(shares))) < math.log(LASTING))


def shaking(results: Sequence[ConditionResult], model: str) -> float:
    """Return the rms acceleration of the floor [mm/s^2] on which one model stands, the same under every condition; 0 at rest."""
    return 1e3 * next(iter(by_condition(results, model).values())).floor


def model_amplitudes(results: Sequence[ConditionResult], model: str) -> ModelAmplitudes:
    """Collect one model's 18 amplitudes and fit its common factor."""
    rows = [row for row in printed_rows() if row.quantity == "amplitude_as_printed"]
    found = by_condition(results, model)
    lines = [found[row.condition].lines[row.line] for row in rows]
    test = np.array([row.test for row in rows])
    acceleration = np.array([line.amplitude for line in lines])
    return ModelAmplitudes(
        test=test,
        acceleration=acceleration,
        displacement=np.array([1e6 * line.displacement for line in lines]),
        levels=[np.array(line.levels) for line in lines],
        factor=log_factor(test, acceleration),
    )


def _error(value: float, test: float) -> float:
    return 100.0 * abs(value - test) / test


def table_rows(results: Sequence[ConditionResult], *, calibrated: bool) -> list[dict[str, Any]]:
    """Return every row of Tables 3-6 beside ours, with recomputed errors [%], spreads and marks.

    Amplitude rows carry our acceleration [m/s^2], the same times the fitted factor (the un-normalised reading), and our
    displacement [um] (the displacement reading). ``spread`` is the members' standard deviation in decades. With
    ``calibrated`` parameters each error is joined by that of a fit that did not know the condition.
    """
    factors = {model: model_amplitudes(results, model).factor for model in MODELS}
    rows = []
    for row in printed_rows():
        entry: dict[str, Any] = {
            "table": row.table,
            "speed_rpm": row.condition.speed_rpm,
            "radial_clearance_um": row.condition.radial_clearance_um,
            "backlash_um": row.condition.backlash_um,
            "line": row.line,
            "quantity": row.quantity,
            "test": row.test,
        }
        for model in MODELS:
            entry.update(_article_columns(row, model))
            line = by_condition(results, model)[row.condition].lines[row.line]
            if row.quantity == "frequency_hz":
                entry[f"ours_{model}"] = line.frequency
                entry[f"ours_{model}_error_pct"] = _error(line.frequency, row.test)
            else:
                scaled, micrometres = factors[model] * line.amplitude, 1e6 * line.displacement
                entry[f"ours_{model}_m_per_s2"] = line.amplitude
                entry[f"ours_{model}"] = scaled
                entry[f"ours_{model}_error_pct"] = _error(scaled, row.test)
                entry[f"ours_{model}_um"] = micrometres
                entry[f"ours_{model}_um_error_pct"] = _error(micrometres, row.test)
                entry[f"ours_{model}_spread_decades"] = line.spread
            if calibrated:
                error = left_out_error(model, row.condition, row.line, row.quantity)
                entry[f"ours_{model}_left_out_error_pct"] = error
            entry[f"ours_{model}_prominence"] = line.prominence
        entry["note"] = row.note
        rows.append(entry)
    return rows


def _article_columns(row: PrintedRow, model: str) -> dict[str, Any]:
    value = row.coupled if model == "coupled" else row.uncoupled
    error = row.coupled_error_printed if model == "coupled" else row.uncoupled_error_printed
    return {
        f"article_{model}": value,
        f"article_{model}_error_printed_pct": error,
        f"article_{model}_error_recomputed_pct": row.recomputed_error(model),
        f"article_{model}_error_follows": row.printed_error_follows(model),
    }


@dataclass(frozen=True)
class LineDifference:
    """Coupled against uncoupled at one line: log10 ratio of levels, its standard error [decades], two-sided p of Welch's test."""

    condition: Condition
    line: str
    decades: float
    standard_error: float
    p: float
    significant: bool


def line_differences(results: Sequence[ConditionResult], level: float = 0.05) -> list[LineDifference]:
    """Test at each line whether the two models' members differ: Welch's t on log10 of the members' levels, Holm's correction.

    Both have the same parameters: the uncoupled model is the switched one where there is one. Needs at least two members a
    model; otherwise p is NaN and nothing is significant.
    """
    from scipy.stats import ttest_ind_from_stats

    coupled = by_condition(results, "coupled")
    uncoupled = by_condition(results, SWITCHED) or by_condition(results, "uncoupled")
    found: list[LineDifference] = []
    for condition in coupled:
        for line in LINES:
            one, other = (r[condition].lines[line] for r in (coupled, uncoupled))
            (level_a, error_a), (level_b, error_b) = one.log_level(), other.log_level()
            a, b = (np.log10(np.maximum(each.levels, 1e-300)) for each in (one, other))
            p = math.nan
            if min(a.size, b.size) > 1:
                spreads = float(a.std(ddof=1)), float(b.std(ddof=1))
                p = 1.0
                if max(spreads) > 0.0:
                    p = float(
                        ttest_ind_from_stats(
                            a.mean(), spreads[0], a.size, b.mean(), spreads[1], b.size, equal_var=False
                        ).pvalue
                    )
            error = math.nan if math.isnan(p) else math.hypot(error_a, error_b)
            found.append(LineDifference(condition, line, level_a - level_b, error, p, False))
    marked = holm([each.p for each in found], level)
    return [replace(each, significant=mark) for each, mark in zip(found, marked, strict=True)]


@dataclass(frozen=True)
class Verdict:
    """A quantity of coupled minus uncoupled with its 95 % interval from resampled members."""

    coupled: float
    uncoupled: float
    difference: float
    low: float
    high: float

    @property
    def better(self) -> str:
        """Which model has the smaller error, or that it cannot be told."""
        if self.high < 0.0:
            return "coupled"
        return "uncoupled" if self.low > 0.0 else "cannot be told"


def _resampled(amplitudes: ModelAmplitudes, draw: Callable[[int], NDArray[np.int64]]) -> Floats:
    """Return the 18 amplitudes of one resampled ensemble: the members' rms levels, scaled to the lines."""
    result = []
    for levels, height in zip(amplitudes.levels, amplitudes.acceleration, strict=True):
        whole = math.sqrt(float(np.mean(levels**2)))
        result.append(height * math.sqrt(float(np.mean(levels[draw(levels.size)] ** 2))) / whole)
    return np.array(result)


def amplitude_verdict(results: Sequence[ConditionResult], seed: int = 0) -> Verdict:
    """Compare the models' mean log error over the 18 amplitudes, each with its own fitted factor (un-normalised reading).

    The interval comes from resampling members with replacement; it says what the ensemble size can tell, not what other
    parameters would give.
    """
    generator = np.random.default_rng(seed)
    sets = [model_amplitudes(results, model) for model in MODELS]

    def draw(size: int) -> NDArray[np.int64]:
        return generator.integers(0, size, size)

    def error(test: Floats, simulated: Floats) -> float:
        return float(np.mean(np.abs(np.log10(log_factor(test, simulated) * simulated / test))))

    differences = [
        error(sets[0].test, _resampled(sets[0], draw)) - error(sets[1].test, _resampled(sets[1], draw))
        for _ in range(RESAMPLES)
    ]
    low, high = np.percentile(differences, [2.5, 97.5])
    return Verdict(
        sets[0].log_error(),
        sets[1].log_error(),
        sets[0].log_error() - sets[1].log_error(),
        float(low),
        float(high),
    )


def radial_frequency_error(results: Sequence[ConditionResult], model: str) -> float:
    """Return the mean error [%] of the six radial frequencies f_r."""
    return float(
        np.mean(
            [
                _error(r.lines["radial"].frequency, printed(r.condition, "radial", "frequency_hz").test)
                for r in by_condition(results, model).values()
            ]
        )
    )


def article_error(model: str, quantity: str, line: str | None = None) -> float:
    """Return the article's own mean error [%] of a model, recomputed from its printed values."""
    rows = [r for r in printed_rows() if r.quantity == quantity and line in (None, r.line)]
    return float(np.mean([r.recomputed_error(model) for r in rows]))
