"""`gearplay diagnose`: one command from a record to the conclusion; files, JSON, refusals."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

import gearplay as gp
from gearplay.cli.main import run
from machine_records import bearing_record, machine_record

BEARING = ["--bearing", "9, 7.94mm, 39.04mm"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("records")
    channel = bearing_record()
    savemat(place / "105.mat", {channel.name: channel.values, "fs": channel.sampling, "X105RPM": 1797.0})
    for name, condition, seed in (("worn", "tooth 2", 5), ("new", "healthy", 6)):
        gp.write_record(gp.Record((machine_record(condition, seed)[0],)), place / f"{name}.h5")
    return place


def document(capsys: pytest.CaptureFixture[str], *words: object) -> dict[str, Any]:
    assert run(["diagnose", *map(str, words), "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.parametrize("speed", ["1797 rpm", "X105RPM"])
def test_inner_ring_of_a_motors_bearing__from_the_envelope(
    speed: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = document(capsys, folder / "105.mat", *BEARING, "--speed", speed)
    assert found["hypotheses"][0]["name"] == "bearing, inner ring"
    assert found["told"]
    assert found["hypotheses"][0]["confidence"] >= found["stated_confidence"]
    line = next(each for each in found["lines"] if each["name"] == "BPFI")
    assert line["expected"] == pytest.approx(162.2, abs=0.05)
    assert line["frequency"] == pytest.approx(162.2, rel=0.01)


def test_text__conclusion_first_then_lines_by_name(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        str(folder / "worn.h5"),
        "--teeth",
        "23:61",
        "--bearing",
        "8,7.9mm,33.5mm",
        "--speed",
        "1500 rpm",
    ]
    assert run(["diagnose", *words, "--healthy", str(folder / "new.h5"), "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("Damaged tooth on gear 2 (61 teeth), confidence 0.9")
    for part in (
        "cannot be told:",
        "2 x mesh, expected",
        "turn of shaft 2",
        "FM4 of gear 2 (61 teeth)",
        "(healthy ",
    ):
        assert part in shown
    assert (tmp_path / "out" / "diagnosis.png").read_bytes().startswith(b"\x89PNG")
    assert gp.read_result(tmp_path / "out" / "diagnosis.nc").told
    assert run(["diagnose", *words, "--out", str(tmp_path / "out")]) == 2
    assert "must not exist yet" in " ".join(capsys.readouterr().err.split())


def test_tacho__a_channel_of_pulses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    channel, f = machine_record("tooth 1", 2)
    pulses = (np.sin(2 * np.pi * 4 * f * channel.time) > 0.0).astype(float)
    both = (channel, gp.Channel("tacho", pulses, channel.sampling, "V"))
    gp.write_record(gp.Record(both), tmp_path / "both.h5")
    words = ("--teeth", "23:61", "--channel", "acc", "--speed", "tacho", "--pulses", "4")
    found = document(capsys, tmp_path / "both.h5", *words)
    assert found["speed_source"] == "measured"
    assert found["shaft_speed"] == pytest.approx(f, rel=1e-4)
    assert found["hypotheses"][0]["name"] == "damaged tooth on gear 1 (23 teeth)"


@pytest.mark.parametrize("ending", ["csv", "mat", "h5", "wav", "tdms", "npy"])
def test_a_record_of_any_format__with_a_table_of_speeds(
    ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The shaft slows down by a tenth: without the speeds of the other file no tooth stands out."""
    rate, n = 10_000.0, 60_000
    time = np.arange(n) / rate
    speed = 25.0 * (1.0 - 0.1 * time / time[-1])
    angle = 2.0 * np.pi * np.cumsum(speed) / rate
    off = (angle - 1.0 + np.pi) % (2.0 * np.pi) - np.pi
    x = (1.0 - 0.5 * np.exp(-((off * 23 / 3.0) ** 2))) * (np.cos(23 * angle) + 0.4 * np.cos(46 * angle))
    x += 0.1 * np.random.default_rng(0).standard_normal(n)
    record = tmp_path / f"bench.{ending}"
    if ending == "npy":
        np.save(record, x)
    elif ending == "tdms":
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(record) as writer:
            about = {"wf_increment": 1.0 / rate, "wf_start_offset": 0.0, "unit_string": "m/s^2"}
            writer.write_segment([ChannelObject("run", "acc", x, about)])
    else:
        gp.write_record(gp.Record((gp.Channel("acc", x, rate, "m/s^2"),)), record)
    rows = "".join(f"{t:.2f},{60.0 * v:.6f}\n" for t, v in zip(time[::100], speed[::100], strict=True))
    (tmp_path / "speeds.csv").write_text(f"time [s],speed [rpm]\n{rows}")
    given = ["--teeth", "23:61", "--speed", str(tmp_path / "speeds.csv")]
    given += ["--sampling", "10kHz"] if ending == "npy" else []
    found = document(capsys, record, *given)
    assert found["speed_source"] == "measured"
    assert found["shaft_speed"] == pytest.approx(23.75, rel=2e-3)
    assert found["hypotheses"][0]["name"] == "damaged tooth on gear 1 (23 teeth)"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "is required where neither a case nor a bearing is given"),
        (["--teeth", "23:61", "--speed", "no such"], "--speed"),
        (["--teeth", "23"], "must be numbers of teeth"),
        (["--teeth", "23:61"], "must be given, within 2 %"),
        (["--teeth", "23:61", "--case", "han2021"], "must not be given with a case"),
        (["--case", "no-such-case"], "no-such-case"),
        (["--bearing", "8,7.9mm,33.5mm@3", "--speed", "1500 rpm"], "must sit on shaft 1, the only one"),
        (["--bearing", "8;7.9;33", "--speed", "1500 rpm"], "must be a bearing's geometry"),
        (["--teeth", "23:61", "--speed", "1500 rpm", "--channel", "ac"], "ac"),
        (["--teeth", "23:61", "--speed", "1500 rpm", "--pulses", "4"], "must name the channel of the pulses"),
        (["--teeth", "23:61", "--speed", "1 rpm"], "must last 10 turns"),
    ],
)
def test_refusals__one_sentence(
    words: list[str], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["diagnose", str(folder / "worn.h5"), *words]) == 2
    shown = " ".join(capsys.readouterr().err.split())
    assert sentence in shown
    assert "Traceback" not in shown
    assert shown.count(". ") <= 2


def test_a_file_that_is_no_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.wav").write_bytes(b"RIFF0000")
    assert run(["diagnose", str(tmp_path / "a.wav"), "--teeth", "23:61", "--speed", "1500 rpm"]) == 6
    assert "Traceback" not in capsys.readouterr().err


def test_analyze__indicators_and_the_most_impulsive_band(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    channel, f = machine_record("tooth 2", 5)
    speed = f"{60 * f * 23 / 61:.9g} rpm"
    words = ["analyze", str(folder / "worn.h5"), "--speed", speed, "--teeth", "61", "--envelope"]
    assert run([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    average = gp.signals.synchronous_average(channel, 2 * np.pi * f * 23 / 61)
    own = gp.signals.gear_indicators(average, 61)
    assert found["indicators"]["fm4"] == pytest.approx(own.fm4, rel=5e-3)
    assert found["indicators"]["fm4"] > 10.0
    assert (found["envelope"]["low"], found["envelope"]["high"]) == gp.signals.most_impulsive_band(channel)
    assert run(words) == 0
    shown = capsys.readouterr().out
    assert "M8A" in shown
    assert "indicators of the gear of 61 teeth" in shown


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--teeth", "61"], "must be given with --teeth"),
        (["--envelope", "--band", "1kHz", "2kHz"], "must not be given with --band"),
        (["--teeth", "6100", "--speed", "1500 rpm"], "at least 4 samples for each"),
    ],
)
def test_analyze__refusals(
    words: list[str], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["analyze", str(folder / "worn.h5"), *words]) == 2
    assert sentence in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("speed", ["1500 rpm", "1507.6 rpm"])
def test_indicators__are_those_of_analyze(
    speed: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both average at the speed of the mesh lines, whichever within 2.5 % is given: the record turns at 1496 rpm."""
    found = document(capsys, folder / "worn.h5", "--teeth", "23:61", "--speed", speed)
    indices = {each["name"]: each["value"] for each in found["indices"]}
    slow = f"{float(speed.split()[0]) * 23 / 61:.9g} rpm"
    for teeth, given, gear in ((23, speed, "gear 1 (23 teeth)"), (61, slow, "gear 2 (61 teeth)")):
        words = ["analyze", str(folder / "worn.h5"), "--teeth", str(teeth), "--speed", given, "--json"]
        assert run(words) == 0
        own = json.loads(capsys.readouterr().out)["indicators"]
        for name, key in (
            ("FM0", "fm0"),
            ("FM4", "fm4"),
            ("M6A", "m6a"),
            ("M8A", "m8a"),
            ("energy ratio", "energy_ratio"),
        ):
            assert own[key] == pytest.approx(indices[f"{name} of {gear}"], rel=1e-6)
        assert "rpm, by its mesh lines" in own["settings"]
