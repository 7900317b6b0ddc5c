"""`run.max_wall_time` is the limit of a request, whatever the number of its runs, and results say what is complete.

The clock of the limit is replaced: it goes on by one second at each look.
"""

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.case import Case
from gearplay.nonlinear import motion as kinds
from gearplay.nonlinear.basins import LATE
from gearplay.nonlinear.bifurcation import OUT_OF_TIME
from gearplay.nonlinear.orbits.branches import OUT_OF_TIME as BRANCH_OUT_OF_TIME
from gearplay.solver import deadline
from gearplay.solver.deadline import Deadline, deadline_of, in_request, limited
from gearplay.solver.integration import Course, OutOfTimeError
from gearplay.solver.status import Status
from gearplay.vocabulary.exit_codes import PARTLY

ERROR = "meshes.0.transmission_error.0.amplitude"


@pytest.fixture
def courses(monkeypatch: pytest.MonkeyPatch) -> list[Course]:
    """Return the runs that are begun, under a clock that goes on at each look."""
    begun: list[Course] = []
    follow = Course.follow

    def noted(course: Course, *given: Any, **named: Any) -> Status:
        if course not in begun:
            begun.append(course)
        return follow(course, *given, **named)

    ticks = itertools.count()
    monkeypatch.setattr(deadline, "clock", lambda: float(next(ticks)))
    monkeypatch.setattr(Course, "follow", noted)
    return begun


def pair(limit: float, **numbers: Any) -> Case:
    given = {"force": 0.05} | numbers
    return gp.replace(gp.torsional_pair(0.7, **given), {"run.max_wall_time": limit})


def test_deadline__is_the_outer_request_s_on_every_thread(courses: list[Course]) -> None:
    assert Deadline(None).left() == math.inf
    with limited(3.0) as outer:
        assert in_request(lambda: deadline_of(100.0))() is outer
        assert [outer.is_over() for _ in range(5)] == [False, False, False, True, True]
    assert outer.has_stopped
    assert deadline_of(None) is not outer


def test_diagram__stops_at_the_limit_of_all_values(courses: list[Course]) -> None:
    values = np.linspace(1e-6, 9e-6, 60).tolist()
    settings = {"settle": 1, "keep": 1, "directions": ("up",)}
    found = gp.bifurcation(pair(60.0), ERROR, values, ["x"], **settings)
    complete = np.isfinite(found.values).all(axis=(2, 3))[0]
    reached = int(complete.sum())
    assert 5 < reached < 30
    assert complete[:reached].all()
    assert set(found.reasons[0][:reached]) == {""}
    assert set(found.reasons[0][reached:]) == {OUT_OF_TIME}
    assert len(courses) in (reached, reached + 1)
    free = gp.bifurcation(pair(1e6), ERROR, values, ["x"], **settings)
    assert np.array_equal(found.values[0, :reached], free.values[0, :reached])
    assert not any(free.reasons[0])


@pytest.mark.parametrize("threads", [1, 4])
def test_basins__mark_starts_that_were_not_reached(courses: list[Course], threads: int) -> None:
    grid = ("wheel.theta", -1e-4, 1e-4, 8), ("wheel.omega", -0.1, 0.1, 8)
    found = gp.basins(pair(300.0), *grid, settle=1, threads=threads)
    late = int(np.sum(found.labels == LATE))
    assert 10 < late < 60
    assert f"; {late} of 64 starts were not reached within run.max_wall_time" in found.message
    again = type(found).from_dataset(found.ds)
    assert np.array_equal(again.labels, found.labels)


def test_branch__ends_with_the_limit(courses: list[Course]) -> None:
    found = gp.branch(pair(200.0), ERROR, "1 um", "9 um", settle=20, orbits=50)
    assert found.ended == BRANCH_OUT_OF_TIME
    assert 1 <= len(found.orbits) < 10
    both = gp.branches(pair(200.0), ERROR, "1 um", "9 um", settle=20, orbits=50)
    assert BRANCH_OUT_OF_TIME in both[0].ended


def test_orbit__out_of_time_is_said_as_such(courses: list[Course]) -> None:
    with pytest.raises(
        gp.SimulationError, match=r"^run\.max_wall_time = 5 s: the limit on wall time was reached"
    ):
        gp.periodic_orbit(pair(5.0), settle=20)
    with pytest.raises(gp.SimulationError, match=r"^run\.max_wall_time = 5 s"):
        gp.branches(pair(5.0), ERROR, "1 um", "9 um")


def test_section__keeps_the_instants_that_were_reached(courses: list[Course]) -> None:
    found = gp.section(pair(30.0), ["x"], keep=100, settle=2)
    whole = gp.section(pair(1e6), ["x"], keep=100, settle=2)
    reached = len(found.times)
    assert 5 < reached < 40
    assert np.array_equal(found.values, whole.values[:reached])
    assert "the limit on wall time was reached" in found.message
    assert whole.ended == ""
    assert type(found).from_dataset(found.ds).ended == found.ended


def test_impacts__keep_the_onsets_that_were_reached(courses: list[Course]) -> None:
    case = gp.replace(gp.load_case("han2021"), {"run.max_wall_time": 30.0})
    found = gp.impacts(case, ["ring.x"], "pinion-ring:drive", duration=1.0, transient=0.0)
    assert "the limit on wall time was reached" in found.ended


def test_portrait__names_its_incomplete_parts(courses: list[Course]) -> None:
    case = pair(700.0)
    found = gp.portrait(case, settle=1, keep=600, show=1)
    assert found.ds.sizes["path_time"] == 201
    assert 0 < found.ds.sizes["section_time"] < 600
    assert "Not complete within run.max_wall_time: sections, onsets of pinion-wheel:drive" in found.message


def test_motion__is_no_artefact_where_the_comparison_was_cut_short(
    courses: list[Course], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    monkeypatch.setattr(deadline, "clock", lambda: now[0])
    compare: Callable[..., Any] = kinds.compare_methods

    def late(*given: Any) -> Any:
        now[0] = 1e6
        return compare(*given)

    monkeypatch.setattr(kinds, "compare_methods", late)
    found = gp.motion(gp.replace(pair(10.0), {"run.duration": 0.01}), periods=200, ensemble=4)
    assert (found.kind, found.order, found.comparisons) == ("periodic", 1, ())
    assert "Within run.max_wall_time it was not compared with other numbers of the method" in found.reason


def test_ensemble__has_one_limit(courses: list[Course]) -> None:
    case = gp.replace(
        gp.load_case("han2021"), {"run.max_wall_time": 3.0, "run.ensemble": 20, "run.transient": 0.0}
    )
    statuses = gp.simulate(case).statuses
    assert set(statuses) <= {Status.DONE, Status.OUT_OF_TIME}
    assert set(statuses[-10:]) == {Status.OUT_OF_TIME}


def test_command__has_one_limit_for_diagram_and_branches(
    courses: list[Course], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        "bifurcation",
        "kahraman-singh-1990",
        "torsional_pair.frequency",
        "--low",
        "0.9",
        "--high",
        "1.2",
    ]
    words += ["--count", "20", "--settle", "1", "--keep", "1", "--signal", "x", "--branches"]
    words += ["--set", "run.max_wall_time=50s", "--out", str(tmp_path / "out")]
    assert run(words) == PARTLY
    said = capsys.readouterr().out
    assert OUT_OF_TIME in said
    assert "run.max_wall_time = 50 s: the limit on wall time was reached" in said


def test_out_of_time__is_a_simulation_error() -> None:
    assert issubclass(OutOfTimeError, gp.SimulationError)
