"""Springs and couplings on the drawing: from the ground to the shaft, rings about both shafts whose marks part by the twist."""

import math

import numpy as np
import pytest

import gearplay as gp
from gearplay.pictures.joints import spring
from gearplay.results.staging import motion_in, stage_of


def test_a_spring_reaches_from_the_ground_to_the_shaft() -> None:
    gear = {"x": 0.1, "y": 0.0, "shaft": 5e-3}
    still = spring(gear, np.array([0.1, 0.0]), 0)
    moved = spring(gear, np.array([0.101, 0.002]), 0)
    assert np.allclose(moved[0] - still[0], [0.0, 0.002])  # the ground stays, beside a shaft that went up
    assert np.allclose(moved[-1] - still[-1], [0.001, 0.002])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "springs", "rings"), [("torsional-train", 6, 4), ("lin-parker-1999", 12, 0)]
)
def test_the_drawing_shows_what_joins(name: str, springs: int, rings: int) -> None:
    """As many springs as stiff axes of supports, two rings a coupling; all where their shafts are."""
    case = gp.load_case(name)
    stiff = sum(k > 0.0 for support in case.supports.values() for k in support.stiffness or ())
    stage = stage_of(
        motion_in(gp.simulate(case, duration=2e-3), (case.run.transient, case.run.transient + 2e-3))
    )
    stage.show(0)
    joints = stage.panes[0].joints
    assert len(joints.springs) == stiff == springs
    assert len(joints.rings) == rings
    for line, gear, *_ in joints.rings:
        x, y = line.get_data()
        assert math.hypot(np.mean(x) - 1e3 * gear["x"], np.mean(y) - 1e3 * gear["y"]) < 2.0
    for line, gear, axis in joints.springs:
        foot = line.get_data()[axis][0]
        assert foot < 1e3 * (gear["x"], gear["y"])[axis] or case.supports[gear["rotor"]].on is not None
