"""Kernels compiled ahead: what a case needs, shared among processes, said once, gone on with after a stop."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.solver import compiling, pace
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


def names(*kinds: str, fixed: bool = False, derivative: bool = False) -> set[str]:
    wanted = compiling._wanted(frozenset(kinds), fixed=fixed, derivative=derivative)
    return {name.removeprefix("gearplay.kernels.") for name in wanted}


def length(*kinds: str) -> int:
    return compiling._length(compiling._wanted(frozenset(kinds), fixed=False, derivative=False))


def test_what_is_compiled_and_how_long_it_takes_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pace.os, "getloadavg", lambda: (0.0, 0.0, 0.0))
    assert pace.seconds_for(10_000, 2, 2, tmp_path) == pytest.approx(10_000 * pace.USUAL / 2)
    pace.note_pace(tmp_path, 10_000, 30.0, 2.0)  # this machine is slower
    assert pace.seconds_for(10_000, 2, 2, tmp_path) == pytest.approx(30.0)
    monkeypatch.setattr(pace.os, "getloadavg", lambda: (2.0, 2.0, 2.0))  # and others are busy on it
    assert pace.seconds_for(10_000, 2, 2, tmp_path) == pytest.approx(60.0)
    wanted = compiling._wanted(frozenset({"sleeve", "mesh"}), fixed=False, derivative=True)
    plain = compiling._wanted(frozenset({"sleeve", "mesh"}), fixed=False, derivative=False)
    count = len(wanted) - len(plain)
    assert compiling._words_for(plain) == f"{len(plain)} kernels of the motion"
    assert (
        compiling._words_for(wanted)
        == f"{len(wanted)} kernels of the motion, {count} of them of its derivative"
    )
    more = [name for name in wanted if name not in plain]
    assert compiling._words_for(more) == f"{count} kernels of the motion's derivative"
    now = iter([100.0, 100.1, 110.0, 125.0, 126.0])
    monkeypatch.setattr(compiling.time, "monotonic", lambda: next(now))
    tell = compiling._said()
    for done in (0, 20, 50, 60):
        tell("Compiling", done, 100)
    assert capsys.readouterr().err.splitlines() == ["Compiling.", "50 % compiled, about 30 s left."]


@pytest.mark.skipif(compiling.INTERPRETED, reason="nothing is compiled here")
def test_a_case_wants_its_kinds_and_no_derivative() -> None:
    few, all_ = names("sleeve", "mesh"), names("sleeve", "mesh", "servo", "coupling")
    assert not any(name.startswith("joined.") or "joined" in name for name in few)
    assert {"joined.propagate_joined", "joined.find_rates", "active_set.integrate_joined"} <= names(
        "sleeve", "mesh", "coupling"
    )
    assert "joined.move_change" in names("mesh", "support", derivative=True) - names("mesh", "support")
    assert {"stepper.take_step", "elements.mesh.forces.stay_open"} <= few < all_
    joined = {name for name in all_ if "joined" in name or name.endswith("integrate_joined")}
    assert {name.split(".")[1] for name in all_ - few - joined} == {"servo", "coupling"}
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
