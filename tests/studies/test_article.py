"""Printed tables as data, and their audit."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from gearplay.parts.sleeve.amplitude import amplitude_bound as kinematic_bound
from gearplay.studies.han2021 import article, article_figures
from gearplay.studies.han2021.article import AMPLITUDE, FREQUENCY, MODELS, SOURCES, best_factor, mean_error
from gearplay.studies.han2021.findings import amplitude_bound, clearances


def test_rows__six_conditions_thirty_six_rows() -> None:
    assert article.conditions() == (
        (60, 100, 100),
        (120, 100, 100),
        (180, 100, 100),
        (120, 200, 100),
        (120, 100, 200),
        (120, 200, 200),
    )
    assert len(article.rows()) == 36
    for row in article.rows():
        for source in SOURCES:
            assert article.printed(source, row.quantity)[row.place] == row.values[source]


def test_printed_errors__four_do_not_follow_from_the_values() -> None:
    wrong = [row for row in article.rows() for model in MODELS if not row.follows(model)]
    assert len(wrong) == 4


def test_article_error__means_of_the_article() -> None:
    assert article.article_error("coupled", AMPLITUDE) == pytest.approx(7.3, abs=0.05)
    assert article.article_error("coupled", FREQUENCY, "radial") == pytest.approx(16.2, abs=0.05)
    assert article.article_error("uncoupled", FREQUENCY, "radial") == pytest.approx(17.1, abs=0.05)


def test_amplitude_bound__thirty_four_of_fifty_four_amplitudes_exceed_it() -> None:
    assert amplitude_bound(1e-4, 40.0) == pytest.approx(kinematic_bound(1e-4, 40.0), rel=1e-15)
    ratios = [
        article.printed(source, AMPLITUDE) / amplitude_bound(clearances(), article.printed(source, FREQUENCY))
        for source in SOURCES
    ]
    assert np.size(ratios) == 54
    assert np.sum(np.array(ratios) > 1.0) == 34


def test_free_factor__removes_most_of_the_uncoupled_error() -> None:
    assert [round(error, 1) for error in article.free_factor("uncoupled")] == [27.8, 15.0]
    assert [round(error, 1) for error in article.free_factor("coupled")] == [7.3, 7.2]


@pytest.mark.slow
def test_best_factor__no_other_factor_is_better() -> None:
    generator = np.random.default_rng(3)
    for _ in range(20):
        test, model = np.exp(generator.normal(size=(2, 9)))
        best = mean_error(test, model, best_factor(test, model))
        scan = best_factor(test, model) * np.linspace(0.2, 5.0, 4001)
        assert best <= min(mean_error(test, model, a) for a in scan) + 1e-9


def test_mesh_readings__scatter_by_a_third_of_a_hertz() -> None:
    assert [round(article.reading_scatter(harmonic), 2) for harmonic in (1, 2)] == [0.33, 0.38]
    assert article.mesh_readings(1).shape == (3, 6)
    # 120 rpm of 20 teeth are 40 Hz; the test's 39.991 is printed for the second condition
    assert article.mesh_readings(1)[0, 1] == pytest.approx(-0.009)
    correlation, p = article.harmonic_correlation()
    assert abs(correlation) < 0.2
    assert p > 0.3


def test_radial_error__within_that_of_two_readings() -> None:
    assert [round(article.radial_error(model), 2) for model in MODELS] == [0.40, 0.38]
    low, high = article.error_of_readings()
    assert low < 16.2 < 17.1 < high


def test_a_figure_is_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """`savefig` draws a figure with a layout engine twice."""
    drawn = []
    draw = Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda self, renderer: drawn.append(self) or draw(self, renderer))
    article_figures.printed_errors()
    assert len(drawn) == 1
