"""Natural frequencies of the planetary sets of Lin, Parker 1999: kinds, multiplicities, both models of backlash."""

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.validation.published import FOUR_PLANETS, THREE_PLANETS

LIN_PARKER = {3: (*THREE_PLANETS, ()), 4: FOUR_PLANETS}


def of_kind(found: gp.modes, kind: str, multiplicity: int) -> np.ndarray:
    """Return frequencies [Hz] of a kind, each once, all of which have that multiplicity."""
    chosen = found.ds["kind"].values == kind
    assert np.all(found.ds["multiplicity"].values[chosen] == multiplicity)
    return found.ds["frequency"].values[chosen][::multiplicity]


@pytest.mark.parametrize("planets", [3, 4])
@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_lin_and_parker_1999(planets: int, model: str, measured: Measured) -> None:
    """Table of J. Vib. Acoust. 121 (1999) 319: frequencies within 0.1 %, kinds and multiplicities as there."""
    case = gp.replace(
        gp.load_case("lin-parker-1999"), {"planetary.stage.planets.count": planets, "backlash_model": model}
    )
    found, (simple, double, planet) = gp.modes(case), LIN_PARKER[planets]
    np.testing.assert_allclose(of_kind(found, "rotational", 1)[1:], simple, rtol=1e-3)
    assert of_kind(found, "rotational", 1)[0] == 0.0
    np.testing.assert_allclose(of_kind(found, "translational", 2), double, rtol=1e-3)
    np.testing.assert_allclose(of_kind(found, "planet", 1), planet, rtol=1e-3)
    assert found.ds.sizes["mode"] == 9 + 3 * planets
    worst = np.max(np.abs(of_kind(found, "translational", 2) / double - 1.0))
    measured(f"doubles of {planets} planets, {model}", float(worst), "relative")
