"""Damaged case files: refused with a message that names the fault."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from gearplay.model.reading import load_case
from gearplay.vocabulary.errors import InputError
from hostile.damage import SOUND, Damaged, damaged_cases
from hostile.damage_elements import damaged_elements

pytestmark = pytest.mark.hostile

CASES = [*damaged_cases(), *damaged_elements()]
HANG = 60  # s: far beyond what any input takes, on a busy machine too
FOREIGN = (
    "Traceback",
    "pydantic",
    "http",
    "Input should",
    "ValidationError",
    "tuple_type",
    "kind:s",
    "kind:h",
    "[key]",
)
THROUGH_THE_COMMAND = (
    "typo meshes.0.modul",
    "latin-1",
    "1 MB of nested keys",
)


@contextmanager
def guard_against_hanging(seconds: int = HANG) -> Iterator[None]:
    def fall_back(*_: object) -> None:
        raise AssertionError(f"still running after {seconds} s")

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, fall_back)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def check_message(text: str, case: Damaged) -> None:
    for named in case.named:
        assert named in text, text
    for word in FOREIGN:
        assert word not in text, text
    assert text.replace("\n", "").isprintable(), "control characters reached the message"
    assert len(text) < 12_000
    assert all(len(line) < 700 for line in text.splitlines())


def command(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "gearplay.cli.main", *words],
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=60,
        cwd=cwd,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    )


def test_the_sound_case_is_accepted_and_every_damage_changes_it(tmp_path: Path) -> None:
    path = tmp_path / "sound.toml"
    path.write_text(SOUND)
    assert load_case(path).meshes[0].backlash == 1e-4
    assert all(case.content != SOUND.encode() for case in CASES)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_damaged_case_is_refused(case: Damaged, tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(case.content)
    with guard_against_hanging(), pytest.raises(InputError) as caught:
        load_case(path)
    assert caught.value.exit_code == 2
    check_message(str(caught.value), case)


@pytest.mark.slow
@pytest.mark.parametrize("name", THROUGH_THE_COMMAND)
def test_the_command_refuses_it_with_exit_code_2(name: str, tmp_path: Path) -> None:
    case = next(case for case in CASES if case.name == name)
    path = tmp_path / "case.toml"
    path.write_bytes(case.content)
    done = command("check", str(path))
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    check_message(done.stderr, case)


@pytest.mark.slow
def test_the_command_prints_the_faults_as_json(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(SOUND.replace('"4 mm"', '"4 kg"').replace("seed = 0", "sede = 0"))
    done = command("check", str(path), "--json")
    assert done.returncode == 2
    document = json.loads(done.stdout)
    assert [fault["path"] for fault in document["faults"]] == ["meshes.0.module", "run.sede"]
    assert "meshes.0.module" in done.stderr


def test_every_fault_of_a_file_is_reported_together(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    text = SOUND.replace('"0.8 kg"', '"-1 kg"').replace('driven = "ring"', 'driven = "rng"')
    path.write_text(text.replace("seed = 0", "sede = 0").replace("restitution = 0.9", "restitution = 9"))
    with pytest.raises(InputError) as caught:
        load_case(path)
    found = {fault.path for fault in caught.value.faults}
    assert found == {"rotors.ring.mass", "meshes.0.driven", "run.sede", "sleeves.ring.restitution"}


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("han2012", ("'han2021'", "external-pair")),
        ("qqq", ("Bundled cases: cooley-parker-2012, external-pair", "pinion-idler-ring")),
        ("", ("Bundled cases",)),
        ("no/such/file.toml", ("no such file",)),
        ("missing.toml", ("no such file",)),
        (".", ("directory",)),
        ("a\0b", ("path",)),
        ("x" * 100_000, ("Bundled cases",)),
        ("/" + "x" * 100_000, ("cannot be read",)),
        ("\x1b[31m", ("\\x1b",)),
        ("/dev/null/x.toml", ("cannot be read",)),
        ("/dev/zero", ("regular file",)),
    ],
)
def test_a_source_that_is_no_case_file(name: str, named: tuple[str, ...]) -> None:
    with guard_against_hanging(), pytest.raises(InputError) as caught:
        load_case(name)
    check_message(str(caught.value), Damaged(name, b"", named))


def test_a_named_pipe_is_refused_without_waiting(tmp_path: Path) -> None:
    path = tmp_path / "pipe.toml"
    os.mkfifo(path)
    with guard_against_hanging(), pytest.raises(InputError, match="regular file"):
        load_case(path)


def test_dictionaries_are_bounded_too() -> None:
    endless: dict[str, object] = {}
    endless["rotors"] = endless
    for source in (endless, {1: 2}, {"a": list(range(200_000))}, {"run": object()}, {"rotors": {"a": None}}):
        with guard_against_hanging(), pytest.raises(InputError) as caught:
            load_case(source)  # type: ignore[arg-type]
        check_message(str(caught.value), Damaged("", b"", ()))
