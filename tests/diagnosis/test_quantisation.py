"""Quantisation step of a record, and records so quiet that its noise follows the meshing."""

import numpy as np
import pytest

import gearplay as gp
from gearplay.diagnosis.quantisation import is_quantisation, quantisation_step

RATE, SIZE = 20_000.0, 60_000


def quiet(amplitude: float, noise: float, step: float) -> gp.Channel:
    """Return the mesh of a pair 23:61 at 1506 rpm, amplitude and noise in steps of its quantisation."""
    t = np.arange(SIZE) / RATE
    turn = 2 * np.pi * 25.1 * t
    wave = (
        (1.0 + 0.05 * np.cos(turn)) * np.cos(23 * turn) + 0.4 * np.cos(46 * turn + 1.0) + 0.2 * np.cos(turn)
    )
    x = amplitude * wave + noise * np.random.default_rng(3).standard_normal(SIZE)
    return gp.Channel("acc", step * np.round(x) if step > 0.0 else x, RATE, "g")


@pytest.mark.parametrize(
    ("amplitude", "noise"), [(0.5, 0.0), (0.4, 0.3), (1.0, 0.1), (4.0, 0.0), (10.0, 0.0)]
)
def test_quantised_quiet_record__is_no_rattle(amplitude: float, noise: float) -> None:
    found = gp.diagnose(quiet(amplitude, noise, 0.0012), teeth="23:61", speed="1500 rpm")
    assert not found.told, found.message
    said = [sentence for sentence in found.cannot_be_told if sentence.startswith("Rattle cannot be told")]
    assert len(said) == 1
    assert said[0].endswith("may be quantisation, in steps of 0.0012 g.")


def test_noise_of_half_a_step__makes_quantisation_harmless() -> None:
    found = gp.diagnose(quiet(4.0, 0.7, 0.0012), teeth="23:61", speed="1500 rpm")
    assert not found.told
    assert "Rattle" not in " ".join(found.cannot_be_told)


@pytest.mark.parametrize("offset", [0.0, 0.37])
@pytest.mark.parametrize("step", [1.0, 0.0012, 2.5e-7])
def test_step__of_scaled_counts(step: float, offset: float) -> None:
    counts = np.round(300.0 * np.random.default_rng(1).standard_normal(20_000))
    assert quantisation_step(offset + step * counts) == pytest.approx(step, rel=1e-6)


def test_step__of_text_rounded_to_six_digits() -> None:
    values = np.array([float(f"{0.0012 * k:.6g}") for k in range(-300, 300)])
    assert quantisation_step(values) == pytest.approx(0.0012, rel=1e-3)


def test_step__of_continuous_values_is_none() -> None:
    rng = np.random.default_rng(2)
    assert quantisation_step(rng.standard_normal(20_000)) == 0.0
    assert quantisation_step(rng.standard_normal(20_000).astype(np.float32).astype(float)) == 0.0
    assert quantisation_step(np.ones(100)) == 0.0


def test_noise_of_half_a_step__is_the_limit() -> None:
    """With Gaussian noise of half a step the level is sqrt(1/4 + 1/12) steps, twice that of quantisation."""
    noise = np.random.default_rng(4).standard_normal(100_000)
    rms = [float(np.std(np.round(share * noise))) for share in (0.45, 0.5, 0.55)]
    assert rms[1] == pytest.approx(np.sqrt(1 / 4 + 1 / 12), rel=0.02)
    assert [is_quantisation(each, 1.0) for each in (rms[0], rms[2])] == [True, False]
