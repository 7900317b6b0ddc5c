"""What the house holds itself to: sizes, public names and what is said of them, what an import loads."""

import inspect
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp

SOURCE = Path(gp.__file__).parent
LONGEST = 350
NAMES = [(gp, name) for name in dir(gp) if not name.startswith("_")]
SIGNALS = [(gp.signals, name) for name in dir(gp.signals)]
PUBLIC = [(room, name) for room, name in NAMES + SIGNALS if not inspect.ismodule(getattr(room, name))]


def test_no_module_is_longer_than_one_can_read() -> None:
    long = {str(p.relative_to(SOURCE)): len(p.read_text().splitlines()) for p in SOURCE.rglob("*.py")}
    assert {name: lines for name, lines in long.items() if lines > LONGEST} == {}


def test_the_door_is_small() -> None:
    assert len(dir(gp)) <= 45
    assert len(PUBLIC) > 50, "the names are found"


@pytest.mark.parametrize(("room", "name"), PUBLIC, ids=[f"{room.__name__}.{name}" for room, name in PUBLIC])
def test_every_public_name_says_what_it_takes_and_shows_itself(room: Any, name: str) -> None:
    """Doctests run, so that an example that is there is an example that works."""
    it = getattr(room, name)
    words = inspect.getdoc(it) or ""
    assert ">>> " in words, "has no example"
    assert "Examples\n--------" in words
    if isinstance(it, type) and issubclass(it, Exception):
        return
    assert "Parameters\n----------" in words
    for parameter in inspect.signature(it).parameters.values():
        if parameter.name == "self" or parameter.kind == parameter.VAR_POSITIONAL:
            continue
        listed = [
            part.strip()
            for line in words.splitlines()
            if not line.startswith(" ")
            for part in line.split(",")
        ]
        assert parameter.name in listed, f"{parameter.name} is not described"
    if inspect.isfunction(it) and name not in ("write_record",):
        assert "Returns\n-------" in words
    if inspect.isfunction(it) and name not in ("band_level", "mean_square"):
        assert "Raises\n------" in words


def test_importing_the_package_loads_nothing_heavy() -> None:
    program = "import gearplay, json, sys; json.dump(sorted(sys.modules), sys.stdout)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in json.loads(done.stdout)}
    assert not loaded & {"numpy", "scipy", "numba", "xarray", "pydantic", "pint", "matplotlib"}
