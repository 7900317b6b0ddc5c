"""Natural frequencies as printed: planetary sets of Lin, Parker 1999 and Cooley, Parker 2012, the pair of Yi et al. 2019."""

import math

import numpy as np
import pytest

import gearplay as gp
from building import Measured

LIN_PARKER = {
    3: ((0.0, 1475.7, 1930.3, 2658.3, 7462.8, 11775.3), (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9), ()),
    4: (
        (0.0, 1536.6, 1970.6, 2625.7, 7773.6, 13071.1),
        (727.0, 1091.0, 1892.8, 2342.5, 7189.9, 10437.6),
        (1808.2, 5963.8, 6981.7),
    ),
}
COOLEY_PARKER = ((0.9296, 1.090, 1.358, 1.931, 5.566, 7.741), (0.7432, 1.018, 1.265, 1.487, 4.976, 6.282))


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
    np.testing.assert_allclose(of_kind(found, "rotational", 1)[1:], simple[1:], rtol=1e-3)
    assert of_kind(found, "rotational", 1)[0] == 0.0
    np.testing.assert_allclose(of_kind(found, "translational", 2), double, rtol=1e-3)
    np.testing.assert_allclose(of_kind(found, "planet", 1), planet, rtol=1e-3)
    assert found.ds.sizes["mode"] == 9 + 3 * planets
    worst = np.max(np.abs(of_kind(found, "translational", 2) / double - 1.0))
    measured(f"doubles of {planets} planets, {model}", float(worst), "relative")


def test_cooley_and_parker_2012() -> None:
    """Frequencies over sqrt(k_p / m_p) with the carrier at rest, within 0.1 %."""
    found, unit = gp.modes("cooley-parker-2012"), math.sqrt(1e7 / 1.86) / (2.0 * math.pi)
    simple, double = COOLEY_PARKER
    np.testing.assert_allclose(of_kind(found, "rotational", 1) / unit, simple, rtol=1e-3)
    np.testing.assert_allclose(of_kind(found, "translational", 2) / unit, double, rtol=1e-3)


def yi(*, held: bool) -> gp.Case:
    """Return the pair of Yi et al. 2019 under a small load, free to turn, its centres held or in bearings of 1e8 N/m."""
    wheel = {"teeth": 20, "mass": 6.57, "inertia": 0.0365}
    bearings = {} if held else {name: {"stiffness": [1e8, 1e8]} for name in ("pinion", "gear")}
    return gp.load_case(
        {
            "rotors": {
                "pinion": {**wheel, "drive": {"kind": "torque", "torque": 1.0}},
                "gear": {**wheel, "load": {"torque": 1.0}},
            },
            "supports": bearings,
            "meshes": [
                {
                    "driver": "pinion",
                    "driven": "gear",
                    "module": 0.01,
                    "backlash": 1e-4,
                    "stiffness": {"kind": "harmonic", "mean": 5.17925e8},
                }
            ],
            "run": {"duration": 0.01},
        }
    )


def test_the_pair_of_yi_2019() -> None:
    """0, 482.93, 620.92 (three times), 3239.40 Hz; in torsion alone 2519.46 Hz: within 1e-4."""
    found = gp.modes(yi(held=False)).ds["frequency"].values
    assert found[0] == 0.0
    np.testing.assert_allclose(found[1:], [482.93, 620.92, 620.92, 620.92, 3239.40], rtol=1e-4)
    assert gp.modes(yi(held=True)).ds["frequency"].values[-1] == pytest.approx(2519.46, rel=1e-4)
