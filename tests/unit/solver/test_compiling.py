"""Kernels compiled ahead: what a case needs, shared among processes, said once, gone on with after a stop."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from gearplay.model.pack import pack
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
here = sum(bool(kernel.dispatcher.signatures) for kernel in KERNELS.values())
run = gp.simulate(case, duration=0.002, transient=0.0)
json.dump({"told": told, "here": here, "success": run.success}, sys.stdout)
"""


def names(*kinds: str, fixed: bool = False, derivative: bool = False) -> set[str]:
    wanted = compiling._wanted(frozenset(kinds), fixed=fixed, derivative=derivative)
    return {name.removeprefix("gearplay.kernels.") for name in wanted}


@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_a_case_wants_its_kinds_and_no_derivative() -> None:
    few, all_ = names("sleeve", "mesh"), names("sleeve", "mesh", "servo", "coupling")
    assert {"stepper.take_step", "elements.mesh.forces.stay_open"} <= few < all_
    assert {name.split(".")[1] for name in all_ - few} == {"servo", "coupling"}
    more = names("sleeve", "mesh", derivative=True)
    assert {"tangent.retrace", "elements.sleeve.linearise"} <= more - few
    plain = names("sleeve", "mesh", fixed=True) - few
    assert {name.split(".")[0] for name in plain} == {"fixed_steps"}
    assert "fixed_steps.take_fixed_step" in plain


@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_kinds_are_those_of_the_case() -> None:
    assert compiling._kinds(pack(gp.load_case("han2021"))) == {"sleeve", "mesh"}


def output_of(tmp_path: Path, *words: str) -> dict[str, Any]:
    done = run_program(PROGRAM, *words, NUMBA_CACHE_DIR=str(tmp_path))
    made: dict[str, Any] = json.loads(done.stdout)
    return made


@pytest.mark.deep
@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_work_that_was_stopped_goes_on(tmp_path: Path) -> None:
    """Stopped after 10 kernels; then the others only; then nothing is left, and nothing is said."""
    first = output_of(tmp_path, "10")
    wanted = len(names("sleeve", "mesh"))
    assert first["success"]
    assert first["told"][0] == [0, wanted]
    second = output_of(tmp_path)
    assert second["told"] == [] or second["told"][0][1] < wanted - 9
    assert second["told"] == [] or second["told"][-1][0] == second["told"][-1][1]
    third = output_of(tmp_path)
    assert third == {"told": [], "here": 0, "success": True}


@pytest.mark.deep
@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_two_processes_do_not_compile_the_same(tmp_path: Path) -> None:
    """Each tells the whole way, but one of them compiles nothing."""
    with ThreadPoolExecutor() as pool:
        both = list(pool.map(lambda _: output_of(tmp_path), range(2)))
    wanted = len(names("sleeve", "mesh"))
    assert sorted(min(made["here"], 1) for made in both) == [0, 1]
    for made in both:
        assert made["success"]
        assert made["told"][0][1] == made["told"][-1][0] == wanted
