"""The radial frequency f_r over the six published conditions, with the drag as the one fitted constant."""

import pytest

from gearplay.published.article import conditions, printed
from gearplay.published.comparison import radial_frequency_error
from gearplay.published.han2021 import run_study
from gearplay.published.settings import Settings


@pytest.mark.slow
@pytest.mark.study
def test_radial_frequency_is_within_ten_per_cent() -> None:
    settings = Settings(parameters="assumed", history=0.01, duration=16.0, transient=2.0, seed=0)
    results = run_study(settings, names=("coupled",))
    error = radial_frequency_error(results, "coupled")
    assert error <= 10.0
    # the article's own coupled model, recomputed from its tables
    theirs = sum(printed(c, "radial", "frequency_hz").recomputed_error("coupled") for c in conditions()) / 6.0
    assert theirs == pytest.approx(16.2, abs=0.05)
    # the swing's law: f_r over sqrt(speed / clearance) is one constant for all six
    ratios = [r.lines["radial"].frequency / r.swing_frequency for r in results]
    assert max(ratios) / min(ratios) < 1.25
