"""`gearplay calibrate`: report, invalid plans, kill and resume, two at once."""

import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from calibration_problems import PLAN
from depth import sized
from gearplay.model.bundled import bundled
from gearplay.model.toml_files import write_toml
from gearplay.vocabulary.errors import InputError
from programs import run_command

KILLS = sized(6, torture=20)
EVALUATIONS: int = PLAN["effort"]["evaluations"]


def command(plan: Path, out: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "gearplay.cli.main", "calibrate", str(plan), "--out", str(out), *more]


def trials(out: Path) -> list[tuple[Any, ...]]:
    """Return model, number, state and point of every stored trial."""
    place = out / "trials.sqlite"
    if not place.exists():
        return []
    query = """
        select s.study_name, t.number, t.state, a.key, a.value_json
        from trials t join studies s on s.study_id = t.study_id
        join trial_user_attributes a on a.trial_id = t.trial_id order by 1, 2, 4"""
    with sqlite3.connect(f"file:{place}?mode=ro", uri=True, timeout=60) as connection:
        try:
            return connection.execute(query).fetchall()
        except sqlite3.OperationalError:  # its tables are not made yet
            return []
        finally:
            connection.commit()


def written(out: Path) -> dict[str, Path]:
    """Return what a calibration wrote for its reader: document, table, page and figures."""
    files = [out / "calibration.json", out / "residuals.csv", out / "report.html", *out.glob("figures/*.png")]
    return {file.relative_to(out).as_posix(): file for file in files}


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plan") / "small.toml"
    path.write_text(write_toml(PLAN), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def whole(plan: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole")
    done = run_command("calibrate", plan, "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["title"] == "small"
    return out


@pytest.mark.slow
def test_the_report_is_written(whole: Path) -> None:
    assert {"report.html", "calibration.json", "residuals.csv"} <= {p.name for p in whole.iterdir()}
    document = json.loads((whole / "calibration.json").read_text(encoding="utf-8"))
    assert document["statement"]["words"]
    assert len(trials(whole)) == 2 * EVALUATIONS * 5


@pytest.mark.slow
def test_more_trials_go_on_from_those_that_are_there(plan: Path, whole: Path, tmp_path: Path) -> None:
    shutil.copytree(whole, tmp_path / "more")
    done = run_command(
        "calibrate", plan, "--out", tmp_path / "more", "--evaluations", EVALUATIONS + 4, "--json"
    )
    assert done.returncode == 0, done.stderr
    assert all(fit["trials"] == EVALUATIONS + 4 for fit in json.loads(done.stdout)["fits"])
    assert set(trials(whole)) < set(trials(tmp_path / "more"))
    fewer = run_command("calibrate", plan, "--out", tmp_path / "more", "--evaluations", EVALUATIONS - 4)
    assert (fewer.returncode, "must hold trials of the same plan" in fewer.stderr) == (2, True)


@pytest.mark.slow
@pytest.mark.hostile
def test_kills_reach_the_same_trials_and_the_same_result(plan: Path, whole: Path, tmp_path: Path) -> None:
    chance, kills, rows, every = random.Random(1), 0, 4, 2 * EVALUATIONS
    while True:
        before = len(trials(tmp_path))
        # Spread over what is left; with nothing left to spare the kill falls into the start-up.
        further = (
            chance.randint(0, max(0, (every - before // rows) // (KILLS - kills))) if kills < KILLS else every
        )
        process = subprocess.Popen(
            command(plan, tmp_path, "--json"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        while process.poll() is None and len(trials(tmp_path)) < before + rows * further:
            time.sleep(0.02)
        time.sleep(chance.random() * 0.2)
        if kills < KILLS:
            assert process.poll() is None, process.communicate()
            os.killpg(process.pid, signal.SIGKILL)
            kills += 1
            process.communicate()
            continue
        _, complaint = process.communicate(timeout=500)
        assert process.returncode == 0, complaint
        break
    assert kills == KILLS
    assert trials(tmp_path) == trials(whole)
    found, expected = (
        json.loads((out / "calibration.json").read_text(encoding="utf-8")) for out in (tmp_path, whole)
    )
    assert found == expected
    assert {place: same.read_bytes() for place, same in written(tmp_path).items()} == {
        place: same.read_bytes() for place, same in written(whole).items()
    }
    assert not list(tmp_path.glob(".*.part"))


@pytest.mark.slow
def test_a_finished_calibration_is_not_run_again(plan: Path, whole: Path) -> None:
    before = trials(whole)
    done = run_command("calibrate", plan, "--out", whole, "--json")
    assert done.returncode == 0
    assert trials(whole) == before


@pytest.mark.slow
def test_another_plan_in_the_same_folder_is_refused(whole: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(write_toml({**PLAN, "uncertainty": 0.1}), encoding="utf-8")
    done = run_command("calibrate", other, "--out", whole)
    assert done.returncode == 2
    assert "its trials.sqlite must hold trials of the same plan" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_damaged_store_is_named(plan: Path, tmp_path: Path) -> None:
    (tmp_path / "trials.sqlite").write_bytes(b"no database" * 100)
    done = run_command("calibrate", plan, "--out", tmp_path)
    assert done.returncode == 2
    assert "trials.sqlite" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.hostile
def test_ctrl_c_says_how_to_go_on(plan: Path, tmp_path: Path) -> None:
    process = subprocess.Popen(
        command(plan, tmp_path), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    while not trials(tmp_path):
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, words = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "continues there" in words


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        ({"conditions": [{"name": "a", "record": "missing.csv"}]}, 2, "missing.csv"),
        ({"sensor": {"rotor": "rng"}}, 2, "must be a rotor of the case"),
    ],
)
def test_plans_at_fault(change: dict[str, Any], code: int, words: str, tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(write_toml({**PLAN, **change}), encoding="utf-8")
    done = run_command("calibrate", path, "--out", tmp_path / "out")
    assert done.returncode == code, done.stderr
    assert words in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.deep
def test_a_plan_can_be_asked_whether_it_finds_known_parameters(plan: Path, tmp_path: Path) -> None:
    words = command(plan, tmp_path, "--recover", "3", "--evaluations", "24", "--json")
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert [row["name"] for row in document["parameters"]] == ["drag", "error"]
    assert len(document["each"]) == document["data_sets"] == 3
    assert document["trials"] == 24
    for each in document["each"]:
        for name, interval in zip(("drag", "error"), each["intervals"], strict=True):
            assert interval["low"] <= interval["median"] <= interval["high"]
            assert each["true"][name] > 0.0
    assert len(trials(tmp_path)) == 24 * 5


@pytest.mark.slow
def test_an_overwrite_that_cannot_go_on_begins_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its trials were damaged: overwriting is the cure that is said, whatever was overwritten before."""
    from gearplay.calibration import calibrate
    from gearplay.calibration.store import StudyStore
    from gearplay.cli.main import run

    plan, out = tmp_path / "plan.toml", tmp_path / "out"
    plan.write_text(write_toml(PLAN), encoding="utf-8")
    found: list[list[str]] = []

    def interrupted(loaded: Any, folder: Path, **more: Any) -> None:
        found.append(sorted(each.name for each in folder.glob("[a-z]*")))
        StudyStore(folder, loaded, "one", "digest")
        (folder / "trials.sqlite").write_bytes(b"no database" * 100)
        raise KeyboardInterrupt

    monkeypatch.setattr(calibrate, "calibrate_in", interrupted)
    for _ in range(2):
        assert run(["calibrate", str(plan), "--out", str(out), "--overwrite"]) == 130
    assert found == [[], ["trials.sqlite"], []]


def test_calibrate__folder_in_use__is_refused(tmp_path: Path) -> None:
    from gearplay.calibration.calibrate import calibrate
    from gearplay.work.folder import locked

    with locked(tmp_path), pytest.raises(InputError, match="must not be in use by another process"):
        calibrate(PLAN, tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == [".lock"]


def test_a_trial_that_was_changed_is_named(tmp_path: Path) -> None:
    from gearplay.calibration.observe import Observed
    from gearplay.calibration.reading import load_plan
    from gearplay.calibration.store import StudyStore
    from gearplay.calibration.trials import Trial

    plan = load_plan(PLAN)
    seen = {"slow": {"mesh": {"frequency": Observed(4.0, 0.01), "amplitude": Observed(0.1, 0.01)}}}
    trial = Trial(0, (0.25, 0.5), seen, "", "startup")
    StudyStore(tmp_path, plan, "coupled", "digest").add(trial)
    assert StudyStore(tmp_path, plan, "coupled", "digest").read() == [trial]
    with sqlite3.connect(tmp_path / "trials.sqlite") as connection:
        connection.execute(
            "update trial_user_attributes set value_json = '[0.25, 0.75]' where key = 'unit'",
        )
    with pytest.raises(InputError, match="trial 0 was changed"):
        StudyStore(tmp_path, plan, "coupled", "digest").read()
    with sqlite3.connect(tmp_path / "trials.sqlite") as connection:
        connection.execute("delete from trial_user_attributes where key = 'sha256'")
    with pytest.raises(InputError, match="trial 0 was changed"):
        StudyStore(tmp_path, plan, "coupled", "digest").read()


@pytest.mark.parametrize(
    ("words", "package"),
    [("calibrate", "gearplay.calibration"), ("sweep", "gearplay.sweeps"), ("dataset", "gearplay.datasets")],
)
def test_help__names_every_bundled_plan(words: str, package: str) -> None:
    said = run_command(words, "--help").stdout
    assert not [name for name in bundled(package, "plans") if name not in said]
