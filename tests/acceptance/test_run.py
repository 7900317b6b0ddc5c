"""The run command: results, exit codes, refusals, Ctrl-C."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gearplay as gp
from gearplay.model.reading import bundled_names

GEARPLAY = [sys.executable, "-m", "gearplay.cli.main"]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*GEARPLAY, "run", *words], capture_output=True, text=True, timeout=120)


def test_run_saves_what_it_says(tmp_path: Path) -> None:
    out = tmp_path / "run.nc"
    done = run(
        "han2021",
        "--set",
        "run.duration=0.05",
        "--set",
        "meshes.0.backlash=200um",
        "--out",
        str(out),
        "--json",
    )
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    saved = gp.read_result(out).ds
    assert document["status"] == saved.attrs["status"] == "DONE"
    assert document["case_sha256"] == saved.attrs["case_sha256"]
    assert saved.sizes["time"] == 5000
    assert json.loads(saved.attrs["case"])["meshes"][0]["backlash"] == pytest.approx(200e-6)
    again = run("han2021", "--set", "run.duration=0.05", "--out", str(out))
    assert again.returncode == 2
    assert "must not exist yet" in again.stderr


@pytest.mark.parametrize("name", bundled_names())
def test_every_bundled_case_runs(name: str) -> None:
    done = run(name, "--set", "run.duration=0.02", "--set", "run.transient=0.0")
    assert done.returncode == 0, done.stderr
    assert "Done." in done.stdout


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["no-such-case"], 2, "no-such-case"),
        (["han2021", "--set", "run.durration=1"], 2, "duration"),
        (["han2021", "--set", "run.duration=1e6", "--set", "run.sampling=1e7"], 5, "GB"),
        (
            ["han2021", "--set", "run.duration=1e6", "--set", "run.sampling=1", "--set", "run.ensemble=1000"],
            5,
            "steps",
        ),
        (["han2021", "--set", "run.max_steps=100"], 3, "max_steps"),
        (["han2021", "--set", "rotors.ring.initial.x=5 mm"], 2, "mesh"),
    ],
)
def test_refusals_have_their_exit_code_and_one_sentence(words: list[str], code: int, says: str) -> None:
    done = run(*words)
    assert done.returncode == code, done.stderr
    assert says in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.hostile
def test_ctrl_c_keeps_what_was_computed(tmp_path: Path) -> None:
    out = tmp_path / "part.nc"
    words = ["run", "han2021", "--set", "run.duration=400000", "--set", "run.sampling=1", "--out", str(out)]
    for delay in (4.0, 12.0, 40.0):  # a loaded machine may still be starting when the signal comes
        process = subprocess.Popen(
            [*GEARPLAY, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
        assert process.returncode == 130, errors
        assert "Interrupted" in output + errors
        if out.exists():
            break
    saved = gp.read_result(out).ds
    assert saved.attrs["status"] == "INTERRUPTED"
    assert 0 < saved.sizes["time"] < 400_000


def test_an_ensemble_that_partly_fails_is_partly_done(monkeypatch: pytest.MonkeyPatch) -> None:
    import dataclasses

    import gearplay.results.door
    from gearplay.cli.main import run as run_words
    from gearplay.solver.status import Status

    simulate = gearplay.results.door.simulate

    def one_fails(*words: object, **options: object) -> gp.Result:
        result = simulate(*words, **options)  # type: ignore[arg-type]
        result.runs[1] = dataclasses.replace(result.runs[1], status=Status.CHATTER)
        return result

    monkeypatch.setattr(gearplay.results.door, "simulate", one_fails)
    words = [
        "run",
        "han2021",
        "--set",
        "run.ensemble=3",
        "--set",
        "run.duration=0.01",
        "--set",
        "run.transient=0",
    ]
    assert run_words(words) == 4


def test_an_ensembles_contacts_are_of_all_members(capsys: pytest.CaptureFixture[str]) -> None:
    from gearplay.cli.main import run as run_words

    words = [
        "run",
        "han2021",
        "--set",
        "run.ensemble=3",
        "--set",
        "run.duration=0.3",
        "--set",
        "run.transient=0",
    ]
    assert run_words([*words, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    each = [r.statistics for r in gp.simulate("han2021", duration=0.3, transient=0.0, ensemble=3).runs]
    hits = sum(s.impacts_per_second[0] for s in each) / 3.0
    assert said["contacts"]["ring"]["impacts_per_second"] == pytest.approx(hits)
    assert said["contacts"]["ring"]["peak_force"] == pytest.approx(max(s.peak_force[0] for s in each))
    assert said["contacts_of"].startswith("3 members together")
    assert run_words(words) == 0
    assert "Contacts: 3 members together" in capsys.readouterr().out


def test_a_record_too_large_to_be_saved_is_refused_before_the_run(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"  # the run itself would take a quarter of an hour
    done = run("han2021", "--set", "run.duration=9e5", "--set", "run.sampling=1e7", "--out", str(path))
    assert done.returncode == 5
    assert "the limit of 16 GB" in done.stderr
    assert not path.exists()


def test_a_saved_run_says_how_large_it_is(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    done = run("han2021", "--set", "run.duration=0.01", "--out", str(path))
    assert done.returncode == 0
    assert f"Saved to {path}, {path.stat().st_size / 1e6:.3g} MB" in done.stdout
