"""Spectra and lines against known sums of tones, Parseval's theorem and the statistics of noise."""

import numpy as np
import pytest

from gearplay.results.spectra import amplitude_spectrum, ensemble_spectrum, smoothed
from gearplay.signals.lines import find_hump, find_line
from gearplay.vocabulary.errors import InputError

SAMPLING = 1000.0
TIME = np.arange(8000) / SAMPLING


def tone(frequency: float, amplitude: float, phase: float = 0.3) -> np.ndarray:
    return amplitude * np.sin(2.0 * np.pi * frequency * TIME + phase)


@pytest.mark.parametrize("window", ["hann", "boxcar"])
def test_a_tone_on_a_bin_has_its_amplitude(window: str) -> None:
    spectrum = amplitude_spectrum(tone(50.0, 3.0) + 7.0, SAMPLING, window=window)
    at = int(np.argmax(spectrum.amplitude))
    assert spectrum.frequency[at] == pytest.approx(50.0)
    assert spectrum.amplitude[at] == pytest.approx(3.0, rel=1e-9)
    assert spectrum.amplitude[0] < 1e-9, "the mean is taken off"


def test_unnormalised_is_half_the_samples_times_the_amplitude() -> None:
    spectrum = amplitude_spectrum(tone(50.0, 3.0), SAMPLING, window="boxcar", normalisation="unnormalised")
    assert spectrum.amplitude.max() == pytest.approx(3.0 * TIME.size / 2.0, rel=1e-9)


def test_boxcar_spectrum_obeys_parseval() -> None:
    signal = np.random.default_rng(1).standard_normal(TIME.size)
    signal -= signal.mean()
    a = amplitude_spectrum(signal, SAMPLING, window="boxcar").amplitude
    power = np.sum(a[1:-1] ** 2) / 2.0 + a[-1] ** 2
    assert power == pytest.approx(np.mean(signal**2), rel=1e-12)


@pytest.mark.parametrize("window", ["hann", "boxcar", "blackman"])
@pytest.mark.parametrize("offset", [0.0, 0.13, 0.37, 0.5, 0.81])
def test_line_between_bins_is_resolved(window: str, offset: float) -> None:
    resolution = SAMPLING / TIME.size
    frequency = 40.0 + offset * resolution
    line = find_line(amplitude_spectrum(tone(frequency, 2.0), SAMPLING, window=window), 40.0)
    exact = window != "blackman"
    assert abs(line.frequency - frequency) < (0.01 if exact else 0.05) * resolution
    assert line.amplitude == pytest.approx(2.0, rel=1e-3 if exact else 2e-2)


def test_the_highest_line_of_the_band_is_taken() -> None:
    spectrum = amplitude_spectrum(tone(40.5, 1.0) + tone(60.0, 5.0), SAMPLING)
    assert find_line(spectrum, 40.0).frequency == pytest.approx(40.5, abs=1e-3)
    assert find_line(spectrum, 40.0).prominence > 100.0


def test_an_empty_band_is_refused() -> None:
    spectrum = amplitude_spectrum(tone(40.0, 1.0), SAMPLING)
    with pytest.raises(InputError, match="band"):
        find_hump(spectrum, 700.0, 800.0)


def test_a_hump_is_found_at_the_resonance_of_filtered_noise() -> None:
    generator = np.random.default_rng(5)
    frequency = np.fft.rfftfreq(TIME.size, 1.0 / SAMPLING)
    shape = 1.0 / np.abs(1.0 - (frequency / 3.0) ** 2 + 0.3j * frequency / 3.0)
    records = [np.fft.irfft(np.fft.rfft(generator.standard_normal(TIME.size)) * shape) for _ in range(32)]
    hump = find_hump(ensemble_spectrum(records, SAMPLING), 0.6, 8.0)
    assert hump.frequency == pytest.approx(3.0 * np.sqrt(1.0 - 0.3**2 / 2.0), rel=0.05)


def test_ensemble_average_is_rms_and_its_spread_is_that_of_the_members() -> None:
    amplitudes = np.array([1.0, 2.0, 4.0])
    spectrum = ensemble_spectrum([tone(50.0, a) for a in amplitudes], SAMPLING)
    at = int(np.argmax(spectrum.amplitude))
    assert spectrum.amplitude[at] == pytest.approx(np.sqrt(np.mean(amplitudes**2)))
    assert spectrum.spread is not None
    assert spectrum.spread[at] == pytest.approx(np.std(np.log10(amplitudes), ddof=1))


def test_smoothing_keeps_a_flat_spectrum_flat() -> None:
    records = [np.random.default_rng(i).standard_normal(TIME.size) for i in range(64)]
    _, amplitude = smoothed(ensemble_spectrum(records, SAMPLING), 50.0, 200.0, 0.1)
    assert np.ptp(amplitude) < 0.1 * amplitude.mean()


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.zeros(3), np.array([np.nan] * 20)])
def test_unfit_records_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(InputError, match="signal"):
        amplitude_spectrum(bad, SAMPLING)


def test_unknown_window_and_normalisation_are_refused() -> None:
    with pytest.raises(InputError, match="window"):
        amplitude_spectrum(tone(1.0, 1.0), SAMPLING, window="hanning-tukey-x")
    with pytest.raises(InputError, match="normalisation"):
        amplitude_spectrum(tone(1.0, 1.0), SAMPLING, normalisation="dB")
