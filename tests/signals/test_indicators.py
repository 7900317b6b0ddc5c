"""Condition indicators of gears against closed forms and an independent computation."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import gearplay as gp
from gearplay.signals import gear_indicators, split_average, synchronous_average
from gearplay.signals.indicators import GearIndicators

N, TEETH = 4096, 24
SEVERITIES = (0.0, 0.1, 0.2, 0.4, 0.8)
P = 2.0 * np.pi * np.arange(N) / N


def average(severity: float) -> NDArray[np.float64]:
    """Return three mesh harmonics, two shaft orders, a pair of sidebands, two other orders and a burst at one tooth."""
    off = (P - 1.2 + np.pi) % (2.0 * np.pi) - np.pi
    lines = {24: (1.0, 0.0), 48: (0.4, 0.5), 72: (0.15, 1.0), 1: (0.2, 0.0), 2: (0.05, 0.3), 23: (0.1, 0.0),
             25: (0.06, 0.7), 37: (0.02, 0.0), 71: (0.015, 0.4)}  # fmt: skip
    tones = sum((a * np.cos(order * P + phase) for order, (a, phase) in lines.items()), np.zeros(N))
    return tones + severity * np.exp(-((off / 0.03) ** 2)) * np.cos(300.0 * off)


# Computed independently of this package, printed to eight digits.
PRINTED = {
    0.0: {"fm0": 1.84407879, "fm4": 1.5, "m6a": 2.5, "m8a": 4.375, "energy_ratio": 0.01807016, "sideband_index": 0.08,
          "sideband_level_factor": 0.20326373, "na4": 2.4160247},
    0.2: {"fm0": 1.84606427, "fm4": 18.54627598, "m6a": 1375.99624771, "m8a": 126343.14179225, "energy_ratio": 0.02230475},
    0.8: {"fm0": 2.15324913, "fm4": 109.36575148, "m6a": 19679.63618308, "m8a": 4015449.12046499,
          "energy_ratio": 0.05533296, "na4": 8.46961477},
}  # fmt: skip


@pytest.mark.parametrize("severity", PRINTED)
def test_indicators__an_independent_computation(severity: float) -> None:
    found = gear_indicators(average(severity), TEETH)
    for name, value in PRINTED[severity].items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-7, abs=5.1e-9), name


def test_na4__against_the_records_before() -> None:
    printed = (2.4160247, 2.41147695, 2.4355625, 3.00417328, 11.73972057)
    every = [average(s) for s in SEVERITIES]
    found = [gear_indicators(x, TEETH, history=every[:k]).na4 for k, x in enumerate(every)]
    np.testing.assert_allclose(found, printed, rtol=1e-7)


def test_history__raises_na4_where_variance_has_grown() -> None:
    quiet, loud = 0.5 * average(0.4), average(0.4)
    # Variances 1 and 4 of the same shape: the mean 2.5 instead of 4, squared (4 / 2.5)^2.
    alone = gear_indicators(loud, TEETH).na4
    assert gear_indicators(loud, TEETH, history=[quiet]).na4 == pytest.approx(alone * 1.6**2, rel=1e-12)


def test_a_sine_as_difference__moments_of_a_sine() -> None:
    found = gear_indicators(np.cos(TEETH * P) + 0.3 * np.cos(37 * P), TEETH)
    assert (found.fm4, found.m6a, found.m8a) == pytest.approx((1.5, 2.5, 4.375), rel=1e-12)
    assert found.energy_ratio == pytest.approx(0.3, rel=1e-12)


def test_noise_as_difference__moments_of_a_normal_distribution() -> None:
    noise = 0.01 * np.random.default_rng(0).standard_normal(1 << 18)
    p = 2.0 * np.pi * np.arange(noise.size) / noise.size
    found = gear_indicators(np.cos(TEETH * p) + noise, TEETH)
    assert found.fm4 == pytest.approx(3.0, rel=0.02)
    assert found.m6a == pytest.approx(15.0, rel=0.06)
    assert found.m8a == pytest.approx(105.0, rel=0.2)


def test_amplitude_modulation__sidebands_and_envelope() -> None:
    """(1 + m cos p) cos z p: sidebands m/2 each, envelope 1 + m cos p."""
    m = 0.3
    found = gear_indicators((1.0 + m * np.cos(P)) * np.cos(TEETH * P), TEETH)
    rms = math.sqrt(0.5 * (1.0 + 0.5 * m * m))
    assert found.sideband_index == pytest.approx(0.5 * m, rel=1e-12)
    assert found.sideband_level_factor == pytest.approx(m / rms, rel=1e-12)
    assert found.nb4 == pytest.approx(1.5, rel=1e-12)
    assert found.rms == pytest.approx(rms, rel=1e-12)
    assert found.fm0 == pytest.approx(
        2.0 + m + m * math.cos(math.pi / TEETH), rel=2e-4
    )  # peaks between samples


def test_nb4__the_band_of_half_a_mesh_order() -> None:
    """A modulation 8 orders wide is within it, a line 13 orders above the mesh outside."""
    m = 0.3
    x = (1.0 + m * np.cos(8 * P)) * np.cos(TEETH * P)
    found = gear_indicators(x + 0.5 * np.cos((TEETH + 13) * P), TEETH)
    assert found.nb4 == pytest.approx(1.5, rel=1e-9)


def test_a_growing_event__which_indicators_see_it() -> None:
    """Six measures rise with the event; kurtosis and crest factor of the average do not see it, NA4 of one record falls first."""
    found = [gear_indicators(average(s), TEETH) for s in SEVERITIES]
    parts = [split_average(average(s), TEETH).difference for s in SEVERITIES]
    rising = {name: [getattr(each, name) for each in found] for name in ("fm4", "m6a", "m8a", "energy_ratio")}
    from scipy.signal import hilbert

    rising["difference"] = [float(np.std(d)) for d in parts]
    rising["its envelope"] = [float(np.sqrt(np.mean(np.abs(hilbert(d)) ** 2))) for d in parts]
    for name, values in rising.items():
        assert np.all(np.diff(values) > 0.0), name
    assert found[1].na4 < found[0].na4
    assert abs(found[2].kurtosis / found[0].kurtosis - 1.0) < 0.02
    assert abs(found[2].crest_factor / found[0].crest_factor - 1.0) < 0.02


def test_parts__add_up_and_share_nothing() -> None:
    x = average(0.4)
    parts = split_average(x, TEETH)
    np.testing.assert_allclose(parts.regular + parts.residual, x - np.mean(x), atol=1e-12)
    beside = parts.residual - parts.difference
    assert abs(float(np.mean(beside * parts.difference))) < 1e-15
    np.testing.assert_allclose(parts.mesh[:3], (1.0, 0.4, 0.15), atol=0.02)
    np.testing.assert_allclose(parts.sidebands[0], (0.1, 0.06), atol=0.02)


def test_a_synchronous_average_is_taken() -> None:
    rate, turns = 4096.0, 20.0
    t = np.arange(int(20 * rate)) / rate
    angle = 2 * np.pi * turns * t
    channel = gp.Channel("acc", np.cos(TEETH * angle) + 0.1 * np.cos((TEETH + 1) * angle), rate, "g")
    found = gear_indicators(synchronous_average(channel, 2 * np.pi * turns), TEETH)
    assert isinstance(found, GearIndicators)
    assert found.sideband_index == pytest.approx(0.05, rel=1e-3)
    assert (found.unit, found.name, found.teeth) == ("g", "acc", TEETH)


def test_nothing_beside_the_mesh__not_defined() -> None:
    found = gear_indicators(np.cos(TEETH * P), TEETH)
    assert math.isnan(found.fm4)
    assert math.isnan(found.na4)
    assert math.isnan(gear_indicators(np.cos(37 * P), TEETH).fm0)
    assert math.isnan(gear_indicators(np.full(N, 3.0), TEETH).sideband_level_factor)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gear_indicators(np.ones(40), 24), "at least 4 samples for each of 24 teeth"),
        (lambda: gear_indicators(average(0.0), 2), "whole number from 3"),
        (lambda: gear_indicators(average(0.0), 24.0), "whole number from 3"),
        (lambda: gear_indicators(np.where(P > 1.0, np.nan, 1.0), 24), "finite numbers"),
        (lambda: gear_indicators(average(0.0), 24, history=[np.ones(3)]), "at least"),
        (lambda: split_average(np.ones((9, 9)), 24), "one signal"),
    ],
)
def test_refusals(call: object, words: str) -> None:
    with pytest.raises(gp.InputError, match=words) as caught:
        call()  # type: ignore[operator]
    assert len(caught.value.faults) == 1


def test_an_average_over_two_turns_is_refused() -> None:
    channel = gp.Channel("acc", np.cos(2 * np.pi * 100.0 * np.arange(8000) / 1000.0), 1000.0)
    with pytest.raises(gp.InputError, match="must be 1 revolution"):
        gear_indicators(synchronous_average(channel, 2 * np.pi * 10.0, period=2), 10)
