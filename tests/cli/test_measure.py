"""The measure command: what it writes, what it says, what it refuses."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer

from gearplay.cli import measure as command
from gearplay.files import measurements
from gearplay.files.record import Record
from gearplay.model.reading import load_case
from gearplay.rig import measure
from gearplay.vocabulary.errors import InputError

MOVING = ["run.transient=0.01", "rotors.ring.initial.vx=40 mm/s", "rotors.ring.initial.vy=30 mm/s"]
SHORT = [word for change in MOVING for word in ("--set", change)] + ["--duration", "0.01"]


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Record, Path]]:
    """Keep what is written instead of writing it: the formats have their own tests."""
    kept: list[tuple[Record, Path]] = []
    monkeypatch.setattr(measurements, "write_record", lambda record, path, **_: kept.append((record, path)))
    return kept


def run(*words: str) -> None:
    app = typer.Typer()
    app.command()(command.measure)
    app(args=list(words), standalone_mode=False)


def test_measure_command__writes_the_record_and_lists_its_content(
    tmp_path: Path, written: list[tuple[Record, Path]], capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[accelerometers.ring]\nkind = "352C33"\n[collector]\nbits = 24\n', encoding="utf-8")
    out = tmp_path / "record.csv"
    run("han2021", "--rig", str(rig), "--out", str(out), *SHORT, "--seed", "5", "--member", "1", "--json")
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    [(record, path)] = written
    assert path == out
    case = load_case("han2021", MOVING)
    same = measure(case, rig, duration=0.01, seed=5, member=1)
    assert np.array_equal(record.channel("ring.counts").values, same.channel("ring.counts").values)
    assert document["case_sha256"] == case.sha256
    assert (document["samples"], document["sampling"], document["seed"]) == (1000, 1e5, "5 1")
    sensor = document["sensors"]["ring"]
    assert sensor["recorded_peak"] == np.max(np.abs(same.channel("ring.recorded").values))
    assert sensor["recorded_peak"] > 0.0
    assert (sensor["place"], sensor["sensor"]) == ("ring, 0 deg from +x", "352C33")
    assert sensor["sensor_saturated"] == "no"


def test_measure_command__reports_clipped_samples(
    tmp_path: Path, written: list[tuple[Record, Path]], capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[accelerometers.ring]\nrange = "1 mm/s^2"\n', encoding="utf-8")
    run("han2021", "--rig", str(rig), "--out", str(tmp_path / "a.csv"), *SHORT)
    shown = capsys.readouterr().out
    assert "ring: the sensor saturated in" in shown
    assert "1000 samples at 100000 Hz, 0.01 s" in shown
    assert len(written) == 1


def test_measure__an_existing_record_is_kept_without_overwrite(
    tmp_path: Path, written: list[tuple[Record, Path]]
) -> None:
    out = tmp_path / "record.csv"
    out.write_text("mine")
    with pytest.raises(InputError, match="must not exist yet"):
        run("han2021", "--out", str(out), *SHORT)
    with pytest.raises(InputError, match="must end in one of"):
        run("han2021", "--out", str(tmp_path / "record.xyz"), "--duration", "1e9")  # before it simulates
    assert not written
    run("han2021", "--out", str(out), *SHORT, "--overwrite")
    assert len(written) == 1


def test_the_file_holds_the_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from gearplay.files.measurements import read_measurement

    out = tmp_path / "record.nc"
    for words in ([], ["--overwrite"]):
        run("han2021", "--out", str(out), *SHORT, *words)
    same = measure(load_case("han2021", MOVING), duration=0.01)
    read = read_measurement(out)
    assert read.names == same.names
    for channel in same.channels:
        assert np.array_equal(read.channel(channel.name).values, channel.values)
    assert read.attributes["case_sha256"] == same.attributes["case_sha256"]
    assert "Saved to" in capsys.readouterr().out
