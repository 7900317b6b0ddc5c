"""What the article's tables say by themselves."""

import numpy as np
import pytest

from gearplay.published.audit import (
    MESH_LINES,
    best_factor,
    error_of_readings,
    free_factor,
    harmonic_correlation,
    mean_error,
    mesh_readings,
    radial_error,
    reading_scatter,
)


def test_one_free_factor_takes_most_of_the_uncoupled_error() -> None:
    coupled, uncoupled = free_factor("coupled"), free_factor("uncoupled")
    assert (round(uncoupled.as_printed, 1), round(uncoupled.with_factor, 1)) == (27.8, 15.0)
    assert (round(coupled.as_printed, 1), round(coupled.with_factor, 1)) == (7.3, 7.2)


@pytest.mark.slow
def test_no_other_factor_does_better() -> None:
    generator = np.random.default_rng(3)
    for _ in range(20):
        test, model = np.exp(generator.normal(size=(2, 9)))
        best = mean_error(test, model, best_factor(test, model))
        scan = best_factor(test, model) * np.linspace(0.2, 5.0, 4001)
        assert best <= min(mean_error(test, model, a) for a in scan) + 1e-9


def test_mesh_lines_are_read_to_a_third_of_a_hertz() -> None:
    assert [round(reading_scatter(line), 2) for line in MESH_LINES] == [0.33, 0.38]
    assert mesh_readings("mesh_1x").shape == (3, 6)
    # 120 rpm of 20 teeth are 40 Hz; the test's 39.991 is printed for the second condition
    assert mesh_readings("mesh_1x")[0, 1] == pytest.approx(-0.009)
    correlation, p = harmonic_correlation()
    assert abs(correlation) < 0.2
    assert p > 0.3


def test_the_radial_frequencys_errors_are_what_such_readings_make() -> None:
    assert [round(radial_error(model), 2) for model in ("coupled", "uncoupled")] == [0.40, 0.38]
    low, high = error_of_readings()
    assert low < 16.2 < 17.1 < high
