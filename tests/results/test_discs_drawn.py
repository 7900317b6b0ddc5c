"""Discs that hide nothing: shafts within the roots of the gears on their axis, stages and shapes of modes beside each other."""

import math
from itertools import combinations

import pytest

from gearplay.linear.figures import _discs
from gearplay.model.bundled import bundled
from gearplay.model.reading import load_case
from gearplay.results.mechanism import mechanism_of
from gearplay.web.toml_edits import edited
from planetary_sets import planetary_document

SMALL = "a sun of 9 mm"


def case_of(name: str) -> object:
    if name != SMALL:
        return load_case(name)
    return load_case(planetary_document(module=1e-3, sun={"teeth": 18}, ring={"teeth": 58}))


@pytest.mark.parametrize("name", [*sorted(bundled("gearplay.model", "cases")), SMALL])
def test_shafts_lie_within_the_roots_of_their_gears(name: str) -> None:
    """With r_f = m (z / 2 - 1.25) of every external gear on the axis of a drawn shaft, carriers' among them."""
    gears = mechanism_of(case_of(name))["gears"]  # type: ignore[arg-type]
    toothed = [each for each in gears if each["teeth"] and each["module"] and not each["internal"]]
    pairs = [(a, b) for a in gears for b in toothed if math.dist((a["x"], a["y"]), (b["x"], b["y"])) < 1e-6]
    assert len(pairs) >= len(toothed)
    for shaft, gear in pairs:
        assert shaft["shaft"] <= 0.51 * gear["module"] * (0.5 * gear["teeth"] - 1.25), (
            shaft["rotor"],
            gear["name"],
        )


@pytest.mark.parametrize("name", ["two-stage-reducer", "torsional-train"])
def test_mode_shapes_of_stages_stand_beside_each_other(name: str) -> None:
    """No circle lies over one of another rotor, and what is one shaft or one coupling is joined by a line."""
    discs, axes = _discs(load_case(name))
    assert len(axes) >= 1
    for a, b in combinations(discs, 2):
        assert math.dist((a.x, a.y), (b.x, b.y)) > 0.98 * (a.radius + b.radius), (a.rotor, b.rotor)


def test_a_changed_list_and_a_temperature_are_written_into_a_file() -> None:
    from gearplay.model.bundled import bundled_text

    article, space = (bundled_text("gearplay.model", "cases", name) for name in ("han2021", "space-drive"))
    text = edited(article, {"sleeves.ring.offset.1": 1e-5})
    assert "offset = [0.0, 1e-05]" in text
    assert "# article: 100 or 200 um" in text
    assert 'temperature = "-60 degC"' in edited(space, {"environment.temperature": 213.15})
