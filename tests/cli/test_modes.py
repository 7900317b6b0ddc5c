"""`gearplay modes`: the table, its files and its refusals."""

import json
from pathlib import Path

import pytest

import gearplay as gp
from gearplay.cli.main import run


@pytest.mark.slow
def test_modes_are_printed_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["modes", "lin-parker-1999", "--out", str(tmp_path), "--campbell", "3000rpm"]) == 0
    text = capsys.readouterr().out
    assert "18 modes, 743.162 to 11775.3 Hz, 1 of them free motions (0 Hz)" in text
    assert "1475.74 Hz  rotational" in text
    assert "meets mode" in text
    assert gp.read_result(tmp_path / "modes.nc").ds["frequency"].size == 18
    assert gp.read_result(tmp_path / "campbell.nc").ds.sizes["speed"] == 200
    for name in ("modes.png", "campbell.png"):
        assert (tmp_path / name).stat().st_size > 20_000
    assert run(["modes", "lin-parker-1999", "--out", str(tmp_path)]) == 2  # nothing is replaced
    assert "must not exist yet" in capsys.readouterr().err


@pytest.mark.slow
def test_modes_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["modes", "two-stage-reducer", "--out", str(tmp_path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["modes"]) == 8
    assert document["modes"][0]["kind"] == "coupled"


@pytest.mark.parametrize("words", [["--load", "half"], ["--speed", "3 kg"], ["--campbell", "fast"]])
def test_what_cannot_be_is_refused(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["modes", "han2021", "--out", str(tmp_path / "new"), *words]) == 2
    assert capsys.readouterr().err.removeprefix("--").startswith(f'{words[0][2:]} = "{words[1]}": ')
    assert not (tmp_path / "new").exists()
