"""`gearplay analyze`: statistics and lines of a record, figures, and what happens to bad input."""

import json
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run

RATE, SECONDS = 2000.0, 20.0


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    t = np.arange(int(RATE * SECONDS)) / RATE
    acc = 2.0 * np.sin(2 * np.pi * 40.013 * t) + 0.1 * np.random.default_rng(0).normal(size=t.size)
    path = tmp_path_factory.mktemp("records") / "bench.h5"
    channels = (
        gp.Channel("acc", acc, RATE, "m/s^2"),
        gp.Channel("speed", np.full(t.size, 120.0), RATE, "rpm"),
    )
    gp.write_record(gp.Record(channels), path)
    return path


def test_lines_come_with_their_uncertainty(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["analyze", str(record), "--channel", "acc", "--line", "40", "--line", "90", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    line, nothing = document["lines"]
    assert line["frequency"] == pytest.approx(40.013, abs=4 * line["frequency_uncertainty"])
    assert line["amplitude"] == pytest.approx(2.0, abs=4 * line["amplitude_uncertainty"])
    assert not nothing["found"]
    assert document["statistics"]["rms"] == pytest.approx(np.sqrt(2.0 + 0.01), rel=0.01)
    assert [c["unit"] for c in document["channels"]] == ["m/s^2", "rpm"]


@pytest.mark.slow
def test_people_get_sentences_and_figures(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["analyze", str(record), "--channel", "acc", "--line", "40", "--line", "90", "--speed", "speed"]
    assert run([*words, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "rms 1.41" in shown
    assert "90 Hz: no line above" in shown
    assert len(list(tmp_path.glob("*.png"))) == 8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("more", "code", "words"),
    [
        ([], 2, "must be a channel of the record"),
        (["--channel", "ac"], 2, "Did you mean 'acc'?"),
        (["--channel", "acc", "--speed", "12 kg"], 2, "--speed"),
        (["--channel", "acc", "--line", "5000"], 2, "5000"),
    ],
)
def test_faults(
    record: Path, more: list[str], code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["analyze", str(record), *more]) == code
    assert words in capsys.readouterr().err
