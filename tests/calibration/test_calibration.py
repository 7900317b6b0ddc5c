"""Calibration against closed forms: a linear model with normal noise has a known posterior and a known evidence."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from calibration_problems import KnownProblem, small_plan
from gearplay.calibration.model_comparison import (
    OPEN,
    Standing,
    compare_pairs,
    emulator_errors,
    leave_one_out,
)
from gearplay.calibration.objective import Comparison, Datum, data_of
from gearplay.calibration.observe import Observed
from gearplay.calibration.out_of_sample import drifts, hold_out, later_than, mean_error
from gearplay.calibration.posterior import FACTOR, Points, Surrogate, sample_posterior
from gearplay.calibration.procedure import STEPS, fit_from, fit_model
from gearplay.calibration.recovery import recover, summary, synthetic
from gearplay.calibration.trials import Problem, Trial, TrialError
from gearplay.surrogates.polynomials import Emulator

Floats = NDArray[np.float64]
Measured = Callable[[str, float, str], None]
SIGMA = 0.05
PARAMETERS = 3


def linear(reading: str, seed: int = 0) -> tuple[Surrogate, Floats, Floats]:
    """Return a surrogate that is linear in the unit cube, its matrix and its offset."""
    generator = np.random.default_rng(seed)
    matrix, offset = generator.normal(size=(12, PARAMETERS)), generator.normal(size=12)
    units = generator.random((60, PARAMETERS))
    emulator = Emulator.fit(units, units @ matrix.T + offset)
    truth = np.array([0.45, 0.6, 0.5])
    y = (
        matrix @ truth
        + offset
        + SIGMA * generator.normal(size=12)
        + (1.3 if reading == "unnormalised" else 0.0)
    )
    data = tuple(Datum(f"c{i // 4}", f"t{i}", "amplitude", float(10.0 ** y[i]), SIGMA) for i in range(12))
    return Surrogate(Comparison(data, reading), emulator, np.zeros(12), tails=np.inf), matrix, y - offset


def test_posterior_and_evidence_of_a_linear_model(measured: Measured) -> None:
    surrogate, matrix, y = linear("absolute")
    posterior = sample_posterior(surrogate, PARAMETERS, discrepancy=False, points=4000)
    covariance = np.linalg.inv(matrix.T @ matrix) * SIGMA**2
    mean = covariance @ matrix.T @ y / SIGMA**2
    found = np.mean(posterior.points.units, axis=0)
    spread = np.std(posterior.points.units, axis=0)
    assert np.all(np.abs(found - mean) < 0.2 * np.sqrt(np.diag(covariance)))
    assert spread == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.15)
    # The prior is 1 over the cube and the posterior well inside it, so the evidence is a Gaussian integral.
    at_mean = np.sum(-0.5 * ((y - matrix @ mean) / SIGMA) ** 2 - 0.5 * np.log(2 * np.pi * SIGMA**2))
    exact = at_mean + 0.5 * np.log(np.linalg.det(2 * np.pi * covariance))
    assert posterior.log_evidence == pytest.approx(exact, abs=4 * posterior.log_evidence_error)
    measured("ln evidence of a linear model, error", abs(posterior.log_evidence - exact), "4 standard errors")


def test_the_common_factor_is_integrated_out(measured: Measured) -> None:
    surrogate, matrix, y = linear("unnormalised")
    posterior = sample_posterior(surrogate, PARAMETERS, discrepancy=False, points=4000)
    wide = np.column_stack((matrix, np.ones(12)))  # the factor is one more unknown of a linear model
    covariance = np.linalg.inv(wide.T @ wide) * SIGMA**2
    mean = covariance @ wide.T @ y / SIGMA**2
    assert np.mean(posterior.points.factor) == pytest.approx(mean[3], abs=0.2 * np.sqrt(covariance[3, 3]))
    at_mean = np.sum(-0.5 * ((y - wide @ mean) / SIGMA) ** 2 - 0.5 * np.log(2 * np.pi * SIGMA**2))
    exact = at_mean + 0.5 * np.log(np.linalg.det(2 * np.pi * covariance)) - np.log(FACTOR[1] - FACTOR[0])
    assert posterior.log_evidence == pytest.approx(exact, abs=4 * posterior.log_evidence_error)
    measured(
        "ln evidence with a common factor, error", abs(posterior.log_evidence - exact), "4 standard errors"
    )


def test_the_likelihood_is_students_t() -> None:
    from scipy.stats import t

    normal, _, _ = linear("absolute")
    surrogate = Surrogate(normal.comparison, normal.emulator, np.full(12, 0.03), tails=4.0)
    points = Points(np.array([[0.4, 0.5, 0.6]]), np.array([0.02]), np.zeros(1))
    scale = np.sqrt(SIGMA**2 + 0.03**2 + 0.02**2)
    exact = t.logpdf(surrogate.simulated(points) - surrogate.comparison.measured, 4.0, scale=scale)
    assert np.allclose(surrogate.log_densities(points), exact)


def test_scatter_of_the_model_is_found() -> None:
    surrogate, _, _ = linear("absolute")
    tight = tuple(Datum(d.condition, d.target, d.key, d.value, 0.001) for d in surrogate.comparison.data)
    posterior = sample_posterior(
        Surrogate(Comparison(tight, "absolute"), surrogate.emulator, np.zeros(12)),
        PARAMETERS,
        discrepancy=True,
    )
    low, _, high = posterior.quantiles(posterior.points.scatter)
    assert low < SIGMA < high


@pytest.mark.slow
def test_a_condition_left_out_is_predicted_by_the_others() -> None:
    surrogate, matrix, y = linear("absolute")
    inside = np.arange(12) >= 4
    covariance = np.linalg.inv(matrix[inside].T @ matrix[inside]) * SIGMA**2
    mean = covariance @ matrix[inside].T @ y[inside] / SIGMA**2
    predictive = multivariate_normal(
        matrix[~inside] @ mean, matrix[~inside] @ covariance @ matrix[~inside].T + SIGMA**2 * np.eye(4)
    )
    found = leave_one_out(surrogate, PARAMETERS, discrepancy=False, points=4000)[0]
    assert found.condition == "c0"
    assert found.log_density == pytest.approx(predictive.logpdf(y[~inside]), abs=0.35)
    assert found.residuals == pytest.approx(matrix[~inside] @ mean - y[~inside], abs=0.02)


def test_leave_one_out__a_single_condition_is_not_predicted_from_none() -> None:
    """Without other data the posterior is the prior: its prediction is no test of the fit."""
    comparison = Comparison(linear("absolute")[0].comparison.data[:4], "absolute")
    assert len({each.condition for each in comparison.data}) == 1
    trials = linear("absolute")[0]
    assert (
        leave_one_out(dataclasses.replace(trials, comparison=comparison), PARAMETERS, discrepancy=False) == []
    )


def test_leave_one_out__a_condition_does_not_affect_its_own_prediction() -> None:
    """Twice what was measured under one condition: the error shows there in full, and nothing else moves."""
    plan = small_plan()
    problem = KnownProblem(plan, plan.models[0])
    truth = problem.run(0, (0.4, 0.6), members=1000)
    data = data_of(plan, truth.observed)
    name = data[0].condition
    doubled = tuple(
        dataclasses.replace(d, value=2.0 * d.value) if d.condition == name and d.key == "amplitude" else d
        for d in data
    )
    trials = design_trials(problem, 64)
    honest, wrong = (
        hold_out(problem, Comparison(each, "absolute"), trials, None) for each in (data, doubled)
    )
    assert [each.condition for each in honest] == list(dict.fromkeys(d.condition for d in data))
    assert mean_error(honest, frequencies=False) < 25.0
    assert wrong[0].best == honest[0].best
    for label, before, now in zip(honest[0].labels, honest[0].residuals, wrong[0].residuals, strict=True):
        moved = -np.log10(2.0) if label.endswith(", amplitude") else 0.0
        assert now - before == pytest.approx(moved, abs=1e-12)


def standing(model: str, evidence: float, densities: list[float], bic: float = 0.0) -> Standing:
    return Standing(model, bic, evidence, 0.2, {f"c{i}": d for i, d in enumerate(densities)})


@pytest.mark.parametrize(
    ("evidence", "ahead", "winner"),
    [
        (10.0, [2.0, 3.0, 2.5, 2.0], "coupled"),
        (-10.0, [-2.0, -3.0, -2.5, -2.0], "uncoupled"),
        (10.0, [20.0, -10.0, 1.0, -2.0], OPEN),  # one condition decides
        (2.0, [2.0, 3.0, 2.5, 2.0], OPEN),  # odds below 20 : 1
        (10.0, [-2.0, -3.0, -2.5, -2.0], OPEN),  # the two disagree
    ],
)
def test_a_duel_needs_odds_and_predictions(evidence: float, ahead: list[float], winner: str) -> None:
    duel = compare_pairs([standing("coupled", evidence, ahead), standing("uncoupled", 0.0, [0.0] * 4)])[0]
    assert duel.winner == winner


def test_pairwise_comparison__error_includes_the_choice_of_trials() -> None:
    """Odds and predictions that two emulators leave open decide nothing."""
    sure = [standing("coupled", 10.0, [2.0, 3.0, 2.5, 2.0]), standing("uncoupled", 0.0, [0.0] * 4)]
    assert compare_pairs(sure)[0].winner == "coupled"
    unsure = dataclasses.replace(sure[0], predictive_error=6.0)
    assert compare_pairs([unsure, sure[1]])[0].winner == OPEN
    assert compare_pairs([unsure, sure[1]])[0].predictive_error == pytest.approx(
        np.hypot(6.0, 0.96), abs=0.02
    )
    assert compare_pairs([dataclasses.replace(sure[0], log_evidence_error=4.0), sure[1]])[0].winner == OPEN


@pytest.mark.slow
def test_the_emulators_share_of_the_error_is_how_other_trials_scatter(measured: Measured) -> None:
    """Evidence from eight sets of trials of one model: their scatter is what the jackknife says of each."""
    plan = small_plan()
    problem = KnownProblem(plan, plan.models[0])
    truth = problem.run(0, (0.4, 0.6), members=1000)
    comparison = Comparison(data_of(plan, truth.observed), "absolute")
    evidence, said = [], []
    for seed in range(8):
        points = 0.96 * np.random.default_rng(seed).random((48, 2))
        trials = [problem.run(n, u) for n, u in enumerate(points)]
        surrogate = Surrogate.of(comparison, trials)
        evidence.append(sample_posterior(surrogate, 2, discrepancy=False).log_evidence)
        said.append(emulator_errors(comparison, trials, 2, discrepancy=False))
    ratio = float(np.sqrt(np.mean(np.square(said)[:, 0])) / np.std(evidence, ddof=1))
    measured(
        "emulator's share of the error of ln evidence, over the scatter of eight sets", ratio, "0.5 to 2"
    )
    assert 0.5 < ratio < 2.0
    assert emulator_errors(comparison, trials[:7], 2, discrepancy=False) == (np.inf, np.inf)


def design_trials(problem: Problem, count: int) -> list[Trial]:
    from scipy.stats import qmc

    return [problem.run(n, 0.96 * u) for n, u in enumerate(qmc.Sobol(2, seed=3).random(count))]


@pytest.mark.slow
def test_known_parameters_are_recovered_with_honest_intervals(measured: Measured) -> None:
    plan = small_plan(uncertainty=0.03, frequency_uncertainty=0.03)
    problem = KnownProblem(plan, plan.models[0])
    found = recover(problem, design_trials(problem, 128), 60, members=16)
    for row in summary(found):
        # 60 intervals of 90 %: 46 to 60 hold the true value in 999 of 1000 cases.
        assert row.coverage >= 46 / 60, row
        measured(f"share of 90 % intervals that miss the true {row.name}", 1.0 - row.coverage, "23 %")
    drag = next(row for row in summary(found) if row.name == "drag")
    assert drag.identified > 50
    assert drag.median_error < 10.0


def test_a_parameter_that_nothing_depends_on_is_not_identified() -> None:
    plan = small_plan()
    extra = [*plan.model_dump(mode="json", exclude_none=True)["parameters"]]
    extra.append(
        {"name": "idle", "path": "sleeves.ring.restitution", "low": 0.1, "high": 0.9, "scale": "linear"}
    )
    plan = small_plan(parameters=extra)

    class Blind(KnownProblem):
        def observe(self, unit: object, **how: object) -> object:  # type: ignore[override]
            return super().observe(tuple(unit)[:2], **how)  # type: ignore[arg-type, call-overload]

    problem = Blind(plan, plan.models[0])
    generator = np.random.default_rng(0)
    trials = [problem.run(n, 0.96 * generator.random(3)) for n in range(100)]
    _, seen = synthetic(problem, 0, members=16, noise=0.02)
    surrogate = Surrogate.of(Comparison(data_of(plan, seen), "absolute"), trials, everywhere=True)
    posterior = sample_posterior(surrogate, 3, discrepancy=False)
    low, _, high = posterior.quantiles(posterior.points.units[:, 2])
    assert high - low > 0.75  # of the prior's 0.9


@pytest.mark.slow
def test_a_fit_survives_its_json_form() -> None:
    import json
    from dataclasses import asdict

    plan = small_plan()
    problem = KnownProblem(plan, plan.models[0])
    truth = problem.run(0, (0.4, 0.6), members=1000)
    comparison = Comparison(data_of(plan, truth.observed), "unnormalised")
    begun: list[int] = []
    fit = fit_model(problem, comparison, design_trials(problem, 64), begun.append)
    assert begun == list(range(len(STEPS)))
    assert fit_from(json.loads(json.dumps(asdict(fit)))) == fit
    assert fit.best["drag"] == pytest.approx(problem.values((0.4, 0.6))["drag"], rel=0.15)
    assert fit.amplitude_error < 15.0
    assert {row.condition for row in fit.rows} == {"slow", "fast"}
    assert len(fit.predicted) == len(fit.left_out) == 2


def test_a_fit_of_a_dying_motion_says_so() -> None:
    """Once with a target that dies away, once with one that only scatters: by how much, and where."""
    plan = small_plan()
    later = later_than(plan.simulation)
    assert later >= 4.0 * plan.simulation.transient

    class Dying(KnownProblem):
        def observe(self, unit: object, **how: object) -> object:  # type: ignore[override]
            seen = super().observe(unit, **how)  # type: ignore[arg-type, call-overload]
            if how["transient"] is not None:
                assert how["transient"] == later
                dying = seen["slow"]["radial"]["amplitude"]
                seen["slow"]["radial"]["amplitude"] = Observed(0.05 * dying.value, dying.error)
            return seen

    lasting, dying = KnownProblem(plan, plan.models[0]), Dying(plan, plan.models[0])
    truth = lasting.run(0, (0.4, 0.6), members=1000)
    comparison = Comparison(data_of(plan, truth.observed), "unnormalised")
    assert drifts(lasting, comparison, (0.4, 0.6), None) == []
    (found,) = drifts(dying, comparison, (0.4, 0.6), None)
    assert (found.condition, found.target, found.key) == ("slow", "radial", "amplitude")
    assert found.decades == pytest.approx(np.log10(0.05), abs=0.1)


def test_a_motion_that_fails_later_costs_no_fit() -> None:
    plan = small_plan()

    class Failing(KnownProblem):
        def observe(self, unit: object, **how: object) -> object:  # type: ignore[override]
            if how["transient"] is not None:
                raise TrialError("8 of 8 members failed")
            return super().observe(unit, **how)  # type: ignore[arg-type, call-overload]

    failing = Failing(plan, plan.models[0])
    truth = KnownProblem(plan, plan.models[0]).run(0, (0.4, 0.6), members=1000)
    assert drifts(failing, Comparison(data_of(plan, truth.observed), "unnormalised"), (0.4, 0.6), None) == []
