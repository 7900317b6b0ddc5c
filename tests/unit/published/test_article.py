"""The published tables as data: counts, the four wrong errors, the impossible amplitudes."""

import pytest

from gearplay.model.geometry import amplitude_bound
from gearplay.published.article import conditions, printed, printed_rows
from gearplay.published.comparison import article_error


def test_six_conditions_and_thirty_six_rows() -> None:
    assert [(c.speed_rpm, c.radial_clearance_um, c.backlash_um) for c in conditions()] == [
        (60, 100, 100),
        (120, 100, 100),
        (180, 100, 100),
        (120, 200, 100),
        (120, 100, 200),
        (120, 200, 200),
    ]
    assert len(printed_rows()) == 36


def test_four_printed_errors_do_not_follow_from_their_values() -> None:
    wrong = [r for r in printed_rows() for m in ("coupled", "uncoupled") if not r.printed_error_follows(m)]
    assert len(wrong) == 4


def test_the_articles_own_errors_are_recomputed() -> None:
    assert article_error("coupled", "amplitude_as_printed") == pytest.approx(7.3, abs=0.05)
    assert article_error("coupled", "frequency_hz", "radial") == pytest.approx(16.2, abs=0.05)
    assert article_error("uncoupled", "frequency_hz", "radial") == pytest.approx(17.1, abs=0.05)


def test_thirty_four_of_fifty_four_amplitudes_exceed_the_kinematic_bound() -> None:
    ratios = [
        getattr(r, source)
        / amplitude_bound(
            1e-6 * r.condition.radial_clearance_um,
            getattr(printed(r.condition, r.line, "frequency_hz"), source),
        )
        for r in printed_rows()
        if r.quantity == "amplitude_as_printed"
        for source in ("test", "coupled", "uncoupled")
    ]
    assert len(ratios) == 54
    assert sum(ratio > 1.0 for ratio in ratios) == 34


def test_the_bound_is_that_of_a_square_wave() -> None:
    # 4/pi: first Fourier coefficient of a square wave of amplitude 1
    assert amplitude_bound(1.0, 1.0) == pytest.approx(
        4.0 / 3.141592653589793 * (2.0 * 3.141592653589793) ** 2
    )
