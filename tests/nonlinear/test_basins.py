"""Basins of attraction of the torsional pair, whose resonance has two motions side by side, and of one that is chaotic."""

import threading
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.nonlinear.basins import FAILED, IRREGULAR, Basins
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.vocabulary.errors import InputError

BISTABLE = gp.torsional_pair(0.6, mean_force=0.1, force=0.05)
ANGLE, SPEED = ("wheel.theta", -6e-4, 4e-4, 6), ("wheel.omega", -4.0, 4.0, 5)


@pytest.fixture(scope="module")
def found() -> Basins:
    return gp.basins(BISTABLE, ANGLE, SPEED, settle=150)


def test_two_motions_share_the_plane(found: Basins) -> None:
    assert found.labels.shape == (5, 6)
    assert set(found.labels.ravel().tolist()) == {0, 1}
    assert found.shares.sum() == 1.0
    assert [len(each) for each in found.attractors] == [1, 1]


@pytest.mark.slow
def test_basins__each_start_settles_to_its_label(found: Basins) -> None:
    period_map = StrobeMap(lambda _: BISTABLE, 0.0)
    for row, column in ((0, 0), (2, 3), (4, 5), (1, 4)):
        start = np.array([found.first[column], found.second[row]])
        end = period_map.settle(start, 0.0, 200)
        distances = [np.max(np.abs(a[0] - end) / period_map.scale) for a in found.attractors]
        assert int(np.argmin(distances)) == found.labels[row, column]
        assert min(distances) < 1e-4


def test_attractors_attract_themselves(found: Basins) -> None:
    for label, attractor in enumerate(found.attractors):
        theta, omega = attractor[0]
        near = gp.basins(
            BISTABLE,
            ("wheel.theta", theta - 1e-6, theta + 1e-6, 2),
            ("wheel.omega", omega - 1e-3, omega + 1e-3, 2),
            settle=100,
        )
        assert len(near.attractors) == 1
        assert near.attractors[0] == pytest.approx(found.attractors[label], rel=1e-3)


@pytest.mark.slow
def test_the_number_of_threads_does_not_matter(found: Basins) -> None:
    again = gp.basins(BISTABLE, ANGLE, SPEED, settle=150, threads=1)
    assert np.array_equal(again.labels, found.labels)


def test_basins__chaos_is_irregular_and_failures_are_marked() -> None:
    chaotic = gp.torsional_pair(0.6, mean_force=0.1, force=0.2, damping_ratio=0.1)
    few = [(*grid[:3], 2) for grid in (ANGLE, SPEED)]
    assert np.all(gp.basins(chaotic, few[0], few[1], settle=50).labels == IRREGULAR)
    stopped = gp.replace(BISTABLE, {"run.max_steps": 10})
    assert np.all(gp.basins(stopped, few[0], few[1], settle=50).labels == FAILED)


def test_a_wish_to_stop_is_heard() -> None:
    stop = threading.Event()
    found = gp.basins(BISTABLE, ANGLE, SPEED, settle=50, stop=stop, progress=lambda *_: stop.set())
    assert np.mean(found.labels == FAILED) > 0.5


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"first": ("wheel.x", 0.0, 1.0, 2)},
            r'name = "wheel\.x": must be an entry .* Choose from: x, x\', wheel\.theta, wheel\.omega',
        ),
        (
            {"first": ("pinion.theta", 0.0, 1.0, 2)},
            "must be an entry of the state that is not prescribed",
        ),
        ({"second": ANGLE}, "must be another entry than the first"),
        ({"first": ("wheel.theta", 1.0, 0.0, 2)}, "must have low below high"),
        ({"first": ("wheel.theta", 0.0, 1.0, 1)}, "its lowest and highest value and how many"),
        ({"settle": 0}, "settle = 0"),
    ],
)
def test_what_cannot_be_is_told(change: dict[str, Any], words: str) -> None:
    given = {"first": ANGLE, "second": SPEED, "settle": 10} | change
    with pytest.raises(InputError, match=words):
        gp.basins(BISTABLE, given.pop("first"), given.pop("second"), **given)
