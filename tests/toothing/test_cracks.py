"""Loss of stiffness by a crack at the root, against numbers of an independent integration."""

import math

import numpy as np
import pytest

from gearplay.toothing.cracks import Crack, crack_losses
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair

PAIR = GearPair(
    DrawnGear(teeth=20, module=4e-3, facewidth=0.01, bore=0.03),
    DrawnGear(teeth=60, module=4e-3, facewidth=0.01, bore=0.06),
    0.16,
)


@pytest.mark.parametrize(
    ("depth", "losses"),
    [
        (0.5e-3, (0.130, 0.291, 0.695)),
        (1.0e-3, (0.613, 1.543, 4.019)),
        (1.5e-3, (1.245, 3.248, 8.603)),
        (2.0e-3, (1.786, 4.825, 13.360)),
        (2.5e-3, (2.412, 6.639, 18.823)),
    ],
)
def test_crack__takes_stiffness(depth: float, losses: tuple[float, ...]) -> None:
    """20/60, module 4 mm, crack of one pinion tooth under 45 deg: percent at A, the middle and E."""
    path = PAIR.path
    places = np.array([path.start, 0.5 * (path.start + path.end), path.end])
    found = 100.0 * crack_losses(PAIR, 0, Crack(depth, math.radians(45.0)), places, 206e9, 0.3)
    assert found == pytest.approx(losses, abs=0.01)
