"""The `case` of a plan file counts from the plan's folder, wherever the command runs."""

from pathlib import Path

import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.files.plan_files import plan_document
from gearplay.model.bundled import bundled_text
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.vocabulary.exit_codes import INPUT

SWEEP = """
case = "CASE"
set = { "run.duration" = "1 ms", "run.transient" = "0 s" }
axes = [{ name = "backlash", path = "meshes.0.backlash", values = ["50 um", "60 um"] }]
reduce = [{ kind = "statistic", name = "rms", signal = "ax", at = "ring", statistic = "rms" }]
"""


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a plan whose case lies in a neighbouring folder; a file of the same name in the current one is another case."""
    for folder in ("plans", "cases", "elsewhere/cases"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "cases" / "own.toml").write_text(bundled_text("gearplay.model", "cases", "han2021"))
    (tmp_path / "elsewhere" / "own.toml").write_text("nonsense = true\n")
    (tmp_path / "plans" / "plan.toml").write_text(SWEEP.replace("CASE", "../cases/own.toml"))
    monkeypatch.chdir(tmp_path / "elsewhere")
    return tmp_path / "plans" / "plan.toml"


def test_sweep__reads_the_case_beside_its_plan(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert gp.sweep(str(plan), threads=1).ds.sizes["backlash"] == 2
    assert run(["sweep", "../plans/plan.toml", "--dry-run"]) == 0
    assert "2 cases" in capsys.readouterr().out


def test_calibration__reads_the_case_beside_its_plan(plan: Path) -> None:
    text = 'case = "../cases/own.toml"\n'
    (plan.parent / "calibration.toml").write_text(text)
    found = plan_document(plan.parent / "calibration.toml", "gearplay.calibration")
    assert gp.load_case(found["case"]).sha256 == gp.load_case("han2021").sha256


def test_plan__names_the_place_of_a_missing_case(plan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan.write_text(SWEEP.replace("CASE", "own.toml"))
    assert run(["sweep", "../plans/plan.toml", "--dry-run"]) == INPUT
    said = capsys.readouterr().err
    assert said.startswith(
        'case = "own.toml": must be a bundled case, or a file relative to the plan\'s folder: '
    )
    assert "../plans/own.toml does not exist." in said
    assert "Traceback" not in said


def test_plan__may_name_a_bundled_case(plan: Path) -> None:
    plan.write_text(SWEEP.replace("CASE", "han2021"))
    assert load_sweep(plan).case == "han2021"
