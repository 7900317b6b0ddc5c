"""Planetary sets against the independent reference: parts of a table, phases of teeth, turning carriers."""

import math

import pytest

from building import Measured
from cross.comparing import RUN, worst_difference_of_sets
from cross.planetary_systems import NAME, SEEDS, expanded, phases_of, planetary_case
from cross.reference import Reference
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.parts.mesh.train.geometry import centres
from gearplay.parts.mesh.train.rolling import nominal_speeds

DURATION = 6e-3  # s


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("seed", SEEDS)
def test_planetary_sets_equal_the_independent_reference(seed: int, measured: Measured) -> None:
    """Two to six planets with clearance or springs at their pins, misplaced and eccentric, over 6 ms."""
    worst = worst_difference_of_sets(planetary_case(seed), duration=DURATION, events=40)
    measured("largest difference over 6 ms of a planetary set from SciPy's [m]", worst, "1e-9")


@pytest.mark.parametrize("seed", SEEDS)
def test_places_speeds_and_phases_are_those_of_the_reference(seed: int) -> None:
    """Phases modulo a turn: in closed form, by the reference's rule for any train, and in the package."""
    document = planetary_case(seed)
    case, plain = Case.model_validate({**document, "run": RUN}), expanded(document)
    reference = Reference(plain)
    for name, speed in zip(case.rotors, nominal_speeds(case), strict=True):
        rotor = reference.rotors[reference.index[name.replace(".", "/")]]
        assert rotor.position == pytest.approx(centres(case)[name], abs=1e-15)
        assert rotor.nominal_speed == pytest.approx(speed, rel=1e-12, abs=1e-9)
    packed = pack(case).system
    table = document["planetary"][NAME]
    count, half = table["planets"]["count"], math.pi * (1 - table["planets"]["teeth"] % 2)
    by_rule = Reference({**plain, "mesh_phases": "by_position", "meshes": _unphased(plain["meshes"])})
    expected = phases_of(table)
    assert [mesh.label for mesh in case.meshes] == [m.label.replace("/", ".") for m in reference.meshes]
    for k, phase in enumerate(expected):
        found = float(packed.records[2]["psi_0"][k])
        assert math.remainder(found - phase, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
        rule = by_rule.meshes[k].psi0 + (half if k >= count else 0.0)
        assert math.remainder(rule - phase, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def _unphased(meshes: list[dict]) -> list[dict]:
    return [{key: part for key, part in mesh.items() if key != "phase"} for mesh in meshes]
