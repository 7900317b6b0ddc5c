"""Dents of rolling bearings: static displacement, trajectory, lines, energy, refusals."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, Measured, case_of, merged, simulate_one
from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.slopes import make_slopes
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import LOADED, OPEN, PENETRATION
from gearplay.model.pack import pack
from gearplay.vocabulary.errors import InputError
from parts.bearing.shafts import BALLS, Law, shaft, under

DENT: Document = {"kind": "outer", "at": "shaft", "depth": "3 um", "arc": "6 deg", "angle": "-90 deg"}


def dented(bearing: Document, *faults: Document, **rest: Any) -> Document:
    """Return a shaft in a bearing with dents; one is `DENT` but for what is given."""
    return shaft(BALLS | bearing, **rest) | {"faults": [DENT | fault for fault in faults]}


@pytest.mark.parametrize(
    ("angle", "sound", "damaged"),
    [(0.0, 8.385455, 10.104639), (1.5, 8.384319, 9.646552), (3.0, 8.380904, 8.380904)],
)
@pytest.mark.parametrize("ring", ["inner", "outer"])
def test_displacement_of_an_element_in_a_dent(
    angle: float, sound: float, damaged: float, ring: str, measured: Measured
) -> None:
    """100 N, play 5 um, a dent of 3 um over 6 deg at the load line: um. At rotation 0 it does not matter of which ring."""
    bearing = under(BALLS, math.radians(angle)) | {"internal_clearance": 1e-5}
    for faults, expected in (((), sound), (({"kind": ring},), damaged)):
        law = Law(bearing, [DENT | each for each in faults])
        _, y = law.displacement(100.0, 1e-6 * expected)
        measured("bearing with a dent: displacement [um]", abs(-1e6 * y - expected), "1.1e-6")
        assert -1e6 * y == pytest.approx(expected, abs=1.1e-6)


def test_trajectory_over_a_dent(measured: Measured) -> None:
    """State x, y [m] at 6 ms of an independent integration (agreement of its own 2e-13 m)."""
    document = dented(
        {"internal_clearance": 4e-6, "damping": {"value": 0.5}},
        {},
        weight=200.0,
        drive={"kind": "speed", "speed": "3000 rpm"},
        initial={"y": -6e-6},
    )
    run = simulate_one(merged(document, {"run": {"duration": 6.1e-3, "sampling": 1e4, "tolerance": 1e-12}}))
    found = [run.signal(axis, "shaft")[60] for axis in "xy"]
    worst = float(np.max(np.abs(np.array(found) - [1.6322944905359254e-07, -6.013476207450371e-06])))
    measured("bearing with a dent: trajectory at 6 ms [m]", worst, "1e-11")
    assert worst < 1e-11


@pytest.mark.parametrize(
    ("fault", "passes"),
    [
        ({"kind": "outer"}, 0.5 * 8 * (1.0 - 7.9375 / 33.5026)),
        ({"kind": "inner"}, 0.5 * 8 * (1.0 + 7.9375 / 33.5026)),
        (
            {"kind": "element", "element": 3, "arc": "20 deg"},
            (33.5026 / 7.9375) * (1.0 - (7.9375 / 33.5026) ** 2),
        ),
    ],
)
@pytest.mark.parametrize("ring", ["inner", "outer"])
def test_lines_of_dents(fault: Document, passes: float, ring: str) -> None:
    """A preloaded shaft without a load, so that every element is pressed alike: lines at BPFO, BPFI and 2 BSF alone.

    The force turns with what carries the dent, so that a line of its size is at the pass frequency.
    """
    turns, per_turn = 40, 4096
    document = dented(
        {"internal_clearance": -2e-5, "damping": {"value": 5.0}, "rotor_ring": ring},
        fault,
        drive={"kind": "speed", "speed": "600 rpm"},
    )
    document["run"] = {
        "duration": turns / 10.0, "transient": 0.2, "sampling": per_turn * 10.0, "tolerance": 1e-7,
    }  # fmt: skip
    run = gp.simulate(document)
    force = np.hypot(*(run.ds[f"bearing_force_{axis}"].sel(bearing="shaft").values for axis in "xy"))
    lines = np.abs(np.fft.rfft(force - np.mean(force)))
    order = np.fft.rfftfreq(force.size, 1.0 / per_turn)
    strong = order[lines > 0.3 * np.max(lines)]
    harmonics = np.round(strong / passes)
    assert len(strong) >= 3
    assert np.max(np.abs(strong - harmonics * passes)) <= 1.01 / turns


@pytest.mark.parametrize("cage_torque", [True, False])
@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_energy_closes_over_dents(cage_torque: bool, damping: float, measured: Measured) -> None:
    """The energy of a rattling disc at its touchless ends changes by what the bearing loses and what the cage puts in."""
    document = dented(
        {"internal_clearance": 4e-5, "damping": {"value": damping}, "cage_torque": cage_torque},
        {"depth": "8 um", "arc": "20 deg"},
        {"kind": "inner", "depth": "8 um", "arc": "20 deg"},
        {"kind": "element", "depth": "8 um", "arc": "60 deg"},
        mass=0.4,
        inertia=1e-4,
        drive=None,
        initial={"x": 1e-5, "omega": 300.0, "vy": 0.05},
    )
    del document["rotors"]["shaft"]["drive"]
    document["run"] = {"duration": 8e-3, "sampling": 2e6, "tolerance": 1e-11}
    run = simulate_one(document)
    energy = 0.2 * (run.signal("vx", "shaft") ** 2 + run.signal("vy", "shaft") ** 2)
    energy = energy + 0.5e-4 * run.signal("omega", "shaft") ** 2
    free = np.flatnonzero(run.signal("bearing_element_load", "shaft") == 0.0)
    gained = run.signal("bearing_cage_power", "shaft") - run.signal("bearing_power_loss", "shaft")
    expected = np.concatenate([[0.0], np.cumsum(0.5 * (gained[1:] + gained[:-1]) * np.diff(run.time))])
    off = np.abs(energy - energy[free[0]] - expected + expected[free[0]])[free]
    measured("bearing with dents: energy, of the centre's", float(np.max(off)) / 5e-4, "1e-4")
    assert run.counters.events > 20
    assert np.max(off) < (1e-4 if np.any(gained) else 1e-9) * 5e-4 + 1e-12 * energy[0]


def test_no_dent_is_passed_within_a_step() -> None:
    """Steps at a constant speed from 10 deg before the dent's end on, and one that turns round a little beyond it."""
    document = dented({"cage_phase": math.radians(-103.0)}, {}, drive={"kind": "speed", "speed": 100.0})
    system = pack(case_of(document)).system
    branch, loads, stages = make_branch(system), make_loads(system), np.zeros((7, 6))
    switch, share = 16, 0.5 * (1.0 - 7.9375 / 33.5026)
    g_0, g_1 = np.zeros(17), np.zeros(17)

    def beyond(travel: float) -> float:
        """Return the switch after an element has moved by an angle [deg]: over 0 within the dent."""
        y = np.zeros(6)
        y[2] = math.radians(travel) / share
        return dispatch.own_switch(system, 0, switch, 0.0, y, branch, loads)

    def may(begin: float, end: float) -> bool:
        g_0[switch], g_1[switch] = beyond(begin), beyond(end)
        h = math.radians(end - begin) / (100.0 * share)
        return dispatch.may_return(system, 0, switch, h, branch, loads, loads, g_0, g_1, stages)

    assert beyond(13.0) == pytest.approx(math.radians(3.0), rel=1e-9), "in its middle"
    assert abs(beyond(10.0)) < 1e-12 > abs(beyond(16.0))
    assert may(0.0, 17.0)
    assert may(9.9, 16.1)
    assert not may(0.0, 9.9)
    assert not may(16.1, 30.0)
    assert not may(9.0, 9.99)
    stages[:, 5] = 1e6  # rad/s^2
    assert may(9.0, 9.99), "within h^2/4 of the end by its acceleration"
    assert not may(0.0, 0.1)


@pytest.mark.parametrize("cage_torque", [True, False])
@pytest.mark.parametrize("kind", ["inner", "outer", "element"])
def test_slopes_of_the_torque(kind: str, cage_torque: bool) -> None:
    """The torque and the force of one loaded element in a dent, by the rotation of the shaft, against differences."""
    document = dented(
        {"internal_clearance": 1e-5, "damping": {"value": 2.0}, "cage_torque": cage_torque},
        {"kind": kind, "arc": "20 deg"} | ({"angle": 0.0} if kind == "element" else {}),
        initial={"omega": 200.0},
    )
    document["bearings"]["shaft"]["cage_phase"] = -0.5 * math.pi
    del document["rotors"]["shaft"]["drive"]
    system = pack(case_of(document)).system
    branch, loads, y = make_branch(system), make_loads(system), np.zeros(6)
    y[:] = 2e-7, -9e-6, 0.02, 1e-3, 2e-3, 200.0
    acting = np.array([1, 0], dtype=np.int64)

    def force(turn: float) -> Floats:
        at, loads.rotors[:] = y.copy(), 0.0
        at[2] += turn
        dispatch.contact_kinematics(system, 0, 0.0, at, branch, loads)
        branch.modes[:8] = np.where(loads.contacts[:, PENETRATION] > 0.0, LOADED, OPEN)
        dispatch.initialise(system, 0, 0.0, at, branch, loads)
        dispatch.apply_forces(system, acting, 0.0, at, branch, loads, np.zeros(6))
        return np.array(loads.rotors[0])

    force(0.0)
    assert branch.modes[8] == 1, "in the dent"
    rows, found, z = make_slopes(system), np.zeros((1, 3)), np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    dispatch.linearise(system, 0, 0.0, y, branch, loads, rows.elements[0])
    dispatch.add_change(system, 0, rows.elements[0], z, branch, found, np.zeros(6))
    expected = (force(1e-5) - force(-1e-5)) / 2e-5
    assert found[0] == pytest.approx(expected, rel=1e-6, abs=1e-9 * float(np.max(np.abs(expected))))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"at": "wheel"}, 'faults.0.at = "wheel": must be a name in the table bearings'),
        ({"kind": "rust"}, 'faults.0.kind = "rust": must be one of inner, outer, element, cage, crack'),
        ({"arc": "37 deg"}, "must be at most 36 deg"),
        ({"kind": "element", "element": 8}, "faults.0.element = 8: must be less than 8"),
        ({"depth": 0.0}, "faults.0.depth"),
    ],
)
def test_refused_faults(change: Document, words: str) -> None:
    with pytest.raises(InputError, match=words.replace(".", r"\.")):
        gp.load_case(dented({}, change))


def test_check_gives_the_pass_frequency() -> None:
    case = case_of(dented({}, {}, drive={"kind": "speed", "speed": "600 rpm"}))
    found = {finding.path: finding.message for finding in gp.check_case(case)}
    assert "3.05231 times, 30.5231 Hz" in found["faults.0"]


def test_a_dent_changes_the_digest_and_an_empty_list_does_not() -> None:
    sound = shaft(BALLS)
    assert case_of(sound | {"faults": []}).sha256 == case_of(sound).sha256
    assert case_of(sound | {"faults": [DENT]}).sha256 != case_of(sound).sha256
    case = case_of(sound | {"faults": [DENT]})
    assert gp.load_case(case.resolved()) == case
    assert gp.replace(case, {"faults.0.depth": "5 um"}).faults[0].depth == 5e-6
