"""Model comparison: leave-one-condition-out prediction, information criterion, evidence, and the conclusion."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.objective import Comparison
from gearplay.calibration.posterior import Posterior, Surrogate, fewest_trials, sample_posterior
from gearplay.calibration.trials import Trial

Floats = NDArray[np.float64]
STRONG = 3.0  # ln of odds 20 : 1, "strong" after Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773
CLEAR = 2.0  # standard errors
OPEN = "undecided"
GROUPS = 4  # of trials that are left out in turn
FEWER_POINTS = 500  # of the posteriors without a group


@dataclass(frozen=True)
class Prediction:
    """One condition predicted from the others.

    ``log_density`` is the log predictive density of its data; ``residuals`` [decades] of the predicted medians, in the order of
    ``labels``; the errors [%] are means over its amplitudes (or values) and over its frequencies.
    """

    condition: str
    log_density: float
    amplitude_error: float
    frequency_error: float
    residuals: tuple[float, ...]
    labels: tuple[str, ...]


def leave_one_out(
    surrogate: Surrogate,
    parameters: int,
    *,
    discrepancy: bool,
    points: int = 1000,
    seed: int = 0,
) -> list[Prediction]:
    """Predict each condition from the posterior of all the others; none of a single condition, which has no others.

    The emulator holds simulations only, no data.
    """
    data = surrogate.comparison.data
    found: list[Prediction] = []
    conditions = list(dict.fromkeys(d.condition for d in data))
    if len(conditions) < 2:
        return found
    for condition in conditions:
        inside = np.array([d.condition != condition for d in data])
        posterior = sample_posterior(
            surrogate, parameters, discrepancy=discrepancy, chosen=inside, points=points, seed=seed
        )
        found.append(_predict(surrogate, posterior, inside, condition))
    return found


def _predict(
    surrogate: Surrogate, posterior: Posterior, inside: NDArray[np.bool_], condition: str
) -> Prediction:
    c = surrogate.comparison
    outside = np.sum(surrogate.log_densities(posterior.points)[:, ~inside], axis=1)
    top = float(np.max(outside))
    density = top + math.log(float(np.mean(np.exp(outside - top))))
    median = np.median(surrogate.simulated(posterior.points), axis=0)
    residuals = (median - c.measured)[~inside]
    per_cent = 100.0 * np.abs(10.0**residuals - 1.0)
    frequencies = c.frequencies[~inside]
    return Prediction(
        condition,
        density,
        _mean(per_cent[~frequencies]),
        _mean(per_cent[frequencies]),
        tuple(float(r) for r in residuals),
        tuple(d.label for d, kept in zip(c.data, inside, strict=True) if not kept),
    )


def _mean(values: Floats) -> float:
    return float(values.mean()) if values.size else math.nan


def emulator_errors(
    comparison: Comparison, trials: Sequence[Trial], parameters: int, *, discrepancy: bool, seed: int = 0
) -> tuple[float, float]:
    """Return the standard errors of log evidence and of the sum of log predictive densities that come from the trials.

    Other trials would have given another emulator. `GROUPS` of trials are left out in turn (jackknife: the square is
    (g - 1) / g sum (v - mean)^2). Infinite where too few trials remain to fit an emulator.
    """
    found = []
    for group in range(GROUPS):
        rest = [trial for trial in trials if trial.number % GROUPS != group]
        if sum(trial.good for trial in rest) < fewest_trials(parameters):
            return math.inf, math.inf
        surrogate = Surrogate.of(comparison, rest)
        whole = sample_posterior(
            surrogate, parameters, discrepancy=discrepancy, points=FEWER_POINTS, seed=seed
        )
        parts = leave_one_out(surrogate, parameters, discrepancy=discrepancy, points=FEWER_POINTS, seed=seed)
        found.append((whole.log_evidence, sum(part.log_density for part in parts)))
    evidence, predictive = np.sqrt((GROUPS - 1) * np.var(found, axis=0))
    return float(evidence), float(predictive)


@dataclass(frozen=True)
class Standing:
    """Criteria of one model for one reading of the ordinate: information criterion, evidence, leave-one-out densities.

    ``bic`` = k ln n - 2 ln L at the best point (Schwarz, Ann. Stat. 6 (1978) 461), ``log_evidence`` ln of the mean
    likelihood over the prior, ``log_densities`` the log predictive density of each condition from the others. Errors are standard
    ones: that of the evidence from sampling and emulator, that of the sum of the densities from the emulator.
    """

    model: str
    bic: float
    log_evidence: float
    log_evidence_error: float
    log_densities: Mapping[str, float]
    predictive_error: float = 0.0

    @property
    def predictive(self) -> float:
        """Sum of the log predictive densities of the conditions from the others."""
        return sum(self.log_densities.values())


def information_criterion(surrogate: Surrogate, posterior: Posterior, parameters: int) -> float:
    """Return Schwarz's criterion k ln n - 2 ln L at the most likely sample; lower is better."""
    best = float(np.max(np.sum(surrogate.log_densities(posterior.points), axis=1)))
    return parameters * math.log(len(surrogate.comparison.data)) - 2.0 * best


@dataclass(frozen=True)
class PairComparison:
    """Pairwise comparison of two models in one reading: differences, first less second, and the better model.

    ``log_odds`` is the difference of log evidence, ``predictive`` that of the log predictive densities; its standard error is
    that over the conditions and of both emulators. ``bic`` is the difference of the criterion (negative favours the first).
    """

    first: str
    second: str
    log_odds: float
    log_odds_error: float
    predictive: float
    predictive_error: float
    bic: float

    @property
    def winner(self) -> str:
        """The better model, by odds beyond 20 : 1 and predictions ahead by two standard errors; else `OPEN`."""
        for name, sign in ((self.first, 1.0), (self.second, -1.0)):
            odds = sign * self.log_odds - CLEAR * self.log_odds_error > STRONG
            ahead = sign * self.predictive > CLEAR * self.predictive_error
            if odds and ahead:
                return name
        return OPEN

    @property
    def words(self) -> str:
        """The comparison in one sentence."""
        outcome = f"{self.winner} explains the data better" if self.winner != OPEN else OPEN
        return (
            f"{self.first} against {self.second}: {outcome}. ln odds {self.log_odds:+.1f} ± {_shown(self.log_odds_error)}"
            f" (decisive beyond ±{STRONG:g}), predictions of each condition from the others {self.predictive:+.1f}"
            f" ± {_shown(self.predictive_error)} (decisive beyond {CLEAR:g} standard errors), BIC {self.bic:+.1f}."
        )


def _shown(error: float) -> str:
    return f"{error:.1f}" if math.isfinite(error) else "unknown"


def compare_pairs(standings: Sequence[Standing]) -> list[PairComparison]:
    """Compare every pair of models in one reading of the ordinate."""
    found = []
    for a, b in combinations(standings, 2):
        ahead = np.array([a.log_densities[c] - b.log_densities[c] for c in a.log_densities])
        error = math.sqrt(ahead.size) * float(np.std(ahead, ddof=1)) if ahead.size > 1 else math.inf
        found.append(
            PairComparison(
                a.model,
                b.model,
                a.log_evidence - b.log_evidence,
                math.hypot(a.log_evidence_error, b.log_evidence_error),
                float(ahead.sum()),
                math.hypot(error, a.predictive_error, b.predictive_error),
                a.bic - b.bic,
            )
        )
    return found


@dataclass(frozen=True)
class ReadingConclusion:
    """Conclusion for one reading of the ordinate: the model that beats every other, or that the data cannot decide."""

    reading: str
    models: tuple[str, ...]
    pairs: tuple[PairComparison, ...]

    @property
    def winner(self) -> str:
        """The model that wins all its pairwise comparisons, else `OPEN`; also `OPEN` for a single model."""
        for model in self.models:
            own = [pair for pair in self.pairs if model in (pair.first, pair.second)]
            if own and all(pair.winner == model for pair in own):
                return model
        return OPEN

    @property
    def words(self) -> str:
        """The conclusion in one sentence."""
        if len(self.models) < 2:
            return f"No comparison: {self.models[0]} is the only model."
        if self.winner == OPEN:
            return f"{OPEN}: no model beats every other."
        return f"{self.winner} explains the data better than {_others(len(self.models))}."


@dataclass(frozen=True)
class Conclusion:
    """The conclusions of each reading, and the overall one.

    ``overall`` is a model's name only where it beats every other model in every reading, else `OPEN`.
    """

    readings: tuple[ReadingConclusion, ...]
    overall: str
    words: str


def conclude(standings: Mapping[str, Sequence[Standing]]) -> Conclusion:
    """Return the conclusion from the standings of the models, by reading.

    >>> good, bad = (Standing(n, 0.0, e, 0.1, {"a": e, "b": e - 1}) for n, e in (("good", 0.0), ("bad", -9.0)))
    >>> conclude({"absolute": [good, bad]}).overall
    'good'
    >>> conclude({"absolute": [good, bad], "displacement": [good]}).overall  # only one model there
    'undecided'
    """
    readings = tuple(
        ReadingConclusion(reading, tuple(s.model for s in found), tuple(compare_pairs(found)))
        for reading, found in standings.items()
    )
    winners = {each.winner for each in readings}
    same_models = len({frozenset(each.models) for each in readings}) == 1
    overall = winners.pop() if len(winners) == 1 and same_models else OPEN
    return Conclusion(readings, overall, _words(readings, overall, same_models=same_models))


def _words(readings: Sequence[ReadingConclusion], overall: str, *, same_models: bool) -> str:
    if not readings:
        return f"{OPEN}: nothing was calibrated."
    if overall != OPEN:
        where = "" if len(readings) == 1 else f", in every reading ({', '.join(r.reading for r in readings)})"
        return f"{overall} explains the data better than {_others(len(readings[0].models))}{where}."
    if len(readings) == 1 or all(len(each.models) < 2 for each in readings):
        return readings[0].words
    each_says = "; ".join(f"{each.reading}: {each.winner}" for each in readings)
    won = {each.winner for each in readings} - {OPEN}
    reason = "the readings disagree" if len(won) > 1 else "not every reading has one model ahead of all"
    if not same_models:
        reason = "not every model was compared in every reading"
    return f"{OPEN}: {reason} ({each_says})."


def _others(models: int) -> str:
    return "the other model" if models == 2 else "every other model"
