"""Break the physics on purpose and see whether a test notices: ``make mutation``; writes docs/mutation.md.

Each mutant, one change of one place, is made in a copy of the tree. Tests are asked in three stages, the fast
ones first, until one fails. A test that hangs has noticed too. What no test notices is judged by hand, in judged.toml.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mutants import Mutant, draw
from page import write_page

ROOT = Path(__file__).resolve().parents[2]
SHORT = ("tests/laws/test_answers.py", "tests/elements")
FAST = {
    "kernels": ("src/gearplay/kernels", *SHORT),
    "integrate": ("src/gearplay/integrate", *SHORT),
    "parts": ("src/gearplay/parts", "tests/model", *SHORT),
    "model": ("src/gearplay/model", "tests/model", *SHORT),
}
"""Examples, unit tests, laws of elements, short motions of every bundled case."""
LAWS = ("laws", "cross", "literature", "linear", "nonlinear", "rig", "planets", "solver")
"""Laws of whole mechanisms, and foreign solvers."""


def laws(module: str) -> tuple[list[str], list[str]]:
    """Return the files of laws that speak of a module, at least those of energy and momentum, and all others."""
    stem = Path(module).stem
    spoken = re.compile(rf"\b{stem}\b|\b{stem.replace('_', '[ -]')}\b|_{stem}_")
    files = [file for folder in LAWS for file in sorted((ROOT / "tests" / folder).glob("test_*.py"))]
    near: list[str] = []
    far: list[str] = []
    for file in files:
        speaks = spoken.search(file.read_text(encoding="utf-8")) or file.stem == "test_energy_momentum"
        (near if speaks else far).append(file.relative_to(ROOT).as_posix())
    return near, far


def tests_of(module: str, stage: int) -> Sequence[str]:
    """Return what is asked about a module: the fast tests, the laws that speak of it, all others."""
    return (FAST[module.split("/")[0]], *laws(module))[stage]


def copied(where: Path) -> Path:
    """Copy what tests need of the tree."""
    shutil.rmtree(where, ignore_errors=True)
    for name in ("src", "tests", "docs"):
        shutil.copytree(ROOT / name, where / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "constraints.txt", "Makefile"):
        shutil.copy(ROOT / name, where)
    return where


def ask(tree: Path, tests: Sequence[str], cache: Path, limit: float) -> str:
    """Run tests of a tree until one fails; return its name, or an empty text where all pass."""
    options = (
        "-n0",
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "-m",
        "not hostile and not study",
    )
    surroundings = os.environ | {
        "PYTHONPATH": str(tree / "src"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "GEARPLAY_LIBRARY": str(cache),
    }
    command = [sys.executable, "-m", "pytest", *options, *tests]
    try:
        done = subprocess.run(
            command, cwd=tree, env=surroundings, timeout=limit, capture_output=True, text=True
        )
    except subprocess.TimeoutExpired:
        return "hangs"
    if done.returncode == 0:
        return ""
    named = [line for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return named[-1].split(" - ")[0].split(" ", 1)[1] if named else "crashes"


def prepare(tree: Path, tests: Sequence[str], cache: Path) -> float:
    """Ask the sound tree twice, the first time to compile; return how many seconds a mutant may take."""
    for _ in range(2):
        begun = time.monotonic()
        if failed := ask(tree, tests, cache, 3600.0):
            sys.exit(f"{failed} fails before anything is broken.")
    return 90.0 + 3.0 * (time.monotonic() - begun)


def judge(mutant: Mutant, tree: Path, tests: Sequence[str], cache: Path, limit: float) -> dict[str, Any]:
    """Return what notices a mutant."""
    file, begun = tree / "src" / "gearplay" / mutant.module, time.monotonic()
    original, own = file.read_text(encoding="utf-8"), cache.with_name("own")
    file.write_text(mutant.text(), encoding="utf-8")
    shutil.rmtree(own, ignore_errors=True)
    shutil.copytree(cache, own, copy_function=os.link)  # the build replaces files and never writes into one
    try:
        by = ask(tree, tests, own, limit)
    finally:
        file.write_text(original, encoding="utf-8")
        shutil.rmtree(own)
    return vars(mutant) | {"by": by, "seconds": round(time.monotonic() - begun, 1)}


def main() -> None:
    """Draw, break, ask; write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=150, help="mutants to draw")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "mutation", help="where a run goes on")
    parser.add_argument(
        "--stages", type=int, default=3, help="1: the fast tests only; 2: the nearest laws too"
    )
    parser.add_argument("--again", action="store_true", help="ask again about those that no test noticed")
    parser.add_argument(
        "--page", action="store_true", help="write the page from what was found, and ask nothing"
    )
    options = parser.parse_args()
    kept, tree, cache = (options.folder / name for name in ("mutants.json", "tree", "library"))
    rows: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    drawn, counts = draw(options.count, options.seed)
    if options.again:
        rows = {name: row for name, row in rows.items() if row["by"]}
    for stage in range(0 if options.page else options.stages):
        todo = [
            each for each in drawn
            if each.name not in rows or not (rows[each.name]["by"] or rows[each.name]["stage"] >= stage)
        ]  # fmt: skip
        if todo:
            copied(tree)
        if todo and stage == 0:
            limits = [prepare(tree, asked, cache) for asked in FAST.values()]
        for each in todo:
            limit = max(limits) if stage == 0 else 1800.0
            row = judge(each, tree, tests_of(each.module, stage), cache, limit) | {"stage": stage}
            row["seconds"] += rows[each.name]["seconds"] if each.name in rows else 0.0
            rows[each.name] = row
            kept.write_text(json.dumps(rows, indent=1), encoding="utf-8")
            print(f"{row['seconds']:6.1f} s  {row['by'] or 'SURVIVES'}  {each.name}", flush=True)
    write_page([rows[each.name] for each in drawn if each.name in rows], counts, options.seed)


if __name__ == "__main__":
    main()
