"""What verbs write they say: each page and each picture is named on the screen, and pages name those beside them."""

import json
import os.path
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from calibration_problems import PLAN
from gearplay.cli.main import run
from gearplay.cli.study import _address
from gearplay.model.toml_files import write_toml

SEEN = (".html", ".png", ".svg", ".pdf", ".gif", ".mp4")
SMALL = ["--set", "run.duration=0.1s", "--set", "run.transient=0s", "--set", "run.sampling=5kHz"]
SWEEP: dict[str, Any] = {
    "case": "han2021",
    "set": {"run.duration": "0.1 s", "run.transient": "0 s", "run.sampling": "2 kHz"},
    "axes": [{"name": "speed", "path": "rotors.pinion.drive.speed", "low": "60 rpm", "high": "200 rpm", "count": 3}],
    "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}],
}  # fmt: skip
CALIBRATION = PLAN | {"effort": PLAN["effort"] | {"evaluations": 12, "startup": 8, "polish": 2}}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder that holds a result, a sweep plan and a calibration plan."""
    monkeypatch.chdir(tmp_path)
    write_toml_file(tmp_path / "sweep.toml", SWEEP)
    write_toml_file(tmp_path / "fit.toml", CALIBRATION)
    assert run(["run", "han2021", *SMALL, "--out", "run.nc"]) == 0
    return tmp_path


def write_toml_file(path: Path, document: dict[str, Any]) -> None:
    path.write_text(write_toml(document), encoding="utf-8")


def pages(folder: Path) -> set[Path]:
    return {each for each in folder.rglob("*") if each.suffix in SEEN}


VERBS = (
    "plot run.nc",
    "animate run.nc --frames 20",
    "analyze run.nc --out figures",
    "modes pulsating-pair --out out",
    "portrait han2021 --settle 2 --keep 5 --out out",
    "bifurcation han2021 rotors.pinion.drive.speed --low 60rpm --high 99rpm --count 4 --settle 2 --keep 3 --signal ring.x "
    "--out out",
    "sweep sweep.toml --out out",
)
LONG_VERBS = ("calibrate fit.toml --out out",)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "words",
    [*VERBS, *(pytest.param(each, marks=pytest.mark.deep) for each in LONG_VERBS)],
    ids=lambda words: words.split()[0],
)
def test_every_page_and_picture_is_named(
    folder: Path, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run(words.split()) == 0
    said = capsys.readouterr().out
    written = pages(folder)
    assert written
    for each in written:
        assert each.name in said, each
        assert str(each.parent.relative_to(folder)) in said, each
    for page in (each for each in written if each.suffix == ".html" and each.name != "run-motion.html"):
        text = page.read_text(encoding="utf-8")
        for other in (each for each in written if each.suffix == ".html" and each != page):
            assert f'href="{os.path.relpath(other, page.parent)}"' in text


def test_reports_of_other_parameters_lie_beside() -> None:
    assert _address("calibrated", "assumed", "calibrated") == "assumed/report.html"
    assert _address("assumed", "calibrated", "calibrated") == "../report.html"
    assert _address("assumed", "geometric-inertia", "calibrated") == "../geometric-inertia/report.html"


@pytest.mark.slow
def test_run_command__names_the_commands_that_draw_it(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run(["run", "han2021", *SMALL, "--out", "a b.nc"]) == 0
    assert capsys.readouterr().out.rstrip().endswith("See it: gearplay plot 'a b.nc'")
    assert run(["run", "han2021", *SMALL, "--json", "--out", "c.nc"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["out"] == "c.nc"
    assert run(["run", "han2021", *SMALL, "--ensemble", "3"]) == 0
    assert "3 members, " in (said := capsys.readouterr().out)
    assert "core seconds" in said


@pytest.mark.slow
def test_advice_from_below_is_said_in_options(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(
        gp.InputError, match=r"must not exist yet\. Choose another name, or give overwrite=True\."
    ):
        gp.read_result("run.nc").save("run.nc")
    capsys.readouterr()
    assert run(["run", "han2021", *SMALL, "--out", "run.nc"]) == 2
    assert "must not exist yet. Choose another name, or say --overwrite." in capsys.readouterr().err
    assert run(["plot", "run.nc", "--at", "rim", "--json"]) == 2
    said = capsys.readouterr()
    assert said.err.startswith('--at = "rim": must be a rotor')
    assert json.loads(said.out)["faults"][0]["path"] == "--at"
