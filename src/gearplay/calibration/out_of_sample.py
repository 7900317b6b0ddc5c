"""Out-of-sample evaluation of calibrated points: choice of the best, its errors, and conditions left out."""

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gearplay.calibration.objective import Comparison
from gearplay.calibration.plan import Simulation
from gearplay.calibration.posterior import Surrogate
from gearplay.calibration.search import refine
from gearplay.calibration.trials import Problem, Trial
from gearplay.vocabulary.errors import SimulationError

CANDIDATES, FINALISTS = 7, 3
CHOOSE_SEED, CHECK_SEED = 10_000_019, 20_000_003  # added to the plan's
LATER_MEMBERS = 8
CHANGED, CLEARLY = 0.1, 3.0  # decades, and standard errors, by which a datum must change to count as drifting


def best_point(
    problem: Problem,
    surrogate: Surrogate,
    good: Sequence[Trial],
    stop: threading.Event | None,
    *,
    candidates: int = CANDIDATES,
) -> tuple[float, ...]:
    """Return the best of a few candidates on fresh members: all of them with few members, then the best three with more.

    Half of the candidates are the best trials by the objective, the others the best by the emulator, which averages over
    their noise: the trial with the least objective is so partly by chance.
    """
    effort, comparison = problem.plan.effort, surrogate.comparison

    def ordered(units: Sequence[tuple[float, ...]], count: int) -> list[tuple[float, ...]]:
        observed = [_observed(problem, unit, CHOOSE_SEED, count, stop) for unit in units]
        return [units[k] for k in np.argsort(comparison.objective(*comparison.logs_of(observed)))]

    trials = np.argsort(comparison.objective(*comparison.logs_of(good)))[: candidates // 2]
    emulated = surrogate.emulator(np.array([trial.unit for trial in good]))
    smooth = np.argsort(comparison.objective(emulated, np.zeros_like(emulated)))[: candidates // 2]
    units = [good[k].unit for k in dict.fromkeys((*trials, *smooth))]
    generator = np.random.default_rng(effort.seed)
    units.append(refine(surrogate.emulator, comparison, np.array(good[smooth[0]].unit), generator))
    first = ordered(units, effort.polish_members)
    return first[0] if len(first) <= FINALISTS else ordered(first[:FINALISTS], effort.check_members)[0]


def check(problem: Problem, unit: tuple[float, ...], stop: threading.Event | None) -> Trial:
    """Return the observations at a point for out-of-sample members."""
    return _observed(problem, unit, CHECK_SEED, problem.plan.effort.check_members, stop)


def _observed(
    problem: Problem,
    unit: tuple[float, ...],
    seed: int,
    members: int,
    stop: threading.Event | None,
    transient: float | None = None,
) -> Trial:
    whole = problem.plan.effort.seed + seed
    return Trial(-1, unit, problem.observe(unit, seed=whole, members=members, transient=transient, stop=stop))


@dataclass(frozen=True)
class Drift:
    """A datum that changes with a longer transient [s]: log10 of the ratio of later to present value [decades]."""

    condition: str
    target: str
    key: str
    transient: float
    decades: float
    error: float


def later_than(simulation: Simulation) -> float:
    """Return the transient [s] after which the observations must be the same as after the plan's."""
    return simulation.transient + 3.0 * max(simulation.transient, simulation.duration)


def drifts(
    problem: Problem, comparison: Comparison, unit: tuple[float, ...], stop: threading.Event | None
) -> list[Drift]:
    """Return the data that change significantly with a longer transient, the largest first; empty where none does.

    The same initial states are integrated for longer; random records of the housing are extended. A remaining effect of
    the initial states is no property of the mechanism, and no fit should depend on it.
    """
    later = later_than(problem.plan.simulation)
    try:
        observed = [_observed(problem, unit, CHECK_SEED, LATER_MEMBERS, stop, each) for each in (None, later)]
    except SimulationError:  # only the check is missing: the fit stands
        return []
    logs, errors = comparison.logs_of(observed)
    found = [
        Drift(d.condition, d.target, d.key, later, float(then - now), float(np.hypot(*error)))
        for d, now, then, error in zip(comparison.data, *logs, errors.T, strict=True)
    ]
    clear = [d for d in found if abs(d.decades) > max(CHANGED, CLEARLY * d.error)]
    return sorted(clear, key=lambda d: -abs(d.decades))


@dataclass(frozen=True)
class LeftOut:
    """One condition simulated at the best trial of all the others: neither the choice nor the factor depends on it.

    The search that made the trials was guided by all conditions.

    ``best`` are the parameters in SI; ``residuals`` [decades] of simulation over measurement, in the order of ``labels``.
    """

    condition: str
    best: Mapping[str, float]
    residuals: tuple[float, ...]
    labels: tuple[str, ...]


def hold_out(
    problem: Problem, comparison: Comparison, trials: Sequence[Trial], stop: threading.Event | None
) -> list[LeftOut]:
    """Leave out each condition in turn: choose the best point by the others alone, simulate it with fresh members.

    None for a plan with one condition. Trials are judged by the other conditions only, with their own common factor.
    """
    names = list(dict.fromkeys(d.condition for d in comparison.data))
    good, found = [trial for trial in trials if trial.good], []
    for name in names if len(names) > 1 else ():
        inside = tuple(d for d in comparison.data if d.condition != name)
        rest = Comparison(inside, comparison.reading)
        unit = best_point(problem, Surrogate.of(rest, good), good, stop, candidates=2)
        observed = check(problem, unit, stop)
        logs, errors = rest.logs_of([observed])
        factor = rest.log_factor(logs, rest.residuals(logs, errors)[1])[0]
        whole, _ = comparison.logs_of([observed])
        residuals = whole[0] + factor * comparison.amplitudes - comparison.measured
        outside = [k for k, d in enumerate(comparison.data) if d.condition == name]
        found.append(
            LeftOut(
                name,
                problem.values(unit),
                tuple(float(residuals[k]) for k in outside),
                tuple(comparison.data[k].label for k in outside),
            )
        )
    return found


def mean_error(left_out: Sequence[LeftOut], *, frequencies: bool) -> float:
    """Return the mean error [%] of the amplitudes (or values), or of the frequencies, of conditions left out; NaN without any."""
    residuals = [
        residual
        for each in left_out
        for label, residual in zip(each.labels, each.residuals, strict=True)
        if label.endswith(", frequency") == frequencies
    ]
    return float(np.mean(100.0 * np.abs(10.0 ** np.array(residuals) - 1.0))) if residuals else float("nan")
