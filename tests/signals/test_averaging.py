"""Averaged spectra: Parseval, windows' corrections, agreement with SciPy's own, medians against shocks."""

import numpy as np
import pytest

from gearplay.files.record import Channel
from gearplay.signals.averaging import averaged_spectrum, mean_square, power_density

FS = 1000.0
NOISE = np.random.default_rng(4).standard_normal(6000) + 0.7


@pytest.mark.parametrize("window", ["boxcar", "hann", "flattop"])
@pytest.mark.parametrize("segment", [511, 512])
def test_windowed_density_obeys_parseval_in_its_exact_form(window: str, segment: int) -> None:
    from scipy.signal import get_window

    w = get_window(window, segment)
    s = power_density(Channel("a", NOISE, FS), window=window, segment=segment, overlap=0.0, detrend="none")
    parts = [NOISE[i : i + segment] for i in range(0, NOISE.size - segment + 1, segment)]
    exact = np.mean([np.sum((w * p) ** 2) for p in parts]) / np.sum(w**2)
    assert s.averages == len(parts)
    assert mean_square(s) == pytest.approx(exact, rel=1e-10)
    a = averaged_spectrum(Channel("a", NOISE, FS), window=window, segment=segment, overlap=0.0, detrend="none",
                          correction="energy").values  # fmt: skip
    lone = a[0] ** 2 + (a[-1] ** 2 if segment % 2 == 0 else 0.0)
    inner = a[1:-1] if segment % 2 == 0 else a[1:]
    assert lone + 0.5 * np.sum(inner**2) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("averaging", ["mean", "median"])
@pytest.mark.parametrize(("detrend", "theirs"), [("mean", "constant"), ("linear", "linear"), ("none", False)])
def test_density_is_that_of_scipy(averaging: str, detrend: str, theirs: object) -> None:
    from scipy.signal import welch

    s = power_density(Channel("a", NOISE, FS), segment=500, averaging=averaging, detrend=detrend)
    f, p = welch(NOISE, FS, window="hann", nperseg=500, noverlap=250, detrend=theirs, average=averaging)
    np.testing.assert_allclose(s.frequency, f)
    np.testing.assert_allclose(s.values, p, rtol=1e-10, atol=1e-18)


def test_chunks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = power_density(Channel("a", NOISE, FS), segment=256).values
    monkeypatch.setattr("gearplay.signals.averaging.CHUNK", 600)
    np.testing.assert_allclose(power_density(Channel("a", NOISE, FS), segment=256).values, whole, rtol=1e-12)


def test_steady_line__amplitude_does_not_depend_on_the_averaging() -> None:
    t = np.arange(8000) / FS
    c = Channel("a", 3.0 * np.sin(2.0 * np.pi * 125.0 * t), FS)
    for averaging in ("mean", "median"):
        s = averaged_spectrum(c, segment=800, averaging=averaging)
        assert s.values[100] == pytest.approx(3.0, rel=1e-9)


def test_a_median_shrugs_off_a_shock() -> None:
    values = np.random.default_rng(2).standard_normal(64 * 256)
    values[5000] += 300.0
    c = Channel("a", values, FS)
    level = {a: np.mean(power_density(c, segment=256, averaging=a).values) for a in ("mean", "median")}
    assert level["median"] == pytest.approx(2.0 / FS, rel=0.05)
    assert level["mean"] > 3.0 * level["median"]


def test_settings_are_carried_and_printed() -> None:
    s = averaged_spectrum(Channel("a", NOISE, FS), segment=1000, overlap=0.75, window="blackman")
    assert (s.segment, s.overlap, s.averages, s.window, s.resolution) == (1000, 0.75, 21, "blackman", 1.0)
    assert s.noise_bandwidth == pytest.approx(1.7268, rel=1e-3)
    assert "21 segments of 1000, overlap 75 %" in s.caption


def test_a_median_of_noise_keeps_its_mean_square() -> None:
    c = Channel("a", np.random.default_rng(2).standard_normal(256 * 256), FS)
    mean, median = (
        averaged_spectrum(c, segment=256, averaging=a, correction="energy").values for a in ("mean", "median")
    )
    assert np.sum(median**2) == pytest.approx(np.sum(mean**2), rel=0.03)
