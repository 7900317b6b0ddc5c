"""Planets on rolling bearings: expansion of the set, load sharing, preload against supports, dents, refusals."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp

BALLS: dict[str, Any] = {
    "catalogue": "6205",
    "groove_ratio": 0.52,
    "internal_clearance": "10 um",
    "damping": {"kind": "hunt-crossley", "value": "1 s/m"},
}


def on_bearings(**changes: Any) -> gp.Case:
    """Return the planetary reducer with its planets on ball bearings."""
    table = {"planetary.stage.pin": None, "planetary.stage.bearing": BALLS | changes}
    return gp.replace("planetary-reducer", table)


def test_bearings_of_planets__are_made_by_the_set() -> None:
    """One for each planet, its outer ring in the planet, the other on the carrier; the file of the case gives it back."""
    case = on_bearings()
    assert list(case.bearings) == ["stage.planet1", "stage.planet2", "stage.planet3"]
    assert {(each.rotor_ring, each.on) for each in case.bearings.values()} == {("outer", "stage.carrier")}
    assert not case.sleeves
    assert gp.load_case(case.resolved()) == case
    back = gp.replace(
        case,
        {
            "planetary.stage.bearing": None,
            "planetary.stage.pin": {"radial_clearance": 1e-5, "stiffness": 2e10},
        },
    )
    assert not back.bearings
    assert list(back.sleeves) == ["stage.planet1", "stage.planet2", "stage.planet3"]
    assert on_bearings(rotor_ring="inner").bearings["stage.planet1"].rotor_ring == "inner"


def test_bearing_of_the_sun__is_its_own() -> None:
    document = gp.replace(on_bearings(), {"planetary.stage.sun.floating": False}).resolved()
    document["bearings"] = {"stage.sun": {**BALLS}}
    case = gp.load_case(document)
    assert sorted(case.bearings) == ["stage.planet1", "stage.planet2", "stage.planet3", "stage.sun"]


def test_planets_on_bearings__share_the_load() -> None:
    found = gp.load_sharing(on_bearings())
    np.testing.assert_allclose(found.ds["load_sharing_factor"].values, 1.0, atol=1e-3)
    assert found.ds.attrs["pin_clearance"] == pytest.approx(5e-6)
    away = np.linalg.norm(found.ds["beside_pin"].values, axis=1)
    assert np.all(away > 5e-6)


def test_preloaded_bearings__have_the_modes_of_supports() -> None:
    """Under little load 20 um of preload are an isotropic stiffness Z/2 n K d^(n - 1): modes of supports as stiff."""
    loads = {"planetary.stage.carrier.load.torque": 50.0}
    K, count, depth = 1e10, 9, 20e-6
    stiffness = 0.5 * count * 1.5 * K * depth**0.5
    bearing = {"rolling_elements": count, "element_diameter": "8 mm", "pitch_diameter": "40 mm", "stiffness": K,
               "internal_clearance": -2.0 * depth}  # fmt: skip
    case = gp.replace(
        "planetary-reducer", {"planetary.stage.pin": None, "planetary.stage.bearing": bearing, **loads}
    )
    supports = {"planetary.stage.pin": None, "planetary.stage.support": {"stiffness": [stiffness, stiffness]}}
    other = gp.replace("planetary-reducer", {**supports, **loads})
    frequencies = [gp.modes(each).ds["frequency"].values for each in (case, other)]
    np.testing.assert_allclose(frequencies[0], frequencies[1], rtol=2e-3)


def test_dent_of_a_planet_bearing__is_in_its_motion() -> None:
    dent = {"faults": [{"kind": "outer", "at": "stage.planet1", "depth": "20 um", "arc": "6 deg"}]}
    sound, dented = (
        gp.simulate(case, duration=0.1, transient=0.0, signals=["stage.planet1.bearing_force_x"])
        for case in (on_bearings(), gp.replace(on_bearings(), dent))
    )
    assert sound.success
    assert dented.success
    force = [run.signal("bearing_force_x", "stage.planet1") for run in (sound, dented)]
    assert np.max(np.abs(force[1] - force[0])) > 0.01 * np.max(np.abs(force[0]))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"planetary.stage.bearing": BALLS}, r"planetary.stage.pin.*must not be given together with bearing"),
        ({"planetary.stage.pin": None}, r"planetary.stage.pin.*required, or support or bearing"),
        ({"planetary.stage.pin": None, "planetary.stage.bearing": {**BALLS, "on": "stage.carrier"}}, r"bearing.on.*pins are on"),
        ({"planetary.stage.pin": None, "planetary.stage.bearing": {"groove_ratio": 0.52}}, r"bearing.rolling_elements.*or cat"),
    ],
)  # fmt: skip
def test_planets__on_two_things_or_none_are_refused(table: dict[str, Any], words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        gp.replace("planetary-reducer", table)
