"""Measured lines of the bundled plans, at the condition of a case."""

from gearplay.calibration.reading import load_plan
from gearplay.model.reading import load_case, replace
from gearplay.web.measured import measured_lines


def test_measured_lines__those_of_the_condition() -> None:
    plan = load_plan("han2021")
    for condition in plan.conditions:
        expected = [
            {"line": name, "frequency": value.frequency} for name, value in condition.measured.items()
        ]
        assert measured_lines(replace(load_case(plan.case), condition.set)) == expected
        assert len(expected) == 3


def test_measured_lines__none_beside_the_conditions() -> None:
    assert measured_lines(replace(load_case("han2021"), {"meshes.0.backlash": "150 um"})) == []
    assert measured_lines(replace(load_case("han2021"), {"rotors.ring.teeth": 62})) == []
    assert measured_lines(replace(load_case("han2021"), {"rotors.pinion.drive": None})) == []
