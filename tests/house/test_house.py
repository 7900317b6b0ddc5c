"""What the house holds itself to: sizes, public names and what is said of them, what an import loads."""

import ast
import inspect
import json
import re
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


WALK = """
import json, sys, threading
import gearplay as gp
from gearplay.solver.compiling import prepare
plan = {"case": "han2021", "set": {"run.duration": 0.01, "run.transient": 0.0},
        "axes": [{"name": "gap", "path": "meshes.0.backlash", "values": ["50 um", "100 um"]}],
        "design": {"count": 2, "parameters": [{"name": "drag", "path": "rotors.ring.load.drag", "low": 1e-3, "high": 2e-3}]},
        "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}]}
BEARERS = {"SweepPlan", "Design", "Sweep", "Template", "Points", "Reducer"}
walk, reached = [], []
def watch(frame, event, argument):
    code = frame.f_code
    file = code.co_filename.partition("/gearplay/")[2]
    if event != "call" or reached or not file.startswith(("sweeps/", "solver/simulate")):
        return
    if code.co_name == "run_one":
        reached.append(True)
    given = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    held = {type(frame.f_locals[name]).__name__ for name in given if name != "self" and name in frame.f_locals}
    if held & BEARERS and (not walk or walk[-1] != file):
        walk.append(file)
prepare(gp.load_case("han2021"))
gp.sweep(dict(plan, set={"run.duration": 0.01, "run.transient": 0.0}), folder=sys.argv[1])
walk.clear(), reached.clear()
threading.setprofile(watch), sys.setprofile(watch)
gp.sweep(plan | {"title": "walked"}, folder=sys.argv[1] + "-2", threads=1)
sys.setprofile(None), threading.setprofile(None)
json.dump({"walk": walk, "reached": reached}, sys.stdout)
"""


def test_a_sweep_plan_passes_eight_files_and_returns_to_none(tmp_path: Path) -> None:
    """Followed as data: the files of the wing that are handed the plan, or what is made of it, up to the first simulation.

    Asking an object that was made of the plan is no hand-over; `plans.reading`, which makes the plan, comes before all.
    """
    program = tmp_path / "walk.py"
    program.write_text(WALK)
    words = [sys.executable, str(program), str(tmp_path / "folder")]
    found = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    walk = ["sweeps/plans/reading.py", *found["walk"]]
    assert found["reached"]
    assert len(walk) == len(set(walk)), f"comes back: {walk}"
    assert len(walk) <= 8, walk
    told = (SOURCE.parents[1] / "docs" / "architecture.md").read_text()
    assert all(file.removesuffix(".py").replace("/", ".") in told for file in walk), walk


def test_no_message_below_the_command_line_names_its_options() -> None:
    """Whoever calls from Python has arguments: `cli.advice` says them as options."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        if path.relative_to(SOURCE).parts[0] in ("cli", "web"):
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        words = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, _DOCUMENTED) and _docstring(node)
        }
        for node in ast.walk(tree):
            said = isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in words
            if said and re.search(r"(^|[\s(])--[a-z]", node.value):
                found.append(f"{path.relative_to(SOURCE)}:{node.lineno}: {node.value}")
    assert found == []


_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def _docstring(node: ast.AST) -> bool:
    first = next(iter(getattr(node, "body", [])), None)
    return isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
