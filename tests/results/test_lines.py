"""Expected lines of spectra: pass frequencies of rolling bearings against Harris's formulas."""

import pytest

import gearplay as gp
from gearplay.results.lines import line_marks, spectrum_lines
from planetary_sets import planetary_document

BEARING = {"rolling_elements": 9, "element_diameter": 8e-3, "pitch_diameter": 40e-3, "stiffness": 1e10}
RATIO = 8.0 / 40.0


def test_bearing_of_a_shaft__has_its_pass_frequencies() -> None:
    case = gp.replace("han2021", {"sleeves": {}, "bearings": {"ring": BEARING}})
    for found in (spectrum_lines(case), line_marks(case)):
        turn = found["shaft of ring"]
        assert found["BPFO of ring"] == pytest.approx(9 / 2 * (1 - RATIO) * turn, rel=1e-9)
        assert found["BPFI of ring"] == pytest.approx(9 / 2 * (1 + RATIO) * turn, rel=1e-9)


def test_bearings_of_planets__pass_at_their_turn_against_the_carrier_and_are_one() -> None:
    document = planetary_document(support=None, bearing=BEARING)
    case = gp.load_case(document)
    found = {name: line for name, line in spectrum_lines(case).items() if name.startswith("BPF")}
    assert list(found) == ["BPFO of stage.planet1", "BPFI of stage.planet1"]
    assert found["BPFI of stage.planet1"] / found["BPFO of stage.planet1"] == pytest.approx(
        (1 + RATIO) / (1 - RATIO)
    )
    set_ = gp.load_case(document).planetary["stage"]
    mesh = spectrum_lines(case)["f_m"]
    assert found["BPFO of stage.planet1"] == pytest.approx(
        9 / 2 * (1 - RATIO) * mesh / set_.planets.teeth, rel=1e-9
    )
