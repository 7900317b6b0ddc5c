"""`gearplay analyze` on records as they come: units given, speeds from scalars and pulses, the envelope's lines as numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from gearplay.cli.main import run

RATE, TURNS, FAULT = 10_000.0, 25.0, 81.0
TIME = np.arange(20_000) / RATE


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """Write a carrier of 3 kHz that a fault modulates with depth 0.5, a tacho of two pulses a turn, and scalars."""
    acc = (1.0 + 0.5 * np.cos(2 * np.pi * FAULT * TIME)) * np.cos(2 * np.pi * 3000.0 * TIME) + np.cos(
        2 * np.pi * TURNS * TIME
    )
    tacho = (np.sin(2 * np.pi * 2 * TURNS * TIME) > 0.0).astype(float)
    path = tmp_path / "run.mat"
    savemat(
        path, {"acc": acc, "tacho": tacho, "fs": RATE, "X097RPM": 60.0 * TURNS, "bearing": {"rate": TURNS}}
    )
    return path


def document(capsys: pytest.CaptureFixture[str], *words: object) -> dict[str, object]:
    assert run(["analyze", *map(str, words), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def test_a_band_prints_the_lines_of_its_envelope(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        run(["analyze", str(record), "--channel", "acc", "--band", "2.5kHz", "3500", "--unit", "acc=g"]) == 0
    )
    shown = capsys.readouterr().out
    assert "envelope from 2500 to 3500 Hz" in shown
    assert "81 Hz: 0.5 g" in shown
    assert run(["analyze", str(record), "--channel", "acc", "--band", "2.5kHz", "3500"]) == 0
    assert "81 Hz: 0.5 ?" in capsys.readouterr().out  # no unit is known
    found = document(capsys, record, "--channel", "acc", "--band", "2500", "3500")["envelope"]
    assert found["lines"][0] == {"frequency": pytest.approx(FAULT), "amplitude": pytest.approx(0.5, rel=1e-3)}  # type: ignore[index]


@pytest.mark.slow
@pytest.mark.parametrize(
    "speed", [["1500 rpm"], ["X097RPM"], ["bearing.rate Hz"], ["tacho", "--pulses", "2"]]
)
def test_a_speed_is_a_quantity_a_scalar_or_pulses(
    speed: list[str], record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = document(capsys, record, "--channel", "acc", "--speed", *speed, "--out", tmp_path / "figures")
    assert any("order_spectrum" in str(path) for path in found["figures"])  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ["--speed", "1490"],
            'Write "1490 rpm" or "1490 rad/s", or name a channel or a scalar: acc, tacho, fs, X097RPM, bearing.rate',
        ),
        (["--speed", "nothing", "--pulses", "2"], "must name the channel of the pulses"),
        (["--speed", "bearing.rate"], "or name a channel or a scalar"),
        (["--unit", "acc"], "Write --unit acc=g"),
        (["--unit", "ac=g"], "must be a channel that is read"),
        (["--sampling", "12 rpm"], "--sampling"),
        (["--sampling", "300"], "must agree with 10000 Hz"),
    ],
)
def test_faults(words: list[str], sentence: str, record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["analyze", str(record), "--channel", "acc", *words]) == 2
    assert sentence in " ".join(capsys.readouterr().err.split())
