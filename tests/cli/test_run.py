"""`gearplay run`: results, exit codes, refusals, Ctrl-C."""

import dataclasses
import json
import pkgutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from gearplay.cli.main import run as command
from gearplay.files import netcdf_streams
from gearplay.model.reading import bundled_names
from gearplay.results import simulate
from gearplay.solver.status import Status
from programs import run_command

GEARPLAY = [sys.executable, "-m", "gearplay.cli.main"]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return run_command("run", *words)


@pytest.mark.slow
def test_run_saves_what_it_says(tmp_path: Path) -> None:
    out = tmp_path / "run.nc"
    changes = ["--set", "run.duration=0.05", "--set", "meshes.0.backlash=200um"]
    done = run("han2021", *changes, "--out", str(out), "--json")
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


@pytest.mark.slow
@pytest.mark.parametrize("name", bundled_names())
def test_every_bundled_case_runs(name: str) -> None:
    done = run(name, "--set", "run.duration=0.02", "--set", "run.transient=0.0")
    assert done.returncode == 0, done.stderr
    assert "Done." in done.stdout


@pytest.mark.slow
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


@pytest.mark.slow
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


THREE = ["run", "han2021", "--set", "run.ensemble=3", "--transient", "0s"]
QUICK = ["run", "han2021", "--duration", "0.01s", "--transient", "0s", "--json", "--out"]
Said = pytest.CaptureFixture[str]


def interrupt_after(do: Callable[..., Any]) -> Callable[..., Any]:
    def done(*words: Any, **more: Any) -> Any:
        found = do(*words, **more)
        signal.raise_signal(signal.SIGINT)
        return found

    return done


@contextmanager
def interrupted_bar(*, quiet: bool) -> Iterator[None]:
    yield None
    signal.raise_signal(signal.SIGINT)


@pytest.mark.slow
@pytest.mark.hostile
@pytest.mark.parametrize(
    "at", ["cli.run.progress_bar", "files.atomic._sync_folder", "files.atomic.os.link", "cli.run._summary"]
)
def test_ctrl_c_after_the_run_leaves_its_whole_result(
    at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    """Before it is saved, when it has its name, when it is saved."""
    out, place = tmp_path / "x.nc", f"gearplay.{at}"
    do = pkgutil.resolve_name(place)
    for words, code in ((QUICK, 130), ([*QUICK[:-2], "--overwrite", "--out"], 0 if "link" in at else 130)):
        with monkeypatch.context() as patched:
            patched.setattr(place, interrupted_bar if "bar" in at else interrupt_after(do))
            assert command([*words, str(out)]) == code
        said = capsys.readouterr()
        if "--json" in words:
            document = json.loads(said.out)
            assert document["kept"] == f"Interrupted, but the result is whole: it is saved to {out}."
            assert (document["status"], document["out"]) == ("DONE", str(out))
        elif code:
            assert said.err == f"Interrupted, but the result is whole: it is saved to {out}.\n"
            assert f"Saved to {out}" in said.out
        assert gp.read_result(out).ds.attrs["status"] == "DONE"
        assert [each.name for each in tmp_path.iterdir()] == ["x.nc"]


@pytest.mark.slow
@pytest.mark.hostile
@pytest.mark.parametrize("old", [False, True])
def test_ctrl_c__before_the_file_is_renamed_is_reported(
    old: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    out = tmp_path / "x.nc"
    if old:
        out.write_bytes(b"old")
    monkeypatch.setattr(netcdf_streams, "_on_thread", interrupt_after(netcdf_streams._on_thread))
    assert command([*QUICK, str(out), "--overwrite"]) == 130
    document = json.loads(capsys.readouterr().out)
    assert document["lost"].startswith(
        f"Interrupted while the result was saved. Nothing was written to {out}; "
    )
    assert document["out"] is None
    assert [each.read_bytes() for each in tmp_path.iterdir()] == ([b"old"] if old else [])


@pytest.mark.hostile
def test_a_disk_that_fails_after_ctrl_c_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("gearplay.cli.run.progress_bar", interrupted_bar)
    monkeypatch.setattr("gearplay.files.atomic.os.fsync", full)
    assert command([*QUICK, str(tmp_path / "x.nc")]) == 130
    said = json.loads(capsys.readouterr().out)["lost"]
    assert said.startswith("Interrupted and the result could not be saved: ")
    assert "No space left" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.hostile
def test_after_ctrl_c_anothers_result_is_not_taken_for_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    out, write = tmp_path / "x.nc", netcdf_streams._on_thread

    def late(*words: Any, **more: Any) -> Any:
        out.write_bytes(b"another's")
        return write(*words, **more)

    monkeypatch.setattr("gearplay.cli.run.progress_bar", interrupted_bar)
    monkeypatch.setattr(netcdf_streams, "_on_thread", late)
    assert command([*QUICK, str(out)]) == 130
    said = json.loads(capsys.readouterr().out)
    assert "must not exist yet" in said["lost"]
    assert said["out"] is None
    assert out.read_bytes() == b"another's"


@pytest.mark.slow
@pytest.mark.parametrize(("whole", "partial"), [(False, False), (True, False), (False, True)])
def test_partial_result__does_not_replace_a_newer_one(
    whole: bool, partial: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    """Another run of the same command has ended by then."""
    out, beside = tmp_path / "x.nc", tmp_path / "x.partial.nc"
    for file in [out] * whole + [beside] * partial:
        file.write_bytes(b"old")
    simulated, write = simulate.simulate, netcdf_streams._on_thread

    def stopped(*words: Any, **more: Any) -> gp.Result:
        result = simulated(*words, **more)
        stopped = dataclasses.replace(result.runs[0], status=Status.INTERRUPTED)
        return gp.Result(result.case, [stopped])

    def late(*words: Any, **more: Any) -> Any:
        out.write_bytes(b"another's, whole")
        return write(*words, **more)

    monkeypatch.setattr(simulate, "simulate", stopped)
    monkeypatch.setattr(netcdf_streams, "_on_thread", late)
    assert command([*QUICK, str(out), "--overwrite"]) == 130
    assert out.read_bytes() == b"another's, whole"
    assert gp.read_result(beside).ds.attrs["status"] == "INTERRUPTED"
    assert json.loads(capsys.readouterr().out)["out"] == str(beside)


def test_an_ensemble_that_partly_fails_is_partly_done(monkeypatch: pytest.MonkeyPatch) -> None:
    run_all = simulate.simulate

    def one_fails(*words: Any, **options: Any) -> gp.Result:
        result = run_all(*words, **options)
        runs = list(result.runs)
        runs[1] = dataclasses.replace(runs[1], status=Status.CHATTER)
        return gp.Result(result.case, runs)

    monkeypatch.setattr(simulate, "simulate", one_fails)
    assert command([*THREE, "--duration", "0.01s"]) == 4


def test_an_ensembles_contacts_are_of_all_members(capsys: pytest.CaptureFixture[str]) -> None:
    words = [*THREE, "--duration", "0.3s"]
    assert command([*words, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    each = [r.statistics for r in gp.simulate("han2021", duration=0.3, transient=0.0, ensemble=3).runs]
    hits = sum(s.impacts_per_second[0] for s in each) / 3.0
    assert said["contacts"]["ring"]["impacts_per_second"] == pytest.approx(hits)
    assert said["contacts"]["ring"]["peak_force"] == pytest.approx(max(s.peak_force[0] for s in each))
    assert said["contacts_of"].startswith("3 members together")
    assert command(words) == 0
    assert "Contacts: 3 members together" in capsys.readouterr().out


@pytest.mark.slow
def test_a_record_too_large_for_memory_is_saved_as_its_motion(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    done = run("han2021", "--duration", "300s", "--set", "run.sampling=10MHz", "--out", str(path))
    assert done.returncode == 0, done.stderr
    back = gp.read_result(path)
    assert back.signal("ring.ax", window=(1.0, 1.001)).size == 10_000
    with pytest.raises(gp.ResourceError, match="limit of 16 GB"):
        back.signal("ring.ax")


@pytest.mark.slow
def test_a_saved_run_says_how_large_it_is(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    done = run("han2021", "--set", "run.duration=0.01", "--out", str(path))
    assert done.returncode == 0
    assert f"Saved to {path}, {path.stat().st_size / 1e6:.3g} MB" in done.stdout


TORQUES = """
[rotors.load]
mass = "1 kg"
inertia = "2e-2 kg m^2"
load = { drag = "8e-3 N m s/rad" }
initial = { omega = 0.0 }

[rotors.motor]
mass = "0.3 kg"
inertia = "3e-5 kg m^2"
initial = { omega = 1.0 }

[[couplings]]
between = ["load", "motor"]
ratio = 0.1
torsional_stiffness = "40 N m/rad"
play = "3e-3 rad"

[run]
duration = "0.2 s"
sampling = "1 kHz"
"""


def test_peaks_of_couplings__are_torques_with_three_digits(tmp_path: Path, capsys: Said) -> None:
    """Torques of instruments are thousandths of N m: the table has the number of ``--json``, not 0.0."""
    case = tmp_path / "tilt.toml"
    case.write_text(TORQUES)
    assert command(["run", str(case), "--json"]) == 0
    contacts = json.loads(capsys.readouterr().out)["contacts"]
    label, found = next((label, each) for label, each in contacts.items() if each["share_of_time"] > 0.0)
    assert 0.0 < found["peak_force"] < 0.05
    assert command(["run", str(case)]) == 0
    text = capsys.readouterr().out
    assert "peak torque" in text
    line = next(line for line in text.splitlines() if line.startswith(label))
    shown, *unit = line.split()[-3:]
    assert unit == ["N", "m"]
    assert float(shown) == pytest.approx(found["peak_force"], rel=5e-3)


RARE = """
gravity = ["0 m/s^2", "0 m/s^2"]

[rotors.disc]
mass = "1 kg"
inertia = "1e-3 kg m^2"
initial = { vx = "0.05 mm/s" }

[sleeves.disc]
radial_clearance = "0.5 mm"
stiffness = "1e12 N/m^1.5"
restitution = 0.2

[run]
duration = "20 s"
sampling = "100 Hz"
"""


def test_a_rare_impact__has_its_rate_and_its_share_of_time(tmp_path: Path, capsys: Said) -> None:
    """One impact in 20 s is 0.05 1/s and less than 0.01 % of the time, neither of them 0."""
    case = tmp_path / "rare.toml"
    case.write_text(RARE)
    assert command(["run", str(case), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["contacts"]["disc"]
    assert found["impacts_per_second"] == pytest.approx(1.0 / 20.0)
    assert 0.0 < found["share_of_time"] < 5e-5
    assert command(["run", str(case)]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("disc"))
    share, percent, rate, unit = line.split()[1:5]
    assert (percent, unit, rate) == ("%", "1/s", "0.05")
    assert float(share) == pytest.approx(100.0 * found["share_of_time"], rel=5e-3)
