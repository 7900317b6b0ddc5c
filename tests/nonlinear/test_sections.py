"""Sections against the sampled run and the log of contacts; diagrams against orbits and their jumps."""

import math
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.cross.random_systems import random_case

import gearplay as gp
from gearplay.nonlinear.bifurcation import _carried, _Last
from gearplay.nonlinear.orbits.period_map import StrobeMap, common_period, section_period
from gearplay.nonlinear.orbits.shooting import find_orbit
from gearplay.nonlinear.torsional import torsional_pair
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_one
from gearplay.vocabulary.errors import Fault, InputError, SimulationError

SPEED = "rotors.pinion.drive.speed"


def case_of(**changes: Any) -> gp.Case:
    return gp.replace(
        gp.load_case("han2021"), {"rotors.ring.initial.vx": 0.05, "run.transient": 0.0, **changes}
    )


def pair(frequency: float) -> gp.Case:
    return torsional_pair(frequency, mean_force=0.1, force=0.05)


def test_a_section_is_the_run_sampled_once_per_period() -> None:
    case = case_of(**{"run.duration": 0.1, "run.sampling": 40.0, "run.tolerance": 1e-12})
    names = [
        "ring.x",
        "ring.vy",
        "pinion-ring.backlash",
        "pinion-ring.center_distance",
        "ring.sleeve_penetration",
    ]
    found = gp.section(case, names, keep=2, period=0.025)
    assert found.names == tuple(names)
    run = run_one(case)
    for at, name in enumerate(names):
        label, signal = name.split(".")
        assert found.values[:, at] == pytest.approx(run.signal(signal, label)[:2], rel=1e-6, abs=1e-12)
    assert found.times == pytest.approx([0.0, 0.025])


def test_a_contact_section_stops_at_the_located_events() -> None:
    case = case_of(**{"run.duration": 0.4})
    run = run_one(case, signals=["x"])
    onsets = run.log[(run.log[:, 1] == 0.0) & (run.log[:, 2] == 1.0)]
    assert len(onsets) > 3
    found = gp.impacts(case, ["ring.sleeve_penetration", "ring.vx"], "ring", member=0)
    assert np.array_equal(found.times, onsets[:, 0])
    assert np.array_equal(found.values[:, -1], onsets[:, 3])
    assert np.max(np.abs(found.values[:, 0])) < 1e-12
    assert found.names == ("ring.sleeve_penetration", "ring.vx", "ring.rate")
    releases = gp.impacts(case, ["ring.sleeve_penetration"], "ring", change="release", member=0)
    assert np.all(releases.values[:, -1] < 0.0)


@pytest.mark.parametrize(("seed", "contact"), [(2, "pinion"), (4, "ring"), (5, "ring"), (19, "pinion")])
def test_all_rotors_are_seen_at_the_instant_of_an_event(seed: int, contact: str) -> None:
    """Also those that nothing touches: against the flow up to that instant."""
    document = {
        **random_case(seed),
        "run": {"duration": 0.006, "transient": 0.0, "sampling": 1e4, "tolerance": 1e-12},
    }
    flow = Flow(gp.load_case(document))
    found = gp.impacts(gp.load_case(document), ["x", "vy", "theta"], contact, member=0)
    assert len(found.times) >= 1
    for t, values in zip(found.times, found.values, strict=True):
        state = flow.go(flow.start(), float(t)).state
        n = len(document["rotors"])
        expected = [state[3 * i + c] for c in (0, 3 * n + 1, 2) for i in range(n)]
        assert values[:-1] == pytest.approx(expected, rel=1e-6, abs=1e-10)


def test_continued_motion__resumes_at_the_phase_of_the_excitation() -> None:
    """Runout of the pinion: 20 mesh periods. After 3 of them the run goes on to the 20th, then the next value begins."""
    fast = case_of(
        **{
            SPEED: 100.0 * math.pi,
            "rotors.pinion.runout.amplitude": 5e-6,
            "rotors.ring.runout.amplitude": 0.0,
        }
    )
    fast = gp.replace(fast, {"run.tolerance": 1e-12})
    backlash = fast.meshes[0].backlash
    found = gp.bifurcation(
        fast,
        "meshes.0.backlash",
        [backlash, backlash * (1.0 + 1e-12)],
        ["ring.x"],
        settle=0,
        keep=3,
        period="mesh",
        directions=["up"],
    )
    whole = gp.section(fast, ["ring.x"], keep=24, period="mesh")
    assert found.values[0, 0, :, 0] == pytest.approx(whole.values[1:4, 0], rel=1e-6)
    assert found.values[0, 1, :, 0] == pytest.approx(whole.values[21:24, 0], rel=1e-3)


def test_periods_of_the_excitation() -> None:
    packed = Flow(case_of()).packed
    mesh = 2.0 * math.pi / (20 * 4.0 * math.pi)
    assert section_period(packed, "mesh") == pytest.approx(mesh)
    assert section_period(packed, "shaft") == pytest.approx(20.0 * mesh)
    assert section_period(packed, 0.3) == 0.3
    assert common_period(packed) == pytest.approx(
        60.0 * mesh
    )  # the ring's runout turns once in 60 mesh periods
    still = Flow(
        case_of(**{"rotors.ring.runout.amplitude": 0.0, "rotors.pinion.runout.amplitude": 0.0})
    ).packed
    assert common_period(still) == pytest.approx(mesh)


@pytest.mark.slow
def test_a_diagram_carried_up_and_down_shows_the_jumps_of_the_resonance() -> None:
    values = np.linspace(0.42, 0.8, 20)
    found = gp.bifurcation(pair, "frequency", values, ["wheel.theta"], settle=200, keep=3)
    assert found.values.shape == (2, 20, 3, 1)
    assert np.ptp(found.values, axis=2).max() < 1e-6  # period 1 everywhere
    up, down = found.values[:, :, -1, 0]
    apart = np.abs(up - down) > 1e-5
    assert apart.any()
    assert not apart[0]
    assert not apart[-1]
    family = StrobeMap(pair, float(values[-1]))
    orbit = find_orbit(family, family.settle(family.start(0.8), 0.8, 200), 0.8)
    assert up[-1] == pytest.approx(orbit.states[0][0], abs=1e-9)


def test_without_carrying_the_way_does_not_matter() -> None:
    values = np.linspace(0.42, 0.8, 6)
    found = gp.bifurcation(pair, "frequency", values, ["wheel.theta"], settle=50, keep=2, carry=False)
    assert np.array_equal(found.values[0], found.values[1])


def test_a_value_that_fails_leaves_the_others() -> None:
    def family(backlash: float) -> gp.Case:
        return case_of(**{"meshes.0.backlash": backlash})

    found = gp.bifurcation(
        family,
        "backlash",
        [5e-5, 1e-4, 0.05],
        ["ring.x"],
        settle=1,
        keep=2,
        period="mesh",
        directions=["up"],
    )
    assert np.isfinite(found.values[0, :2]).all()
    assert np.isnan(found.values[0, 2]).all()
    assert found.reasons[0][2].startswith("meshes.0.backlash = 0.05")


def test_a_wish_to_stop_is_heard() -> None:
    stop = threading.Event()
    found = gp.bifurcation(
        pair,
        "frequency",
        np.linspace(0.5, 0.9, 50),
        ["wheel.theta"],
        settle=20,
        keep=1,
        stop=stop,
        progress=lambda *_: stop.set(),
    )
    assert np.isnan(found.values).mean() > 0.5


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: gp.section(case_of(), ["ring.ax"], keep=1),
            'signals = "ax": must follow from the state alone',
        ),
        (lambda: gp.section(case_of(), ["ring.x"], keep=1, period="tooth"), 'period = "tooth"'),
        (lambda: gp.section(case_of(), ["ring.x"], keep=1, period=-1.0), "period = -1"),
        (lambda: gp.impacts(case_of(), ["ring.x"], "rng", duration=1.0), 'contact = "rng"'),
        (
            lambda: gp.impacts(case_of(), ["ring.x"], "ring", change="hit", duration=1.0),
            'change = "hit"',
        ),
        (lambda: gp.impacts(case_of(), ["ring.x"], "ring", duration=0.0), "duration = 0"),
        (
            lambda: gp.bifurcation(pair, "frequency", [0.5, 0.4], ["wheel.theta"]),
            "must have values that rise",
        ),
        (
            lambda: gp.bifurcation(pair, "frequency", [0.5], ["wheel.theta"], directions=["left"]),
            "must be up, down or both",
        ),
        (
            lambda: gp.bifurcation(pair, "frequency", [0.5], ["wheel.theta"], keep=0),
            "keep = 0: must be a whole number, 1 or more",
        ),
        (
            lambda: gp.section(gp.load_case("external-pair"), ["output.x"], keep=1),
            "must be a prescribed speed without a ramp",
        ),
        (lambda: common_period(Flow(case_of(**{SPEED: 0.0})).packed), "must not be 0 for a periodic motion"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told(call: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()


def test_continuation__a_state_that_cannot_be_simulated_is_not_used() -> None:
    """From 2.9 mm of clearance down to 10 um: the ring is shot out of its sleeve; it starts as its case says, and says so."""
    case, path = case_of(), "sleeves.ring.radial_clearance"
    found = gp.bifurcation(
        case, path, [1e-5, 2.9e-3], ["ring.x"], settle=1, keep=2, period="mesh", directions=["down"]
    )
    alone = gp.bifurcation(
        case, path, [1e-5], ["ring.x"], settle=1, keep=2, period="mesh", directions=["down"]
    )
    assert np.array_equal(found.values[0, 0], alone.values[0, 0])
    assert found.starts[0][1] == ""
    assert found.starts[0][0].startswith("began anew, from the state of the value before:")


def test_a_step_that_presses_a_contact_is_reported() -> None:
    """From 200 um of clearance to 100 um the state is carried; the ring then begins up to 100 um within its sleeve."""
    case = case_of(**{"gravity.1": -9.81})
    found = gp.bifurcation(
        case,
        "sleeves.ring.radial_clearance",
        [1e-4, 2e-4],
        ["ring.y"],
        settle=200,
        keep=1,
        period="mesh",
        directions=["down"],
    )
    assert "the step itself raised ring.sleeve_penetration from" in found.starts[0][0]
    assert found.starts[0][1] == ""


def test_another_mechanism_and_gears_that_cannot_mesh_begin_anew() -> None:
    """Each says so, in the dataset too; what follows a value that failed as well."""
    base = case_of()
    more = base.resolved()
    more["rotors"]["disc"] = {"mass": 1.0, "inertia": 1e-3}
    other = gp.load_case(more)

    def family(value: float) -> Any:
        if value == 3.0:
            raise InputError(Fault("value", value, "must not be 3", "Take another"))
        return base if value in (0.0, 1.0) else other

    found = gp.bifurcation(
        family,
        "value",
        [0.0, 1.0, 2.0, 3.0, 4.0],
        ["ring.x"],
        settle=1,
        keep=1,
        period="mesh",
        directions=["up"],
    )
    assert found.starts[0][:2] == ("", "")
    assert "as it is another mechanism" in found.starts[0][2]
    assert found.reasons[0][3] != ""
    assert "as the value before failed" in found.starts[0][4]
    flow = Flow(base)
    state = flow.start()
    state[3] = 0.05  # m, of the ring along the line of centres
    start, words = _carried(_Last(flow, state, np.zeros(flow.impact_count)), flow)
    assert start is None
    assert "the gears of pinion-ring could not mesh" in words


def test_read_diagram__has_the_places_of_restarts(tmp_path: Path) -> None:
    """`start` of the dataset, the message and the file."""
    found = gp.bifurcation(
        case_of(),
        "sleeves.ring.radial_clearance",
        ["10 um", "2.9 mm"],
        ["ring.x"],
        settle=1,
        keep=1,
        period="mesh",
    )
    assert found.ds["start"].dims == ("direction", "radial_clearance")
    assert "Down at 1e-05 m: began anew" in found.message
    found.save(tmp_path / "diagram.nc")
    read = gp.read_result(tmp_path / "diagram.nc")
    assert (read.starts, read.message, read.names) == (found.starts, found.message, found.names)


def test_a_course_that_runs_away_ends() -> None:
    flow = Flow(case_of(**{"run.max_steps": 50}))
    with pytest.raises(SimulationError, match="limit on steps"):
        flow.go(flow.start(), 1e3)
    stop = threading.Event()
    stop.set()
    with pytest.raises(SimulationError, match="flow: "):
        flow.begin(flow.start(), stop=stop).advance(1e6)


def test_sections__start_from_a_drawn_state_by_default() -> None:
    case = gp.load_case("han2021")
    by_default, drawn, exact = (
        gp.section(case, ["ring.x"], keep=2, period="mesh", **more).values
        for more in ({}, {"member": 1}, {"member": 0})
    )
    np.testing.assert_array_equal(by_default, drawn)
    assert abs(exact[0, 0]) < 1e-12 < abs(drawn[0, 0])
    given = gp.load_case({**case.resolved(), "title": "moved"}, ["rotors.ring.initial.x=10um"])
    assert gp.section(given, ["ring.x"], keep=1, period="mesh").values[0, 0] == pytest.approx(1e-5)
