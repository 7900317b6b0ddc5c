"""Starts: one and the same whatever the order of tables, no flank inside another, speeds that roll together."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from depth import sized
from gearplay.model.bundled import bundled
from gearplay.model.check_start import start_findings
from gearplay.model.initial import Starts
from gearplay.model.matching import matching_speeds
from gearplay.model.pack import pack
from gearplay.parts.mesh.train.rolling import nominal_speeds, starting_speeds
from starting import by_name, depths, expanded, orders, planetary, starts_of, train

SAME = 1e-12  # m, and for speeds of some 50 rad/s their rounding
ROUNDING = 1e-14  # m
MEMBERS = 3


def pair(**first: Any) -> dict[str, Any]:
    """Return an external pair of 23 and 31 teeth, ``first`` fields of its first rotor."""
    mesh = {
        "driver": "a",
        "driven": "b",
        "module": 3e-3,
        "pressure_angle": 0.35,
        "backlash": 6e-5,
        "stiffness": {"kind": "harmonic", "mean": 8e7},
    }
    rotors = {
        "a": {"teeth": 23, "mass": 0.7, "inertia": 3e-4, **first},
        "b": {"teeth": 31, "mass": 1.1, "inertia": 1.2e-3},
    }
    return {"rotors": rotors, "meshes": [mesh], "run": {"duration": 2e-4, "sampling": 1e6}}


def speeds_of(document: dict[str, Any]) -> dict[str, float]:
    """Return the speeds at the start [rad/s]."""
    case, packed, starts = starts_of(document)
    return {name: values[-1] for name, values in by_name(case, packed, starts.state(0)).items()}


def shocks(document: dict[str, Any]) -> list[str]:
    """Return the findings on the start."""
    return [str(each) for each in gp.check_case(gp.load_case(document)) if "at the start" in each.message]


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_starts__tree__independent_of_order_and_in_touch(part: int) -> None:
    for seed in range(part, sized(300, 40), 10):
        first: list[dict[str, list[float]]] = []
        for document in orders(train(seed)):
            case, packed, starts = starts_of(document)
            found = []
            for member in range(MEMBERS):
                y = starts.state(member)
                flanks = depths(case, packed, y)
                assert np.max(flanks) <= ROUNDING, (seed, member)
                assert member or np.max(np.abs(flanks[:, 0])) <= ROUNDING, (seed, "drive flanks touch")
                found.append(by_name(case, packed, y))
            first = first or found
            for mine, other in zip(found, first, strict=True):
                assert all(np.allclose(mine[name], other[name], rtol=SAME, atol=SAME) for name in other), seed


@pytest.mark.slow
@pytest.mark.parametrize("part", range(5))
def test_starts__planetary_set__sound_members_in_every_order(part: int) -> None:
    for seed in range(part, sized(60, 10), 5):
        document = planetary(seed)
        whole = expanded(document)
        first: list[dict[str, list[float]]] = []
        for each in [document, *orders(whole, 4)]:
            case, packed, starts = starts_of(each)
            found = []
            for member in range(MEMBERS):
                y = starts.state(member)
                assert np.max(depths(case, packed, y)) <= ROUNDING, (seed, member)
                named = by_name(case, packed, y)
                found.append({name.replace("stage.", ""): values for name, values in named.items()})
            first = first or found
            for mine, other in zip(found, first, strict=True):
                assert all(np.allclose(mine[name], other[name], rtol=SAME, atol=SAME) for name in other), seed


def test_starts__planetary_set__one_planet_carries_first() -> None:
    """The carrier turns until the first planet touches both sun and ring; the play of the others is in halves."""
    document = planetary(1)
    case, packed, starts = starts_of(document)
    gaps = -depths(case, packed, starts.state(0))[:, 0].reshape(2, -1)
    assert np.min(gaps) == pytest.approx(0.0, abs=ROUNDING)
    assert np.allclose(gaps[0], gaps[1], atol=1e-9)
    assert np.max(gaps) > 1e-6


def test_starts__ring_coupled_to_the_carrier__both_turn_the_mesh() -> None:
    document = planetary(0)
    stage = document["planetary"]["stage"]
    for member in ("sun", "ring", "carrier"):
        stage[member].pop("fixed", None)
        stage[member].pop("drive", None)
    stage["sun"]["drive"] = {"kind": "torque", "torque": 20.0}
    document["couplings"] = [{"between": ["stage.ring", "stage.carrier"], "torsional_stiffness": 1e4}]
    case, packed, starts = starts_of(document)
    for member in range(MEMBERS):
        assert np.max(depths(case, packed, starts.state(member))) <= ROUNDING


def test_starts__clearance_of_a_carrier__planets_stay_on_their_pins() -> None:
    document = planetary(2)
    document["planetary"]["stage"]["carrier"]["sleeve"] = {
        "radial_clearance": 100e-6, "stiffness": 1e10, "restitution": 0.9,
    }  # fmt: skip
    case, packed, starts = starts_of(document)
    for member in range(1, 6):
        named = by_name(case, packed, starts.state(member))
        carrier = np.array(named["stage.carrier"])
        for k in (1, 2, 3):
            planet = np.array(named[f"stage.planet{k}"])
            position = np.array(case.rotors[f"stage.planet{k}"].position)
            turn = carrier[2]
            turned = np.array(
                [
                    (math.cos(turn) - 1.0) * position[0] - math.sin(turn) * position[1],
                    math.sin(turn) * position[0] + (math.cos(turn) - 1.0) * position[1],
                ]
            )
            assert np.hypot(*(planet[:2] - carrier[:2] - turned)) <= 20e-6


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0), (0, 2, 1)])
@pytest.mark.parametrize("drive", [{"kind": "speed", "speed": 10.0}, {"kind": "torque", "torque": 3.0}])
def test_starts__train_with_runouts__drive_flanks_touch(
    order: tuple[int, ...], drive: dict[str, Any]
) -> None:
    """Listed backwards it started pressed by 17.8 um and open by 19.5 um."""
    module, teeth = 2e-3, {name: 20 + 3 * k for k, name in enumerate("abcd")}
    rotors: dict[str, Any] = {k: {"teeth": z, "mass": 0.3, "inertia": 1e-4} for k, z in teeth.items()}
    place = 0.0
    for name, z in teeth.items():
        rotors[name]["position"] = [place, 0.0]
        place += module * (2 * z + 3) / 2
    rotors["a"]["drive"], rotors["d"]["load"] = drive, {"torque": 1.0}
    rotors["b"]["runout"] = {"amplitude": 20e-6, "phase": 1.0}
    rotors["c"]["runout"] = {"amplitude": 30e-6, "phase": 2.0}
    shared = {"module": module, "backlash": 1e-4, "stiffness": {"kind": "harmonic", "mean": 1e8}}
    meshes = [{"driver": p, "driven": q, **shared} for p, q in ("ab", "bc", "cd")]
    case, packed, starts = starts_of(
        {"rotors": rotors, "meshes": [meshes[k] for k in order], "run": {"duration": 1e-4}}
    )
    y = starts.state(0)
    assert np.max(np.abs(depths(case, packed, y)[:, 0])) <= ROUNDING
    turns = [named[2] for named in by_name(case, packed, y).values()]
    assert turns == pytest.approx([0.0, 902.93e-6, -71.79e-6, -719.22e-6], abs=1e-8)


def test_starts__rotations_given_at_both_ends__room_in_between_is_found() -> None:
    """Between two given gears the third stands where no tooth is in another; where there is no room `check` says it."""
    shared = {"module": 2e-3, "backlash": 1e-4, "stiffness": {"kind": "harmonic", "mean": 1e8}}
    body = {"teeth": 20, "mass": 0.3, "inertia": 1e-4}

    def between(turn: float) -> dict[str, Any]:
        rotors = {
            "a": body | {"initial": {"theta": 0.0}},
            "b": body,
            "c": body | {"initial": {"theta": turn}},
        }
        meshes = [{"driver": p, "driven": q, **shared} for p, q in ("ab", "bc")]
        return {"rotors": rotors, "meshes": meshes, "run": {"duration": 1e-3}}

    radius = 20e-3 * math.cos(math.radians(20.0))
    for misfit in (0.0, 30e-6, -30e-6, 99e-6, -99e-6):
        case, packed, starts = starts_of(between(misfit / radius))
        gaps = -depths(case, packed, starts.state(0))[:, 0]
        assert np.sort(gaps) == pytest.approx([0.0, abs(misfit)], abs=ROUNDING)
        assert not shocks(between(misfit / radius))
    for misfit in (150e-6, -150e-6):  # 50 um more than the backlash
        case, packed, starts = starts_of(between(misfit / radius))
        flanks = depths(case, packed, starts.state(0))
        assert np.max(flanks, axis=1) == pytest.approx([25e-6, 25e-6], abs=1e-10)
        said = shocks(between(misfit / radius))
        assert len(said) == 2
        assert all(
            "inside each other at the start, the" in each and "flanks by 25 um" in each for each in said
        )
        assert "rotors.a.initial.theta and rotors.c.initial.theta" in said[0]


@pytest.mark.parametrize("drive", [{"drive": {"kind": "torque", "torque": 5.0}}, {}])
def test_starting_speeds__initial_speed_of_one_gear__partner_matches(drive: dict[str, Any]) -> None:
    """The partner started at 0: the first blow was 10.4 kN."""
    document = pair(initial={"omega": 80.0}, **drive)
    assert speeds_of(document) == pytest.approx({"a": 80.0, "b": -80.0 * 23 / 31}, rel=1e-12)
    assert not shocks(document)


@pytest.mark.parametrize("ratio", [1.0, -2.5])
def test_starting_speeds__coupling__passed_by_its_ratio(ratio: float) -> None:
    document = pair(initial={"omega": 80.0})
    document["rotors"] |= {"disc": {"mass": 1.0, "inertia": 1e-3}}
    document["couplings"] = [{"between": ["disc", "b"], "torsional_stiffness": 1e3, "ratio": ratio}]
    expected = {"a": 80.0, "b": -80.0 * 23 / 31, "disc": -80.0 * ratio * 23 / 31}
    assert speeds_of(document) == pytest.approx(expected, rel=1e-12)
    assert not shocks(document)


@pytest.mark.parametrize(
    ("given", "holds"),
    [
        ({"sun": 30.0, "carrier": 5.0}, {}),
        ({"ring": -4.0, "carrier": 5.0}, {}),
        ({"sun": 30.0, "ring": 2.0}, {}),
        ({"carrier": 5.0}, {"ring": {"fixed": True}}),
        ({"sun": 30.0}, {"ring": {"support": {"torsional_stiffness": 1e4}}}),
    ],
)
def test_starting_speeds__planetary_set__two_members_fix_the_third(
    given: dict[str, float], holds: dict[str, Any]
) -> None:
    """Willis: (sun - carrier) z_sun = -(ring - carrier) z_ring."""
    document = planetary(0)
    stage = document["planetary"]["stage"]
    for member in ("sun", "ring", "carrier"):
        for name in ("drive", "fixed"):
            stage[member].pop(name, None)
        if member in given:
            stage[member]["initial"] = {"omega": given[member]}
        stage[member] |= holds.get(member, {})
    found = {name.removeprefix("stage."): speed for name, speed in speeds_of(document).items()}
    assert {name: found[name] for name in given} == given
    assert all(found[name] == 0.0 for name in holds)
    relative = {name: speed - found["carrier"] for name, speed in found.items()}
    assert relative["sun"] * 24 == pytest.approx(-relative["ring"] * 60, rel=1e-9)
    assert relative["planet1"] * 18 == pytest.approx(relative["ring"] * 60, rel=1e-9)
    assert not shocks(document)


def test_starting_speeds__prescribed_drive__wins_over_a_speed_further_on() -> None:
    """Of a, b, c with a driven and c given, b matches the drive; `check` names the blow between b and c, and its cure."""
    document = pair(drive={"kind": "speed", "speed": 10.0})
    document["rotors"]["c"] = {"teeth": 23, "mass": 0.7, "inertia": 3e-4, "initial": {"omega": -3.0}}
    document["meshes"].append(document["meshes"][0] | {"driver": "b", "driven": "c"})
    found = speeds_of(document)
    assert found == pytest.approx({"a": 10.0, "b": -10.0 * 23 / 31, "c": -3.0}, rel=1e-12)
    (said,) = shocks(document)
    base = 0.5 * 3e-3 * 23 * math.cos(0.35)
    assert f"at {base * 13.0:.4g} m/s" in said
    assert "warning: meshes.1: the teeth of b-c meet at the start with up to" in said
    assert "The cause: rotors.c.initial.omega, rotors.a.drive." in said
    assert "Leave rotors.c.initial.omega out, or give the matching speed, 10 rad/s." in said


def test_starting_speeds__next_to_a_given_speed__matches_that() -> None:
    """Of a, b, c with a driven and b given, c matches b: one blow, not two."""
    document = pair(drive={"kind": "speed", "speed": 10.0})
    document["rotors"]["b"]["initial"] = {"omega": 0.0}
    document["rotors"]["c"] = {"teeth": 23, "mass": 0.7, "inertia": 3e-4}
    document["meshes"].append(document["meshes"][0] | {"driver": "b", "driven": "c"})
    assert speeds_of(document) == pytest.approx({"a": 10.0, "b": 0.0, "c": 0.0}, rel=1e-12)
    (said,) = shocks(document)
    assert "teeth of a-b" in said


def test_starting_speeds__contradiction_at_a_coupling__is_named() -> None:
    rotors = {
        "a": {"mass": 1.0, "inertia": 1e-3, "initial": {"omega": 50.0}},
        "b": {"mass": 1.0, "inertia": 2e-3, "initial": {"omega": 40.0}},
    }
    coupling = {"between": ["a", "b"], "torsional_stiffness": 1e3}
    (said,) = shocks({"rotors": rotors, "couplings": [coupling], "run": {"duration": 1e-3}})
    assert said.startswith(
        "warning: couplings.0: a-b twists at the start at 10 rad/s, since 50 rad/s of a and 40 rad/s of b"
    )
    assert "rotors.a.initial.omega, rotors.b.initial.omega" in said


def test_starting_speeds__rounded_given_speed__is_no_shock() -> None:
    document = pair(initial={"omega": 80.0})
    document["rotors"]["b"]["initial"] = {"omega": -59.35}
    assert speeds_of(document)["b"] == -59.35
    assert not shocks(document)


@pytest.mark.parametrize("name", bundled("gearplay.model", "cases"))
def test_starting_speeds__bundled_cases__as_drives_start_and_sound(name: str) -> None:
    case = gp.load_case(name)
    nominal = nominal_speeds(case)
    assert np.array_equal(matching_speeds(case, nominal), starting_speeds(case, nominal))
    assert not list(start_findings(case, pack(case)))


def test_starting_speeds__ripple__others_are_nominal_and_a_finding() -> None:
    ripple = [{"order": 1, "amplitude": 0.1, "phase": math.pi / 2}]
    document = pair(drive={"kind": "speed", "speed": 10.0, "ripple": ripple})
    assert speeds_of(document) == pytest.approx({"a": 11.0, "b": -10.0 * 23 / 31}, rel=1e-12)
    (said,) = shocks(document)
    assert "The cause: rotors.a.drive.ripple. Give phases with which the ripple is 0 at t = 0" in said


def test_starts__first_blow_of_a_coasting_pair__none() -> None:
    found = gp.simulate(gp.load_case(pair(initial={"omega": 80.0}))).ds
    assert float(found.drive_force.max()) < 1e-6
    assert float(found.back_force.max()) < 1e-6


def test_starts__wedged_tree__is_turned_to_the_middle() -> None:
    """Negative backlash at the start: both flanks press alike, and the rest of the train is in touch nevertheless."""
    document = pair()
    document["rotors"]["a"] |= {"floating": True, "initial": {"x": 150e-6}}
    document["rotors"]["c"] = {"teeth": 23, "mass": 0.7, "inertia": 3e-4}
    document["meshes"].append(document["meshes"][0] | {"driver": "b", "driven": "c"})
    case, packed, starts = starts_of(document)
    flanks = depths(case, packed, starts.state(0))
    assert flanks[0, 0] == pytest.approx(flanks[0, 1], abs=ROUNDING)
    assert flanks[0, 0] > 1e-6
    assert flanks[1, 0] == pytest.approx(0.0, abs=ROUNDING)
    (said,) = shocks(document)
    assert "teeth of a-b are inside each other at the start" in said
    assert "Move initial.x" in said


def test_starts__members__drawn_alike_whatever_is_common() -> None:
    """A `Starts` that has drawn others before draws the same."""
    case = gp.load_case(planetary(4))
    packed = pack(case)
    starts = Starts(case, packed)
    found = [starts.state(member) for member in (3, 0, 3)]
    assert np.array_equal(found[0], found[2])
    assert np.array_equal(found[0], Starts(case, packed).state(3))
