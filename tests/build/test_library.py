"""Kernel library: found by the digest of its sources, complete, of a trusted owner, built once."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay
from depth import sized
from gearplay.kernels import library
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.library import (
    LibraryError,
    check_owner,
    content_digest,
    find,
    source_digest,
    source_files,
)
from programs import run_program

pytestmark = [
    pytest.mark.hostile,
    pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here"),
    pytest.mark.skipif(sys.platform == "win32", reason="owners and modes of files"),
]
SOURCE = Path(gearplay.__file__).parent


def put(folder: Path, content: bytes) -> Path:
    """Write a library of the present sources."""
    file = folder / f"gearplay-{library.SOURCES}-{content_digest(content)}{library.SUFFIX}"
    file.write_bytes(content)
    return file


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """Return a copy of the package."""
    copy = tmp_path / "src" / "gearplay"
    shutil.copytree(SOURCE, copy, ignore=shutil.ignore_patterns("__pycache__", "_library", "*.nc", "*.png"))
    return copy


def test_library_is_found_by_the_digest_of_the_sources(tmp_path: Path) -> None:
    assert find(tmp_path) is None
    (tmp_path / f"gearplay-{'0' * 16}-{content_digest(b'other')}{library.SUFFIX}").write_bytes(b"other")
    assert find(tmp_path) is None
    file = put(tmp_path, b"content")
    assert find(tmp_path) == file


def test_source_digest_depends_on_every_file_of_kernels(sources: Path) -> None:
    before = source_digest(sources)
    assert before == source_digest()
    names = [file.relative_to(sources).as_posix() for file in source_files(sources)]
    assert {
        "kernels/layout.py",
        "integrate/stepper.py",
        "parts/registry.py",
        "parts/mesh/law/record.py",
    } <= set(names)
    for name in names:
        file = sources / name
        whole = file.read_bytes()
        file.write_bytes(whole + b"\n# edited\n")
        assert source_digest(sources) != before, name
        file.write_bytes(whole)
    schema = sources / "parts" / "sleeve" / "schema.py"
    schema.write_bytes(schema.read_bytes() + b"\n# no kernel\n")
    assert source_digest(sources) == before


def test_source_files_are_all_that_kernels_refer_to() -> None:
    """A constant from a file that the digest does not cover would let an edit go by."""
    program = """
import sys
from gearplay.build.objects import import_kernels
from gearplay.build.dependencies import _globals_of
from gearplay.kernels.compiled import CONTAINED
from gearplay.kernels.compiled_once import KERNELS
from gearplay.kernels.library import source_files
import_kernels()
sources = {str(file) for file in source_files()}
functions = {kernel.py_func for kernel in KERNELS.values()} | set(CONTAINED)
modules = {function.__module__ for function in functions}
for function in functions:
    for _, value in _globals_of(function.__code__, function.__globals__):
        modules.add(getattr(value, "__module__", None) or function.__module__)
modules = {name for name in modules if name.startswith("gearplay")}
print(len(functions), sorted(name for name in modules if sys.modules[name].__file__ not in sources))
"""
    count, others = run_program(program).stdout.split(maxsplit=1)
    assert int(count) > 300
    assert others == "[]\n"


def test_damaged_library_is_never_loaded(tmp_path: Path, tried: Callable[..., Any]) -> None:
    """Flips, cuts, swaps and growth of the kernel library: it is built anew."""
    whole, random = os.urandom(4000), np.random.default_rng(1)
    file = put(tmp_path, whole)
    assert find(tmp_path) == file
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
        assert find(tmp_path) is None
    tried(trials)


@pytest.mark.parametrize("mode", [0o777, 0o757])
@pytest.mark.parametrize("which", ["file", "folder"])
def test_library_that_others_may_replace_is_refused(mode: int, which: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    file = put(folder, b"content")
    (file if which == "file" else folder).chmod(mode)
    with pytest.raises(LibraryError, match="another user may replace this kernel library"):
        find(folder)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root may give files away")
@pytest.mark.parametrize("which", ["file", "folder"])
def test_library_of_another_user_is_refused(which: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    file = put(folder, b"content")
    os.chown(file if which == "file" else folder, 12345, -1)
    with pytest.raises(LibraryError, match="another user"):
        check_owner(file)


def test_library_folder_of_the_environment_is_the_only_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEARPLAY_LIBRARY", "/somewhere")
    assert library.folders() == [Path("/somewhere")]
    monkeypatch.delenv("GEARPLAY_LIBRARY")
    monkeypatch.setattr(library.os.path, "expanduser", lambda path: path)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert library.folders() == [library.OWN]  # without a home there is none


RUN = """
import sys
import gearplay as gp
run = gp.simulate("han2021", duration=0.01, transient=0.0)
print(run.success, "numba" in sys.modules, "llvmlite" in sys.modules)
"""


def test_run_needs_no_compiler() -> None:
    assert run_program(RUN).stdout.split() == ["True", "False", "False"]


@pytest.mark.slow
def test_missing_numba_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "numba.py").write_text("raise ModuleNotFoundError('no', name='numba')")
    paths = os.pathsep.join([str(tmp_path), str(SOURCE.parent)])
    done = run_program(RUN, check=False, GEARPLAY_LIBRARY=str(tmp_path / "library"), PYTHONPATH=paths)
    last = done.stderr.strip().splitlines()[-1]
    assert "LibraryError: The kernel library could not be built: it needs numba." in last
    assert "pip install numba" in last


@pytest.mark.slow
def test_folder_that_takes_no_files_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    done = run_program(RUN, check=False, GEARPLAY_LIBRARY=str(tmp_path / "file" / "library"))
    assert "LibraryError: The kernel library could not be built: No folder for it" in done.stderr
    assert "set GEARPLAY_LIBRARY" in done.stderr


@pytest.mark.deep
def test_no_kernel_reads_outside_its_arrays(tmp_path: Path) -> None:
    """A library that checks every index follows pairs, trains and derivatives; an index beyond its array is an error."""
    command = [sys.executable, "-m", "gearplay.build", "--bounds", "--folder", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    program = """
import gearplay as gp
for case, duration in (("han2021", 0.5), ("external-pair", 0.02), ("planetary-reducer", 0.005), ("torsional-train", 0.02)):
    result = gp.simulate(case, duration=duration)
    result.ds.load()
    print(result.success)
print(gp.modes("two-stage-reducer").ds.sizes["mode"] > 0, gp.lyapunov_exponents("han2021", duration=0.2, transient=0.1).largest)
"""
    done = run_program(program, GEARPLAY_LIBRARY=str(tmp_path))
    assert done.stdout.split()[:5] == ["True"] * 5


def is_running(group: int) -> bool:
    """Return whether a process group has any process."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def objects_of(folder: Path) -> None:
    """Link the object files of the present library into a folder: a build there has only to link."""
    kept = Path(os.environ["GEARPLAY_LIBRARY"]) if os.environ.get("GEARPLAY_LIBRARY") else library.OWN
    if not (kept / "objects").is_dir():
        pytest.skip("the object files of this library are not kept")
    (folder / "objects").mkdir(parents=True)
    for file in (kept / "objects").glob("*.o"):
        shutil.copy2(file, folder / "objects" / file.name)


@pytest.mark.slow
def test_builds_at_the_same_time_end_with_one_library(tmp_path: Path, tried: Callable[..., Any]) -> None:
    """Runs that find no library start at once, some are killed: the others have the right numbers, no half file is loaded."""
    random, rounds = np.random.default_rng(2), sized(2, 1, torture=300)
    for turn in range(rounds):
        folder = tmp_path / str(turn)
        objects_of(folder)
        environment = {**os.environ, "GEARPLAY_LIBRARY": str(folder)}
        running = [
            subprocess.Popen(
                [sys.executable, "-c", RUN],
                env=environment,
                stdout=subprocess.PIPE,
                text=True,
                stderr=subprocess.DEVNULL,
            )
            for _ in range(3)
        ]
        time.sleep(random.uniform(0.2, 4.0))
        running[0].kill()
        said = [each.communicate(timeout=600)[0].split()[:1] for each in running]
        assert said[1:] == [["True"], ["True"]]
        assert len(list(folder.glob("*.so"))) == 1
        shutil.rmtree(folder)
    tried(3 * rounds)


@pytest.mark.slow
def test_ctrl_c_ends_a_build_with_one_sentence(tmp_path: Path) -> None:
    """A command waits for a build of several minutes: Ctrl-C ends both, with all processes; kernels that are compiled stay."""
    command = [sys.executable, "-m", "gearplay", "run", "han2021", "--duration", "0.1"]
    environment = {**os.environ, "GEARPLAY_LIBRARY": str(tmp_path)}
    running = subprocess.Popen(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    for _ in range(600):
        time.sleep(0.1)
        if list(tmp_path.glob("objects/*.o")):
            break
    os.killpg(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=30.0)
    assert running.returncode == 130
    assert "Traceback" not in said
    assert said.count("nterrupted") == 1
    ended = time.monotonic() + 30.0
    while time.monotonic() < ended and is_running(running.pid):
        time.sleep(0.1)
    assert not is_running(running.pid)
    assert list(tmp_path.glob("objects/*.o"))
    assert find(tmp_path) is None


@pytest.mark.slow
def test_builds_that_are_killed_leave_no_half_library(tmp_path: Path, tried: Callable[..., Any]) -> None:
    """A build is killed at any moment: what is found afterwards is whole, and the next build completes it."""
    random, trials = np.random.default_rng(3), sized(4, 2, torture=3000)
    objects_of(tmp_path)
    command = [sys.executable, "-m", "gearplay.build", "--folder", str(tmp_path)]
    for _ in range(trials):
        builder = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(random.uniform(0.3, 2.5))
        builder.kill()
        builder.wait()
        found = find(tmp_path)
        if found is not None:
            assert content_digest(found.read_bytes()) == found.stem.rpartition("-")[2]
            found.unlink()
    assert subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()[-1] == str(
        find(tmp_path)
    )
    tried(trials)


def test_progress__what_is_kept_and_lines_while_nothing_is_complete(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Lines come before the first kernel is complete, and a build that resumes names the part that is there."""
    from unittest.mock import patch

    from gearplay.build import __main__ as program

    times = iter([0.0, 0.0, 10.0, 20.0, 25.0, 40.0])
    with patch.object(program.time, "monotonic", lambda: next(times)):
        report = program._progress()
        for done in (300, 300, 400, 500, 1000):
            report(done, 1000)
    assert capsys.readouterr().err.splitlines() == [
        "Building the kernel library, once after an installation or an edit: some minutes; 30 % of it is there already.",
        "30 % of the kernel library, 10 s so far.",
        "40 % of the kernel library, about 120 s left.",
    ]


@pytest.mark.slow
def test_a_build_that_is_terminated_leaves_no_semaphores_and_no_traceback(tmp_path: Path) -> None:
    """As `timeout` and a batch system end it: all processes of its group at once."""
    command = [sys.executable, "-m", "gearplay.build", "--folder", str(tmp_path)]
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    for _ in range(900):
        time.sleep(0.1)
        if list(tmp_path.glob("objects/*.part")) or list(tmp_path.glob("objects/*.o")):
            break
    os.killpg(running.pid, signal.SIGTERM)
    out, said = running.communicate(timeout=60.0)
    assert running.returncode in (1, 130)
    assert "Building the kernel library" in said
    assert "leaked" not in said
    assert "Traceback" not in out + said


@pytest.mark.slow
def test_a_build_that_waits_for_another_says_so(tmp_path: Path) -> None:
    from gearplay.vocabulary.file_lock import try_lock

    handle = try_lock(tmp_path / ".lock")
    assert handle is not None
    command, said = [sys.executable, "-m", "gearplay.build", "--folder", str(tmp_path)], tmp_path / "said.txt"
    with said.open("w") as file:
        running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=file)
    try:
        for _ in range(600):
            time.sleep(0.1)
            if said.read_text():
                break
    finally:
        running.kill()
        running.wait()
        os.close(handle)
    assert said.read_text() == f"Another process builds the kernel library in {tmp_path}: waiting for it.\n"
