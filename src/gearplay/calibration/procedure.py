"""`run_calibration`: search, out-of-sample check, posterior and model comparison, for every model and reading."""

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from gearplay.calibration.model_comparison import (
    GROUPS,
    Prediction,
    Standing,
    emulator_errors,
    information_criterion,
    leave_one_out,
)
from gearplay.calibration.objective import Comparison, Measurements, data_of
from gearplay.calibration.out_of_sample import (
    Drift,
    LeftOut,
    best_point,
    check,
    drifts,
    hold_out,
    later_than,
)
from gearplay.calibration.plan import Model, Plan
from gearplay.calibration.posterior import Interval, Surrogate, fewest_trials, sample_posterior
from gearplay.calibration.search import run_search
from gearplay.calibration.trials import Problem, Trial, TrialStore, distinct
from gearplay.vocabulary.errors import SimulationError
from gearplay.vocabulary.progress import Progress
from gearplay.work.pieces import PieceStore

Floats = NDArray[np.float64]

PICTURE = 400  # posterior points kept for pictures


@dataclass(frozen=True)
class Row:
    """One datum of the residual table: measured and simulated in the ordinate's unit, log10 of their ratio [decades]."""

    condition: str
    target: str
    key: str
    measured: float
    simulated: float
    residual: float
    ensemble_error: float  # decades

    @property
    def error(self) -> float:
        """Error of the simulated value [%]."""
        return 100.0 * abs(self.simulated / self.measured - 1.0)


@dataclass(frozen=True)
class Fit:
    """One model in one reading of the ordinate, calibrated.

    ``best`` holds the parameters of the best point in SI, chosen among candidates on fresh members and reported from other
    fresh ones; ``found_errors`` are the mean errors [%] of the search at its best trial, which are too small.
    ``predicted`` are conditions predicted from the posterior of the others, on the emulator; ``left_out`` are conditions
    simulated where the others fit best.
    """

    model: str
    reading: str
    trials: int
    failed: int
    best: dict[str, float]
    unit: tuple[float, ...]
    factor: float
    amplitude_error: float
    frequency_error: float
    found_errors: tuple[float, float]
    rows: tuple[Row, ...]
    intervals: tuple[Interval, ...]
    correlation: tuple[tuple[float, ...], ...]
    sample: tuple[tuple[float, ...], ...]  # [sample, parameter], in the unit cube, equally weighted
    scatter: tuple[float, float, float]  # decades: 5, 50, 95 % points of the model's own scatter
    emulator_degree: int
    emulator_error: tuple[float, ...]  # decades, by datum
    predicted: tuple[Prediction, ...]
    left_out: tuple[LeftOut, ...]
    standing: Standing
    history: tuple[float, ...]  # least objective after each trial
    drift: tuple[Drift, ...]  # changes by a longer transient at the best point


STEPS = (
    "best point",
    "check of the best point",
    "posterior",
    "conditions predicted",
    "conditions left out",
    "later times",
)
"""Steps of a fit after the trials, in their order."""


@cache
def _fits() -> TypeAdapter[Fit]:
    return TypeAdapter(Fit)


def fit_from(part: Mapping[str, Any]) -> Fit:
    """Return a fit from its JSON-able form."""
    return _fits().validate_python(part)


def run_calibration(
    plan: Plan,
    measurements: Measurements,
    *,
    trials: Callable[[str], TrialStore],
    pieces: PieceStore,
    report: Progress | None = None,
    stop: threading.Event | None = None,
) -> list[Fit]:
    """Calibrate every model of a plan in every reading; finished work comes from the stores.

    ``trials`` returns the store of a model's trials by its name.

    Raises `InputError` for a plan that does not fit its case, `SimulationError` where no trial of a model finishes,
    `KeyboardInterrupt` soon after ``stop`` is set.
    """
    stop = stop or threading.Event()
    data = data_of(plan, measurements)
    problems = [(model, Problem(plan, model)) for model in plan.models]  # all are checked before any runs
    total = float(len(plan.models) * plan.effort.evaluations)
    fits = []
    for at, (model, problem) in enumerate(problems):
        comparisons = [Comparison(data, reading) for reading in plan.readings]

        def searched(done: float, _: float, at: int = at, model: Model = model) -> None:
            if report is not None:
                report(f"{model.name}: trials", at * plan.effort.evaluations + done, total)

        found = run_search(problem, comparisons, trials(model.name), report=searched, stop=stop)
        for comparison in comparisons:

            def stepped(step: int, of: str = f"{model.name}, {comparison.reading}") -> None:
                if report is not None:
                    report(f"{of}: {STEPS[step]}", float(step), float(len(STEPS)))

            identity = [
                plan.model_dump(mode="json"),
                model.name,
                comparison.reading,
                [asdict(d) for d in data],
                [field.name for field in fields(Fit)],  # parts of another layout are not read
                GROUPS,
                later_than(plan.simulation),
            ]
            make = partial(_fit_part, problem, comparison, found, stepped, stop=stop)
            fits.append(fit_from(pieces.keep(identity, make)))
    return fits


def _fit_part(
    problem: Problem,
    comparison: Comparison,
    trials: Sequence[Trial],
    report: Callable[[int], None],
    *,
    stop: threading.Event,
) -> dict[str, Any]:
    return asdict(fit_model(problem, comparison, trials, report, stop=stop))


def fit_model(
    problem: Problem,
    comparison: Comparison,
    trials: Sequence[Trial],
    report: Callable[[int], None] = lambda _: None,
    *,
    stop: threading.Event | None = None,
) -> Fit:
    """Return the fit of one model in one reading from finished trials: best point, posterior, hold-out.

    ``report`` is called with the number of each step in `STEPS` when it begins.

    Raises `SimulationError` where too few trials finished.
    """
    plan, number = problem.plan, len(problem.parameters)
    own = distinct(trials)
    good = [trial for trial in own if trial.good]
    if len(good) < fewest_trials(number):
        reason = next((t.reason for t in trials if not t.good), "no trial was run")
        raise SimulationError(
            f"{problem.model.name}: only {len(good)} of {len(trials)} trials finished: {reason}"
        )
    logs, errors = comparison.logs_of(good)
    values = comparison.objective(logs, errors)
    surrogate = Surrogate.of(comparison, own)
    report(0)
    unit = best_point(problem, surrogate, good, stop)
    report(1)
    checked = check(problem, unit, stop)
    checked_logs, checked_errors = comparison.logs_of([checked])
    report(2)
    posterior = sample_posterior(surrogate, number, discrepancy=plan.discrepancy, seed=plan.effort.seed)
    free = number + int(plan.discrepancy) + int(comparison.reading == "unnormalised")
    report(3)
    predicted = leave_one_out(surrogate, number, discrepancy=plan.discrepancy, seed=plan.effort.seed)
    evidence_error, predictive_error = emulator_errors(
        comparison, own, number, discrepancy=plan.discrepancy, seed=plan.effort.seed
    )
    found_amplitude, found_frequency = comparison.mean_errors(logs, errors)
    amplitude, frequency = comparison.mean_errors(checked_logs, checked_errors)
    best = int(np.argmin(values))
    _, variance = comparison.residuals(checked_logs, checked_errors)
    low, middle, high = posterior.quantiles(posterior.points.scatter).tolist()
    report(4)
    left_out = tuple(hold_out(problem, comparison, good, stop))
    report(5)
    later = tuple(drifts(problem, comparison, unit, stop))
    return Fit(
        model=problem.model.name,
        reading=comparison.reading,
        trials=len(trials),
        failed=sum(not trial.good for trial in trials),
        best=problem.values(unit),
        unit=unit,
        factor=float(10.0 ** comparison.log_factor(checked_logs, variance)[0]),
        amplitude_error=float(amplitude[0]),
        frequency_error=float(frequency[0]),
        found_errors=(float(found_amplitude[best]), float(found_frequency[best])),
        rows=_rows(comparison, checked_logs, checked_errors),
        intervals=posterior.intervals(problem),
        correlation=_tuples(posterior.correlation()),
        sample=_tuples(posterior.points.units[:PICTURE]),
        scatter=(low, middle, high),
        emulator_degree=surrogate.emulator.degree,
        emulator_error=tuple(float(v) for v in surrogate.error),
        predicted=tuple(predicted),
        left_out=left_out,
        standing=Standing(
            problem.model.name,
            information_criterion(surrogate, posterior, free),
            posterior.log_evidence,
            math.hypot(posterior.log_evidence_error, evidence_error),
            {each.condition: each.log_density for each in predicted},
            predictive_error,
        ),
        history=tuple(float(v) for v in np.minimum.accumulate(values)),
        drift=later,
    )


def _rows(comparison: Comparison, logs: Floats, errors: Floats) -> tuple[Row, ...]:
    residuals, _ = comparison.residuals(logs, errors)
    return tuple(
        Row(d.condition, d.target, d.key, d.value, float(d.value * 10.0**r), float(r), float(e))
        for d, r, e in zip(comparison.data, residuals[0], errors[0], strict=True)
    )


def _tuples(table: Floats) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(f"{v:.6g}") for v in row) for row in table)
