"""Deviation of a record from simulated causes: closed forms of one feature and of many, alike causes, spread."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gearplay.diagnosis.comparison import ALLOWED, LARGE, compared
from gearplay.diagnosis.features import background, features_of
from gearplay.diagnosis.machine import machine_of_teeth
from gearplay.diagnosis.shaft_speed import FoundSpeed
from gearplay.files.record import Channel

Floats = NDArray[np.float64]


def levels(*means: list[float]) -> Floats:
    """Return simulated features without spread: three members of each level."""
    return np.repeat(np.array(means)[:, None, :], 3, axis=1)


SPEED = FoundSpeed(25.0, 1e-6, "mesh")
SOUND = levels([0.0] * 20)


@pytest.mark.parametrize("z", [0.0, 0.5, 2.0, 5.0])
def test_one_level__is_hubers_loss(z: float) -> None:
    (found,) = compared(np.full((1, 20), z * ALLOWED), [SOUND])
    expected = z if z <= LARGE else math.sqrt(2.0 * LARGE * z - LARGE**2)
    assert found.deviation == pytest.approx(expected, rel=1e-12)
    assert (found.place, found.spread, found.alike) == (0.0, pytest.approx(0.0, abs=1e-12), True)


def test_severity__between_two_levels() -> None:
    """At 3/4 of the way from the first level to the second both of the cause's features are met."""
    cause = levels([1.0] * 10 + [0.0] * 10, [1.0] * 10 + [2.0] * 10)
    record = np.array([[1.0] * 10 + [1.5] * 10])
    sound, own = compared(record, [SOUND, cause])
    assert own.place == 1.75
    assert own.deviation == pytest.approx(0.0, abs=1e-12)
    assert own.expected.tolist() == record[0].tolist()
    assert (sound.alike, own.alike) == (False, True)


def test_causes_with_the_same_features__are_alike() -> None:
    one, other = levels([1.0] * 20), levels([1.0] * 19 + [1.02])
    found = compared(np.full((1, 20), 1.0), [SOUND, one, other])
    assert [each.alike for each in found] == [False, True, True]


def test_a_cause_is_never_further_off_than_its_beginning() -> None:
    rng = np.random.default_rng(1)
    sound, causes = rng.normal(size=(1, 3, 20)), [rng.normal(size=(3, 3, 20)) for _ in range(4)]
    found = compared(rng.normal(size=(2, 20)), [sound, *causes])
    assert all(each.deviation <= found[0].deviation for each in found[1:])


def test_spread__grows_with_that_of_members_and_pieces() -> None:
    rng = np.random.default_rng(2)
    noise = rng.normal(size=(1, 4, 30))
    spreads = [compared(np.full((1, 30), 0.3), [s * noise])[0].spread for s in (0.0, 0.01, 0.1)]
    assert spreads == sorted(spreads)
    assert spreads[0] == pytest.approx(0.0, abs=1e-12)
    pieces = 0.1 * rng.normal(size=(3, 30))
    assert compared(pieces, [SOUND[:, :, :1].repeat(30, axis=2)])[0].spread > 0.0


def test_noise_alone__leaves_every_cause_alike_in_most_draws() -> None:
    """Sound records against causes that change one feature of 30 by far: the case as it is stays possible."""
    rng, alike = np.random.default_rng(3), 0
    for _ in range(40):
        cause = np.zeros(30)
        cause[0] = 1.0
        causes = [0.1 * rng.normal(size=(1, 3, 30)), cause + 0.1 * rng.normal(size=(3, 3, 30))]
        alike += compared(0.1 * rng.normal(size=(2, 30)), causes)[0].alike
    assert alike >= 36


@pytest.mark.parametrize("deviation", [0.01, 1.0])
def test_background__of_noise_under_tones_and_shocks(deviation: float) -> None:
    rng, t = np.random.default_rng(4), np.arange(40_000) / 20_000.0
    shocks = 30.0 * np.exp(-800.0 * (t % 0.05)) * np.sin(2.0 * np.pi * 4000.0 * (t % 0.05))
    x = deviation * rng.standard_normal(t.size) + np.cos(2.0 * np.pi * 460.0 * t)
    assert background(Channel("a", x, 20_000.0)) == pytest.approx(deviation, rel=0.1)
    alone = deviation * rng.standard_normal(t.size)
    loud = 50.0 * deviation * np.fft.rfft(rng.standard_normal(t.size))
    loud[(np.fft.rfftfreq(t.size) < 0.2) | (np.fft.rfftfreq(t.size) > 0.3)] = 0.0
    humped = Channel("a", alone + np.fft.irfft(loud, t.size), 20_000.0)
    assert background(humped) == pytest.approx(deviation, rel=0.2)
    assert background(Channel("a", alone + shocks, 20_000.0)) == pytest.approx(deviation, rel=0.2)


def test_features__of_a_modulated_mesh() -> None:
    """A record ten times as large has one feature more, its level; sidebands of 0.3 are a modulation of 0.3."""
    machine, t = machine_of_teeth("20:41"), np.arange(40_000) / 20_000.0
    x = (1.0 + 0.3 * np.cos(2.0 * np.pi * 25.0 * t)) * np.cos(2.0 * np.pi * 500.0 * t)
    x += 0.01 * np.random.default_rng(5).standard_normal(t.size)
    one, ten = (features_of(Channel("a", a * x, 20_000.0), machine, SPEED, levels=True) for a in (1.0, 10.0))
    changed = {name for name in one if abs(one[name] - ten[name]) > 1e-6}
    assert changed == {"level"}
    assert ten["level"] - one["level"] == pytest.approx(1.0)
    gear = machine.gears[0].name
    assert one[f"modulation of {gear}"] == pytest.approx(math.log10(0.01 + 0.3), abs=0.01)
    assert "level" not in features_of(Channel("a", x, 20_000.0), machine, SPEED, levels=False)


def test_modulation__of_a_mesh_line_lost_in_noise_is_none() -> None:
    """Sidebands as large as their line are a modulation only where that line stands out of the noise."""
    machine, t = machine_of_teeth("20:41"), np.arange(40_000) / 20_000.0
    lines = sum(a * np.cos(2.0 * np.pi * f * t) for f, a in ((475.0, 0.5), (500.0, 1.0), (525.0, 0.5)))
    for seed in range(8):
        noise = np.random.default_rng(seed).standard_normal(t.size)
        lost, there = (features_of(Channel("a", noise + height * lines, 20_000.0), machine, SPEED, levels=False)
                       for height in (0.0, 5.0))  # fmt: skip
        name = f"modulation of {machine.gears[0].name}"
        assert lost[name] == -2.0
        assert there[name] == pytest.approx(0.0, abs=0.1)
