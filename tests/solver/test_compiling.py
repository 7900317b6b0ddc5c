"""Kernels compiled ahead: what a case needs, shared among processes, said once, gone on with after a stop."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from gearplay.solver import compiling
from programs import run_program

PROGRAM = """
import json, sys
import gearplay as gp
from gearplay.kernels.compiled_once import KERNELS
from gearplay.solver.compiling import prepare

told = []

def tell(label, done, total):
    told.append((done, total))
    if len(sys.argv) > 1 and done >= int(sys.argv[1]):
        raise KeyboardInterrupt

case = gp.load_case("han2021")
try:
    prepare(case, progress=tell)
except KeyboardInterrupt:
    pass
here = sum(kernel.found for kernel in KERNELS.values())
run = gp.simulate(case, duration=0.002, transient=0.0)
json.dump({"told": told, "here": here, "success": run.success}, sys.stdout)
"""


def length(*kinds: str) -> int:
    return compiling._length(compiling._wanted(frozenset(kinds), fixed=False, derivative=False))


def output_of(tmp_path: Path, *words: str) -> dict[str, Any]:
    done = run_program(PROGRAM, *words, NUMBA_CACHE_DIR=str(tmp_path))
    made: dict[str, Any] = json.loads(done.stdout)
    return made


@pytest.mark.deep
@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_work_that_was_stopped_goes_on(tmp_path: Path) -> None:
    """Stopped after a quarter; then the others only; then nothing is left, and nothing is said."""
    wanted = length("sleeve", "mesh")
    first = output_of(tmp_path, str(wanted // 4))
    assert first["success"]
    assert first["told"][0] == [0, wanted]
    second = output_of(tmp_path)
    assert second["told"] == [] or second["told"][0][1] <= wanted - wanted // 4
    assert second["told"] == [] or second["told"][-1][0] == second["told"][-1][1]
    third = output_of(tmp_path)
    assert third == {"told": [], "here": 0, "success": True}


@pytest.mark.deep
@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_two_processes_do_not_compile_the_same(tmp_path: Path) -> None:
    """Each tells the whole way, but one of them compiles nothing."""
    with ThreadPoolExecutor() as pool:
        both = list(pool.map(lambda _: output_of(tmp_path), range(2)))
    wanted = length("sleeve", "mesh")
    assert sorted(min(made["here"], 1) for made in both) == [0, 1]
    for made in both:
        assert made["success"]
        assert made["told"][0][1] == made["told"][-1][0] == wanted
