"""Statistics of contacts equal the motion: the largest sample of the motion at 10 ns and below is the judge."""

from typing import NamedTuple

import numpy as np
import pytest

import gearplay as gp
from building import Document, forum_pair
from depth import sized
from random_trains import train


class Peak(NamedTuple):
    """The largest force [N or N m] and penetration [m] of a contact."""

    force: float
    penetration: float


def sampled(document: Document, sampling: float) -> dict[str, tuple[Peak, Peak, bool]]:
    """Return the largest samples and the statistics of each flank, journal and coupling, and whether its force falls at the end.

    A force that rises at the end of a run is larger there than in its last sample.
    """
    result = gp.simulate(gp.load_case(document), threads=1, sampling=sampling)
    run = result.runs[0]
    found = {}
    for k, label in enumerate(run.statistics.labels):
        owner, _, part = label.partition(":")
        if part in ("drive", "back"):
            force, depth = run.signal(f"{part}_force", owner), run.signal(f"{part}_penetration", owner)
        elif not part:
            force = np.hypot(run.signal("sleeve_force_x", owner), run.signal("sleeve_force_y", owner))
            depth = run.signal("sleeve_penetration", owner)
        else:
            sign = 1.0 if part == "forward" else -1.0
            force, depth = sign * run.signal("coupling_torque", owner), np.zeros(1)
        seen = Peak(float(force.max(initial=0.0)), float(depth.max(initial=0.0)))
        said = Peak(float(run.statistics.peak_force[k]), float(run.statistics.max_penetration[k]))
        found[label] = seen, said, bool(np.argmax(force) < len(force) - 1)
    return found


def test_peaks_of_a_steep_ramp() -> None:
    """2011.1 N and 1917.6 N; a parabola through ends of steps said 6665 N and 6224 N."""
    result = gp.simulate(gp.load_case(forum_pair({"ratio": 0.2, "depth": 1e-6})))
    peaks = result.runs[0].statistics.peak_force
    assert peaks[0] == pytest.approx(2011.1, abs=0.1)
    assert peaks[1] == pytest.approx(1917.7, abs=0.15)


@pytest.mark.parametrize("depth", [1e-8, 1e-7, 1e-6, 1e-5])
def test_peaks_are_the_largest_samples_whatever_the_ramp(depth: float) -> None:
    for label, (seen, said, _) in sampled(forum_pair({"ratio": 0.2, "depth": depth}), 1e7).items():
        assert seen.force * (1.0 - 1e-6) <= said.force <= seen.force * 1.001, label
        assert seen.penetration * (1.0 - 1e-6) <= said.penetration <= seen.penetration * 1.001, label


def test_peaks_of_random_trains_are_the_largest_samples() -> None:
    """At any tolerance within 0.1 % of the motion, never below its samples by more than 1e-6 of them."""
    for seed in range(sized(300, 20, torture=2000)):
        rng = np.random.default_rng([43, seed])
        document = train(rng, float(10.0 ** rng.uniform(-9.0, -3.0)))
        for sleeve in document.get("sleeves", {}).values():
            sleeve.pop("friction_coefficient", None)  # the statistic is of the normal force
        document["run"] |= {"duration": 1e-3}
        for label, (seen, said, falls) in sampled(document, 5e6).items():
            assert said.force >= seen.force * (1.0 - 1e-6) - 1e-9, (seed, label)
            assert said.penetration >= seen.penetration * (1.0 - 1e-6) - 1e-15, (seed, label)
            if falls and seen.force > 1.0:
                assert said.force <= seen.force * 1.001, (seed, label)
