import numpy as np
import pytest

from gearplay.calibration.observe import Ensemble, observe
from gearplay.calibration.plan import HumpTarget, LevelTarget, LineTarget, StatisticTarget

SAMPLING, SECONDS = 1000.0, 8.0
T = np.arange(int(SAMPLING * SECONDS)) / SAMPLING


def ensemble(members: int = 8, noise: float = 0.0, seed: int = 0) -> Ensemble:
    generator = np.random.default_rng(seed)
    tones = 0.5 * np.sin(2 * np.pi * 2.3 * T) + 3.0 * np.sin(2 * np.pi * 40.03 * T + 1.0)
    return Ensemble(tones + noise * generator.normal(size=(members, T.size)), SAMPLING, 40.0)


LINE = LineTarget(name="mesh", order=1)
HUMP = HumpTarget(name="radial", band=(1.0, 6.0), width=0.03)
LEVEL = LevelTarget(name="band", band=(30.0, 50.0))
RMS = StatisticTarget(name="rms", statistic="rms")


def test_tones_are_seen_with_their_amplitudes_frequencies_and_displacements() -> None:
    seen = observe([LINE, HUMP, LEVEL, RMS], ensemble())
    mesh = seen["mesh"]
    assert mesh["frequency"].value == pytest.approx(40.03, abs=0.001)
    assert mesh["amplitude"].value == pytest.approx(3.0, rel=2e-3)
    assert mesh["displacement"].value == pytest.approx(3.0 / (2 * np.pi * 40.03) ** 2, rel=2e-3)
    assert seen["radial"]["frequency"].value == pytest.approx(2.3, abs=0.1)
    assert seen["band"]["amplitude"].value == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-3)
    assert seen["rms"]["value"].value == pytest.approx(np.sqrt(0.5 * (0.25 + 9.0)), rel=2e-3)
    assert all(o.error < 1e-9 for keys in seen.values() for o in keys.values())  # all members are alike


def test_the_jackknife_error_is_the_scatter_between_ensembles() -> None:
    seen = [observe([RMS], ensemble(8, 2.0, seed))["rms"]["value"] for seed in range(40)]
    scatter = np.std(np.log10([s.value for s in seen]), ddof=1)
    assert np.sqrt(np.mean([s.error**2 for s in seen])) == pytest.approx(scatter, rel=0.4)


def test_a_single_record_has_no_error_of_its_own() -> None:
    assert observe([RMS], ensemble(1, 2.0))["rms"]["value"].error == 0.0


def test_statistics_of_known_shapes() -> None:
    kurtosis = StatisticTarget(name="k", statistic="kurtosis")
    crest = StatisticTarget(name="c", statistic="crest_factor")
    sine = Ensemble(np.tile(np.sin(2 * np.pi * 5.0 * T), (2, 1)), SAMPLING, 40.0)
    seen = observe([kurtosis, crest], sine)
    assert seen["k"]["value"].value == pytest.approx(1.5)
    assert seen["c"]["value"].value == pytest.approx(np.sqrt(2.0))
