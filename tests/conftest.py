"""Test-wide settings: depths, the order of files, checks of every figure that is drawn."""

import gc
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

# Workers share the cores: more threads of linear algebra, in them and in the commands that they start, wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from depth import ALL, FULL, SHARE
from pictures import looked_at

TESTS = Path(__file__).resolve().parent
LONG = ("web", "cli/test_sweep.py", "cli", "hostile", "laws")
"""Files that take long come first, so that workers end together."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Select the tests of the depth; long files come first."""
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


def pytest_collection_finish() -> None:
    """Leave the tests and modules that are there out of all further garbage collections."""
    gc.freeze()


def _place(path: Path) -> str:
    return path.relative_to(TESTS).as_posix() if path.is_relative_to(TESTS) else ""


def _turn(path: Path) -> int:
    place = _place(path)
    return next((at for at, name in enumerate(LONG) if place.startswith(name)), len(LONG))


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
    """Look at every figure that is drawn, with `pictures.looked_at`, and keep what is wrong with any."""
    from gearplay.pictures import canvas

    found: list[str] = []
    draw = canvas.to_bytes

    def look(figure: Any, form: str) -> bytes:
        drawn, faults = looked_at(draw, figure, form)
        found.extend(faults)
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


@pytest.fixture
def undrawn(watched: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the drawing of figures, which other tests look at."""
    monkeypatch.setattr("gearplay.pictures.canvas.to_bytes", lambda figure, form: b"\x89PNG\r\n\x1a\n")


@pytest.fixture(autouse=True)
def pictures_are_whole(watched: list[str], beside: Path) -> Iterator[None]:
    """Fail a test that draws a figure, itself or by a command, which `pictures.looked_at` finds at fault."""
    watched.clear()
    yield
    for each in sorted(beside.iterdir()):
        watched.append(each.read_text(encoding="utf-8"))
        each.unlink()
    assert not watched
