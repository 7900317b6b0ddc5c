"""Gearboxes built for tests: trains, rings, couplings, planetary sets with more on their shafts, older names, notes."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

import gearplay as gp
from gearplay.rexs.importing import Imported, import_rexs
from gearplay.rexs.notes import Notes
from gearplay.rexs.writing import Table
from rexs.gearbox_files import RIGID, Box, pair, place, planetary


def said(found: Imported, *words: str) -> bool:
    """Return whether one note has all words."""
    return any(all(word in str(note) for word in words) for note in found.notes)


def train() -> tuple[Box, list[int]]:
    """Return motor, elastic coupling, pinion, layshaft with two gears, output."""
    box = Box()
    casing = box.add("gear_casing")
    motor = box.shaft("Motor", (0, 0), rotational_speed=(1500.0, "1 / min"), defines_speed=True)
    shafts = [
        motor,
        *(box.shaft(name, at) for name, at in (("Pinion", (0, 0)), ("Lay", (60, 0)), ("Out", (60, 90)))),
    ]
    box.hold(motor, shafts[1], "coupling", rotational_stiffness=(2e6, "N mm / rad"))
    box.stage(box.gear(shafts[1], 20), box.gear(shafts[2], 40), 60.0)
    box.stage(box.gear(shafts[2], 30), box.gear(shafts[3], 60), 90.0)
    for shaft in shafts:
        box.hold(shaft, casing, radial_stiffness=(3e8, "N / m"))
    box.add("external_load", "", motor, torque_around_u_axis=(10.0, "N m"))
    box.add("external_load", "", shafts[3], transmits_torque=True)
    return box, shafts


def test_a_train_with_a_coupling_and_two_gears_on_a_shaft(tmp_path: Path) -> None:
    found = import_rexs(train()[0].write(tmp_path))
    case = found.case
    assert list(case.rotors) == ["motor", "pinion", "lay", "out"]
    assert {name: gear.teeth for name, gear in case.rotors["lay"].gears.items()} == {
        "gear_40": 40,
        "gear_30": 30,
    }
    assert [mesh.label for mesh in case.meshes] == ["pinion-lay.gear_40", "lay.gear_30-out"]
    assert (case.couplings[0].between, case.couplings[0].torsional_stiffness) == (("motor", "pinion"), 2000.0)
    assert case.rotors["motor"].drive.speed == pytest.approx(50 * math.pi)
    assert case.rotors["out"].load.torque == pytest.approx(40.0)
    assert case.supports["lay"].stiffness == pytest.approx((3e8, 3e8))
    k, mass = 3e8, case.rotors["lay"].mass
    assert case.supports["lay"].damping == pytest.approx([2 * 0.05 * math.sqrt(k * mass)] * 2, rel=1e-3)
    assert gp.simulate(case, duration="5 ms", transient="0 s").success


def test_the_gear_nearer_to_the_drive_drives(tmp_path: Path) -> None:
    """A load that drives the last shaft turns every stage around."""
    box, shafts = train()
    for number, (kind, name, attributes) in box.components.items():
        if kind == "external_load" and "torque_around_u_axis" in attributes:
            box.components[number] = (kind, name, {"torque_around_u_axis": (-10.0, "N m")})
    case = import_rexs(box.write(tmp_path)).case
    assert [mesh.label for mesh in case.meshes] == ["lay.gear_40-pinion", "out-lay.gear_30"]
    assert case.rotors["out"].drive.speed == pytest.approx(50 * math.pi / 4)
    assert case.rotors["motor"].load.torque == pytest.approx(10.0)
    assert shafts


def test_solid_gear_bodies(tmp_path: Path) -> None:
    """A wheel of 80 mm and 20 mm width on a shaft of 40 mm."""
    box = pair()
    bare, solid = (import_rexs(box.write(tmp_path), gear_bodies=kind) for kind in ("none", "solid"))
    body = 7850 * math.pi / 4 * 0.02 * (0.08**2 - 0.04**2)
    assert solid.case.rotors["output"].mass - bare.case.rotors["output"].mass == pytest.approx(body, rel=1e-7)
    inertia = solid.case.rotors["output"].inertia - bare.case.rotors["output"].inertia
    assert inertia == pytest.approx(body * (0.08**2 + 0.04**2) / 8, rel=1e-7)
    assert said(bare, "left out", "bodies of the gears", "0.5919 kg")
    assert not said(solid, "bodies of the gears")


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_shift_of_a_ring_counts_away_from_its_axis(tmp_path: Path, sign: float) -> None:
    """ISO counts a ring's shift the other way; a file that does not is read by its centre distance."""
    box = Box()
    first, ring = box.shaft("in", (0, 0)), box.shaft("ring", (40, 0))
    box.stage(box.gear(first, 20, shift=0.2), box.gear(ring, 60, type="ring_gear", shift=sign * 0.2), 40.0)
    found = import_rexs(box.write(tmp_path))
    assert found.case.rotors["ring"].profile_shift == pytest.approx(0.2)
    assert said(found, "counted away from its axis") == (sign > 0)


def test_missing_shifts_follow_from_the_centre_distance(tmp_path: Path) -> None:
    """KHK's example: module 3 mm, 12/24 teeth at 56.5 mm, shifts 0.6 and 0.36."""
    box = Box()
    first, second = box.shaft("in", (0, 0)), box.shaft("out", (56.4998697, 0))
    box.stage(box.gear(first, 12, 3.0, shift=0.6), box.gear(second, 24, 3.0), 56.4998697)
    found = import_rexs(box.write(tmp_path))
    assert found.case.rotors["out"].profile_shift == pytest.approx(0.36, abs=1e-6)
    assert said(found, "assumed", "profile shift of", "0.36")


@pytest.mark.parametrize("version", ["1.0", "1.6"])
def test_names_of_all_versions(tmp_path: Path, version: str) -> None:
    old = version == "1.0"
    box = Box(version)
    first, second = box.shaft("in", (0, 0)), box.shaft("out", (60, 0))
    half = box.shaft("half", (0, 0), ((50.0, 30.0, 0.0),))
    series = (
        "din_3967_deviation_tolerance_series"
        if old
        else "tooth_thickness_deviation_tolerance_series_din_3967_1978"
    )
    field = (
        "din_3964_center_distance_tolerance_field" if old else "center_distance_tolerance_field_din_3964_1980"
    )
    gears = [box.gear(shaft, teeth, **{series: "cd25"}) for shaft, teeth in ((first, 20), (second, 40))]
    box.stage(*gears, 60.0, **{field: "7"})
    number = box.add("fixed_coupling" if old else "coupling", "", **({} if old else RIGID))
    sides = ("side_1", "side_2") if old else ("inner_part", "outer_part")
    box.relate("side", assembly=number, **dict(zip(sides, (first, half), strict=True)))
    case = import_rexs(box.write(tmp_path)).case
    assert {rotor.allowance for rotor in case.rotors.values()} == {"cd25"}
    assert case.meshes[0].center_distance_allowance == "js7"
    volume = math.pi / 4 * (0.1 * 0.04**2 + 0.05 * 0.03**2)
    assert next(iter(case.rotors.values())).mass == pytest.approx(7850 * volume, rel=1e-7)


def test_allowances_in_micrometres(tmp_path: Path) -> None:
    """Of the span, by the cosine of the pressure angle on the tooth thickness; of the centre distance as they are."""
    box = Box()
    first, second = box.shaft("a", (0, 0)), box.shaft("b", (60, 0))
    span = {
        "upper_backlash_allowance_referenced_to_span": (-80.0, "mum"),
        "lower_backlash_allowance_referenced_to_span": (-120.0, "mum"),
    }
    box.stage(
        box.gear(first, 20, **span), box.gear(second, 40, **span), 60.0,
        upper_center_distance_allowance=(20.0, "mum"), lower_center_distance_allowance=(-10.0, "mum"),
    )  # fmt: skip
    case = import_rexs(box.write(tmp_path)).case
    limits = case.rotors["a"].allowance
    assert (limits.upper, limits.lower) == pytest.approx(
        (-80e-6 / math.cos(math.radians(20)), -120e-6 / math.cos(math.radians(20)))
    )
    distance = case.meshes[0].center_distance_allowance
    assert (distance.upper, distance.lower) == pytest.approx((20e-6, -10e-6))


def test_a_shaft_that_is_carrier_and_has_a_gear(tmp_path: Path) -> None:
    """Two rotors with half of the mass, coupled by the shaft's twist; speeds by Willis and the teeth."""
    box = Box()
    casing = box.add("gear_casing")
    sun, _, carrier = planetary(box, casing)
    out = box.shaft("Out", (0, 150))
    box.stage(box.gear(carrier, 50, 3.0), box.gear(out, 50, 3.0), 150.0)
    box.hold(out, casing, radial_stiffness=(1e20, "N / m"))
    box.add("external_load", "", sun, torque_around_u_axis=(100.0, "N m"))
    box.add("external_load", "", out, transmits_torque=True)
    case = import_rexs(box.write(tmp_path)).case
    assert case.couplings[0].between == ("stage.carrier", "carrier")
    whole = 7850 * math.pi / 4 * (0.1 * 0.04**2 + 3 * 0.03 * 0.03**2)
    assert [case.rotors[name].mass for name in ("stage.carrier", "carrier")] == pytest.approx([whole / 2] * 2)
    assert case.supports["carrier"].stiffness == pytest.approx((5e8, 5e8))
    assert case.rotors["out"].load.torque == pytest.approx(100 * (1 + 60 / 18))
    twist = 80e9 * math.pi / 32 * 0.04**4 / 0.1
    assert case.couplings[0].torsional_stiffness == pytest.approx(twist, rel=1e-3)


def test_two_planetary_stages_in_a_row(tmp_path: Path) -> None:
    box = Box()
    casing = box.add("gear_casing")
    sun, _, carrier = planetary(box, casing)
    _, _, out = planetary(box, casing, sun=carrier)
    box.add("external_load", "", sun, torque_around_u_axis=(10.0, "N m"))
    box.add("external_load", "", out, transmits_torque=True)
    case = import_rexs(box.write(tmp_path)).case
    assert list(case.planetary) == ["stage1", "stage2"]
    assert case.couplings[0].between == ("stage1.carrier", "stage2.sun")
    assert case.planetary["stage2"].carrier.load.torque == pytest.approx(10 * (1 + 60 / 18) ** 2)
    assert case.planetary["stage1"].ring.mass == case.planetary["stage2"].ring.mass
    assert gp.simulate(case, duration="2 ms", transient="0 s").success


def test_a_coupling_that_is_not_engaged_joins_nothing(tmp_path: Path) -> None:
    box, shafts = train()
    box.hold(shafts[0], shafts[1], "switchable_coupling", **RIGID, is_engaged=([False], "none"))
    found = import_rexs(box.write(tmp_path))
    assert len(found.case.rotors) == 4
    assert said(found, "left out", "not engaged")


def test_positions_relative_to_another_component(tmp_path: Path) -> None:
    """A housing turned by 90 deg about u and moved."""
    box = Box()
    box.add("gear_unit", "", **place((0, 0)))
    turned = {"u_axis_vector": ([1, 0, 0], "mm"), "w_axis_vector": ([0, -1, 0], "mm")}
    part = box.add("assembly_group", "", support_vector=([5.0, 7.0, 9.0], "mm"), **turned)
    first, second = (
        box.shaft(name, at, reference_component_for_position=part)
        for name, at in (("a", (0, 0)), ("b", (60, 0)))
    )
    box.stage(box.gear(first, 20), box.gear(second, 40), 60.0)
    angle = import_rexs(box.write(tmp_path)).case.meshes[0].angle
    assert math.degrees(angle) == pytest.approx(90.0)


@pytest.mark.parametrize("turned", [0.0, 90.0, 200.0])
def test_places_without_positions_follow_rotating_angles(tmp_path: Path, turned: float) -> None:
    """From w about -u: what the public files say of positions and rotating angles."""
    box = Box()
    first, second = box.add("shaft", "a"), box.add("shaft", "b")
    box.stage(box.gear(first, 20), box.gear(second, 40), 60.0, rotating_angle_around_neg_u_axis=(turned, "°"))
    found = import_rexs(box.write(tmp_path))
    assert math.degrees(found.case.meshes[0].angle) == pytest.approx((90.0 - turned) % 360.0)
    assert said(found, "assumed", "no positions")
    assert said(found, "no mass in the file")


def test_power_instead_of_torque(tmp_path: Path) -> None:
    box = pair()
    for number, (kind, name, attributes) in box.components.items():
        if kind == "external_load" and "torque_around_u_axis" in attributes:
            box.components[number] = (kind, name, {"power": (10.0, "kW")})
    torque = import_rexs(box.write(tmp_path)).case.rotors["output"].load.torque
    assert torque == pytest.approx(10e3 / (1000 * math.pi / 30) * 2)


def test_whatever_is_not_read_is_listed(tmp_path: Path) -> None:
    box = pair()
    box.add("bevel_gear_tool", "cutter")
    box.add("tip_relief", "relief")
    kind, name, attributes = box.components[2]
    box.components[2] = (kind, name, {**attributes, "surface_roughness": (3.0, "mum")})
    found = import_rexs(box.write(tmp_path))
    assert said(found, "not read", "bevel_gear_tool (1)")
    assert said(found, "not read", "attributes of shaft", "surface_roughness")
    text = found.text
    assert "surface_roughness" in text


def test_a_field_that_the_schema_lacks_is_a_comment(tmp_path: Path) -> None:
    """The schema itself decides, when the file is written."""

    class Old(BaseModel):
        teeth: int

    notes, table = Notes(), Table("[rotors.a]", Old)
    table.add("teeth", 20)
    table.add("profile_shift", 0.3)
    lines = list(table.lines(notes))
    assert "teeth = 20" in lines
    assert "# profile_shift = 0.3  # not in this version" in lines
    assert ["profile_shift = 0.3: not in this version" in str(note) for note in notes.every] == [True]


def test_nominal_speeds_have_their_sense(tmp_path: Path) -> None:
    """An external pair turns against each other, a ring with its pinion."""
    assert "-500 rpm nominal" in import_rexs(pair().write(tmp_path)).text
    box = Box()
    first = box.shaft("in", (0, 0), rotational_speed=(900.0, "1 / min"))
    ring = box.shaft("ring", (40, 0))
    box.stage(box.gear(first, 20), box.gear(ring, 60, type="ring_gear"), 40.0)
    box.add("external_load", "", ring, torque_around_u_axis=(-3.0, "N m"))
    assert "# 300 rpm nominal" in import_rexs(box.write(tmp_path)).text


def test_speeds_in_both_senses(tmp_path: Path) -> None:
    """A shaft whose u axis points the other way turns the other way for the same speed."""
    box = pair()
    kind, name, attributes = box.components[2]
    speed = import_rexs(box.write(tmp_path)).case.rotors["input"].drive.speed
    turned = {**attributes, "u_axis_vector": ([-1, 0, 0], "mm")}
    box.components[2] = (kind, name, turned)
    box.add("gear_unit", "", **place((0, 0)))
    assert np.isclose(import_rexs(box.write(tmp_path)).case.rotors["input"].drive.speed, -speed)


def test_a_loop_of_stages_closes(tmp_path: Path) -> None:
    """Two layshafts between input and output, centre distances rounded to 0.01 mm."""
    box = Box()
    at = {"in": (0.0, 0.0), "left": (-48.0, 36.0), "right": (48.0, 36.0), "out": (0.0, 0.0)}
    shafts = {name: box.shaft(name, place_) for name, place_ in at.items()}
    first, last = box.gear(shafts["in"], 20), box.gear(shafts["out"], 20)
    for name in ("left", "right"):
        box.stage(first, box.gear(shafts[name], 40), 60.01)
        box.stage(box.gear(shafts[name], 40), last, 60.01)
    found = import_rexs(box.write(tmp_path))
    assert [mesh.center_distance for mesh in found.case.meshes] == pytest.approx([0.06] * 4)
    assert said(found, "assumed", "close a loop")


def test_torques_without_signs(tmp_path: Path) -> None:
    """Both ends positive, as programs write that give amounts: the shaft with the speed drives."""
    box = pair()
    number = max(n for n, (kind, _, _) in box.components.items() if kind == "external_load")
    kind, name, _ = box.components[number]
    box.components[number] = (kind, name, {"torque_around_u_axis": (-100.0, "N m")})
    found = import_rexs(box.write(tmp_path))
    assert found.case.rotors["input"].drive.kind == "speed"
    assert found.case.rotors["output"].load.torque == pytest.approx(100.0)
    assert said(found, "assumed", "every torque of the file drives")


def test_a_gear_without_an_allowance_beside_one_that_has_it_is_noted(tmp_path: Path) -> None:
    """The pair has backlash from the other gear, and no allowance is assumed: the note says that it counts as 0."""
    box = Box()
    first, second = box.shaft("a", (0, 0)), box.shaft("b", (60, 0))
    span = {
        "upper_backlash_allowance_referenced_to_span": (-80.0, "mum"),
        "lower_backlash_allowance_referenced_to_span": (-120.0, "mum"),
    }
    box.stage(box.gear(first, 20, **span), box.gear(second, 40), 60.0)
    found = import_rexs(box.write(tmp_path))
    assert found.case.rotors["b"].allowance is None
    assert said(found, "assumed", "no allowance of its tooth thickness", "of the other gear alone")
    assert not said(found, "both gears")


def test_allowances_of_a_set__the_ring_counts_as_none(tmp_path: Path) -> None:
    box = Box()
    casing = box.add("gear_casing")
    sun, _, carrier = planetary(box, casing)
    box.add("external_load", "", sun, torque_around_u_axis=(10.0, "N m"))
    box.add("external_load", "", carrier, transmits_torque=True)
    found = import_rexs(box.write(tmp_path))
    assert found.case.rotors["stage.ring"].allowance is None
    assert said(found, "both gears c25")
    assert sum("no allowance of its tooth thickness" in str(note) for note in found.notes) == 1
