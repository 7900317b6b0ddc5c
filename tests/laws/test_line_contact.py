"""Line-contact laws of a plain bearing with length: printed forces, slopes, energy, restitution, the end of Johnson's law."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured, case_of, merged, simulate_one, single_rotor_document
from gearplay.model.check import check_case
from gearplay.parts.sleeve.line import DEEPEST, LINE_JOHNSON, LINE_LIU, line_force, line_slope
from gearplay.vocabulary.errors import InputError

STEEL = {"modulus": 206e9, "poisson": 0.3}
MODULUS = 206e9 / (2.0 * (1.0 - 0.09))
BUSH: Document = {"radial_clearance": 1e-4, "length": 10e-3, "material": STEEL, "restitution": 1.0}


def record(law: int) -> Any:
    """Return the numbers of the bush that the laws read."""
    return SimpleNamespace(line=law, clearance=1e-4, line_length=10e-3, line_modulus=MODULUS)


@pytest.mark.parametrize(
    ("law", "printed"),
    [(LINE_JOHNSON, (37.2317, 513.3440, 3563.4746)), (LINE_LIU, (3.9736, 125.0950, 1371.7061))],
)
def test_forces_as_printed(law: int, printed: tuple[float, ...]) -> None:
    """At 0.1, 1 and 5 um, journal of 10 mm radius and length, clearance 0.1 mm."""
    for depth, force in zip((0.1e-6, 1e-6, 5e-6), printed, strict=True):
        assert line_force(record(law), depth) == pytest.approx(force, abs=6e-5)


def test_johnson_is_the_inverse_of_its_formula(measured: Measured) -> None:
    worst = 0.0
    end = 4.0 * DEEPEST * 1e-4
    assert 1e6 * end == pytest.approx(54.134, abs=5e-4)
    for depth in [*np.geomspace(1e-12, 0.99 * end, 60), end * (1.0 - 1e-9)]:
        w = line_force(record(LINE_JOHNSON), float(depth)) / 10e-3
        back = w / (math.pi * MODULUS) * (math.log(4.0 * math.pi * MODULUS * 1e-4 / w) - 1.0)
        worst = max(worst, abs(back - depth) / depth)
    measured("Johnson's law: depth of its force, relative", worst, "1e-12")
    assert worst < 1e-12


@pytest.mark.parametrize("law", [LINE_JOHNSON, LINE_LIU])
def test_slopes_are_those_of_differences(law: int) -> None:
    for depth in np.geomspace(1e-9, 4e-5, 20):
        h = 1e-4 * float(depth)
        ends = [line_force(record(law), float(depth) + s * h) for s in (1.0, -1.0)]
        assert line_slope(record(law), float(depth)) == pytest.approx(
            (ends[0] - ends[1]) / (2.0 * h), rel=1e-6
        )


@pytest.mark.parametrize("law", ["johnson", "liu"])
def test_an_impact_conserves_energy_or_has_its_restitution(law: str) -> None:
    """Against the bush and back; with restitution 0.8 as delivered."""
    for e in (1.0, 0.8):
        bush = BUSH | {"law": law, "restitution": e, "restitution_reading": "delivered"}
        document = single_rotor_document(bush, initial={"x": 9e-5, "vx": 0.2})
        document["run"] = {"duration": 6e-4, "sampling": 1e6, "tolerance": 1e-11}
        run = simulate_one(document)
        assert run.signal("vx", "disc")[-1] == pytest.approx(-0.2 * e, rel=1e-8)
        assert np.max(run.signal("sleeve_penetration", "disc")) > 1e-6


def test_a_run_ends_where_johnson_does() -> None:
    bush = BUSH | {"law": "johnson", "length": 1e-3}
    document = single_rotor_document(bush, initial={"x": 9e-5, "vx": 30.0})
    found = gp.simulate(document)
    assert found.status.name == "CANNOT_MESH"
    assert "deeper than the law johnson" in found.message
    notes = [str(each) for each in check_case(case_of(document))]
    assert any("54.13 um and 1.925e+04 N" in note for note in notes), notes


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"law": "johnson", "length": None}, "length.*is required by the law johnson"),
        ({"law": "liu", "material": None}, "material.*is required by the law liu"),
        ({"law": "liu", "stiffness": "1e9 N/m^1.5"}, "stiffness.*must not be given with the law liu"),
        ({"law": "johnson", "radial_clearance": 0.0}, "radial_clearance.*must be greater than 0 m"),
        ({"law": "flores", "shaft_radius": 0.01}, "length.*must not be given with the law flores"),
    ],
)
def test_bad_input_gets_one_sentence(changes: Document, text: str) -> None:
    with pytest.raises(InputError, match=text):
        gp.load_case(single_rotor_document(merged(BUSH, changes)))
