"""Static load and displacement of rolling bearings by the packed law, against printed and independent numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import root

from building import Document, Measured
from parts.bearing.shafts import BALLS, Law, under

ROLLERS: Document = {
    "rolling_elements": 13,
    "element_diameter": 7.5e-3,
    "pitch_diameter": 46e-3,
    "stiffness": 2e8,
    "exponent": 10.0 / 9.0,
}
# Radial play [um], displacement [um] with an element under the load and with two beside it.
BALLS_100N = [
    (0, 2.550018, 2.567585),
    (5, 8.385455, 8.165242),
    (10, 13.830271, 13.577203),
    (20, 23.830271, 24.401125),
]
ROLLERS_2000N = [(0, 11.176318, 11.137230), (10, 23.303245, 23.301444)]


def exact(bearing: Document, weight: float, play: float, angle: float) -> np.ndarray:
    """Return the displacement [m] along and across the load from the sum over elements, by SciPy."""
    count, n = bearing["rolling_elements"], bearing.get("exponent", 1.5)
    at = angle + 2.0 * math.pi * np.arange(count) / count

    def left(z: np.ndarray) -> list[float]:
        depth = np.maximum(1e-6 * (z[0] * np.cos(at) + z[1] * np.sin(at)) - play, 0.0)
        load = bearing["stiffness"] * depth**n
        return [float(load @ np.cos(at)) / weight - 1.0, float(load @ np.sin(at)) / weight]

    start = play + (4.4 * weight / count / bearing["stiffness"]) ** (1.0 / n)
    found: np.ndarray = 1e-6 * root(left, [1e6 * start, 0.0], method="lm", tol=1e-15).x
    return found


@pytest.mark.parametrize(
    ("bearing", "weight", "rows"), [(BALLS, 100.0, BALLS_100N), (ROLLERS, 2000.0, ROLLERS_2000N)]
)
def test_displacement_under_load(bearing: Document, weight: float, rows: list, measured: Measured) -> None:
    """Printed to 1e-6 um; relative to an independent solution of the same sums to 1e-9."""
    worst = 0.0
    for play, *printed in rows:
        for angle, value in zip((0.0, math.pi / bearing["rolling_elements"]), printed, strict=True):
            law = Law(under(bearing, angle) | {"internal_clearance": 2e-6 * play})
            x, y = law.displacement(weight, 1e-6 * value)
            assert -1e6 * y == pytest.approx(value, abs=1.1e-6)
            along, across = exact(bearing, weight, 1e-6 * play, angle)
            across = across if play < 10 else x  # free where one element is loaded
            worst = max(worst, abs(-y - along) / along, abs(abs(x) - abs(across)) / along)
    measured("bearing: displacement under load, relative", worst, "1e-9")
    assert worst < 1e-9


@pytest.mark.parametrize(
    ("play", "loads"), [(0.0, [54.3214, 32.2997, 32.2997]), (5e-6, [83.0962, 11.9528, 11.9528])]
)
def test_loads_of_the_elements(play: float, loads: list[float]) -> None:
    law = Law(under(BALLS, 0.0) | {"internal_clearance": 2.0 * play})
    law.force(*law.displacement(100.0, play + 3e-6))
    assert law.loads_of_elements()[:3] == pytest.approx(loads, abs=6e-5)


def share(eps: float, n: float) -> float:
    """Return the Stribeck-Sjovall integral of the load zone eps."""
    limit = math.acos(1.0 - 2.0 * eps) if eps < 1.0 else math.pi
    return quad(lambda p: (1.0 - (1.0 - math.cos(p)) / (2.0 * eps)) ** n * math.cos(p), -limit, limit)[0] / (
        2.0 * math.pi
    )


@pytest.mark.parametrize(
    ("n", "rows"),
    [
        (1.5, {0.1: 0.1156, 0.5: 0.2288, 0.9: 0.2576, 1.0: 0.2546, 1.25: 0.2289, 2.5: 0.1339, 5.0: 0.0711}),
        (1.1, {0.1: 0.1268, 0.5: 0.2453, 0.9: 0.2628, 1.0: 0.2523, 1.25: 0.2079, 2.5: 0.1075, 5.0: 0.0544}),
    ],
)
def test_a_thousand_elements_share_the_load_as_the_integral(n: float, rows: dict, measured: Measured) -> None:
    """F / (Z Q_max) of the law is the integral of Stribeck and Sjovall; its printed values are as Harris and NSK have them."""
    worst, depth, count = 0.0, 4e-6, 1000
    for eps, printed in rows.items():
        assert share(eps, n) == pytest.approx(printed, abs=5e-4 if n == 1.1 else 1e-4)
        displacement = depth / (2.0 * eps)  # eps = (1 - c/e)/2, depth = e - c
        bearing = {
            "rolling_elements": count,
            "element_diameter": 1e-5,
            "pitch_diameter": 0.05,
            "stiffness": 1e7,
            "exponent": n,
            "internal_clearance": 2.0 * (displacement - depth),
        }
        law = Law(under(bearing, 0.0))
        force = law.force(0.0, -displacement)[1]
        worst = max(worst, abs(force / (count * 1e7 * depth**n) - share(eps, n)) / share(eps, n))
    measured("bearing: 1000 elements against the integral, relative", worst, "1e-4")
    assert worst < 1e-4
    assert 1.0 / share(0.5, 1.5) == pytest.approx(4.3701, abs=5e-5)
    assert 1.0 / share(0.5, 1.1) == pytest.approx(4.0766, abs=5e-5)


@pytest.mark.parametrize(
    ("play", "swing", "harmonics"),
    [
        (0.0, 0.017567, (0.008464, 0.000909, 0.000243)),
        (5.0, 0.220213, (0.114047, 0.017278, 0.004708)),
        (20.0, 24.401125 - 23.830271, ()),  # between the places of the first test
    ],
)
def test_variable_compliance(
    play: float, swing: float, harmonics: tuple[float, ...], measured: Measured
) -> None:
    """Displacement over one pitch of the elements, slowly: peak to peak and harmonics."""
    found, start = [], 1e-6 * play + 3e-6
    for angle in np.arange(64) * 2.0 * math.pi / 8 / 64:
        law = Law(under(BALLS, float(angle)) | {"internal_clearance": 2e-6 * play})
        place = law.displacement(100.0, start)
        found.append(-1e6 * place[1])
    lines = np.abs(np.fft.rfft(found))[1:] * 2.0 / len(found)
    differences = [abs(line - printed) for line, printed in zip(lines, harmonics, strict=False)]
    worst = max(abs(np.ptp(found) - swing), *differences, 0.0)
    measured("bearing: variable compliance [um]", float(worst), "1e-5")
    assert worst < 1e-5


def test_stiffness_at_the_load() -> None:
    """Sum of n K d^(n-1) u u' over the loaded elements."""
    for play, along, across in ((0.0, 58823119.0, 26869600.0), (5e-6, 56108455.0, 19290844.0)):
        law = Law(under(BALLS, 0.0) | {"internal_clearance": 2.0 * play})
        stiffness = law.stiffness(*law.displacement(100.0, play + 3e-6))
        assert stiffness[1, 1] == pytest.approx(along, rel=1e-7)
        assert stiffness[0, 0] == pytest.approx(across, rel=1e-7)
        assert abs(stiffness[0, 1]) < 1e-6 * along
    preloaded = Law(BALLS | {"internal_clearance": -1e-5}).stiffness(0.0, 0.0)
    assert preloaded == pytest.approx(178974880.92 * np.eye(2), rel=1e-9, abs=1.0)
