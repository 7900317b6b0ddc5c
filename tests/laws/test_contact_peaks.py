"""Statistics of contacts equal the motion: the largest sample of the motion at 10 ns and below is the judge."""

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import gearplay as gp
from building import Document, forum_pair
from depth import sized
from random_trains import train

Floats = NDArray[np.float64]


class Peak(NamedTuple):
    """The largest force [N or N m] and penetration [m] of a contact."""

    force: float
    penetration: float


def motion_of(result: gp.Result, label: str, sampling: float) -> tuple[Floats, Floats]:
    """Return the force [N or N m] and penetration [m] of a flank, journal or coupling, shape [sample]."""
    owner, _, part = label.partition(":")

    def signal(name: str) -> Floats:
        return result.signal(f"{owner}.{name}", sampling=sampling, window=(0.0, result.case.run.duration))

    if part in ("drive", "back"):
        return signal(f"{part}_force"), signal(f"{part}_penetration")
    if not part:
        return np.hypot(signal("sleeve_force_x"), signal("sleeve_force_y")), signal("sleeve_penetration")
    return (1.0 if part == "forward" else -1.0) * signal("coupling_torque"), np.zeros(1)


def sampled(document: Document, sampling: float) -> dict[str, tuple[Peak, Peak, float]]:
    """Return the largest samples of each contact, its statistics, and how far the peak force is above a fine sample.

    A force that rises at the end of a run is larger there than in its last sample, and one that is damped may peak between two:
    where the statistic is the larger one by more than 0.1 % the motion is looked at every 2 ns.
    """
    result = gp.simulate(gp.load_case(document), threads=1, sampling=sampling)
    statistics, found = result.runs[0].statistics, {}
    for k, label in enumerate(statistics.labels):
        force, depth = motion_of(result, label, sampling)
        seen = Peak(float(force.max(initial=0.0)), float(depth.max(initial=0.0)))
        said = Peak(float(statistics.peak_force[k]), float(statistics.max_penetration[k]))
        fine = seen.force
        if fine > 1.0 and said.force > 1.001 * fine:
            fine = float(motion_of(result, label, 5e8)[0].max())
        found[label] = seen, said, said.force / fine - 1.0 if fine > 1.0 else 0.0
    return found


def test_peaks_of_a_steep_ramp() -> None:
    """2011.1 N and 1917.6 N; a parabola through ends of steps said 6665 N and 6224 N."""
    result = gp.simulate(gp.load_case(forum_pair({"ratio": 0.2, "depth": 1e-6})))
    peaks = result.runs[0].statistics.peak_force
    assert peaks[0] == pytest.approx(2011.1, abs=0.1)
    assert peaks[1] == pytest.approx(1917.7, abs=0.15)


@pytest.mark.parametrize("depth", [1e-8, 1e-7, 1e-6, 1e-5])
def test_peaks__equal_the_largest_samples_under_any_ramp(depth: float) -> None:
    for label, (seen, said, above) in sampled(forum_pair({"ratio": 0.2, "depth": depth}), 1e7).items():
        assert seen.force * (1.0 - 1e-6) <= said.force, label
        assert above <= 1e-3, label
        assert seen.penetration * (1.0 - 1e-6) <= said.penetration <= seen.penetration * 1.001, label


def test_peaks_of_random_trains_are_the_largest_samples() -> None:
    """At any tolerance within 0.1 % of the motion, never below its samples by more than 1e-6 of them, or 1e-12 m of depth."""
    for seed in range(sized(300, 20, torture=2000)):
        rng = np.random.default_rng([43, seed])
        document = train(rng, float(10.0 ** rng.uniform(-9.0, -3.0)))
        for sleeve in document.get("sleeves", {}).values():
            sleeve.pop("friction_coefficient", None)  # the statistic is of the normal force
        document["run"] |= {"duration": 1e-3}
        for label, (seen, said, above) in sampled(document, 5e6).items():
            assert said.force >= seen.force * (1.0 - 1e-6) - 1e-9, (seed, label)
            assert said.penetration >= seen.penetration * (1.0 - 1e-6) - 1e-12, (seed, label)
            assert above <= 1e-3, (seed, label)
