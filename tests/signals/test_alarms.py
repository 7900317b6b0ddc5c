"""Alarms: false alarms at the stated rate, of noise and of simulated sound gears; alarms of damaged ones; what is refused."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from depth import sized
from gearplay.signals import alarm_limit, gear_indicators, synchronous_average

ROOT = Path(__file__).resolve().parents[2]
TURN = 2.0 * np.pi * np.arange(256) / 256


def of_noise(rng: np.random.Generator, burst: float = 0.0) -> Any:
    """Return indicators of a mesh with noise, and a burst at one tooth."""
    return gear_indicators(np.cos(20 * TURN) + 0.05 * rng.normal(size=256) + burst * (TURN < 0.15), 20)


def test_false_alarms__have_the_stated_rate() -> None:
    """The threshold is a score of the healthy records: of others the share p is above, on average over many healthy sets."""
    rng, shares = np.random.default_rng(1), []
    others = [of_noise(rng) for _ in range(400)]
    for _ in range(20):
        limit = alarm_limit([of_noise(rng) for _ in range(99)], false_alarms=0.1)
        shares.append(np.mean([limit.raises(each) for each in others]))
    assert np.mean(shares) == pytest.approx(0.1, abs=0.025)
    assert limit.raises(of_noise(rng, burst=0.5))


def test_threshold__is_the_stated_order_statistic() -> None:
    rng = np.random.default_rng(2)
    healthy = [of_noise(rng) for _ in range(59)]
    limit = alarm_limit(healthy, false_alarms=0.05)
    scores = sorted(limit.score(each) for each in healthy)
    assert limit.threshold == pytest.approx(scores[math.ceil(60 * 0.95) - 1], rel=1e-12)
    assert sum(limit.raises(each) for each in healthy) == 2


def test_score__counts_healthy_spreads() -> None:
    rng = np.random.default_rng(3)
    healthy = [of_noise(rng) for _ in range(49)]
    limit = alarm_limit(healthy)
    logarithms = np.log([[getattr(each, name) for name in limit.watched] for each in healthy])
    deviation = np.median(np.abs(logarithms - np.median(logarithms, axis=0)), axis=0)
    np.testing.assert_allclose(limit.spread, 1.4826 * deviation, rtol=1e-12)
    one = of_noise(rng)
    others = {name: math.exp(middle) for name, middle in zip(limit.watched, limit.middle, strict=True)}
    raised = math.exp(limit.middle[3] + 7.5 * limit.spread[3])
    assert limit.score(replace(one, **{**others, "energy_ratio": raised})) == pytest.approx(7.5, rel=1e-9)


@pytest.mark.parametrize(
    ("count", "share", "words"),
    [
        (48, 0.02, r"healthy = \"48 records\": must be at least 49 for false alarms in 2 %"),
        (10, 0.0, "false_alarms.*above 0"),
        (2, 0.9, "at least 3"),
    ],
)
def test_limit__without_enough_records_is_refused(count: int, share: float, words: str) -> None:
    rng = np.random.default_rng(4)
    with pytest.raises(gp.InputError, match=words):
        alarm_limit([of_noise(rng) for _ in range(count)], false_alarms=share)


def test_indicators_without_power__are_refused() -> None:
    rng = np.random.default_rng(5)
    pure = gear_indicators(np.cos(20 * TURN), 20)
    with pytest.raises(gp.InputError, match=r"healthy.0.fm4.*must be above 0"):
        alarm_limit([pure, *(of_noise(rng) for _ in range(60))])


def plan_of(label: str, faults: list[dict[str, Any]], records: int) -> dict[str, Any]:
    """Return a plan of records of a loaded pair with deviations of class 6, drawn backlash, clearance and torque."""
    case = gp.load_case(ROOT / "docs" / "how-to" / "cracked-pinion.toml").resolved()
    del case["supports"]["wheel"]
    case["sleeves"] = {
        "wheel": {
            "radial_clearance": "30 um",
            "stiffness": "2e10 N/m^1.5",
            "restitution": 0.5,
            "law": "flores",
        }
    }
    for gear in ("pinion", "wheel"):
        case["rotors"][gear]["quality"] = 6
    case["run"].update(duration=0.22, transient=0.06, tolerance=1e-6)
    return {
        "case": case,
        "rig": {
            "accelerometers": {"sensor": {"kind": "352C33", "rotor": "wheel"}},
            "collector": {"sampling": "20 kHz"},
        },
        "members": records,
        "seed": 4,
        "classes": [{"label": label, "set": {"faults": faults}}],
        "draws": [
            {"name": "backlash", "path": "meshes.0.backlash", "low": "60 um", "high": "240 um"},
            {"name": "clearance", "path": "sleeves.wheel.radial_clearance", "low": "10 um", "high": "60 um"},
            {"name": "torque", "path": "rotors.wheel.load.torque", "low": "120 N m", "high": "200 N m"},
        ],
        "split": {"by": "condition", "train": 1.0, "validation": 0.0, "test": 0.0},
    }  # fmt: skip


def indicators_in(plan: dict[str, Any], folder: Path) -> list[Any]:
    """Return the indicators of the pinion in the records of a plan."""
    found = gp.make_dataset(plan, folder)
    averages = [
        synchronous_average(gp.Channel("a", np.load(folder / path)[0], 20e3, "m/s^2"), 2.0 * math.pi * 20.0)
        for path in found.ds["path"].values
    ]
    return [gear_indicators(each, 20) for each in averages]


@pytest.mark.slow
def test_sound_gears__raise_few_alarms(tmp_path: Path) -> None:
    """Deviations, clearances and loads drawn: at most 5 % of 200 sound gears raise an alarm; most spalls of 60 um do."""
    reference, tested = sized(100, 19), sized(200, 20)
    sound = indicators_in(plan_of("sound", [], reference + tested), tmp_path / "sound")
    share = 0.02 if reference >= 49 else 0.05
    limit = alarm_limit(sound[:reference], false_alarms=share)
    raised = sum(limit.raises(each) for each in sound[reference:])
    assert raised <= max(0.05 * tested, 3)  # 9 of 200
    spall = {"kind": "spall", "at": "pinion", "tooth": 3, "depth": "60 um", "flank": "left"}
    damaged = indicators_in(plan_of("spall", [spall], sized(30, 5)), tmp_path / "spall")
    assert np.mean([limit.raises(each) for each in damaged]) >= 0.7
