"""The package against the independent reference on all that connects, supports and excites rotors."""

import numpy as np
import pytest

from building import Measured
from cross.comparing import RUN, simulated, worst_difference
from cross.excited_systems import SEEDS, excited_case
from cross.reference import Reference
from gearplay.model.case import Case
from gearplay.parts.mesh.train.geometry import centres
from gearplay.parts.mesh.train.rolling import nominal_speeds


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_excited_trains_equal_the_independent_reference(seed: int, measured: Measured) -> None:
    """Supports, couplings, torque terms, unbalance, base motion and position servos, over 7 ms."""
    worst = worst_difference(excited_case(seed), duration=0.007)
    measured("largest difference over 7 ms of an excited train from SciPy's [m]", worst, "1e-9")


@pytest.mark.parametrize("seed", SEEDS)
def test_places_and_nominal_speeds_are_those_of_the_reference(seed: int) -> None:
    document = excited_case(seed)
    case, reference = Case.model_validate({**document, "run": RUN}), Reference(document)
    for rotor, speed in zip(reference.rotors, nominal_speeds(case), strict=True):
        assert rotor.position == pytest.approx(centres(case)[rotor.name], abs=1e-15)
        assert rotor.nominal_speed == pytest.approx(speed, rel=1e-12)


@pytest.mark.parametrize("seed", [1, 10])
def test_the_housing_moves_as_in_the_reference(seed: int) -> None:
    """A harmonic motion and a half-sine pulse, as the results tell them beside the relative accelerations."""
    document = excited_case(seed)
    _, run = simulated(document)
    base = Reference(document).base
    assert base is not None
    expected = np.array([base.at(float(t)) for t in run.time])
    for k, name in enumerate(("base_ax", "base_ay")):
        np.testing.assert_allclose(run.signal(name, "base"), expected[:, k], atol=1e-9)
