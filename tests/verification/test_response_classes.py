"""Kinds of motion against responses whose kind is known by construction."""

from collections import Counter
from collections.abc import Callable

from depth import sized
from gearplay.nonlinear.kinds.response import classify
from responses import CLASSES, responses

SEED = 11
EACH = sized(40, 10)


def test_kinds_of_known_responses(measured: Callable[[str, float, str], None]) -> None:
    """Of 200 cycles, tori, chaotic motions and transients 95 % get their kind (and order), and 90 % of each class."""
    right: Counter[str] = Counter()
    for response in responses(SEED, EACH):
        found = classify(response.samples, resolution=response.resolution, swing=response.swing)
        right[response.group] += found.kind == response.kind and found.order == response.order
    total = sum(right.values())
    measured(
        "kind of motion of 200 responses: share wrong", 1.0 - total / (len(CLASSES) * EACH), "at most 0.05"
    )
    assert total >= 0.95 * len(CLASSES) * EACH
    assert all(right[group] >= 0.9 * EACH for group in CLASSES)
