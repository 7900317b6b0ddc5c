"""Temperature: expansion in closed form, a motion at temperature against the same one with its lengths written out."""

import math
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured, case_of, simulate_one
from gearplay.model.check import check_case
from gearplay.parts.mesh.train import geometry
from gearplay.vocabulary.errors import InputError

ALUMINIUM, STEEL = 23.1e-6, 11.5e-6  # 1/K
A, ALPHA, BACKLASH = 0.080, math.radians(20.0), 100e-6


def pair(*, warmer: float = 100.0, steel: float = STEEL, sleeve: bool = True, **environment: Any) -> Document:
    """Return an external pair of steel, A = 80 mm, in an aluminium housing, ``warmer`` [K] than 20 degC."""
    wheel = {"mass": 0.5, "inertia": 2e-4, "teeth": 40, "material": {"expansion": steel}}
    document: Document = {
        "rotors": {
            "one": {**wheel, "drive": {"kind": "speed", "speed": 20.0}},
            "two": {**wheel, "load": {"torque": 1.0}, "radial_damping": 20.0},
        },
        "meshes": [
            {
                "driver": "one",
                "driven": "two",
                "module": "2 mm",
                "backlash": BACKLASH,
                "stiffness": {"kind": "harmonic", "mean": 1e8, "amplitude": 1e7},
                "transmission_error": [{"order": 1, "amplitude": 2e-6}],
            }
        ],
        "environment": {
            "temperature": f"{20.0 + warmer:g} degC",
            "housing": {"expansion": ALUMINIUM},
            **environment,
        },
        "run": {"duration": 5e-3, "sampling": 2e4, "tolerance": 1e-10},
    }
    if sleeve:
        document["sleeves"] = {
            "two": {"radial_clearance": 50e-6, "shaft_radius": "10 mm", "stiffness": "1e9 N/m^1.5"}
        }
    return document


def test_the_contract_s_example(measured: Measured) -> None:
    """Aluminium housing, steel gears, +100 K: the centre distance leaves the gears by 92.8 um, the clearance of a journal of
    10 mm grows by 11.6 um. The backlash grows by the printed 63.5 um to first order, 2 sin(alpha) dA; the involute makes it 63.8.
    """
    case = case_of(pair())
    hot = case.operating
    distance = math.dist(*geometry.centres(hot).values())
    beyond = distance - geometry.working_distance(hot, 0)
    assert distance - A == pytest.approx(A * ALUMINIUM * 100.0, abs=1e-12)
    assert beyond == pytest.approx(92.8e-6, abs=1e-9)
    # The bush is wider than the journal by the clearance, and grows as itself.
    clearance = hot.sleeves["two"].radial_clearance - 50e-6
    assert clearance - 50e-6 * ALUMINIUM * 100.0 == pytest.approx(11.6e-6, abs=1e-9)
    first = 2.0 * math.sin(ALPHA) * beyond
    assert first == pytest.approx(63.5e-6, abs=0.05e-6)
    # Exactly: from the involute of the working angle, and from the mean of both angles.
    working = math.acos(math.cos(ALPHA) * (A * (1.0 + STEEL * 100.0)) / distance)
    exact = 2.0 * beyond * math.sin(0.5 * (ALPHA + working))
    grown = geometry.installed_backlash(hot, 0) - BACKLASH * (1.0 + STEEL * 100.0)
    measured("backlash at temperature, from first order [m]", abs(grown - first), "3e-7")
    assert grown == pytest.approx(exact, abs=1e-9)
    assert abs(grown - first) < 3e-7


def test_a_motion_at_temperature_is_that_of_the_written_lengths() -> None:
    """The same file with module, positions, backlash and clearance as they are at temperature moves alike, bit for bit."""
    hot = pair()
    written = pair()
    del written["environment"]
    f, h = 1.0 + STEEL * 100.0, 1.0 + ALUMINIUM * 100.0
    written["meshes"][0] |= {"module": 2e-3 * f, "backlash": BACKLASH * f}
    written["rotors"]["one"]["position"], written["rotors"]["two"]["position"] = [0.0, 0.0], [A * h, 0.0]
    sleeve = written["sleeves"]["two"]
    sleeve |= {"radial_clearance": (0.01 + 50e-6) * h - 0.01 * f, "shaft_radius": 0.01 * f}
    one, other = simulate_one(hot), simulate_one(written)
    for name in ("x", "y", "theta", "omega"):
        assert np.max(np.abs(one.signal(name, "two") - other.signal(name, "two"))) < 1e-13


def test_alike_materials_keep_the_angle_and_the_play() -> None:
    """All of one material: everything grows by one factor, no working angle changes."""
    case = case_of(pair(steel=ALUMINIUM)).operating
    factor = 1.0 + ALUMINIUM * 100.0
    assert geometry.installed_backlash(case, 0) == pytest.approx(BACKLASH * factor, rel=1e-12)
    assert case.sleeves["two"].radial_clearance == pytest.approx(50e-6 * factor, rel=1e-9)


def test_a_planet_s_pin_moves_with_its_carrier() -> None:
    """The carrier expands by its own material, and its bush too."""
    document = pair(sleeve=False)
    arm = {"mass": 1.0, "inertia": 1e-2, "material": {"expansion": 15e-6}, "position": [0.0, 0.0]}
    document["rotors"]["arm"] = arm
    document["rotors"]["two"]["load"] = {}
    document["sleeves"] = {"two": {**sleeve_of(5e-5), "on": "arm"}}
    hot = case_of(document).operating
    centres = geometry.centres(hot)
    assert centres["two"][0] - centres["arm"][0] == pytest.approx(A * (1.0 + 15e-4), rel=1e-12)
    clearance = (0.01 + 5e-5) * (1.0 + 15e-4) - 0.01 * (1.0 + STEEL * 100.0)
    assert hot.sleeves["two"].radial_clearance == pytest.approx(clearance, rel=1e-9)


@pytest.mark.parametrize(("side", "grown"), [("bush", 1.0), ("journal", -1.0)])
def test_clearance_of_a_pin__grows_in_the_cold_where_the_planet_is_the_bush(side: str, grown: float) -> None:
    """An aluminium carrier shrinks more than planets of steel, and its pins with it: a planet is the bush if nothing is said."""
    radius, clearance, cold = 5e-3, 10e-6, -80.0
    case = gp.load_case("planetary-reducer")
    (name,) = case.planetary
    assert case.sleeves[f"{name}.planet1"].rotor_side == "bush"
    changes: dict[str, Any] = {
        "environment": {"temperature": 293.15 + cold, "housing": {"expansion": ALUMINIUM}},
        f"planetary.{name}.pin.shaft_radius": radius,
        f"planetary.{name}.pin.radial_clearance": clearance,
        f"planetary.{name}.pin.rotor_side": side,
        f"planetary.{name}.carrier.material": {"expansion": ALUMINIUM},
    }
    for member in ("sun", "planets", "ring"):
        changes[f"planetary.{name}.{member}.material"] = {"expansion": STEEL}
    hot = gp.replace(case, changes).operating.sleeves[f"{name}.planet1"]
    factors = {"planet": 1.0 + STEEL * cold, "pin": 1.0 + ALUMINIUM * cold}
    bush, journal = (factors["planet"], factors["pin"])[:: round(grown)]
    assert hot.radial_clearance == pytest.approx((radius + clearance) * bush - radius * journal, rel=1e-9)
    assert (hot.radial_clearance - clearance) * grown > 4e-6  # m


@pytest.mark.parametrize("warmer", [0.0, None])
def test_at_the_reference_nothing_changes(warmer: float | None) -> None:
    """Numbers of a case at its reference temperature are those of one without an environment."""
    document = pair(warmer=warmer or 0.0)
    if warmer is None:
        document["environment"] |= {"temperature": "90 degC", "reference_temperature": "363.15 K"}
    case = case_of(document)
    assert case.operating is case
    plain = pair()
    del plain["environment"]
    assert np.array_equal(simulate_one(document).values, simulate_one(plain).values)


def test_cold_closes_the_backlash_and_the_pair_can_jam() -> None:
    """Steel gears in aluminium shrink together: the backlash falls in proportion, the jam ratio rises over 1, check warns."""
    case = case_of(pair(sleeve=False) | {"sleeves": {"two": sleeve_of(9e-5)}})
    left, ratios = [], []
    for degrees in (20.0, -20.0, -60.0, -100.0):
        cold = gp.replace(case, {"environment.temperature": f"{degrees} degC"})
        left.append(geometry.installed_backlash(cold.operating, 0))
        ratios.append(geometry.jam_ratio(cold.operating, 0))
    assert left == sorted(left, reverse=True)
    assert left[3] < 30e-6
    assert ratios[0] < 1.0 < ratios[3]
    paths = [finding.path for finding in check_case(cold) if finding.severity == "warning"]
    assert "meshes.0.backlash" in paths


def sleeve_of(clearance: float) -> Document:
    """Return a sleeve."""
    return {"radial_clearance": clearance, "shaft_radius": "10 mm", "stiffness": "1e9 N/m^1.5"}


def test_check_tells_each_length_at_temperature() -> None:
    words = {finding.path: finding.message for finding in check_case(case_of(pair()))}
    assert "+92.8 um beyond its gears" in words["meshes.0"]
    assert "+63.5 um)" in words["meshes.0"]
    assert "+11.7 um" in words["sleeves.two.radial_clearance"]


def test_uncoupled_backlash__follows_the_temperature() -> None:
    """It does not follow the run-out, but it does follow the housing."""
    document = pair() | {"backlash_model": "uncoupled"}
    shown = simulate_one(document).signal("backlash", "one-two")
    assert shown == pytest.approx(BACKLASH * (1.0 + STEEL * 100.0) + 63.75e-6, abs=0.1e-6)
    assert simulate_one(pair()).signal("backlash", "one-two")[0] == pytest.approx(shown[0], abs=0.1e-6)


def test_expansion__is_required_of_parts_at_a_temperature() -> None:
    document = pair()
    del document["rotors"]["two"]["material"]
    with pytest.raises(InputError, match=r"rotors\.two\.material.*is required at 120 degC"):
        gp.simulate(case_of(document))
    document = pair()
    del document["sleeves"]["two"]["shaft_radius"]
    with pytest.raises(InputError, match=r"shaft_radius.*is required"):
        gp.simulate(case_of(document))


def test_seized_journal__is_reported() -> None:
    document = pair(warmer=-100.0)
    document["sleeves"]["two"] = sleeve_of(5e-6)
    with pytest.raises(InputError, match="no longer fits its bush"):
        gp.simulate(case_of(document))


def test_a_sweep_over_temperature_runs() -> None:
    found = gp.sweep(
        case_of(pair()),
        {"environment.temperature": ["-20 degC", "20 degC", "120 degC"]},
        set={"run.duration": 5e-3},
        reduce=[{"kind": "statistic", "name": "rms", "signal": "ax", "at": "two"}],
    )
    assert found.ds.sizes["temperature"] == 3
    assert np.all(np.isfinite(found.ds.rms.values))
    assert found.ds.temperature.values == pytest.approx([253.15, 293.15, 393.15])


def test_the_bundled_plan_closes_the_backlash_and_crosses_the_jam_line(tmp_path: Path) -> None:
    """Thinned to three temperatures, without weight and with it: heat closes an internal pair's backlash, which then can jam."""
    text = (files("gearplay.sweeps.plans") / "space-temperature.toml").read_text(encoding="utf-8")
    plan = tomllib.loads(text)
    plan["members"], plan["axes"][1]["count"] = 1, 3
    plan["set"] |= {"run.duration": "0.05 s", "run.transient": "0 s"}
    found = gp.sweep(plan, out=tmp_path / "sweep").ds
    backlash = found.backlash.transpose("weight", "temperature", ...).values.reshape(2, 3)
    assert np.all(np.diff(backlash, axis=1) < 0.0)
    ratios = [
        geometry.jam_ratio(gp.load_case("space-drive", [f"environment.temperature={t} degC"]).operating, 0)
        for t in (-100, 120)
    ]
    assert ratios[0] < 1.0 < ratios[1]


def test_a_temperature_without_an_environment_is_refused() -> None:
    document = pair()
    del document["environment"]
    document["rotors"]["two"]["temperature"] = "90 degC"
    with pytest.raises(InputError, match=r"rotors\.two\.temperature.*without an environment"):
        gp.load_case(document)
