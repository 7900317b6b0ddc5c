"""Findings at temperatures: a verdict on jamming, equal meshes once, the parts on which a backlash depends."""

import re
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding
from planetary_sets import planetary_document

STEEL, ALUMINIUM = 11.5e-6, 23.1e-6
PIN = {"radial_clearance": 8e-6, "shaft_radius": 4e-3, "stiffness": 1e10}


def cold_set(count: int = 4, *, carrier: float = ALUMINIUM, **environment: Any) -> gp.Case:
    """Return a set of steel whose carrier has another expansion, at -60 degC."""
    document = planetary_document(support=None, pin=PIN)
    stage = document["planetary"]["stage"]
    stage["planets"]["count"] = count
    for name in ("sun", "ring", "carrier", "planets"):
        stage[name]["material"] = {"expansion": carrier if name == "carrier" else STEEL}
    document["environment"] = {"temperature": "-60 degC", "housing": {"expansion": ALUMINIUM}, **environment}
    return gp.load_case(document)


def cold_pair(housing: float = ALUMINIUM, **environment: Any) -> gp.Case:
    """Return a pair of steel, 80 mm apart, in a housing of another expansion, at -60 degC."""
    gear = {"mass": 0.5, "inertia": 2e-4, "teeth": 40, "material": {"expansion": STEEL}}
    driven = {**gear, "load": {"torque": 1.0}}
    mesh = {"driver": "one", "driven": "two", "module": "2 mm", "backlash": "90 um"}
    return gp.load_case(
        {
            "rotors": {"one": {**gear, "drive": {"kind": "speed", "speed": 20.0}}, "two": driven},
            "meshes": [mesh | {"stiffness": {"kind": "harmonic", "mean": 1e8, "amplitude": 0.0}}],
            "environment": {"temperature": "-60 degC", "housing": {"expansion": housing}} | environment,
            "run": {"duration": 0.01, "transient": 0.01, "sampling": 1e4},
        }
    )


def verdict(case: gp.Case) -> Finding:
    found = [each for each in gp.check_case(case) if each.path == "environment"]
    assert len(found) == 1
    return found[0]


def test_verdict_has_the_least_backlash_with_its_temperature_and_mesh() -> None:
    """Of gears of steel in aluminium it is the coldest; 2 sin(alpha) A (a_h - a_s) dT less, about 50 um here."""
    case = cold_pair(temperature_range=["-80 degC", "60 degC"])
    said = verdict(case)
    assert "does not jam over -80 degC to 60 degC" in said.message
    least = geometry.installed_backlash(case.at_temperature(193.15), 0)
    assert f"is {1e6 * least:.4g} um, of one-two at -80 degC" in said.message
    assert gp.check_case(case)[-1] == said
    jams = verdict(cold_pair(temperature_range=["-190 degC", "60 degC"]))
    assert jams.message.startswith("jams at -190 degC: the least normal backlash is -")


def test_verdict_is_of_the_case_s_temperature_too() -> None:
    assert verdict(cold_pair()).message.startswith("does not jam at -60 degC: ")
    assert verdict(cold_pair(temperature="-200 degC")).message.startswith("jams at -200 degC: ")
    at_reference = cold_pair(temperature="20 degC")
    assert not [each for each in gp.check_case(at_reference) if each.path == "environment"]


def test_runouts_count_in_the_verdict_as_in_the_motion() -> None:
    """Both gears have 40 teeth and point at each other once a turn: the least backlash of the motion is that of the verdict."""
    runouts = {
        f"rotors.{name}.runout": {"amplitude": 20e-6, "phase": phase}
        for name, phase in (("one", 0.0), ("two", np.pi))
    }
    turn = 2.0 * np.pi / 20.0
    case = gp.replace(cold_pair(), runouts | {"run.duration": 1.05 * turn, "run.transient": 0.0})
    least = float(gp.simulate(case).ds["backlash"].min())
    assert least < 90e-6 - 2.0 * 20e-6  # the cold takes more
    assert f"the least normal backlash is {1e6 * least:.3g}" in verdict(case).message
    assert "by its runouts" in verdict(case).message
    deep = gp.replace(case, {"meshes.0.backlash": "60 um"})
    assert verdict(deep).message.startswith("jams at -60 degC")
    assert any("the runouts of its gears take up to" in each.message for each in gp.check_case(deep))


def test_a_clearance_that_closes_the_backlash_is_said() -> None:
    case = gp.replace(
        cold_pair(),
        {"sleeves.two": {"radial_clearance": "100 um", "shaft_radius": "10 mm", "stiffness": 1e9}},
    )
    assert geometry.jam_ratio(case.operating, 0) > 1.0
    assert "Within the clearances of its bearings one-two can jam at -60 degC" in verdict(case).message


def test_a_journal_that_seizes_at_an_end_of_the_range__is_a_warning_with_its_temperature() -> None:
    """The clearance there is (R + c) f_housing - R f_steel; the other end keeps its backlash and its verdict."""
    sleeve = {"radial_clearance": "5 um", "shaft_radius": "10 mm", "stiffness": 1e9}
    found = gp.check_case(
        gp.replace(
            cold_pair(temperature="20 degC", temperature_range=["-80 degC", "60 degC"]),
            {"sleeves.two": sleeve},
        )
    )
    left = 1e6 * (0.010005 * (1.0 - 100.0 * ALUMINIUM) - 0.01 * (1.0 - 100.0 * STEEL))
    (seized,) = (
        each for each in found if each.path == "sleeves.two.radial_clearance" and each.severity == "warning"
    )
    assert seized.message.startswith(
        f"at -80 degC it is {left:.4g} um: the journal no longer fits its bush. Raise it"
    )
    (backlash,) = (each for each in found if "are left" in each.message)
    assert "-80 degC" not in backlash.message
    assert "at 60 degC" in backlash.message
    assert "over 20 degC to 60 degC" in found[-1].message


def test_more_planets_make_no_more_lines() -> None:
    """Equal planets are one line: the number of findings does not depend on their number, and no line is there twice."""
    few, many = (
        gp.check_case(cold_set(count, temperature_range=["-60 degC", "80 degC"])) for count in (1, 5)
    )
    assert [each.path for each in few] == [each.path for each in many]
    assert sum("are left" in each.message for each in many) == 2
    assert sum("beyond its gears" in each.message for each in many) == 2
    assert sum(each.path == "planetary.stage.pin.radial_clearance" for each in many) == 1


@pytest.mark.parametrize("expansion", [STEEL, ALUMINIUM])
def test_no_change_has_no_sign(expansion: float) -> None:
    case = cold_set(carrier=expansion)
    for each in gp.check_case(case):
        assert not re.search(r"-0(\.0+)? (um|degC)", each.message), each


@pytest.mark.parametrize(("case", "follows"), [(cold_pair(), True), (cold_set(), False)], ids=["pair", "set"])
def test_housing_is_said_to_have_no_effect_where_it_has_none(case: gp.Case, follows: bool) -> None:
    other = gp.replace(case, {"environment.housing.expansion": 50e-6})
    here, there = (geometry.installed_backlash(each.operating, 0) for each in (case, other))
    assert (abs(here - there) > 1e-6) is follows
    assert ("housing has no effect" not in verdict(case).message) is follows
