import pickle
from typing import Any

import pytest

from gearplay.model.field_units import unit_at
from gearplay.model.pack import pack
from gearplay.model.reading import load_case, replace
from gearplay.model.schema import json_schema
from gearplay.vocabulary.errors import InputError
from programs import run_program

RECEIVER = """
import pickle, sys
case = pickle.loads(bytes.fromhex(sys.argv[1]))
from gearplay.model.reading import load_case
print(case.sha256, load_case(case.resolved()) == case)
"""
"""What a worker process does first."""
SMALL: dict[str, Any] = {"rotors": {"disc": {"mass": 1, "inertia": 1}}, "run": {"duration": 1}}


@pytest.mark.parametrize(
    "drive",
    [
        {"kind": "speed", "speed": "10 rpm", "ramp": "0.1 s"},
        {"kind": "torque", "torque": "-5 N m"},
        {
            "kind": "servo",
            "speed": 1,
            "proportional_gain": "1 N m s/rad",
            "integral_gain": "0 N m/rad",
            "torque_limit": 5,
        },
    ],
)
def test_every_kind_of_drive(drive: dict[str, Any]) -> None:
    found = replace(load_case(SMALL), {"rotors.disc.drive": drive}).rotors["disc"].drive
    assert found is not None
    assert found.kind == drive["kind"]


@pytest.mark.parametrize(
    "stiffness",
    [
        {"kind": "harmonic", "mean": 1e8, "amplitude": 9.9e7},
        {"kind": "square", "single": 1e8, "double": 1.5e8, "contact_ratio": 1.6},
        {"kind": "square", "single": 1e8, "double": 1e8},
        {"kind": "fourier", "mean": 1e8, "terms": [{"order": 3, "amplitude": -1e6, "phase": "30 deg"}]},
        {"kind": "fourier", "mean": 1e8, "terms": []},
        {"kind": "table", "phase": ["0 deg", 1, 2, "359.9 deg"], "stiffness": [1e8, "100 N/um", 1e8, 1e8]},
        {"kind": "iso6336", "facewidth": "6 mm"},
    ],
)
def test_every_kind_of_stiffness(stiffness: dict[str, Any]) -> None:
    found = replace(load_case("han2021"), {"meshes.0.stiffness": stiffness})
    assert found.meshes[0].stiffness.kind == stiffness["kind"]
    assert load_case(found.resolved()) == found


def test_a_square_wave_needs_teeth_that_let_go() -> None:
    """From a contact ratio of 2 on there is no time with one pair: refused, not taken as constant in silence."""
    square = {"kind": "square", "single": 1e8, "double": 1.5e8}
    teeth = {"rotors.pinion.teeth": 40, "rotors.ring.teeth": 120, "meshes.0.pressure_angle": "18 deg"}
    many = replace(load_case("han2021"), {"meshes.0.stiffness": square, **teeth})
    with pytest.raises(InputError, match=r"meshes\.0\.stiffness.*contact ratio of 2\.\d.*kind table"):
        pack(many)
    with pytest.raises(InputError, match=r"contact_ratio = 2\.0: must be .* less than 2"):
        replace(many, {"meshes.0.stiffness.contact_ratio": 2.0})
    assert pack(replace(many, {"meshes.0.stiffness.contact_ratio": 1.9})).state_size > 0


def test_the_unit_of_a_contact_stiffness_follows_the_exponent() -> None:
    base = replace(load_case("han2021"), {"sleeves.ring.material": None, "sleeves.ring.stiffness": 1e11})
    for exponent, text in ((1.5, "1e11 N/m^1.5"), (1, "1e8 N/m"), (1.1, "1e8 N/m^1.1"), (2, "1 N/um^2")):
        changed = {"sleeves.ring.exponent": exponent, "sleeves.ring.stiffness": text}
        assert replace(base, changed).sleeves["ring"].stiffness > 0  # type: ignore[operator]
    with pytest.raises(InputError, match=r"sleeves\.ring\.stiffness.*exponent 1\.5"):
        replace(base, {"sleeves.ring.stiffness": "1e8 N/m"})


def test_both_sides_of_a_sleeve() -> None:
    case = load_case("pinion-idler-ring")
    assert case.sleeves["idler"].sides() == ((207e9, 0.3), (110e9, 0.34))
    assert case.sleeves["ring"].sides() == ((207e9, 0.3), (207e9, 0.3))


def test_a_material_fixes_the_exponent() -> None:
    with pytest.raises(InputError, match=r"sleeves\.ring\.exponent = 2: must be 1\.5"):
        replace(load_case("han2021"), {"sleeves.ring.exponent": 2})


def test_the_schema_describes_every_field() -> None:
    schema = json_schema()
    for name, part in schema["$defs"].items():
        assert part["additionalProperties"] is False
        for field, described in part["properties"].items():
            text = str(described)
            assert "description" in text or "$ref" in text or field == "kind", f"{name}.{field}"


def test_the_schema_has_units_and_bounds() -> None:
    parts = json_schema()["$defs"]
    mass = parts["Rotor"]["properties"]["mass"]
    assert mass["x-unit"] == "kg"
    assert mass["anyOf"][0] == {"type": "number", "minimum": 0.0}
    assert mass["anyOf"][1]["type"] == "string"
    assert parts["Sleeve"]["properties"]["restitution"]["maximum"] == 1.0
    assert json_schema()["properties"]["rotors"]["maxProperties"] == 200
    assert json_schema()["properties"]["gravity"]["minItems"] == 2


def test_parts_built_later_are_as_any_other() -> None:
    """Planetary sets and a moving housing are built where a case has one: schema, units, messages and round trip know them."""
    parts, fields = json_schema()["$defs"], json_schema()["properties"]
    assert {"$ref": "#/$defs/Planetary"} in fields["planetary"]["patternProperties"].values()
    assert {"$ref": "#/$defs/Base"} in fields["base"]["anyOf"]
    assert {"sun", "planets"} <= parts["Planetary"]["properties"].keys()
    assert unit_at(load_case("han2021"), "base.acceleration.direction") == "rad"
    for name, path, hint in (
        ("planetary-reducer", "planetary.stage.sun.teth", "Did you mean 'teeth'?"),
        ("space-launch", "base.acceleration.dirction", "Did you mean 'direction'?"),
    ):
        case = load_case(name)
        assert load_case(case.resolved()) == case
        sent = run_program(RECEIVER, pickle.dumps(case).hex())
        assert sent.stdout.split() == [case.sha256, "True"]
        with pytest.raises(InputError) as caught:
            replace(case, {path: 1})
        assert [(fault.path, fault.cure) for fault in caught.value.faults] == [(path, hint)]
