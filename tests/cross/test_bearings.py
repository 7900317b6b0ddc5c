"""The package against the independent reference on mechanisms with rolling bearings."""

import pytest

from building import Measured
from cross.bearing_systems import SEEDS, bearing_case
from cross.comparing import worst_difference

SLOW, DEEP = SEEDS[:3], SEEDS[3:]
"""One mechanism of each kind, and the others."""


@pytest.mark.parametrize(
    "seed",
    [
        *(pytest.param(seed, marks=pytest.mark.slow) for seed in SLOW),
        *(pytest.param(seed, marks=pytest.mark.deep) for seed in DEEP),
    ],
)
def test_mechanisms_with_rolling_bearings_equal_the_reference(seed: int, measured: Measured) -> None:
    """Balls and rollers, preload and clearance, waviness, on the ground and on a carrier, with meshes and shafts."""
    worst = worst_difference(bearing_case(seed), events=2, duration=6e-3)
    measured(
        "largest difference over 6 ms of a mechanism with rolling bearings from SciPy's [m]", worst, "1e-9"
    )
