"""Recovery test: parameters inferred from synthetic data with known values, through the same emulator."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearplay.calibration.objective import Comparison, data_of
from gearplay.calibration.observe import FREQUENCY, Observed
from gearplay.calibration.posterior import Interval, Surrogate, sample_posterior
from gearplay.calibration.trials import Observations, Problem, Trial, mapped
from gearplay.vocabulary.progress import Tick

TRUE_SEED = 30_000_001  # added to the plan's: members of no trial
MARGIN = 0.02  # of the bounds that true points keep off, in the unit cube


@dataclass(frozen=True)
class Recovered:
    """One synthetic data set: the true parameters in SI by name, and the interval found for each."""

    number: int
    true: dict[str, float]
    intervals: tuple[Interval, ...]


@dataclass(frozen=True)
class Recovery:
    """Recovery of one parameter over all data sets.

    ``identified`` counts the data sets that declare it identified; ``median_error`` is the median of |found / true - 1| [%] over
    those, NaN without any; ``coverage`` the share of all data sets whose 90 % interval holds the true value.
    """

    name: str
    identified: int
    median_error: float
    coverage: float


def synthetic(
    problem: Problem, number: int, *, members: int, noise: float
) -> tuple[tuple[float, ...], Observations]:
    """Return drawn parameters and synthetic data of them, from out-of-sample members with noise [decades]."""
    plan = problem.plan
    generator = np.random.default_rng([plan.effort.seed, TRUE_SEED, number])
    unit = tuple(float(u) for u in generator.uniform(MARGIN, 1.0 - MARGIN, len(problem.parameters)))
    observed = problem.observe(unit, seed=plan.effort.seed + TRUE_SEED + number, members=members)

    def noisy(key: str, observed: Observed) -> Observed:
        deviation = plan.frequency_uncertainty if key == FREQUENCY else noise
        return Observed(float(observed.value * 10.0 ** generator.normal(0.0, deviation)), observed.error)

    return unit, mapped(observed, noisy)


def recover(
    problem: Problem,
    trials: Sequence[Trial],
    sets: int,
    *,
    members: int = 16,
    report: Tick | None = None,
    stop: threading.Event | None = None,
) -> list[Recovered]:
    """Infer the parameters of ``sets`` synthetic data sets from an emulator of ``trials`` spread over the whole range.

    Each datum has the plan's uncertainty as noise. The model that makes the data is the one that explains them, so no
    discrepancy is allowed for.

    Raises `KeyboardInterrupt` soon after ``stop`` is set.
    """
    found = []
    for number in range(sets):
        if stop is not None and stop.is_set():
            raise KeyboardInterrupt
        unit, observed = synthetic(problem, number, members=members, noise=problem.plan.uncertainty)
        surrogate = Surrogate.of(
            Comparison(data_of(problem.plan, observed), "absolute"), trials, everywhere=True
        )
        posterior = sample_posterior(surrogate, len(unit), discrepancy=False, seed=number)
        found.append(Recovered(number, problem.values(unit), posterior.intervals(problem)))
        if report is not None:
            report(number + 1.0, float(sets))
    return found


def summary(found: Sequence[Recovered]) -> list[Recovery]:
    """Return how well each parameter is recovered."""
    table = []
    for at, first in enumerate(found[0].intervals):
        pairs = [(r.true[first.name], r.intervals[at]) for r in found]
        errors = [100.0 * abs(i.median / true - 1.0) for true, i in pairs if i.identified]
        inside = [i.low <= true <= i.high for true, i in pairs]
        table.append(
            Recovery(
                first.name,
                len(errors),
                float(np.median(errors)) if errors else float("nan"),
                float(np.mean(inside)),
            )
        )
    return table
