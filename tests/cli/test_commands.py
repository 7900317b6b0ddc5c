"""The command line as a user meets it: documents, messages, exit codes."""

import importlib
import json
import os
import subprocess
import sys

import pytest
import typer

from gearplay.cli import main as cli
from gearplay.vocabulary import errors
from programs import run_command


def test_version_is_one_line_and_loads_nothing_heavy() -> None:
    code = (
        "import sys; from gearplay.cli.main import run\n"
        "print(run(['--version']), [name for name in ('pydantic', 'numpy', 'rich') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[1] == "0 []"
    assert done.stdout.startswith("gearplay ")


@pytest.mark.slow
def test_check_prints_findings() -> None:
    done = run_command("check", "han2021", "--set", "rotors.pinion.inertia=2kg m^2", "--set", "accepted=[]")
    assert (done.returncode, done.stderr) == (0, "")
    assert "warning: rotors.pinion.inertia" in done.stdout
    assert done.stdout.rstrip().endswith("2 warnings.")


@pytest.mark.slow
def test_check_prints_one_json_document() -> None:
    done = run_command("check", "han2021", "--json", "--set", "meshes.0.backlash=50 um")
    assert (done.returncode, done.stderr) == (0, "")
    document = json.loads(done.stdout)
    assert document["case"]["meshes"][0]["backlash"] == 5e-5
    assert len(document["sha256"]) == 64
    assert {finding["severity"] for finding in document["findings"]} == {"warning", "note"}


@pytest.mark.slow
def test_schema_is_json_with_and_without_json() -> None:
    plain, asked = run_command("schema"), run_command("schema", "--json")
    assert plain.stdout == asked.stdout
    assert json.loads(plain.stdout)["title"] == "gearplay case"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("chek", "han2021"), "chek"),
        (("check",), "case"),
        (("check", "han2021", "--bogus"), "--bogus"),
        (("check", "han2012"), "'han2021'"),
        (("check", "han2021", "--set", "run.sede=1"), "'seed'"),
    ],
)
def test_bad_input_ends_with_2_and_one_sentence(words: tuple[str, ...], named: str) -> None:
    done = run_command(*words)
    assert (done.returncode, done.stdout) == (2, "")
    assert named in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_debug_shows_the_traceback_wherever_it_stands() -> None:
    for words in (("--debug", "check", "han2012"), ("check", "han2012", "--debug")):
        line = [sys.executable, "-m", "gearplay.cli.main", *words]
        done = subprocess.run(line, capture_output=True, text=True)
        assert done.returncode != 0
        assert "Traceback" in done.stderr
        assert "InputError" in done.stderr


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (errors.InputError(errors.Fault("a", 1, "is wrong")), 2),
        (errors.SimulationError("it diverged"), 3),
        (errors.ResourceError("too much"), 5),
        (errors.MeasurementError("unreadable"), 6),
        (KeyboardInterrupt(), 130),
        (typer.Abort(), 130),
        (ZeroDivisionError("division by zero"), 1),
    ],
)
def test_each_error_has_its_exit_code(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise error

    importlib.import_module("gearplay.model.check")  # which would keep what it imports now
    monkeypatch.setattr("gearplay.model.reading.load_case", fail)
    assert cli.run(["check", "han2021"]) == code
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") <= 1
    assert "Traceback" not in printed.err
    assert cli.run(["check", "han2021", "--json"]) == code
    if code != 130:
        assert json.loads(capsys.readouterr().out)["exit_code"] == code


@pytest.mark.slow
def test_a_closed_pipe_is_nothing_to_talk_about() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "wb") as closed:
        line = [sys.executable, "-m", "gearplay.cli.main", "schema"]
        done = subprocess.run(line, stdout=closed, stderr=subprocess.PIPE, timeout=60)
    assert done.stderr == b""


@pytest.mark.slow
@pytest.mark.parametrize("words", [(), ("--json",)])
def test_a_narrow_encoding_does_not_break_a_result(words: tuple[str, ...]) -> None:
    line = [sys.executable, "-m", "gearplay.cli.main", "check", "han2021", "--set", "title=Zähne", *words]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii:strict", "PYTHONUTF8": "1"}
    done = subprocess.run(line, capture_output=True, timeout=60, env=environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"Z\\xe4hne" in done.stdout or b"Z\\u00e4hne" in done.stdout
