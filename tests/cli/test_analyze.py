"""`gearplay analyze`: statistics, lines and figures of a record; units, speeds and the band of an envelope; refusals."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat, wavfile

import gearplay as gp
from gearplay.cli.main import run
from gearplay.signals import figures

RATE, SECONDS = 2000.0, 20.0
FINE, TURNS, FAULT = 10_000.0, 25.0, 81.0  # of the record of a modulated carrier


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


def test_lines__have_their_uncertainty(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["analyze", str(record), "--channel", "acc", "--line", "40", "--line", "90", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    line, nothing = document["lines"]
    assert line["frequency"] == pytest.approx(40.013, abs=4 * line["frequency_uncertainty"])
    assert line["amplitude"] == pytest.approx(2.0, abs=4 * line["amplitude_uncertainty"])
    assert not nothing["found"]
    assert document["statistics"]["rms"] == pytest.approx(np.sqrt(2.0 + 0.01), rel=0.01)
    assert [c["unit"] for c in document["channels"]] == ["m/s^2", "rpm"]


@pytest.mark.slow
def test_summary__sentences_and_figures(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["analyze", str(record), "--channel", "acc", "--line", "40", "--line", "90", "--speed", "speed"]
    assert run([*words, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "rms 1.41" in shown
    assert "90 Hz: no line above" in shown
    names = ("history", "spectrum", "density", "spectrogram", "envelope_spectrum", "order_spectrum", "order_map",
             "synchronous_average")  # fmt: skip
    drawn = sorted(tmp_path.glob("*.png"))
    assert {path.stem for path in drawn} == {*names}
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)


@pytest.fixture
def carrier(tmp_path: Path) -> Path:
    """Write a carrier of 3 kHz that a fault modulates with depth 0.5, a tacho of two pulses a turn, and scalars."""
    time = np.arange(20_000) / FINE
    acc = (1.0 + 0.5 * np.cos(2 * np.pi * FAULT * time)) * np.cos(2 * np.pi * 3000.0 * time) + np.cos(
        2 * np.pi * TURNS * time
    )
    tacho = (np.sin(2 * np.pi * 2 * TURNS * time) > 0.0).astype(float)
    path = tmp_path / "run.mat"
    savemat(
        path, {"acc": acc, "tacho": tacho, "fs": FINE, "X097RPM": 60.0 * TURNS, "bearing": {"rate": TURNS}}
    )
    return path


def document(capsys: pytest.CaptureFixture[str], *words: object) -> dict[str, object]:
    assert run(["analyze", *map(str, words), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def test_band__lines_of_its_envelope(carrier: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        run(["analyze", str(carrier), "--channel", "acc", "--band", "2.5kHz", "3500", "--unit", "acc=g"]) == 0
    )
    shown = capsys.readouterr().out
    assert "envelope from 2500 to 3500 Hz" in shown
    assert "81 Hz: 0.5 g" in shown
    assert run(["analyze", str(carrier), "--channel", "acc", "--band", "2.5kHz", "3500"]) == 0
    assert "81 Hz: 0.5 ?" in capsys.readouterr().out  # no unit is known
    found = document(capsys, carrier, "--channel", "acc", "--band", "2500", "3500")["envelope"]
    assert found["lines"][0] == {"frequency": pytest.approx(FAULT), "amplitude": pytest.approx(0.5, rel=1e-3)}  # type: ignore[index]


@pytest.mark.parametrize(
    "speed", [["1500 rpm"], ["X097RPM"], ["bearing.rate Hz"], ["tacho", "--pulses", "2"]]
)
def test_speed__a_quantity_a_scalar_or_pulses(
    speed: list[str], carrier: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each gives the line of the turns at order 1, of the fault at 81 / 25."""
    found = []

    def draw(channel: gp.Channel, out: Path, *, speed: object, **more: object) -> list[Path]:
        found.append(gp.signals.order_spectrum(channel, speed, highest=150.0))
        return []

    monkeypatch.setattr(figures, "draw_record", draw)
    words = [
        "analyze",
        str(carrier),
        "--channel",
        "acc",
        "--speed",
        *speed,
        "--out",
        str(tmp_path / "figures"),
    ]
    assert run(words) == 0
    order, amplitude = found[0].order, found[0].amplitude
    low, high = order < 2.0, order > 100.0
    assert order[low][np.argmax(amplitude[low])] == pytest.approx(1.0, abs=0.03)
    assert order[high][np.argmax(amplitude[high])] == pytest.approx(3000.0 / TURNS, abs=0.1)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ["--speed", "1490"],
            'Write "1490 rpm" or "1490 rad/s", or name a channel or a scalar: acc, tacho, fs, X097RPM, bearing.rate',
        ),
        (["--channel", "ac"], "Did you mean 'acc'?"),
        (["--speed", "12 kg"], "--speed"),
        (["--line", "50000"], "50000"),
        (["--speed", "nothing", "--pulses", "2"], "must name the channel of the pulses"),
        (["--speed", "bearing.rate"], "or name a channel or a scalar"),
        (["--unit", "acc"], "Write --unit acc=g"),
        (["--unit", "ac=g"], "must be a channel that is read"),
        (["--calibration", "acc=g"], 'Write --calibration "channel 1=9.81 m/s^2"'),
        (["--calibration", "acc=9,81 m/s^2"], 'Write it with a decimal point: "9.81 m/s^2"'),
        (["--calibration", "ac=2 g"], '--calibration = "ac": must be a channel that is read'),
        (["--calibration", "acc=2 g", "--unit", "acc=g"], "must give the unit of a channel once"),
        (["--sampling", "12 rpm"], "--sampling"),
        (["--sampling", "300"], "must agree with 10000 Hz"),
    ],
)
def test_refusals__one_sentence(
    words: list[str], sentence: str, carrier: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        run(["analyze", str(carrier), *words, *([] if "--channel" in words else ["--channel", "acc"])]) == 2
    )
    assert sentence in " ".join(capsys.readouterr().err.split())


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write 19 healthy records of a gear of 20 teeth at 10 turns a second."""
    folder = tmp_path_factory.mktemp("healthy")
    for seed in range(19):
        gp.write_record(gp.Record((gear_channel(seed),)), folder / f"{seed}.h5")
    return folder


def gear_channel(seed: int, burst: float = 0.0) -> gp.Channel:
    """Return two seconds of a mesh with its own noise over the turn, and a burst at one tooth."""
    rng = np.random.default_rng(seed)
    turn = np.arange(RATE * 2.0) / RATE * 10.0 % 1.0
    pattern = np.fft.irfft(np.fft.rfft(rng.normal(size=200)) * (np.arange(101) > 2), 200)
    own = np.interp(turn, np.arange(200) / 200.0, pattern, period=1.0)
    acc = np.sin(2.0 * np.pi * 20.0 * turn) + 0.05 * own + burst * (np.abs(turn - 0.5) < 0.02)
    return gp.Channel("acc", acc, RATE, "m/s^2")


@pytest.mark.parametrize(("burst", "raised"), [(0.0, False), (1.0, True)])
def test_alarm__of_a_burst_at_one_tooth(
    burst: float, raised: bool, healthy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gp.write_record(gp.Record((gear_channel(100, burst),)), tmp_path / "now.h5")
    words = [
        "analyze",
        str(tmp_path / "now.h5"),
        "--speed",
        "600 rpm",
        "--teeth",
        "20",
        "--healthy",
        str(healthy),
    ]
    assert run(words) == 2  # 19 records are too few for 2 %
    assert "must be at least 49" in capsys.readouterr().err
    words += ["--false-alarms", "0.05"]
    assert run([*words, "--json"]) == 0
    alarm = json.loads(capsys.readouterr().out)["alarm"]
    assert alarm["raised"] is raised
    assert (alarm["score"] > alarm["threshold"]) is raised
    assert run(words) == 0
    shown = capsys.readouterr().out
    assert ("ALARM: score" if raised else "no alarm: score") in shown
    assert "set by 19 healthy records for false alarms in 5 %" in shown


@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (["--healthy", "nowhere", "--teeth", "20"], "--healthy.*folder with a file"),
        (["--healthy", "nowhere"], "--healthy.*must be given with --teeth"),
        (["--teeth", "20", "--false-alarms", "0.1"], "--false-alarms = 0.1: must be given with --healthy"),
        (["--healthy", ".", "--teeth", "20"], "must not hold the record itself"),
        (
            ["--healthy", "nowhere", "--teeth", "20", "--speed", "1.h5"],
            "--speed.*must not be a file with --healthy",
        ),
    ],
)
def test_alarm__without_what_it_needs_is_refused(
    words: list[str],
    rule: str,
    healthy: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(healthy)
    assert run(["analyze", "0.h5", "--speed", "600 rpm", *words]) == 2
    assert re.search(rule, capsys.readouterr().err)


def test_alarm__names_the_file_of_a_record_that_does_not_fit(
    healthy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sound record of 4 turns among those of 20: its average has more noise, which is no damage."""
    short = gear_channel(7).values[: int(0.4 * RATE)]
    now, folder = tmp_path / "now.h5", tmp_path / "sound"
    folder.mkdir()
    for file in healthy.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    gp.write_record(gp.Record((gp.Channel("acc", short, RATE, "m/s^2"),)), now)
    words = ["--speed", "600 rpm", "--teeth", "20", "--healthy", str(folder), "--false-alarms", "0.05"]
    assert run(["analyze", str(now), *words]) == 2
    assert "indicators.turns = 4: must be 16 to 25" in capsys.readouterr().err
    (folder / "short.h5").write_bytes(now.read_bytes())
    (folder / ".hidden").write_text("no record")
    gp.write_record(gp.Record((gear_channel(7),)), now, overwrite=True)
    assert run(["analyze", str(now), *words]) == 2
    assert "--healthy short.h5: turns = 4: must be 16 to 25" in capsys.readouterr().err


def test_pictures__replaced_only_with_overwrite(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second record in the folder is refused; with ``--overwrite`` no picture of the first one stays or is named."""
    record, out = tmp_path / "short.h5", tmp_path / "out"
    gp.write_record(gp.Record((gear_channel(1),)), record)
    words = ["analyze", str(record), "--out", str(out)]
    assert run([*words, "--speed", "600 rpm"]) == 0
    assert "order_map.png" in capsys.readouterr().out
    before = {each.name: each.read_bytes() for each in out.iterdir()}
    assert run(words) == 2
    assert "must not exist yet. Choose another name, or say --overwrite." in " ".join(
        capsys.readouterr().err.split()
    )
    assert {each.name: each.read_bytes() for each in out.iterdir()} == before
    (out / "mine.png").write_bytes(b"")
    assert run([*words, "--overwrite"]) == 0
    names = sorted(each.name for each in out.iterdir() if each.name != "mine.png")
    assert f"Pictures in {out}: {', '.join(names)}\n" in capsys.readouterr().out
    assert not {"order_map.png", "order_spectrum.png", "synchronous_average.png"} & set(names)
    assert (out / "mine.png").exists()


@pytest.mark.parametrize("command", ["analyze", "diagnose"])
def test_calibration__integers_of_a_wav_file_in_physical_units(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sine of 3 m/s^2 recorded at 8 m/s^2 full scale; without a calibration full scale is named as 1."""
    values = 3.0 / 8.0 * np.sin(2.0 * np.pi * 500.0 * np.arange(16_000) / 8000.0)
    path = tmp_path / "m16.wav"
    wavfile.write(path, 8000, np.round(32768.0 * values).astype(np.int16))
    words = [
        command,
        str(path),
        *(
            ["--line", "500Hz"]
            if command == "analyze"
            else ["--speed", "1500 rpm", "--teeth", "20:41", "--quick"]
        ),
    ]
    assert run([*words, "--calibration", "channel 1=8 m/s^2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["lines"]
    line = min(found, key=lambda each: abs((each["frequency"] or 0.0) - 500.0))
    assert line["amplitude"] == pytest.approx(3.0, rel=1e-3)
    if command == "analyze":
        assert run([*words, "--calibration", "channel 1=8 m/s^2"]) == 0
        calibrated = capsys.readouterr().out
        assert "[m/s^2]" in calibrated
        assert "full scale" not in calibrated
        assert run([*words, "--unit", "channel 1=g"]) == 0
        assert (
            "WAV, integer of 16 bits: full scale of the file is 1 g; set another" in capsys.readouterr().out
        )
