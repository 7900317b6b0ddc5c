"""Programs in a Python of their own; scripts of the repository and commands in this one."""

import contextlib
import importlib.util
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any


def load_script(file: Path) -> Any:
    """Return a script that belongs to no package, as a module."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_program(
    program: str, *words: str, file: Path | None = None, check: bool = True, **environment: str
) -> "subprocess.CompletedProcess[str]":
    """Run a program's text; from a ``file``, where it has kernels of its own: numba keeps only what has one."""
    if file is not None:
        file.write_text(program, encoding="utf-8")
    return subprocess.run(
        [sys.executable, *(["-c", program] if file is None else [str(file)]), *words],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=check,
        timeout=1200,
    )


def run_command(*words: object) -> "subprocess.CompletedProcess[str]":
    """Run a command of gearplay in this process, which spares the start of Python; return its exit code and what it said."""
    from gearplay.cli.main import run

    given, out, err = [str(word) for word in words], io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run(given)
    return subprocess.CompletedProcess(given, code, out.getvalue(), err.getvalue())
