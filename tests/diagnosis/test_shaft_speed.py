"""Speed of the first shaft from a spectrum, and its uncertainty."""

import numpy as np
import pytest

import gearplay as gp
from gearplay.diagnosis.machine import machine_of_teeth
from gearplay.diagnosis.shaft_speed import FoundSpeed, found_speed
from gearplay.results.spectra import amplitude_spectrum

RATE, SIZE = 5000.0, 20_000


def found(seed: int, off: float = 0.0) -> tuple[FoundSpeed, float]:
    """Return the speed found of a shaft with 23 teeth, its second harmonic off by a share, in noise, and the true one [Hz]."""
    rng = np.random.default_rng(seed)
    f = 25.0 * (1.0 + rng.uniform(-0.02, 0.02))
    t = np.arange(SIZE) / RATE
    lines = ((1.0, 1.0), (2.0 + 2.0 * off, 0.4), (3.0, 0.2))
    x = sum(a * np.cos(2 * np.pi * 23 * h * f * t + rng.uniform(0, 6)) for h, a in lines)
    spectrum = amplitude_spectrum(x + 2.0 * rng.standard_normal(SIZE), RATE)
    return found_speed(spectrum, machine_of_teeth("23:61"), 25.0), f


def test_uncertainty__is_the_standard_deviation_of_the_error() -> None:
    every = [found(seed) for seed in range(60)]
    assert {speed.source for speed, _ in every} == {"mesh"}
    ratios = np.array([(speed.frequency - f) / speed.uncertainty for speed, f in every])
    assert 0.75 < np.sqrt(np.mean(ratios**2)) < 1.25
    assert np.mean(np.abs(ratios) < 2.0) > 0.9


def test_uncertainty__grows_where_lines_disagree() -> None:
    """Half a line of the spectrum between the second harmonic and twice the first is more than noise explains."""
    exact, apart = (np.mean([found(seed, off)[0].uncertainty for seed in range(8)]) for off in (0.0, 1e-4))
    assert apart > 2.0 * exact


@pytest.mark.parametrize(
    ("speed", "words"),
    [
        (FoundSpeed(25.126825, 2.9e-6, "mesh"), "1507.60950 ± 0.00017 rpm, by its mesh lines"),
        (FoundSpeed(25.0, 0.5, "envelope"), "1500 ± 30 rpm, by its turns in an envelope"),
        (FoundSpeed(25.0, 0.0, "measured"), "1500 rpm, as measured, with its deviation over the record"),
    ],
)
def test_speed__as_text_to_two_digits_of_its_uncertainty(speed: FoundSpeed, words: str) -> None:
    assert speed.words == words


def test_given_speed__has_two_per_cent() -> None:
    noise = gp.Channel("a", np.random.default_rng(3).standard_normal(20_000), 12_000.0)
    message = gp.diagnose(noise, bearings="6205", speed="1800 rpm").message
    assert "first shaft 1800 ± 36 rpm, as given, since none of" in message


def test_measured_speed__has_its_deviation_over_the_record() -> None:
    rng, t = np.random.default_rng(1), np.arange(40_000) / 10_000.0
    rpm = gp.Channel("n", 1500.0 * (1.0 + 0.01 * np.sin(2 * np.pi * t)), 10_000.0, "rpm")
    x = gp.Channel("a", np.cos(23 * 2 * np.pi * 25.0 * t) + rng.standard_normal(t.size), 10_000.0)
    found = gp.diagnose(x, teeth="23:61", speed=rpm)
    assert 60.0 * float(found.ds["shaft_speed_uncertainty"]) == pytest.approx(15.0 / np.sqrt(2.0), rel=0.01)
    assert found.ds["shaft_speed_uncertainty"].attrs["long_name"] == "its standard deviation over the record"
    assert f"first shaft {found.ds.attrs['speed']}" in found.message
