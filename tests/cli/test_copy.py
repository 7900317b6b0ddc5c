"""`gearplay copy` and the first screen: what comes with the package can be found, copied and run."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gearplay as gp
from gearplay.cli.copy import PLACES, names
from gearplay.cli.main import app
from gearplay.sweeps.plans.reading import load_sweep

KNOWN = names()


def answer(*words: str, code: int = 0) -> str:
    """Return what a command prints."""
    done = CliRunner(env={"COLUMNS": "80"}).invoke(app, list(words))
    assert done.exit_code == code, (done.output, done.exception)
    return str(done.output)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWN["case"])
def test_a_copied_case_is_the_bundled_one(name: str) -> None:
    answer("copy", name, "--kind", "case")
    assert gp.load_case(f"{name}.toml").sha256 == gp.load_case(name).sha256


@pytest.mark.parametrize("name", KNOWN["sweep"])
def test_a_copied_sweep_is_the_bundled_one(name: str) -> None:
    answer("copy", name, "--kind", "sweep")
    assert load_sweep(f"{name}.toml") == load_sweep(name)


@pytest.mark.parametrize("name", KNOWN["calibration"])
def test_a_copied_calibration_has_its_records_beside_it(name: str, folder: Path) -> None:
    answer("copy", name, "--kind", "calibration", "--out", "here/mine.toml")
    plan = gp.load_plan("here/mine.toml")
    assert plan == gp.load_plan(name)
    assert all((folder / "here" / c.record).is_file() for c in plan.conditions if c.record is not None)
    assert any(c.record is not None for c in plan.conditions) == (name == "tutorial")


def test_all_names_are_listed_with_titles() -> None:
    said = answer("copy")
    assert all(f"  {name} " in said for of in KNOWN.values() for name in of)
    assert gp.load_case("two-stage-reducer").title in said
    assert json.loads(answer("copy", "--json"))["case"] == KNOWN["case"]


def test_a_copy_replaces_nothing_unasked(folder: Path) -> None:
    (folder / "han2021.toml").write_text("mine")
    from gearplay.vocabulary.errors import InputError

    done = CliRunner().invoke(app, ["copy", "han2021"])
    assert isinstance(done.exception, InputError)
    assert (folder / "han2021.toml").read_text() == "mine"
    assert "--kind calibration" in answer("copy", "han2021", "--overwrite")
    assert (folder / "han2021.toml").read_text() != "mine"


def test_no_description_of_a_command_is_cut() -> None:
    """At 80 columns; and the first screen says how to begin."""
    said = answer("--help")
    lines = said[said.index("Commands:") :].splitlines()
    assert len(lines) > 12
    assert not [line for line in lines if line.endswith("...")]
    assert "gearplay run han2021" in said
    assert "gearplay copy" in said


@pytest.mark.slow
def test_every_command_writes_set_in_one_way() -> None:
    commands = [
        line.split()[0] for line in answer("--help").split("Commands:\n")[1].split("\n\n")[0].splitlines()
    ]
    takers = [
        name for name in commands if "--set" in (text := answer(name, "--help")) and "PATH=VALUE" in text
    ]
    assert {"run", "check", "measure", "motion", "sweep"} <= set(takers)
    assert not [name for name in commands if "--set" in answer(name, "--help") and name not in takers]


def test_short_options_of_run_are_the_fields_of_the_case() -> None:
    short = answer(
        "run", "han2021", "--duration", "1ms", "--ensemble", "2", "--seed", "7", "--transient", "0", "--json"
    )
    long = answer(
        "run",
        "han2021",
        *(f"--set=run.{f}" for f in ("duration=1ms", "ensemble=2", "seed=7", "transient=0")),
        "--json",
    )
    one, other = json.loads(short), json.loads(long)
    assert one["members"] == 2
    assert one["simulated_time"] == pytest.approx(2e-3, abs=1e-3)
    assert one["case_sha256"] == other["case_sha256"] != gp.load_case("han2021").sha256


def test_package_data__folders_are_not_empty() -> None:
    assert all(KNOWN[kind] for kind in PLACES)
