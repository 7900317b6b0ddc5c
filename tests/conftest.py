"""Test-wide settings: depths, one kernel cache named by its source, compiled once for all workers during the first tests."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from depth import ALL, FULL, SHARE
from gearplay.kernels.compiled_files import kernel_digest
from pictures import faults_of

TESTS = Path(__file__).resolve().parent
ALONE = (
    "cli/test_analyze",
    "hostile/test_damaged",
    "cross/test_posterior",
    "cross/test_reference_self",
    "calibration",
    "files",
    "model",
    "nonlinear/test_classify",
    "nonlinear/test_zero_one",
    "studies/test_article",
    "rig/test_chain",
    "rig/test_modes",
    "rig/test_plan",
    "signals",
    "sweeps/test_points",
    "sweeps/test_sweep_figures",
    "sweeps/test_sweep_jam",
    "sweeps/test_template",
    "sweeps/test_tolerance",
    "vocabulary",
    "nonlinear/test_response_classes",
)
"""Tests that run no kernel: they come first, while the kernels are compiled."""
LONG = ("web", "cli/test_sweep.py", "cli", "hostile", "laws")
"""Files that take long come next, so that workers end together."""
COMPILE = """
from gearplay.solver.compiling import prepare_all
try:
    prepare_all()
finally:
    open({ready!r}, "w").close()
"""

DIGEST = kernel_digest(TESTS.parent / "src" / "gearplay")[:16]
if "NUMBA_CACHE_DIR" not in os.environ:
    os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"gearplay-kernels-{DIGEST}")

NAME_OF_READY = "GEARPLAY_TESTS_KERNELS_READY"
"""Environment variable with the path of the file that marks the end of the compilation, a new path for each run."""


def pytest_configure(config: pytest.Config) -> None:
    """Start the compilation of the kernels, in parallel with the first tests, which run none."""
    several = bool(getattr(config.option, "numprocesses", None)) and not hasattr(config, "workerinput")
    if several and "NUMBA_DISABLE_JIT" not in os.environ:
        ready = Path(tempfile.mkdtemp(prefix="gearplay-tests-")) / "ready"
        os.environ[NAME_OF_READY] = str(ready)  # workers inherit it
        config.compiling = subprocess.Popen([sys.executable, "-c", COMPILE.format(ready=str(ready))])  # type: ignore[attr-defined]


def pytest_unconfigure(config: pytest.Config) -> None:
    """Stop the compiler where tests were interrupted, and remove its marker file."""
    if (compiling := getattr(config, "compiling", None)) is not None:
        compiling.terminate()
        compiling.wait()
        shutil.rmtree(Path(os.environ.pop(NAME_OF_READY)).parent, ignore_errors=True)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Select the tests of the depth; tests without kernels come first, long files next."""
    seen: dict[str, int] = {}
    kept, left = [], []
    for item in items:
        chosen = FULL or (
            item.get_closest_marker("deep") is None and (ALL or item.get_closest_marker("slow") is None)
        )
        if chosen and not FULL and item.get_closest_marker("many") is not None:
            name = item.nodeid.partition("[")[0]
            seen[name] = seen.get(name, -1) + 1
            chosen = seen[name] % SHARE == 0
        (kept if chosen else left).append(item)
    items[:] = sorted(kept, key=lambda item: _turn(item.path))
    if left:
        config.hook.pytest_deselected(items=left)


def _place(path: Path) -> str:
    return path.relative_to(TESTS).as_posix() if path.is_relative_to(TESTS) else ""


def _turn(path: Path) -> int:
    place = _place(path)
    if place.startswith(ALONE):
        return 0
    return next((at for at, name in enumerate(LONG, 1) if place.startswith(name)), len(LONG) + 1)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Wait for the kernels where several workers run, before any fixture of a test that runs some."""
    if "PYTEST_XDIST_WORKER" not in os.environ or "NUMBA_DISABLE_JIT" in os.environ:
        return
    place, end, ready = _place(item.path), time.monotonic() + 900.0, Path(os.environ[NAME_OF_READY])
    while not place.startswith(ALONE) and not ready.exists() and time.monotonic() < end:
        time.sleep(0.1)


@pytest.fixture
def measured(record_property: Callable[[str, object], None]) -> Callable[[str, float, str], None]:
    """Record what a test measured beside its limit; `make verification` turns the records into docs/verification.md."""

    def record(quantity: str, value: float, limit: str) -> None:
        record_property("measured", f"{quantity}|{value:.2g}|{limit}")

    return record


@pytest.fixture
def tried(record_property: Callable[[str, object], None]) -> Callable[[int], None]:
    """Record how many hostile inputs a test tried; `make torture` turns the records into docs/reliability.md."""
    return lambda count: record_property("tried", count)


@pytest.fixture(scope="session")
def watched() -> Iterator[list[str]]:
    """Look at every figure that is drawn, with `pictures.faults_of`, and keep what is wrong with any."""
    from gearplay.pictures import canvas

    found: list[str] = []
    draw = canvas.to_bytes

    def look(figure: Any, form: str) -> bytes:
        drawn = draw(figure, form)
        found.extend(faults_of(figure))
        return drawn

    canvas.to_bytes = look
    yield found
    canvas.to_bytes = draw


@pytest.fixture(scope="session")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Have commands that tests start look at their figures too; yield the folder where they say what is wrong with one."""
    folder = tmp_path_factory.mktemp("watched")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GEARPLAY_TESTS_WATCHED", str(folder))
        patch.setenv("PYTHONPATH", str(Path(__file__).parent / "watching"), prepend=os.pathsep)
        yield folder


@pytest.fixture(autouse=True)
def pictures_are_whole(watched: list[str], beside: Path) -> Iterator[None]:
    """Fail a test that draws a figure, itself or by a command, which `pictures.faults_of` finds at fault."""
    watched.clear()
    yield
    for each in sorted(beside.iterdir()):
        watched.append(each.read_text(encoding="utf-8"))
        each.unlink()
    assert not watched
