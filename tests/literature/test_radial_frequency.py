"""The radial frequency f_r over the six published conditions, with the drag as the one fitted constant."""

import pytest

from gearplay.studies.han2021.article import FREQUENCY, article_error
from gearplay.studies.han2021.comparison import by_model
from gearplay.studies.han2021.simulation import Settings, run_study


@pytest.mark.slow
@pytest.mark.study
def test_radial_frequency__within_ten_per_cent() -> None:
    settings = Settings(parameters="assumed", history=0.01, duration=16.0, transient=2.0, seed=0)
    results = run_study(settings, names=("coupled",))
    assert by_model(results)["coupled"].radial_error() <= 10.0
    # the article's own coupled model, recomputed from its tables
    assert article_error("coupled", FREQUENCY, "radial") == pytest.approx(16.2, abs=0.05)
    # the swing's law: f_r over sqrt(speed / clearance) is one constant for all six
    ratios = [r.lines[0].frequency / r.swing_frequency for r in results]
    assert max(ratios) / min(ratios) < 1.25
