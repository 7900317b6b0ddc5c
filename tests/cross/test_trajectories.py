"""The compiled kernels against an independent reference: plain Python, SciPy's DOP853, every event located."""

import pytest

from building import Measured
from cross.comparing import simulated, worst_difference
from cross.random_systems import random_case
from cross.reference import Reference
from depth import some


# 43 and 58: a damped flank lets go and takes hold again within one step, just before it opens.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [*some(range(20), 10), 43, 58])
def test_trajectory_equals_the_independent_reference(seed: int, measured: Measured) -> None:
    worst = worst_difference(random_case(seed))
    measured("largest difference over 10 ms from an independent SciPy simulator [m]", worst, "1e-9")


RIPPLE = [
    {"order": 1, "amplitude": 0.05, "phase": 0.4},
    {"order": 9, "amplitude": 0.03, "phase": 2.0},
    {"order": 40, "amplitude": 0.02, "phase": -1.0},
]  # in 10 ms the highest order has one to three periods


@pytest.mark.slow
@pytest.mark.parametrize("seed", some([0, 1, 2, 3, 5, 6, 9, 11, 13, 16, 17, 18], 4))
def test_a_rippling_drive_equals_the_independent_reference(seed: int, measured: Measured) -> None:
    document = random_case(seed)
    drives = [r["drive"] for r in document["rotors"].values() if "drive" in r]
    assert [d["kind"] for d in drives] == ["speed"]
    drives[0]["ripple"] = RIPPLE
    worst = worst_difference(document)
    measured("largest difference over 10 ms of a rippling drive from SciPy's [m]", worst, "1e-9")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2, 5, 11])
def test_forces_equal_the_independent_reference(seed: int) -> None:
    document = random_case(seed)
    case, run = simulated(document)
    reference = Reference(document)
    expected = reference.trajectory(run.time)
    for at in range(0, len(run.time), 7):
        forces = reference.forces(float(run.time[at]), expected["state"][at], expected["impact_speed"][at])
        for mesh in case.meshes:
            label = f"{mesh.driver}-{mesh.driven}"
            found = forces["mesh"][label]
            for signal, key in (
                ("drive_penetration", "p_d"),
                ("back_penetration", "p_b"),
                ("backlash", "b_t"),
                ("center_distance", "A"),
            ):
                assert abs(run.signal(signal, label)[at] - found[key]) < 1e-11
            for signal, key in (("drive_force", "F_d"), ("back_force", "F_b")):
                assert run.signal(signal, label)[at] == pytest.approx(found[key], rel=1e-5, abs=1e-3)
