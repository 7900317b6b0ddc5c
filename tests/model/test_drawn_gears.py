"""Gears as drawn in a case: centre distance, backlash, faults, findings, temperature, planetary sets."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.reading import to_toml
from gearplay.parts.mesh.check_pairs import pair_table
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.train import geometry
from gearplay.toothing.cracks import Crack, crack_tip

PART = {"mass": "1 kg", "inertia": "1e-3 kg m^2"}


def document(first: dict[str, Any], second: dict[str, Any], **mesh: Any) -> dict[str, Any]:
    """Return a pair of gears; the first turns at 60 rpm."""
    given = {
        "driver": "one",
        "driven": "two",
        "module": "4 mm",
        "stiffness": {"kind": "harmonic", "mean": "1e8 N/m"},
    }
    return {
        "rotors": {
            "one": {**PART, "drive": {"kind": "speed", "speed": "60 rpm"}, **first},
            "two": {**PART, "load": {"torque": "10 N m"}, **second},
        },
        "meshes": [{**given, **mesh}],
        "run": {"duration": "10 ms"},
    }  # fmt: skip


def pair(first: dict[str, Any], second: dict[str, Any], **mesh: Any) -> gp.Case:
    return gp.load_case(document(first, second, **mesh))


def row(case: gp.Case, j: int = 0) -> dict[str, Any]:
    return pair_table(case)[j]


def said(case: gp.Case, severity: str = "warning") -> str:
    return "\n".join(f"{f.path}: {f.message}" for f in gp.check_case(case) if f.severity == severity)


WIND = (
    {"teeth": 18, "profile_shift": 0.389, "tip_diameter": "432.838 mm"},
    {
        "teeth": 36,
        "profile_shift": 0.504,
        "tip_diameter": "815.668 mm",
    },
)


@pytest.mark.parametrize("placed", [True, False])
def test_a_shifted_pair_at_its_distance(
    placed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """18/36, m 21, at 584 mm by positions or by centre distance: contact ratio 1.3704, working angle 24.1695 deg."""
    first, second = WIND
    mesh: dict[str, Any] = {"module": "21 mm", "backlash": "300 um"}
    if placed:
        first, second = {**first, "position": [0, 0]}, {**second, "position": ["584 mm", 0]}
    else:
        mesh["center_distance"] = "584 mm"
    case = pair(first, second, **mesh)
    assert row(case)["contact_ratio"] == pytest.approx(1.370399731, abs=2e-9)
    assert math.degrees(row(case)["working_pressure_angle"]) == pytest.approx(24.1695, abs=5e-5)
    assert row(case)["center_distance"] == pytest.approx(0.584, rel=1e-12)
    assert row(case)["backlash"] == pytest.approx(300e-6, rel=1e-12)
    assert "working pressure angle 24.1695 deg at 584 mm" in said(case, "note")
    file = tmp_path / "case.toml"
    file.write_text(to_toml(case))
    assert gp.load_case(file) == case
    assert run(["check", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["pairs"][0]
    assert found["contact_ratio"] == row(case)["contact_ratio"]
    assert {"backlash", "mesh_frequency", "hunting_frequency"} < found.keys()


def test_positions_without_shift_keep_the_nominal_distance() -> None:
    """A pair off its reference distance: the backlash counts there, and the shifts that belong to the distance are said."""
    case = pair(
        {"teeth": 18, "position": [0, 0]},
        {"teeth": 36, "position": ["584 mm", 0]},
        module="21 mm",
        backlash="300 um",
    )
    assert geometry.working_distance(case, 0) == pytest.approx(0.567)
    assert row(case)["backlash"] > 0.01
    assert "the sum of both 0.8929: give them as profile_shift" in said(case)


def test_rounded_shifts_that_jam_are_found() -> None:
    """The wind gearbox's second stage without allowances: -1.88 um at its printed distance."""
    case = pair(*WIND, module="21 mm", center_distance="584 mm")
    assert 1e6 * row(case)["backlash"] == pytest.approx(-1.876, abs=1e-3)
    assert "the normal backlash is -1.876 um at the distance of the centres" in said(case)


def test_backlash_from_allowances_of_a_planetary_set() -> None:
    """17/22/61, m 4, a 78 js7, c25 of sun and planets: normal backlash [um] least, middle, largest of both kinds of mesh."""
    member = {"mass": "1 kg", "inertia": "1e-3 kg m^2"}
    case = gp.planetary(
        module="4 mm",
        center_distance="78 mm",
        center_distance_allowance="js7",
        stiffness={"kind": "harmonic", "mean": "3e8 N/m"},
        sun={"teeth": 17, "allowance": "c25", "drive": {"kind": "speed", "speed": "600 rpm"}, **member},
        planets={"count": 3, "teeth": 22, "allowance": "c25", **member},
        ring={"teeth": 61, "fixed": True, **member},
        carrier=member,
        pin={"radial_clearance": "10 um", "stiffness": "1e10 N/m^1.5"},
    )
    for j, values in ((0, (149.495, 197.335, 245.191)), (3, (69.606, 98.668, 127.715))):
        found = row(case, j)
        least, largest = found["backlash_range"]
        assert [1e6 * each for each in (least, found["backlash"], largest)] == pytest.approx(values, abs=6e-4)
    assert gp.load_case(case.resolved()) == case
    assert gp.simulate(case, duration=2e-3, transient=0.0).success


def test_planets_at_a_shifted_distance() -> None:
    """Ring teeth need not be sun + 2 planets where shifts make up for it; teeth that cannot reach are refused."""
    member = {"mass": "1 kg", "inertia": "1e-3 kg m^2"}
    fields: dict[str, Any] = {
        "module": "2 mm",
        "backlash": "50 um",
        "stiffness": {"kind": "harmonic", "mean": "3e8 N/m"},
        "sun": {"teeth": 18, "profile_shift": 0.3, "drive": {"kind": "speed", "speed": "60 rpm"}, **member},
        "planets": {"count": 3, "teeth": 20, "profile_shift": 0.3, **member},
        "ring": {"teeth": 60, "profile_shift": 0.1, "fixed": True, **member},
        "carrier": member,
        "pin": {"radial_clearance": "10 um", "stiffness": "1e10 N/m^1.5"},
    }
    case = gp.planetary(**fields)
    distance = geometry.installed_distance(case, 0)
    assert distance == pytest.approx(geometry.pair_of(case, 0).shifted_distance, rel=1e-12)
    assert distance > 38e-3
    assert geometry.installed_distance(case, 3) == pytest.approx(distance, rel=1e-12)
    assert row(case, 3)["backlash"] == pytest.approx(50e-6, rel=1e-9)
    with pytest.raises(gp.InputError, match="for planets to mesh with the ring"):
        gp.planetary(**{**fields, "ring": {**fields["ring"], "teeth": 66}})


def test_forms_of_backlash() -> None:
    """Length normal to the teeth, angle of the driven gear, arc of the working pitch circle, also of helical gears."""
    for beta in ("0 deg", "15 deg"):
        gears = {"teeth": 20, "helix_angle": beta}, {"teeth": 60, "helix_angle": beta}
        by_length = pair(*gears, backlash="100 um")
        transverse = geometry.installed_backlash(by_length, 0)
        drawn = geometry.pair_of(by_length, 0)
        assert transverse == pytest.approx(100e-6 / math.cos(drawn.first.base_helix), rel=1e-12)
        angle = transverse / drawn.second.base_radius
        arc = transverse / math.cos(drawn.working_angle)
        for form in (f"{math.degrees(angle) * 60.0!r} arcmin", {"angle": angle}, {"circumferential": arc}):
            case = pair(*gears, backlash=form)
            assert row(case)["backlash"] == pytest.approx(100e-6, rel=1e-9)
            assert gp.load_case(case.resolved()) == case


def test_contact_ratios_of_helical_gears__transverse_and_total() -> None:
    """The range over the clearances is of transverse and overlap ratio together, around their sum."""
    gear = {"helix_angle": "15 deg", "facewidth": "40 mm"}
    given = document({**gear, "teeth": 20}, {**gear, "teeth": 60}, backlash="100 um")
    given["sleeves"] = {"two": {"radial_clearance": "200 um", "stiffness": 1e9}}
    case = gp.load_case(given)
    found = re.search(
        r"transverse contact ratio (\S+), in total (\S+) to (\S+) within the clearances", said(case, "note")
    )
    assert found
    transverse, least, largest = map(float, found.groups())
    total = transverse + row(case)["overlap_ratio"]
    assert (least + largest) / 2.0 == pytest.approx(total, abs=2e-3)
    assert least < total < largest


def test_limits_of_a_centre_distance_move_its_middle() -> None:
    """A table or a list of both allowances: gears are placed at the middle, the backlash follows from there."""
    gears = {"teeth": 20, "allowance": ["-125 um", "-85 um"]}, {"teeth": 60}
    for limits in ({"upper": "60 um", "lower": "20 um"}, ["60 um", "20 um"], ["20 um", "60 um"]):
        case = pair(*gears, center_distance="160 mm", center_distance_allowance=limits)
        assert geometry.installed_distance(case, 0) == pytest.approx(0.16004, rel=1e-12)
        expected = geometry.pair_of(case, 0).at(0.16004).backlash
        assert row(case)["backlash"] == pytest.approx(expected, rel=1e-9)
        least, largest = row(case)["backlash_range"]
        assert least < row(case)["backlash"] < largest
    with pytest.raises(gp.InputError, match="center_distance_allowance"):
        pair(*gears, center_distance="160 mm", center_distance_allowance=["1 um", "2 um", "3 um"])


def test_the_simulated_backlash_is_that_of_the_drawing() -> None:
    """b_t at displaced centres of shifted and helical gears, external and internal: base pitch less both thicknesses."""
    rng = np.random.default_rng(5)
    for internal in (False, True):
        for beta in ("0 deg", "12 deg"):
            case = pair(
                {"teeth": 21, "profile_shift": 0.25, "helix_angle": beta, "allowance": "b26"},
                {
                    "teeth": 64,
                    "profile_shift": 0.4,
                    "helix_angle": beta,
                    "internal": internal,
                    "thickness": "5.2 mm" if internal else "7.2 mm",
                    "floating": True,
                    "initial": {"x": float(rng.uniform(-5e-5, 5e-5)), "y": float(rng.uniform(-5e-5, 5e-5))},
                },
            )
            result = gp.simulate(case, duration=1e-3, transient=0.0, sampling=1e4)
            distances = result.signal("center_distance", "one-two")
            drawn = geometry.pair_of(case, 0)
            expected = [drawn.at(float(each)).backlash for each in distances]
            assert result.signal("backlash", "one-two") == pytest.approx(expected, abs=1e-12)


def test_the_simulated_backlash_far_from_the_working_distance() -> None:
    """Positions 1.5 mm off the given centre distance: b_t follows the involutes beyond the reach of their series."""
    case = pair(
        {"teeth": 21, "profile_shift": 0.5, "position": [0, 0]},
        {"teeth": 64, "profile_shift": 0.4, "position": ["174.5 mm", 0]},
        center_distance="173 mm",
        backlash="50 um",
    )
    result = gp.simulate(case, duration=1e-3, transient=0.0, sampling=1e4)
    drawn = geometry.pair_of(case, 0)
    expected = 50e-6 + drawn.at(0.1745).backlash - drawn.at(0.173).backlash
    assert result.signal("backlash", "one-two")[0] == pytest.approx(expected, abs=1e-12)
    assert geometry.installed_backlash(case, 0) == pytest.approx(expected, abs=1e-12)


def test_the_default_drawing_changes_nothing() -> None:
    """Fields of full-depth spur teeth at the nominal distance written out: the same motion, bit for bit."""
    plain = pair({"teeth": 20}, {"teeth": 60}, backlash="100 um")
    written = pair(
        {"teeth": 20, "profile_shift": 0.0, "addendum": 1.0, "facewidth": "10 mm"},
        {"teeth": 60, "dedendum": 1.25},
        backlash="100 um",
        center_distance="160 mm",
    )
    one, other = (gp.simulate(each, duration=5e-3, transient=0.0) for each in (plain, written))
    assert np.array_equal(one.signal("theta", "two"), other.signal("theta", "two"))
    again = pair({"teeth": 20, "profile_shift": 0.0}, {"teeth": 60, "addendum": 1.0}, backlash="100 um")
    assert again.sha256 == plain.sha256


def test_expansion_of_drawn_gears() -> None:
    """All of one material: distance and backlash grow by its factor, the working angle stays."""
    doc = document(
        {"teeth": 20, "profile_shift": 0.3, "allowance": "c25", "material": {"expansion": "11.5e-6 1/K"}},
        {"teeth": 60, "profile_shift": 0.2, "allowance": "c25", "material": {"expansion": "11.5e-6 1/K"}},
        center_distance="161.9 mm",
    )
    doc["environment"] = {"temperature": "120 degC", "housing": {"expansion": "11.5e-6 1/K"}}
    case = gp.load_case(doc)
    hot, factor = case.operating, 1.0 + 11.5e-6 * 100.0
    assert geometry.installed_distance(hot, 0) == pytest.approx(0.1619 * factor, rel=1e-12)
    assert geometry.installed_backlash(hot, 0) == pytest.approx(
        geometry.installed_backlash(case, 0) * factor, rel=1e-9
    )
    assert geometry.installed_pair(hot, 0).working_angle == pytest.approx(
        geometry.installed_pair(case, 0).working_angle, rel=1e-12
    )
    assert gp.simulate(case, duration=2e-3, transient=0.0).success


def test_backlash_left_at_both_ends_of_the_temperatures() -> None:
    """Steel in aluminium: cold takes 2 sin(alpha_w) a (alpha_h - alpha_s) dT; a jam there is a warning."""
    steel = {"material": {"expansion": "11.5e-6 1/K"}, "allowance": "c25"}
    doc = document({"teeth": 20, **steel}, {"teeth": 60, **steel}, center_distance="160 mm")
    doc["environment"] = {
        "temperature": "20 degC",
        "housing": {"expansion": "23.1e-6 1/K"},
        "temperature_range": ["-40 degC", "85 degC"],
    }
    case = gp.load_case(doc)
    words = next(line for line in said(case, "note").splitlines() if "are left" in line)
    least, _ = row(case)["backlash_range"]
    cold = 2.0 * math.sin(math.radians(20.0)) * 0.16 * 11.6e-6 * 60.0
    found = float(words.split("are left ")[1].split(" um")[0]) * 1e-6
    assert found == pytest.approx(row(case)["backlash"] - cold, abs=0.3e-6)
    lowest = float(words.split("degC, ")[1].split(" um")[0]) * 1e-6
    assert lowest == pytest.approx(least - cold, abs=0.3e-6)
    doc["environment"]["temperature_range"] = ["-150 degC", "85 degC"]
    assert "it jams there" in said(gp.load_case(doc))
    doc["environment"]["temperature_range"] = ["85 degC", "-40 degC"]
    with pytest.raises(gp.InputError, match="must be the coldest and then the hottest"):
        gp.load_case(doc)


TEETH = {"kind": "teeth", "method": "iso6336"}
WIDE = {"teeth": 20, "facewidth": "10 mm"}, {"teeth": 60, "facewidth": "10 mm"}


def test_stiffness_from_the_teeth() -> None:
    """K of the case is c_gamma b at the load of the case: 2 pairs about the start of the path, the fourth root below 100 N/mm."""
    case = pair(*WIDE, backlash="100 um", stiffness={**TEETH, "line_load": "150 N/mm"})
    packed = pack_stiffness(case, 0)
    assert packed.average == pytest.approx(13.152570e9 * 0.01 * (0.75 * 1.6707764 + 0.25), rel=3e-5)
    assert packed.highest / packed.average == pytest.approx(1.2, rel=0.1)
    light = pack_stiffness(pair(*WIDE, backlash="100 um", stiffness=TEETH), 0).average
    line_load = 10.0 / 0.12 / 0.01  # F_t / b of 10 N m at a reference radius of 120 mm
    assert light / packed.average == pytest.approx((line_load / 1e5) ** 0.25, rel=1e-9)
    assert gp.simulate(case, duration=5e-3, transient=0.0).success


def test_light_loads__are_reported() -> None:
    """Note of the factor below 100 N/mm, of a case without load, none above."""
    light = pair(*WIDE, backlash="100 um", stiffness=TEETH)
    assert "at F_t/b = 8.333 N/mm the teeth have 0.537 of the stiffness" in said(light, "note")
    heavy = pair(*WIDE, backlash="100 um", stiffness={**TEETH, "line_load": "150 N/mm"})
    assert "of the stiffness above" not in said(heavy, "note")
    doc = document(*WIDE, backlash="100 um", stiffness=TEETH)
    del doc["rotors"]["two"]["load"]
    assert "the case has no load, so that the stiffness" in said(gp.load_case(doc), "note")


def test_planets_with_stiffness_from_the_teeth() -> None:
    """K of both kinds of mesh from the drawing; planets on the path in turn; a facewidth that lacks is named in its table."""
    member = {"mass": "1 kg", "inertia": "1e-3 kg m^2"}
    fields: dict[str, Any] = {
        "module": "4 mm",
        "backlash": "100 um",
        "stiffness": {"kind": "teeth", "method": "iso6336"},
        "sun": {"teeth": 17, "facewidth": "30 mm", "drive": {"kind": "speed", "speed": "600 rpm"}, **member},
        "planets": {"count": 3, "teeth": 22, "facewidth": "30 mm", **member},
        "ring": {"teeth": 61, "facewidth": "30 mm", "fixed": True, **member},
        "carrier": {**member, "load": {"torque": "300 N m"}},
        "pin": {"radial_clearance": "10 um", "stiffness": "1e10 N/m^1.5"},
    }
    case = gp.planetary(**fields)
    sun, ring = (pack_stiffness(case, j).average for j in (0, 3))
    assert ring > sun > 1e8
    assert gp.simulate(case, duration=2e-3, transient=0.0).success
    del fields["planets"]["facewidth"]
    with pytest.raises(gp.InputError, match=r"planetary\.stage\.planets\.facewidth: is required") as caught:
        gp.planetary(**fields)
    assert len(caught.value.faults) == 1


def test_stiffness_runs_the_way_of_the_contact() -> None:
    """The phase of entering pairs is that of the contact: K backwards for a driver that turns the other way, or is the second."""
    given = {**TEETH, "line_load": "150 N/mm"}
    gears = {"teeth": 14, "profile_shift": 0.4, "facewidth": "10 mm"}, {"teeth": 60, "facewidth": "10 mm"}
    psi = np.linspace(0.0, 2.0 * math.pi, 1001)
    forth = pack_stiffness(pair(*gears, backlash="100 um", stiffness=given), 0).at(psi)
    doc = document(*gears, backlash="100 um", stiffness=given)
    doc["rotors"]["one"]["drive"]["speed"] = "-60 rpm"
    back = pack_stiffness(gp.load_case(doc), 0).at(psi)
    assert back == pytest.approx(forth[::-1], rel=1e-9)
    assert np.max(np.abs(forth - back)) > 0.1 * forth.mean()
    shifted = pair(*gears, backlash="100 um", stiffness=given, friction_phase="90 deg")
    assert pack_stiffness(shifted, 0).at(psi - 0.5 * math.pi) == pytest.approx(
        forth, rel=1e-6, abs=1e-3 * forth.mean()
    )


@pytest.mark.parametrize(
    ("first", "second", "mesh", "words"),
    [
        ({}, {}, {}, "meshes.0.backlash: is required"),
        ({"helix_angle": "10 deg"}, {}, {"backlash": "0.1 mm"}, 'rotors.two.helix_angle = "0 deg": must be that of one, 10 deg'),
        ({"tip_diameter": "1 mm"}, {}, {"backlash": "0.1 mm"}, "must give a tip diameter of more than 70 mm"),
        ({"tip_diameter": "88 mm", "addendum": 1.1}, {}, {"backlash": "0.1 mm"}, "must not be given together with"),
        ({"thickness": "6 mm", "allowance": "c25"}, {}, {}, 'allowance = "c25": must not be given together with thickness'),
        ({"allowance": "c31"}, {}, {}, 'allowance = "c31": must be a class of DIN 3967'),
        ({"allowance": {"upper": "-90 um", "lower": "-85 um"}}, {}, {}, 'allowance.lower = "-85 um": must be at most upper'),
        ({"profile_shift": -1.2}, {"profile_shift": -1.2}, {"backlash": "0.1 mm"}, "no centre distance without backlash"),
        ({}, {}, {"center_distance": "150 mm", "backlash": "0.1 mm"}, "must be between 159 and 168 mm for these teeth"),
        ({"addendum": 1.3}, {}, {"backlash": "0.1 mm"}, "a clearance at their centre distance, 160 mm"),
        ({"addendum": 0.1}, {"addendum": 0.1, "tip_diameter": "2.3 m"}, {"backlash": "0.1 mm"}, "given together with"),
        (
            {"profile_shift": 0.5, "position": [0, 0]},
            {"position": ["150 mm", 0]},
            {"backlash": "0.1 mm"},
            "rotors.two.position = \"150 mm\": must be between 161 and 170 mm for these teeth to mesh",
        ),
        ({}, {}, {"center_distance_allowance": "js7", "backlash": "0.1 mm"}, "must not be given without center_distance"),
        ({}, {}, {"center_distance": "160 mm", "center_distance_allowance": "h7"}, "must be a class of DIN 3964"),
        ({}, {}, {"backlash": {"angle": 0.1, "circumferential": 1e-4}}, "must have one of angle and circumferential"),
        ({}, {}, {"backlash": "0.1 mm", "stiffness": TEETH}, "rotors.one.facewidth: is required by stiffness kind"),
        (
            {"facewidth": 0.01},
            {"facewidth": 0.01, "bore": 0.06},
            {"backlash": "0.1 mm", "stiffness": {"kind": "teeth", "method": "potential-energy"}},
            "rotors.one.bore: is required by potential-energy",
        ),
        ({"tip_radius": 0.6}, {}, {"backlash": "0.1 mm"}, "tip_radius = 0.6: must be at most 0.4719 modules"),
        ({"bore": "71 mm"}, {}, {"backlash": "0.1 mm"}, "must be less than the root diameter, 70 mm"),
        ({}, {}, {"backlash": "0.1 mm", "contact": "pairs"}, 'meshes.0.stiffness.kind = "harmonic": must be "teeth"'),
        (
            {"facewidth": 0.01, "deviations": {"pitch": [1e-6, 2e-6]}},
            {"facewidth": 0.01},
            {"backlash": "0.1 mm", "contact": "pairs", "stiffness": TEETH},
            'rotors.one.deviations.pitch = "2 items": must have one item for each of the 20 teeth',
        ),
    ],
)  # fmt: skip
def test_drawn_gears__impossible_ones_are_refused(
    first: dict[str, Any], second: dict[str, Any], mesh: dict[str, Any], words: str
) -> None:
    with pytest.raises(gp.InputError) as caught:
        pair({"teeth": 20, **first}, {"teeth": 60, **second}, **mesh)
    assert words in str(caught.value)


def test_faults_of_teeth__in_a_mesh_without_pairs_are_refused() -> None:
    """Also where the mesh has no field of a drawing: a fault without effect would be taken for a sound gear."""
    fault = {"kind": "chip", "at": "one", "tooth": 2, "share": 0.5}
    plain = document({"teeth": 20}, {"teeth": 60}, backlash="0.1 mm")
    with pytest.raises(
        gp.InputError, match=r'faults\.0\.kind = "chip": must be in meshes with contact = "pairs"'
    ):
        gp.load_case(plain | {"faults": [fault]})
    eccentric = {"kind": "eccentricity", "at": "one", "amount": "20 um"}
    assert gp.load_case(plain | {"faults": [eccentric]}).faults


def test_cracks__end_at_the_middle_of_the_tooth() -> None:
    """The crack begins at a half thickness s of its tooth and may be s / sin(angle) long; along the tooth it has no end here."""
    wide = {"facewidth": "20 mm"}
    case = document(
        {"teeth": 20, **wide}, {"teeth": 60, **wide}, backlash="0.1 mm", contact="pairs", stiffness=TEETH
    )
    drawn = geometry.pair_of(gp.load_case(case), 0).first
    half = crack_tip(drawn, Crack(0.0, 0.0))[0]
    assert 0.6 * drawn.module < half < 1.2 * drawn.module
    for angle in (30.0, 60.0, 90.0):
        most = half / math.sin(math.radians(angle))
        fault = {"kind": "crack", "at": "one", "angle": f"{angle} deg"}
        assert gp.load_case(case | {"faults": [{**fault, "depth": 0.999 * most}]}).faults
        with pytest.raises(
            gp.InputError, match=rf"faults\.0\.depth = .* must be at most {1e3 * most:.4g} mm"
        ):
            gp.load_case(case | {"faults": [{**fault, "depth": 1.001 * most}]})
    assert gp.load_case(
        case | {"faults": [{"kind": "crack", "at": "one", "angle": 0.0, "depth": "5 mm"}]}
    ).faults


def test_findings_of_a_gear_designer() -> None:
    """Undercut that a shift heals, pointed teeth, tips at the roots, the ring's tip of the article."""
    assert "or with a profile shift of 0.298" in said(pair({"teeth": 12}, {"teeth": 40}, backlash="0.1 mm"))
    healed = pair({"teeth": 12, "profile_shift": 0.3}, {"teeth": 40}, backlash="0.1 mm")
    assert "undercut" not in said(healed)
    pointed = pair({"teeth": 12, "profile_shift": 0.9}, {"teeth": 40}, backlash="0.1 mm")
    assert "with a profile shift of 0.9 are pointed" in said(pointed)
    near = pair({"teeth": 20, "tip_diameter": "89.5 mm"}, {"teeth": 60}, backlash="0.1 mm")
    assert "0.250 mm are left between the tips of one and the roots of two" in said(near)
    words = said(gp.load_case("han2021"), "note")
    assert "the tip of ring stands 0.150 mm inside the base tangent point of pinion" in words
    assert "clean from a tip diameter of 232.0705 mm" in words
    clean = gp.replace(gp.load_case("han2021"), {"rotors.ring.tip_diameter": "232.0705 mm"})
    assert "stands" not in said(clean, "note")


def test_contact_ratio_over_the_clearances() -> None:
    """Apart by both clearances a pair of short teeth loses contact between two pairs."""
    doc = document({"teeth": 20, "addendum": 0.6}, {"teeth": 60, "addendum": 0.6}, backlash="1 mm")
    assert "contact ratio" not in said(gp.load_case(doc))
    doc["sleeves"] = {
        name: {"radial_clearance": "400 um", "stiffness": "1e10 N/m^1.5"} for name in ("one", "two")
    }
    assert "with the centres as far apart as the clearances allow" in said(gp.load_case(doc))
