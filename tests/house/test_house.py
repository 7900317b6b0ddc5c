"""Public names and their documentation, what an import loads, messages without options of the command line."""

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
NAMES = [(gp, name) for name in dir(gp) if not name.startswith("_")]
SIGNALS = [(gp.signals, name) for name in dir(gp.signals)]
PUBLIC = [(room, name) for room, name in NAMES + SIGNALS if not inspect.ismodule(getattr(room, name))]


@pytest.mark.parametrize(("room", "name"), PUBLIC, ids=[f"{room.__name__}.{name}" for room, name in PUBLIC])
def test_public_names__have_parameters_and_a_representation(room: Any, name: str) -> None:
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


@pytest.mark.slow
def test_messages__name_no_command_line_options_outside_cli() -> None:
    """Whoever calls from Python has arguments: `cli.options` says them as options."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        if path.relative_to(SOURCE).parts[0] in ("build", "cli", "web"):
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
