import numpy as np
import pytest

from calibration_problems import KnownProblem, small_plan
from gearplay.calibration.objective import Comparison, data_of, printed_measurements
from gearplay.calibration.observe import Observed
from gearplay.calibration.trials import Trial

PLAN = small_plan()
DATA = data_of(PLAN, printed_measurements(PLAN))
TRIAL = KnownProblem(PLAN, PLAN.models[0]).run(0, (0.3, 0.6))


def scaled(trial: Trial, factor: float, *keys: str) -> Trial:
    seen = {
        c: {
            t: {k: Observed(o.value * (factor if k in keys else 1.0), o.error) for k, o in ks.items()}
            for t, ks in ts.items()
        }
        for c, ts in trial.observed.items()
    }
    return Trial(trial.number, trial.unit, seen)


def objective(reading: str, trial: Trial) -> float:
    comparison = Comparison(DATA, reading)
    return float(comparison.objective(*comparison.logs_of([trial]))[0])


def test_data_come_in_the_plans_order_without_displacements() -> None:
    assert [(d.condition, d.target, d.key) for d in DATA[:3]] == [
        ("slow", "radial", "amplitude"),
        ("slow", "radial", "frequency"),
        ("slow", "mesh", "amplitude"),
    ]


def test_a_common_factor_of_the_amplitudes_matters_in_the_absolute_reading_only() -> None:
    louder = scaled(TRIAL, 7.0, "amplitude")
    assert objective("unnormalised", louder) == pytest.approx(objective("unnormalised", TRIAL))
    assert abs(objective("absolute", louder) - objective("absolute", TRIAL)) > 100.0
    comparison = Comparison(DATA, "unnormalised")
    logs, errors = comparison.logs_of([TRIAL, louder])
    factors = comparison.log_factor(logs, comparison.uncertainty**2 + errors**2)
    assert factors[0] - factors[1] == pytest.approx(np.log10(7.0))


def test_frequencies_are_not_part_of_the_factor() -> None:
    assert objective("unnormalised", scaled(TRIAL, 1.5, "frequency")) != pytest.approx(
        objective("unnormalised", TRIAL)
    )


def test_the_displacement_reading_compares_micrometres() -> None:
    comparison = Comparison(DATA, "displacement")
    logs, _ = comparison.logs_of([TRIAL])
    seen = TRIAL.observed["slow"]["radial"]
    assert 10.0 ** logs[0, 0] == pytest.approx(1e6 * seen["displacement"].value)
    assert 10.0 ** logs[0, 1] == pytest.approx(seen["frequency"].value)
    assert objective("displacement", scaled(TRIAL, 3.0, "amplitude")) == pytest.approx(
        objective("displacement", TRIAL)
    )


def test_the_objective_is_minus_two_log_likelihood() -> None:
    from scipy.stats import norm

    comparison = Comparison(DATA, "absolute")
    logs, errors = comparison.logs_of([TRIAL])
    sigma = np.sqrt(comparison.uncertainty**2 + errors[0] ** 2)
    exact = -2.0 * np.sum(norm.logpdf(logs[0], comparison.measured, sigma))
    constant = np.sum(np.log(2.0 * np.pi * comparison.uncertainty**2))
    assert comparison.objective(logs, errors)[0] == pytest.approx(exact - constant)


def test_mean_errors_are_in_per_cent_of_the_measured_values() -> None:
    comparison = Comparison(DATA, "absolute")
    logs = np.array([comparison.measured + np.log10(np.where(comparison.frequencies, 1.1, 0.8))])
    amplitude, frequency = comparison.mean_errors(logs, np.zeros_like(logs))
    assert amplitude[0] == pytest.approx(20.0)
    assert frequency[0] == pytest.approx(10.0)
