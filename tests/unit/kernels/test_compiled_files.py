"""Compiled code on disk: damaged, full, without a folder, of two versions at once: right numbers, or one sentence."""

import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from depth import sized
from gearplay.kernels import compiled_files
from gearplay.kernels.compiled_files import CompiledFiles, forget_old
from gearplay.kernels.compiled_once import INTERPRETED

pytestmark = pytest.mark.hostile

KEY = ("(float64,)", "cpu", "digest")
SMALL = """
import os, sys, time
import gearplay.kernels.compiled as how
how.FOLDER, BY = "gearplay-" + sys.argv[1], float(sys.argv[2])
from gearplay.kernels.compiled_files import not_kept

@how.compiled
def times(x):
    return BY * x

os.makedirs(sys.argv[3], exist_ok=True)
open(os.path.join(sys.argv[3], sys.argv[1]), "w").close()
while len(sys.argv) > 4 and len(os.listdir(sys.argv[3])) < int(sys.argv[4]):
    time.sleep(0.001)
print(times(1.0), sum(times.stats.cache_hits.values()), *not_kept)
"""


@pytest.fixture
def files(tmp_path: Path) -> CompiledFiles:
    return CompiledFiles(tmp_path / "gearplay-1", "kernel")


@pytest.fixture(autouse=True)
def nothing_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_files, "not_kept", [])


def only_file(files: CompiledFiles) -> Path:
    (file,) = files.folder.iterdir()
    return file


def test_what_was_saved_is_loaded_for_its_key_alone(files: CompiledFiles) -> None:
    assert files.load(KEY) is None
    files.save(KEY, {"code": b"\x90"})
    assert files.load(KEY) == {"code": b"\x90"}
    assert files.load((*KEY[:2], "other")) is None
    other = files.folder / only_file(files).name.replace("kernel.", "kernel2.")
    shutil.copy(
        only_file(files), other
    )  # under the name of another kernel, with the same key: it has the digest
    assert CompiledFiles(files.folder, "kernel").load(KEY) == {"code": b"\x90"}
    files.flush()
    assert files.load(KEY) is None


def test_damaged_code_is_never_run(files: CompiledFiles, tried: Callable[..., Any]) -> None:
    """Flips, cuts, swaps and growth of a compiled kernel's file: it is compiled anew."""
    files.save(KEY, os.urandom(4000))
    file = only_file(files)
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
        assert files.load(KEY) is None
    tried(trials)
    file.unlink()
    file.mkdir()
    assert files.load(KEY) is None
    files.save(KEY, 1)  # in its place
    assert len(compiled_files.not_kept) == 1
    assert [each.name for each in files.folder.iterdir()] == [file.name]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EDQUOT])
def test_a_disk_that_takes_nothing_is_noted_once(
    files: CompiledFiles, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any) -> None:
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as broken:
        broken.setattr(Path, "write_bytes", fail)
        files.save(KEY, 1)
        files.save(KEY, 1)
    assert compiled_files.not_kept == [f"{files.folder.parent}: {os.strerror(number)}"]
    assert list(files.folder.iterdir()) == []


def test_old_versions_go_and_a_few_stay(tmp_path: Path) -> None:
    for n in range(9):
        (tmp_path / f"gearplay-{n}").mkdir()
        os.utime(tmp_path / f"gearplay-{n}", (n, n))
    (tmp_path / "another").mkdir()
    forget_old(tmp_path / "gearplay-2")
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        "another",
        "gearplay-2",
        "gearplay-6",
        "gearplay-7",
        "gearplay-8",
    ]


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


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_damage_full_disk_and_no_folder_give_the_right_number(tmp_path: Path) -> None:
    file = tmp_path / "small.py"
    file.write_text(SMALL)
    where = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "0"]
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "1"]
    (code,) = (tmp_path / "cache").rglob("*.code")
    code.write_bytes(code.read_bytes()[:-7] + b"damaged")
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "0"]
    assert value_of(file, "one", "3", str(tmp_path / "met"), **where) == ["3.0", "1"]
    nowhere = {"NUMBA_CACHE_DIR": str(file / "no"), "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    assert value_of(file, "one", "3", str(tmp_path / "met"), **nowhere) == [
        "3.0", "0", "no folder that could be written to\n"
    ]  # fmt: skip


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
        ) == [value, "1"]
    tried(rounds)
