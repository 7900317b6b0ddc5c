"""The study's own formulas: the swing of the driven gear, the conditions' cases."""

import math

import numpy as np
import pytest

from gearplay.model.reading import load_case, replace
from gearplay.published.article import conditions
from gearplay.published.han2021 import SimulatedLine, swing_frequency
from gearplay.published.settings import condition_case


def test_swing_frequency_is_that_of_a_pendulum_under_the_drags_mesh_force() -> None:
    case = replace(load_case("han2021"), {"rotors.ring.load.drag": 3e-4})
    force = 3e-4 * (120.0 / 3.0 * math.pi / 30.0) / (0.12 * math.cos(math.radians(20.0)))
    assert swing_frequency(case) == pytest.approx(
        math.sqrt(force / (0.8 * 100e-6)) / (2.0 * math.pi), rel=1e-12
    )


def test_swing_frequency_goes_with_the_root_of_speed_over_clearance() -> None:
    base = load_case("han2021")
    scaled = {
        c.label: swing_frequency(condition_case(base, c, "coupled"))
        / math.sqrt(c.speed_rpm / c.radial_clearance_um)
        for c in conditions()
    }
    assert max(scaled.values()) == pytest.approx(min(scaled.values()), rel=1e-12)


def test_a_conditions_case_has_its_speed_clearance_backlash_and_model() -> None:
    for condition in conditions():
        case = condition_case(load_case("han2021"), condition, "uncoupled")
        drive = case.rotors["pinion"].drive
        assert drive is not None
        assert drive.kind == "speed"
        assert drive.speed == pytest.approx(condition.speed_rpm * math.pi / 30.0)
        assert case.sleeves["ring"].radial_clearance == pytest.approx(1e-6 * condition.radial_clearance_um)
        assert case.meshes[0].backlash == pytest.approx(1e-6 * condition.backlash_um)
        assert case.backlash_model == "uncoupled"


def test_the_level_of_a_line_is_its_amplitude_and_its_error_that_of_the_members_mean_square() -> None:
    rng = np.random.default_rng(5)
    drawn = [rng.lognormal(0.0, 0.8, 24) for _ in range(4000)]
    lines = [SimulatedLine(40.0, math.sqrt(float(np.mean(each**2))), 2.0, tuple(each)) for each in drawn]
    levels = np.array([line.log_level() for line in lines])
    np.testing.assert_allclose(10.0 ** levels[:, 0], [line.amplitude for line in lines])
    assert np.median(levels[:, 1]) == pytest.approx(float(np.std(levels[:, 0])), rel=0.35)
    assert SimulatedLine(40.0, 0.1, 2.0, (0.1,)).log_level() == (-1.0, math.inf)
