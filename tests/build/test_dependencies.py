"""Keys of machine code: an edit changes those of the kernels that it reaches, and no other."""

import json
import shutil
from pathlib import Path

import pytest

import gearplay
from gearplay.kernels.compiled import INTERPRETED
from programs import run_program

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
SOURCE = Path(gearplay.__file__).parent
KEYS = """
import json, sys
from gearplay.build.dependencies import key_of
from gearplay.build.objects import import_kernels
from gearplay.kernels.compiled_once import KERNELS
import_kernels()
json.dump({name.removeprefix("gearplay."): key_of(kernel) for name, kernel in KERNELS.items()}, sys.stdout)
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("keys") / "src" / "gearplay"
    shutil.copytree(SOURCE, place, ignore=shutil.ignore_patterns("__pycache__", "_library", "*.nc", "*.png"))
    return place


def keys_in(package: Path) -> dict[str, str]:
    done = run_program(KEYS, PYTHONPATH=str(package.parent), PYTHONDONTWRITEBYTECODE="1")
    found: dict[str, str] = json.loads(done.stdout)
    return found


def changed_by(package: Path, name: str, old: str, new: str, before: dict[str, str]) -> set[str]:
    """Return the kernels whose keys an edit changes."""
    file = package / name
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1
    file.write_text(text.replace(old, new), encoding="utf-8")
    try:
        after = keys_in(package)
    finally:
        file.write_text(text, encoding="utf-8")
    return {name for name in before if after[name] != before[name]}


@pytest.fixture(scope="module")
def before(copy: Path) -> dict[str, str]:
    return keys_in(copy)


def test_keys_are_the_same_in_every_process(copy: Path, before: dict[str, str]) -> None:
    assert len(set(before.values())) == len(before) > 100
    assert keys_in(copy) == before


def test_keys_ignore_words(copy: Path, before: dict[str, str]) -> None:
    law, words = "parts/sleeve/conformal.py", '    """Return the half contact angle theta0'
    assert changed_by(copy, law, words, '    """Half contact angle theta0', before) == set()


def test_keys_change_with_a_function_that_is_contained(copy: Path, before: dict[str, str]) -> None:
    """The involute's series is compiled into meshes, their callers and nothing of sleeves; it lies in a file of its own."""
    series = "return (even + odd * u) * u\n"
    found = changed_by(copy, "parts/mesh/involute.py", series, series.replace("* u\n", "* u * 2.0\n"), before)
    assert "parts.mesh.geometry.gaps_at" in found
    assert not {name for name in found if name.startswith(("parts.sleeve", "parts.coupling"))}


def test_keys_change_with_a_constant_of_another_file(copy: Path, before: dict[str, str]) -> None:
    found = changed_by(copy, "parts/sleeve/conformal.py", "leggauss(16)", "leggauss(17)", before)
    assert found
    assert not {name for name in found if name.startswith("parts.mesh")}


def test_keys_change_with_a_field_of_a_record(copy: Path, before: dict[str, str]) -> None:
    """Every kernel that takes the system."""
    old = '("drag", "f8"),  # N m s\n'
    found = changed_by(copy, "kernels/layout.py", old, f'("drag_0", "f8"),\n        {old}', before)
    assert "integrate.stepper.advance" in found
    assert len(found) > 100
