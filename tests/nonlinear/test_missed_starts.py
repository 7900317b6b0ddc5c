"""Branches say near which of their starts there was no orbit."""

from pathlib import Path

import pytest

import gearplay as gp
from gearplay.nonlinear.orbits import continuation
from gearplay.nonlinear.orbits.branch_tree import settled_orbits
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.torsional import torsional_pair
from gearplay.vocabulary.errors import SimulationError

AMPLITUDE = "meshes.0.transmission_error.0.amplitude"


@pytest.mark.slow
def test_a_start_without_an_orbit_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In the object, its message and the file; the other start is followed."""

    class Failing(StrobeMap):
        def settle(self, state: object, parameter: float, periods: int) -> object:  # type: ignore[override]
            if parameter > 5.9e-6:
                raise SimulationError("the motion cannot be followed. Soften it.")
            return super().settle(state, parameter, periods)  # type: ignore[arg-type]

    monkeypatch.setattr(continuation, "StrobeMap", Failing)
    pair = torsional_pair(0.7, force=0.05)
    found = gp.branches(pair, AMPLITUDE, "4 um", "6 um", orbits=3, doublings=0, settle=50)
    assert found.missed == ("no start at 6e-06: the motion cannot be followed. Soften it.",)
    assert found.missed[0] in found.message
    found.save(tmp_path / "branches.nc")
    assert gp.read_result(tmp_path / "branches.nc").missed == found.missed
    with pytest.raises(SimulationError, match="tried at 6e-06"):
        settled_orbits(Failing(lambda _: pair, 6e-6), [6e-6], order=1, settle=1)
