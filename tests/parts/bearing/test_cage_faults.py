"""Elements that the cage holds off their even places: statics, lines, energy, dents beside them, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from gearplay.integrate import dispatch
from gearplay.kernels.layout import PENETRATION
from gearplay.vocabulary.errors import InputError
from parts.bearing.shafts import BALLS, Law, shaft, under
from parts.bearing.test_dents import dented

RATIO = 7.9375 / 33.5026
ROOM = 45.0 - math.degrees(2.0 * math.asin(RATIO))
"""Angle [deg] by which one of eight balls may be off, up to its neighbours."""


def off(element: int, angle: float) -> Document:
    """Return the fault of the pocket of an element, off by an angle [deg]."""
    return {"kind": "cage", "at": "shaft", "element": element, "angle": math.radians(angle)}


def broken(bearing: Document, *faults: Document, **rest: Any) -> Document:
    """Return a shaft in a bearing with faults."""
    return shaft(BALLS | bearing, **rest) | {"faults": list(faults)}


@pytest.mark.parametrize("faults", [[off(3, 0.0)], [off(k, 1e-20) for k in (0, 3, 7)]])
def test_no_offset_gives_the_same_bits(faults: list[Document]) -> None:
    """Of 0, and of one that is lost in the rounding of the angles."""
    waves = [{"order": 5, "amplitude": 1e-6, "ring": "outer"}]
    rest: dict[str, Any] = {"weight": 100.0, "drive": {"kind": "speed", "speed": "3000 rpm"}}
    play = {"internal_clearance": 1e-5, "damping": {"value": 0.5}, "waviness": waves}
    sound, found = (simulate_one(broken(play, *each, **rest)) for each in ([], faults))
    for axis in "xy":
        assert np.array_equal(sound.signal(axis, "shaft"), found.signal(axis, "shaft"))


def test_all_elements_off_alike_are_another_phase() -> None:
    """With waviness and a dent of the outer ring, which is passed under load."""
    dent: Document = {"kind": "outer", "at": "shaft", "depth": 3e-6, "arc": 0.1, "angle": -1.6}
    waves = [{"order": 5, "amplitude": 1e-6, "ring": "outer"}]
    play = {"internal_clearance": 1e-5, "damping": {"value": 5.0}, "waviness": waves, "cage_phase": 0.3}
    rest: dict[str, Any] = {"weight": 100.0, "drive": {"kind": "speed", "speed": "3000 rpm"}}
    turned = simulate_one(broken(play | {"cage_phase": 0.3 + math.radians(50.0)}, dent, **rest))
    found = simulate_one(broken(play, dent, *(off(k, 50.0) for k in range(8)), **rest))
    for axis in "xy":
        assert found.signal(axis, "shaft") == pytest.approx(turned.signal(axis, "shaft"), abs=1e-12)


@pytest.mark.parametrize("ring", ["inner", "outer"])
@pytest.mark.parametrize(("element", "angle"), [(0, 9.0), (1, -14.0), (7, 14.0)])
def test_displacement_with_one_element_off(element: int, angle: float, ring: str, measured: Measured) -> None:
    """A load of 100 N along -y with element 0 under it: the sum over the elements at their own angles, by SciPy."""
    bearing = under(BALLS, 0.0) | {"internal_clearance": 1e-5, "rotor_ring": ring}
    bearing["cage_phase"] += 0.0 if ring == "inner" else math.pi  # the loaded side of an outer ring
    at = 2.0 * math.pi * np.arange(8) / 8
    at[element] += math.radians(angle)

    def left(z: Floats) -> list[float]:
        depth = np.maximum(1e-6 * (z[0] * np.cos(at) + z[1] * np.sin(at)) - 5e-6, 0.0)
        load = 1.334e10 * depth**1.5
        return [float(load @ np.cos(at)) / 100.0 - 1.0, float(load @ np.sin(at)) / 100.0]

    along, across = 1e-6 * root(left, [8.0, 0.1], method="lm", tol=1e-15).x
    x, y = Law(bearing, [off(element, angle)]).displacement(100.0, 8e-6)
    worst = max(abs(-y - along), abs(x - across)) / along
    measured("bearing, one element off: displacement, relative", worst, "1e-9")
    assert worst < 1e-9
    assert abs(across) > 1e-7


def spectrum_of(*faults: Document) -> tuple[Floats, float]:
    """Return amplitudes [m] of the shaft's motion along a constant load over 12 turns of the cage, and the static one."""
    document = broken(
        {"internal_clearance": 1e-5, "damping": {"value": 200.0}},
        *faults,
        weight=100.0,
        drive={"kind": "speed", "speed": "120 rpm"},
        initial={"y": -8.3e-6},
    )
    cage, per_turn = 2.0 * 0.5 * (1.0 - RATIO), 512
    document["run"] = {
        "duration": 12.0 / cage, "transient": 0.2, "sampling": per_turn * cage, "tolerance": 1e-8,
    }  # fmt: skip
    y = gp.simulate(document).ds["y"].sel(rotor="shaft").values[: 12 * per_turn]
    lines: Floats = np.abs(np.fft.rfft(y - np.mean(y))) * 2.0 / y.size
    found = []
    for angle in 2.0 * math.pi * np.arange(160) / 160:
        bearing = under(BALLS, float(angle)) | {"internal_clearance": 1e-5}
        found.append(Law(bearing, faults).displacement(100.0, 8e-6)[1])
    return lines[::12], float(abs(np.fft.rfft(found))[1]) * 2.0 / 160


def test_lines_of_the_cage_under_a_constant_load(measured: Measured) -> None:
    """Multiples of FTF = (1 - g)/2 of the turns, absent of an even cage; slowly as large as in the static displacement."""
    sound, _ = spectrum_of()
    lines, expected = spectrum_of(off(2, 10.0))
    assert np.max(sound[1:8]) < 1e-3 * sound[8], "the passing elements alone"
    measured(
        "bearing, one element off: line at FTF over the static one", abs(lines[1] / expected - 1.0), "0.02"
    )
    assert lines[1] == pytest.approx(expected, rel=0.02)
    assert np.min(lines[1:4]) > 100.0 * np.max(sound[1:8])


@pytest.mark.parametrize("cage_torque", [True, False])
def test_energy_closes(cage_torque: bool, measured: Measured) -> None:
    """The energy of a rattling disc at its touchless ends changes by what the bearing loses and what the cage puts in."""
    document = broken(
        {"internal_clearance": 4e-5, "damping": {"value": 0.5}, "cage_torque": cage_torque},
        off(2, 12.0),
        off(5, -10.0),
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
    wrong = np.abs(energy - energy[free[0]] - expected + expected[free[0]])[free]
    measured("bearing, two elements off: energy, of the centre's", float(np.max(wrong)) / 5e-4, "1e-4")
    assert run.counters.events > 20
    assert np.max(wrong) < 1e-4 * 5e-4


def test_the_element_that_is_off_meets_a_dent_later() -> None:
    """Penetration of element 1 in the middle of a dent of the outer ring: at the angle at which it stands, not the even one."""
    dent: Document = {"kind": "outer", "at": "shaft", "depth": 3e-6, "arc": "10 deg", "angle": "35 deg"}
    for angle, depth in ((-10.0, 3e-6), (0.0, 0.0)):
        law = Law(BALLS, [dent, off(1, angle)])
        law.force(0.0, 0.0)
        penetration = law.loads.contacts[:, PENETRATION]
        assert penetration == pytest.approx(np.where(np.arange(8) == 1, -depth, 0.0), abs=1e-15)
        beyond = dispatch.own_switch(law.system, 0, 16, 0.0, law.y, law.branch, law.loads)
        assert beyond == pytest.approx(math.radians(-5.0), abs=1e-12), "to the dent's end"
    law = Law(BALLS, [dent | {"angle": "131 deg"}, off(1, -10.0)])
    beyond = dispatch.own_switch(law.system, 0, 16, 0.0, law.y, law.branch, law.loads)
    assert beyond == pytest.approx(math.radians(1.0), abs=1e-12), (
        "element 3, at its even place, is 4 deg from the middle"
    )


@pytest.mark.parametrize(
    ("faults", "words"),
    [
        ([off(8, 2.0)], "faults.0.element = 8: must be less than 8, the number of elements"),
        ([off(2, ROOM + 0.1)], f"must be between {-ROOM:.4g} and {ROOM:.4g} deg, where the element touches"),
        ([off(2, -ROOM - 0.1)], f"must be between {-ROOM:.4g} and {ROOM:.4g} deg, where the element touches"),
        ([off(0, -ROOM + 5.0), off(7, 6.0)], "faults.0.angle = "),
        ([off(2, 1.0), off(2, 1.0)], "faults.1.element = 2: must not be that of another fault of this cage"),
        ([{"kind": "cage", "at": "shaft"}], "faults.0.angle"),
        ([{"kind": "cage", "at": "wheel", "angle": 0.1}], 'faults.0.at = "wheel": must be a name in the table'),
        ([off(2, 10.0), {"kind": "outer", "at": "shaft", "depth": 1e-6, "arc": "30 deg"}], "must be at most 28 deg"),
    ],
)  # fmt: skip
def test_refused_cage_faults(faults: list[Document], words: str) -> None:
    with pytest.raises(InputError, match=words.replace(".", r"\.")):
        gp.load_case(broken({}, *faults))


def test_neighbours_may_be_off_together() -> None:
    """By more than the room between even places, as long as they keep their distance."""
    gp.load_case(broken({}, *(off(k, 30.0) for k in (2, 3, 4)), off(5, 13.0)))
    gp.load_case(broken({}, off(2, ROOM - 0.1), off(4, -ROOM + 0.1)))


def test_check_gives_the_frequency_of_the_cage() -> None:
    document = broken({}, off(2, 5.0), drive={"kind": "speed", "speed": "600 rpm"})
    found = {finding.path: finding.message for finding in gp.check_case(case_of(document))}
    assert "the cage turns 0.381539 times, 3.81539 Hz at the nominal speed" in found["faults.0"]


def test_an_uneven_bearing_repeats_with_its_cage() -> None:
    from gearplay.model.pack import pack
    from gearplay.parts.registry import recurrence_rates

    document = broken({}, off(2, 5.0), drive={"kind": "speed", "speed": 100.0})
    rates = recurrence_rates(pack(case_of(document)).system, np.array([100.0]), np.zeros(1))
    assert rates == pytest.approx([100.0 * 0.5 * (1.0 - RATIO)])


def test_modes_are_those_of_an_even_bearing() -> None:
    """The linear form is the mean over all angles of the cage."""
    sound, found = (
        gp.modes(case_of(broken({"internal_clearance": -1e-5}, *each))).ds["frequency"].values
        for each in ((), (off(2, 5.0),))
    )
    assert np.array_equal(sound, found)


def test_dents_of_rings_and_a_cage_together_keep_the_digest_of_the_case() -> None:
    case = case_of(dented({}, {}) | {"faults": [off(1, 2.0)]})
    assert gp.load_case(case.resolved()) == case
    assert gp.replace(case, {"faults.0.angle": "3 deg"}).faults[0].angle == math.radians(3.0)
