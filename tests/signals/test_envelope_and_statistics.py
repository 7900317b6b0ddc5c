"""Envelopes, spectrograms and statistics against closed forms."""

import math

import numpy as np
import pytest

from gearplay.files.record import Channel
from gearplay.signals.averaging import mean_square, power_density
from gearplay.signals.envelopes import envelope, envelope_spectrum, most_impulsive_band
from gearplay.signals.spectrograms import spectrogram
from gearplay.signals.statistics import signal_statistics

FS = 2000.0
T = np.arange(8000) / FS
AM = Channel(
    "a", (1.0 + 0.4 * np.cos(2 * np.pi * 7.0 * T)) * np.cos(2 * np.pi * 500.0 * T + 0.3), FS, "m/s^2"
)


def test_fft_envelope_of_a_modulated_carrier_is_exact() -> None:
    e = envelope(AM, 450.0, 550.0)
    np.testing.assert_allclose(e.channel.values, 1.0 + 0.4 * np.cos(2 * np.pi * 7.0 * T), atol=1e-10)
    np.testing.assert_allclose(e.band.values, AM.values, atol=1e-10)


def test_butterworth_envelope_is_the_same_away_from_the_ends() -> None:
    e = envelope(AM, 400.0, 600.0, filter="butterworth").channel.values
    np.testing.assert_allclose(e[800:-800], (1.0 + 0.4 * np.cos(2 * np.pi * 7.0 * T))[800:-800], atol=2e-3)


def test_a_whole_band_gives_back_the_signal() -> None:
    values = np.random.default_rng(1).standard_normal(1000)
    np.testing.assert_allclose(
        envelope(Channel("a", values, FS), 0.0, 1000.0).band.values, values, atol=1e-12
    )


def test_envelope_spectrum_has_the_modulations_line_and_no_carrier() -> None:
    s = envelope_spectrum(AM, 450.0, 550.0).spectrum
    assert s.values[28] == pytest.approx(0.4, rel=1e-9)
    assert s.frequency[28] == 7.0
    assert np.max(s.values[40:]) < 1e-9


def test_the_impulsive_band_holds_the_resonance() -> None:
    ring = np.exp(-60.0 * T[:400]) * np.sin(2 * np.pi * 700.0 * T[:400])
    shocks = np.zeros(T.size)
    shocks[::400] = 1.0
    values = np.convolve(shocks, ring)[: T.size] + 0.3 * np.random.default_rng(0).standard_normal(T.size)
    low, high = most_impulsive_band(Channel("a", values, FS))
    assert low < 700.0 < high


def test_the_impulsive_band_may_be_a_third() -> None:
    """A resonance at the edge of all halves and quarters is in the middle of the middle third."""
    ring = np.exp(-100.0 * T[:400]) * np.sin(2 * np.pi * 500.0 * T[:400])
    shocks = np.zeros(T.size)
    shocks[::400] = 1.0
    values = np.convolve(shocks, ring)[: T.size] + 0.1 * np.random.default_rng(0).standard_normal(T.size)
    assert most_impulsive_band(Channel("a", values, FS), levels=2) == pytest.approx((350.0, 650.0))


def test_spectrogram_follows_a_chirp() -> None:
    c = Channel("a", 2.0 * np.cos(2 * np.pi * (100.0 * T + 50.0 * T**2)), FS, "V", start=5.0)
    s = spectrogram(c, segment=256, overlap=0.75)
    ridge = s.frequency[np.argmax(s.values, axis=0)]
    assert np.max(np.abs(ridge - (100.0 + 100.0 * (s.time - 5.0)))) < 0.6 * s.resolution
    assert s.values.max() == pytest.approx(2.0, rel=0.02)
    assert s.time[0] == 5.0 + 128 / FS
    assert s.time[-1] <= 9.0 - 128 / FS


def test_spectrogram_density_averages_to_the_welch_density() -> None:
    c = Channel("a", np.random.default_rng(3).standard_normal(4096), FS)
    s = spectrogram(c, kind="density", segment=256)
    flat = power_density(c, segment=256, detrend="none")
    np.testing.assert_allclose(np.mean(s.values, axis=1)[2:], flat.values[2:], rtol=1e-9)
    assert mean_square(flat) == pytest.approx(1.0, rel=0.1)


def test_statistics_of_a_sine() -> None:
    s = signal_statistics(Channel("a", 3.0 * np.sin(2 * np.pi * 10.0 * T), FS, "V"))
    assert s.rms == pytest.approx(3.0 / math.sqrt(2.0), rel=1e-12)
    assert s.crest_factor == pytest.approx(math.sqrt(2.0), rel=1e-12)
    assert s.kurtosis == pytest.approx(1.5, rel=1e-12)
    assert s.skewness == pytest.approx(0.0, abs=1e-12)
    assert (s.peak, s.peak_to_peak, s.unit) == (3.0, 6.0, "V")


def test_kurtosis_of_noise_is_three_and_skewness_of_its_exponential_is_two() -> None:
    r = np.random.default_rng(0)
    assert signal_statistics(Channel("a", r.standard_normal(200_000), FS)).kurtosis == pytest.approx(
        3.0, abs=0.05
    )
    assert signal_statistics(Channel("a", r.exponential(size=400_000), FS)).skewness == pytest.approx(
        2.0, abs=0.05
    )


def test_removing_the_mean_changes_rms_and_peak_alone() -> None:
    c = Channel("a", 5.0 + np.sin(2 * np.pi * 10.0 * T), FS)
    about, kept = signal_statistics(c, remove_mean=True), signal_statistics(c)
    assert about.rms == pytest.approx(math.sqrt(0.5))
    assert kept.rms == pytest.approx(math.sqrt(25.5))
    assert about.kurtosis == kept.kurtosis


@pytest.mark.parametrize("value", [0.0, 4.2, 1e139, -1e-300])
def test_a_constant_has_no_kurtosis(value: float) -> None:
    s = signal_statistics(Channel("a", np.full(100, value), FS))
    assert math.isnan(s.kurtosis)
    assert s.rms == pytest.approx(abs(value), rel=1e-12)
