"""`gearplay lost-motion`: files, numbers as the function returns them, refusals of options."""

import json
from pathlib import Path

import pytest

import gearplay as gp
from gearplay.cli.main import run
from hysteresis_curves import Truth, record

HELD = ["lost-motion", "two-stage-reducer", "--at", "output", "--hold", "input"]


def test_lost_motion__of_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        *HELD,
        "--rated-torque",
        "200Nm",
        "--stages",
        "28Nm,96Nm",
        "--positions",
        "3",
        "--members",
        "4",
        "--out",
        str(tmp_path),
    ]
    assert run([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    expected = gp.lost_motion(
        "two-stage-reducer",
        at="output",
        hold="input",
        torque=200.0,
        stages=[28.0, 96.0],
        positions=3,
        members=4,
    ).ds
    for name in ("lost_motion", "backlash_arcmin", "torsional_stiffness"):
        assert document[name] == pytest.approx(float(expected[name]), rel=1e-12)
    assert list(document["stiffness"]) == ["K1", "K2", "K3"]
    assert len(document["lost_motion_by_member"]) == 4
    assert document["lost_motion_by_position"][0] == pytest.approx(document["lost_motion"], rel=1e-9)
    assert gp.read_result(document["out"]).ds.attrs["at"] == "output"
    assert Path(document["picture"]).stat().st_size > 20_000
    page = Path(document["report"]).read_text(encoding="utf-8")
    assert "arcmin of lost motion" in page
    assert "Over 4 members" in page
    assert run(words) == 2  # they are there
    assert "overwrite" in capsys.readouterr().err
    assert run([*words, "--overwrite"]) == 0
    assert "mesh layshaft.pinion-output" in capsys.readouterr().out


def test_lost_motion__of_a_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = record(tmp_path / "rig.csv", Truth(), noise=1e-3)
    words = ["lost-motion", str(path), "--columns", "Torque,Output Poisition", "--stages", "14Nm,48Nm"]
    assert run([*words, "--out", str(tmp_path / "a"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    low, high = document["play_interval"]
    assert low < 1e-3 < high
    assert gp.read_result(document["out"]).ds.sizes["sample"] == 800
    assert "Fit to 800 samples" in Path(document["report"]).read_text(encoding="utf-8")
    assert run([*words, "--out", str(tmp_path / "b")]) == 0
    assert "friction" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["--torque", "5 parsec"], "--rated-torque"),
        ([], "--rated-torque: is required of a case"),
        (["--torque", "5Nm", "--columns", "1,2"], "--columns"),
        (["--torque", "5Nm", "--stages", "4Nm,3Nm"], "--stages"),
        (["--torque", "5Nm", "--hold", "layshaf"], "--hold"),
        (["--torque", "5Nm", "--temperatures", "cold"], "temperatures.0"),
    ],
)
def test_lost_motion__refusals(
    words: list[str], shown: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*HELD, *words, "--out", str(tmp_path)]) == 2
    assert shown in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_lost_motion__options_of_a_case_with_a_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = record(tmp_path / "rig.csv", Truth(), noise=1e-3)
    assert run(["lost-motion", str(path), "--hold", "input", "--out", str(tmp_path / "a")]) == 2
    assert "must not be given with a measured curve" in capsys.readouterr().err
