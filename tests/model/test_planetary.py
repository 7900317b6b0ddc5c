"""Planetary sets: what their table stands for, mesh phases, what cannot be assembled, the same from Python."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.model.reading import to_toml
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.parts.mesh.train.rolling import nominal_speeds
from gearplay.parts.planetary.frequencies import set_frequencies
from gearplay.parts.registry import MESH
from planetary_sets import PART, planetary_document

SLEEVE = {"radial_clearance": 1e-5, "stiffness": 1e10}


def phases(case: gp.Case) -> Any:
    """Return the packed starting phases of the meshes, in turns between 0 and 1."""
    return np.round(np.mod(pack(case).system.records[MESH]["psi_0"] / (2.0 * math.pi), 1.0), 9) % 1.0


def refusal(document: dict[str, Any]) -> str:
    with pytest.raises(gp.InputError) as caught:
        gp.load_case(document)
    return str(caught.value)


def test_a_set_is_its_rotors_pins_and_meshes() -> None:
    case = gp.load_case(planetary_document())
    names = ["sun", "ring", "carrier", *(f"planet{k}" for k in range(1, 5))]
    assert list(case.rotors) == [f"stage.{name}" for name in names]
    assert [mesh.label for mesh in case.meshes[:2]] == ["stage.sun-stage.planet1", "stage.sun-stage.planet2"]
    assert case.meshes[-1].label == "stage.planet4-stage.ring"
    assert case.supports["stage.planet3"].on == "stage.carrier"
    assert case.rotors["stage.planet2"].position == pytest.approx((0.0, 0.08))
    speeds = dict(zip(names, nominal_speeds(case), strict=True))
    assert speeds["carrier"] == pytest.approx(60.0 * 20 / 80)
    assert speeds["planet1"] == pytest.approx(15.0 - 45.0 * 20 / 20)


def test_a_set_survives_every_way_of_writing_it(tmp_path: Any) -> None:
    case = gp.load_case(planetary_document(pin_errors=[{"planet": 2, "tangential": 5e-5}]))
    place = tmp_path / "case.toml"
    place.write_text(to_toml(case), encoding="utf-8")
    for again in (gp.load_case(case.resolved()), gp.load_case(place), gp.replace(case, {})):
        assert again == case
        assert again.sha256 == case.sha256
    assert "rotors" not in case.resolved() or not case.resolved()["rotors"]
    heavier = gp.replace(case, {"planetary.stage.planets.mass": "3 kg", "planetary.stage.planets.count": 5})
    assert [r.mass for n, r in heavier.rotors.items() if "planet" in n] == [3.0] * 5
    assert len(heavier.meshes) == 10


def test_python_builds_the_same() -> None:
    document = planetary_document()
    built = gp.planetary(**document["planetary"]["stage"], run=document["run"])
    assert built == gp.load_case(document)


def test_a_pin_error_turns_with_its_planet_s_direction() -> None:
    case = gp.load_case(planetary_document(pin_errors=[{"planet": 2, "tangential": 5e-5, "radial": 1e-5}]))
    assert case.supports["stage.planet2"].offset == pytest.approx((-5e-5, 1e-5))
    assert case.supports["stage.planet1"].offset == (0.0, 0.0)


def test_phases_of_25_teeth_and_3_planets_are_thirds() -> None:
    case = gp.load_case(planetary_document(sun={"teeth": 25}, ring={"teeth": 65}, planets={"count": 3}))
    # 25/3 = 8 + 1/3; the ring's beside half a turn, since 20 planet teeth have a gap opposite a tooth
    assert phases(case)[:3] == pytest.approx([0.0, 2 / 3, 1 / 3])
    assert np.mod(phases(case)[3:] - 0.5, 1.0) == pytest.approx([0.0, 1 / 3, 2 / 3])


def test_a_set_of_the_literature() -> None:
    """17/37/91, N = 3, ring fixed, sun 800 rpm: frequencies, spacing of events, phases, contact ratios as published."""
    case = gp.load_case("planetary-reducer")
    found = set_frequencies(case, "stage")
    assert found.mesh == pytest.approx(190.98765432, rel=1e-6)
    assert found.sun == pytest.approx(33.70370370, rel=1e-6)
    assert found.planet == pytest.approx(5.16182849, rel=1e-6)
    assert found.carrier == pytest.approx(2.09876543, rel=1e-6)
    assert (1.0 / found.sun, 1.0 / found.planet) == pytest.approx((0.029670, 0.193730), abs=5e-7)
    # Position of the pattern of teeth at each planet, counter-clockwise, in pitches: z psi / (2 pi).
    assert np.mod(-phases(case)[:3], 1.0) == pytest.approx([0.0, 2 / 3, 1 / 3], abs=1e-6)
    ring = -(phases(case)[3:] - phases(case)[3])  # planets turn the other way beside the carrier
    assert np.mod(ring, 1.0) == pytest.approx([0.0, 1 / 3, 2 / 3], abs=1e-6)
    assert pair_of(case, 0).contact_ratio == pytest.approx(1.6064, abs=5e-5)
    assert pair_of(case, 3).contact_ratio == pytest.approx(1.9418, abs=5e-5)


def test_sun_and_ring_mesh_alike_at_every_planet() -> None:
    """A turn of the set by one planet is a shift in time by which sun and ring agree: also where N is even."""
    for sun, planet, count in ((20, 20, 4), (22, 25, 2), (60, 24, 6), (17, 37, 3)):
        case = gp.load_case(
            planetary_document(
                sun={"teeth": sun},
                planets={"teeth": planet, "count": count},
                ring={"teeth": sun + 2 * planet},
            )
        )
        speeds = dict(zip(case.rotors, nominal_speeds(case), strict=True))
        before, at_sun, at_ring = (
            speeds["stage.sun"] - speeds["stage.carrier"],
            phases(case)[:count],
            phases(case)[count:],
        )
        planets = speeds["stage.planet1"] - speeds["stage.carrier"]
        for k in range(count):
            shift = (
                2.0 * math.pi * (at_sun[k] - at_sun[0]) / (sun * before)
            )  # s, sun's mesh of planet k is ahead
            ring = planet * planets * shift / (2.0 * math.pi) + at_ring[0]
            assert np.mod(ring - at_ring[k] + 0.5, 1.0) == pytest.approx(0.5, abs=1e-6)


def test_meshes_elsewhere_than_along_x_start_at_their_own_phase() -> None:
    wheels = {"one": {"teeth": 21, **PART}, "two": {"teeth": 40, **PART}, "three": {"teeth": 30, **PART}}
    wheels["one"]["drive"] = {"kind": "speed", "speed": 10.0}
    mesh = {"driver": "one", "module": 2e-3, "backlash": 5e-5, "stiffness": {"kind": "harmonic", "mean": 1e8}}
    meshes = [{**mesh, "driven": "two"}, {**mesh, "driven": "three", "angle": "90 deg"}]
    document = {"rotors": wheels, "meshes": meshes, "run": {"duration": 1e-3}}
    case = gp.load_case(document)
    assert phases(case) == pytest.approx([0.0, np.mod(-21 / 4, 1.0)])
    old = gp.replace(case, {"mesh_phases": "from_zero"})
    assert phases(old) == pytest.approx([0.0, 0.0])
    assert old.sha256 != case.sha256
    assert phases(gp.replace(case, {"meshes.1.phase": "90 deg"})) == pytest.approx([0.0, 0.0])
    for name in ("han2021", "pinion-idler-ring", "two-stage-reducer", "external-pair"):
        assert not phases(gp.load_case(name)).any()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sun": {"teeth": 27}, "planets": {"teeth": 35, "count": 3}, "ring": {"teeth": 97}}, "27 + 97 = 124"),
        ({"planets": {"count": 8}, "support": None, "pin": SLEEVE}, "must leave neighbours apart"),
        ({"sun": {"teeth": 21}, "planets": {"teeth": 31}, "ring": {"teeth": 84}}, "must be 83, since the planets are"),
        ({"planets": {"count": 2, "angles": [0.0, 3.0]}}, "must be a whole number of steps of 360/(20 + 60)"),
        ({"planets": {"count": 2, "angles": [0.0]}}, "must have 2 items, one for each planet"),
        ({"support": None}, "planetary.stage.pin: is required, or support"),
        ({"pin": SLEEVE}, "must not be given together with support"),
        ({"stiffness": None}, "planetary.stage.sun_planet: is required, or stiffness"),
        ({"pin_errors": [{"planet": 5}]}, "must be at most 4, the number of planets"),
        ({"pin_errors": [{"planet": 1}, {"planet": 1}]}, "must not be named twice"),
        ({"ring": {"drive": {"kind": "torque", "torque": 1.0}}}, "must not be given for a member that is fixed"),
        ({"sun": {"sleeve": {**SLEEVE, "on": "stage.carrier"}}}, "members are held by the ground"),
    ],
)  # fmt: skip
def test_planetary_set__an_impossible_one_is_refused_with_its_reason(
    changes: dict[str, Any], words: str
) -> None:
    text = refusal(planetary_document(**changes))
    assert words in text
    assert "planetary.stage" in text
    assert all(
        line.startswith("planetary.stage.") for line in text.splitlines()
    )  # nothing that follows from it


def test_planet_positions__an_error_above_a_tenth_of_a_micrometre_is_refused_with_the_right_place() -> None:
    turn = 2.0 * math.pi * 30 / 80
    whole = gp.load_case(planetary_document(planets={"count": 2, "angles": [0.0, turn]}))
    radius = 0.5 * whole.planetary["stage"].module * (20 + whole.planetary["stage"].planets.teeth)
    gp.load_case(planetary_document(planets={"count": 2, "angles": [0.0, turn + 0.9e-7 / radius]}))
    text = refusal(planetary_document(planets={"count": 2, "angles": [0.0, turn + 1.5e-7 / radius]}))
    x, y = 1e3 * radius * math.cos(turn), 1e3 * radius * math.sin(turn)
    assert f"The nearest is 135 deg, its centre at [{x:.4f} mm, {y:.4f} mm]" in text


def test_names_with_dots_are_for_members_alone() -> None:
    document = planetary_document()
    document["rotors"] = {"other.sun": {"mass": 1.0, "inertia": 1.0}}
    assert "a dot is for members of planetary sets" in refusal(document)
    document["rotors"] = {"stage": {"mass": 1.0, "inertia": 1.0}}
    assert "must not be the name of a rotor too" in refusal(document)


@pytest.mark.parametrize("name", ["1st", "a b", "", "first.stage", "x" * 33])
def test_a_set_needs_a_name(name: str) -> None:
    document = planetary_document()
    document["planetary"] = {name: document["planetary"]["stage"]}
    assert "must be a letter followed by at most 31 letters" in refusal(document)


def test_stages_in_a_row() -> None:
    """The carrier of one set turns the sun of the next through a coupling: 4 x 4 = 16."""
    document = planetary_document()
    second = planetary_document()["planetary"]["stage"]
    second["sun"].pop("drive")
    document["planetary"]["second"] = second
    document["couplings"] = [{"between": ["stage.carrier", "second.sun"], "torsional_stiffness": 1e5}]
    case = gp.load_case(document)
    speeds = dict(zip(case.rotors, nominal_speeds(case), strict=True))
    assert speeds["second.carrier"] == pytest.approx(60.0 / 16.0)


def test_any_member_may_drive() -> None:
    turning = {"drive": {"kind": "speed", "speed": 30.0}}
    ring = gp.load_case(
        planetary_document(sun={"drive": None, "fixed": True}, ring={"fixed": False, **turning})
    )
    assert (ring.meshes[0].driver, ring.meshes[-1].driven) == ("stage.ring", "stage.sun")
    carrier = gp.load_case(planetary_document(sun={"drive": None}, carrier=turning))
    assert (carrier.meshes[0].driver, carrier.meshes[-1].driven) == ("stage.ring", "stage.sun")
    speeds = dict(zip(carrier.rotors, nominal_speeds(carrier), strict=True))
    assert speeds["stage.sun"] == pytest.approx(120.0)


@pytest.mark.parametrize(
    ("driven", "fixed"),
    [("sun", "ring"), ("ring", "sun"), ("carrier", "ring"), ("carrier", "sun"), ("sun", "carrier")],
)
def test_torques_turn_a_set_as_speeds_do(driven: str, fixed: str) -> None:
    """The same flanks drive whether the input has a speed or a torque; loads know which way to oppose."""
    loaded = next(member for member in ("carrier", "ring", "sun") if member not in (driven, fixed))

    def with_drive(drive: dict[str, Any]) -> Any:
        members: dict[str, Any] = {
            m: {"drive": None, "load": None, "fixed": False} for m in ("sun", "ring", "carrier")
        }
        members[fixed]["fixed"] = True
        members[loaded]["load"] = {"torque": 10.0}
        document = planetary_document(**members)
        document["planetary"]["stage"][driven]["drive"] = drive
        return pack(gp.load_case(document)).system

    by_speed, by_torque = (with_drive({"kind": kind, kind: 30.0}) for kind in ("speed", "torque"))
    assert by_torque.records[MESH]["sigma"].tolist() == by_speed.records[MESH]["sigma"].tolist()
    np.testing.assert_array_equal(
        np.where(by_speed.rotors["drive"] == 1, 0.0, np.sign(by_speed.rotors["torque"]))[
            by_speed.rotors["torque"] != 0.0
        ],
        np.sign(by_torque.rotors["torque"])[by_speed.rotors["torque"] != 0.0],
    )


def test_damping_beside_elastic_pins() -> None:
    plain, damped = (
        pack(gp.load_case(planetary_document(planets={"radial_damping": extra}))).system.records[4]
        for extra in (0.0, 300.0)
    )
    assert (damped["damping_x"] - plain["damping_x"]).tolist() == [300.0] * 4


@pytest.mark.parametrize(("planet", "shift"), [(20, math.pi), (21, 0.0)])
def test_pairs__have_their_phases_from_the_places_of_the_teeth(planet: int, shift: float) -> None:
    """The half pitch between both flanks of an even planet is of a mesh in one contact only."""
    teeth = {"sun": {"teeth": 60 - 2 * planet, "facewidth": 0.02}, "ring": {"facewidth": 0.02}}
    fields: dict[str, Any] = {**teeth, "planets": {"count": 2, "teeth": planet, "facewidth": 0.02}}
    tables = {"kind": "teeth", "method": "iso6336"}
    fields |= {"stiffness": None, "sun_planet": tables, "planet_ring": tables}
    one = gp.load_case(planetary_document(**fields))
    pairs = gp.load_case(planetary_document(**fields, contact="pairs", tip_contact=False))
    assert [mesh.phase for mesh in one.meshes] == [0.0, 0.0, shift, shift]
    assert [mesh.phase for mesh in pairs.meshes] == [0.0] * 4
    assert [(mesh.contact, mesh.tip_contact) for mesh in pairs.meshes] == [("pairs", False)] * 4


def test_pairs__of_a_planetary_set_share_the_load() -> None:
    """Perfect teeth and equal planets: the flanks of the sun carry a third of its torque each, in the mean."""
    wide = {"facewidth": 0.02, "tip_relief": {"amount": 5e-6, "length": 3e-3}}
    fields: dict[str, Any] = {"stiffness": None, "contact": "pairs", "damping": {"ratio": 0.1}}
    fields |= {"sun": {"teeth": 18, **wide}, "planets": {"count": 3, "teeth": 21, **wide}, "ring": wide}
    tables = {"kind": "teeth", "method": "iso6336"}
    case = gp.load_case(planetary_document(**fields, sun_planet=tables, planet_ring=tables))
    run = gp.simulate(case, duration=0.05, transient=0.05)
    ds = run.ds
    force = ds["drive_force"].sel(mesh=[f"stage.sun-stage.planet{k}" for k in (1, 2, 3)]).mean("time")
    base = pair_of(case, 0).first.base_radius
    torque = float(ds["load_torque"].sel(rotor="stage.carrier").mean("time"))
    each = abs(torque) / (1.0 + 60.0 / 18.0) / 3.0 / base
    np.testing.assert_allclose(force, each, rtol=0.02)
    assert not any(":drive-" in label for label in run.contacts.labels)
