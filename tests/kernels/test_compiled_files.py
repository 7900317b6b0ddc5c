"""Compiled code on disk: damaged, full, without a folder, of two versions at once: right numbers, or one sentence."""

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from depth import sized
from gearplay.kernels import compiled_files
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.compiled_files import forget_old, load, save
from gearplay.kernels.machine_code import Code, link
from gearplay.solver import compiling

pytestmark = pytest.mark.hostile

CODE = Code("kernel", ["sin", "another"], b"\x90\n" + bytes(range(256)))
SMALL = """
import os, sys, time
from gearplay.kernels import compiled_files, compiler
BY = float(sys.argv[2])
compiled_files.compiled_from = lambda: sys.argv[1]
from gearplay.kernels.compiled_once import compiled_once
made, compile_kernel = [], compiler.compile_kernel
compiler.compile_kernel = lambda kernel: made.append(kernel.name) or compile_kernel(kernel)

@compiled_once
def times(x: float) -> float:
    return BY * x

os.makedirs(sys.argv[3], exist_ok=True)
open(os.path.join(sys.argv[3], sys.argv[1]), "w").close()
while len(sys.argv) > 4 and len(os.listdir(sys.argv[3])) < int(sys.argv[4]):
    time.sleep(0.001)
print(times(1.0), len(made), *compiled_files.not_kept)
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "code-1" / "room.kernel.code"


@pytest.fixture(autouse=True)
def nothing_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_files, "not_kept", [])


def test_what_was_saved_is_loaded_for_its_form_alone(file: Path) -> None:
    assert load(file, "one") is None
    save(file, CODE, "one")
    assert load(file, "one") == CODE
    assert load(file, "another") is None


def test_damaged_code_is_never_run(file: Path, tried: Callable[..., Any]) -> None:
    """Flips, cuts, swaps and growth of a compiled kernel's file: it is compiled anew."""
    save(file, Code("kernel", [], os.urandom(4000)), "one")
    whole, random = file.read_bytes(), np.random.default_rng(1)
    trials = sized(200, 40, torture=5000)
    for n in range(trials):
        at = int(random.integers(len(whole)))
        damaged = (
            whole[:at],
            whole + bytes(1 + at % 9),
            whole[:at] + bytes([whole[at] ^ (1 << at % 8)]) + whole[at + 1 :],
            whole[at:] + whole[:at] if at else whole[1:],
        )[n % 4]
        file.write_bytes(damaged)
        assert load(file, "one") is None
    tried(trials)
    file.unlink()
    file.mkdir()
    assert load(file, "one") is None
    save(file, CODE, "one")  # in its place
    assert len(compiled_files.not_kept) == 1
    assert [each.name for each in file.parent.iterdir()] == [file.name]


def test_code_that_needs_what_is_not_there_is_compiled_anew() -> None:
    """LLVM would end the process."""
    assert link(Code("kernel", ["sin", "no_such_function_anywhere"], b""), lambda name: None) is None


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EDQUOT])
def test_a_disk_that_takes_nothing_is_noted_once(
    file: Path, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any) -> None:
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as broken:
        broken.setattr(Path, "write_bytes", fail)
        save(file, CODE, "one")
        save(file, CODE, "one")
    assert compiled_files.not_kept == [f"{file.parent.parent}: {os.strerror(number)}"]
    assert list(file.parent.iterdir()) == []


def test_old_versions_go_and_a_few_stay(tmp_path: Path) -> None:
    for n in range(9):
        (tmp_path / f"code-{n}").mkdir()
        os.utime(tmp_path / f"code-{n}", (n, n))
    (tmp_path / "another").mkdir()
    forget_old(tmp_path / "code-2")
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        "another",
        "code-2",
        "code-6",
        "code-7",
        "code-8",
    ]


def test_a_folder_that_is_made_has_old_ones_removed(tmp_path: Path) -> None:
    """By whoever makes it: the lock of those that compile lies in it before any code."""
    for n in range(8):
        (tmp_path / f"code-{n}").mkdir()
    with compiling._alone(tmp_path / "code-new", lambda: None):
        save(tmp_path / "code-new" / "kernel.code", CODE, "one")
    assert len(list(tmp_path.iterdir())) == compiled_files.VERSIONS


def test_the_folder_depends_on_what_changes_the_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def digest() -> str:
        compiled_files.compiled_from.cache_clear()
        return compiled_files.compiled_from()

    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    try:
        usual = digest()
        monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
        assert digest() == usual
        monkeypatch.setenv("NUMBA_OPT", "1")
        changed = digest()
        assert changed != usual
        monkeypatch.delenv("NUMBA_OPT")
        (tmp_path / ".numba_config.yaml").write_text("opt: 1")
        assert digest() not in (usual, changed)
    finally:
        compiled_files.compiled_from.cache_clear()


def test_without_a_home_there_is_no_place_at_home(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(compiled_files.os.path, "expanduser", lambda path: path)
    assert [place.name for place in compiled_files._places()] == ["__pycache__"]


def value_of(file: Path, *words: str, **environment: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, str(file), *words],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.split(maxsplit=2)


@pytest.mark.slow
@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_damage_full_disk_and_no_folder_give_the_right_number(tmp_path: Path) -> None:
    file = tmp_path / "small.py"
    file.write_text(SMALL)
    where = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "1"]
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "0"]
    (code,) = (tmp_path / "cache").rglob("*.code")
    code.write_bytes(code.read_bytes()[:-7] + b"damaged")
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "1"]
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "0"]
    nowhere = {"NUMBA_CACHE_DIR": str(file / "no")}
    assert value_of(file, "one", "3", str(tmp_path / "met"), **nowhere) == [
        "3.0", "1", "no folder that could be written to\n"
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_two_versions_at_once_each_have_their_own_numbers(tmp_path: Path, tried: Callable[..., Any]) -> None:
    """Two versions compile a kernel of one name at one place, at the same time in one cache: each has its own numbers."""
    file = tmp_path / "small.py"
    file.write_text(SMALL)
    rounds = sized(3, 1, torture=50)
    for n in range(rounds):
        met = str(tmp_path / f"met-{n}")
        running = [
            subprocess.Popen(
                [sys.executable, str(file), version, by, met, "2"],
                env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}, stdout=subprocess.PIPE, text=True,
            )
            for version, by in (("one", "3"), ("two", "5"))
        ]  # fmt: skip
        told = [each.communicate(timeout=600)[0].split()[0] for each in running]
        assert told == ["3.0", "5.0"]
    for version, value in (("one", "3.0"), ("two", "5.0")):  # each loads its own
        assert value_of(
            file, version, value, str(tmp_path / "met"), NUMBA_CACHE_DIR=str(tmp_path / "cache")
        ) == [value, "0"]
    tried(rounds)
