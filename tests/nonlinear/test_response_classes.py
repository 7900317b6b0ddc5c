"""Kinds of motion against responses whose kind is known by construction."""

from collections import Counter
from collections.abc import Callable

import pytest

from depth import sized
from gearplay.nonlinear.kinds.classify import classify
from other_responses import others
from responses import CLASSES, responses

EACH = sized(40, 4)


@pytest.mark.slow
def test_kinds_of_known_responses(measured: Callable[[str, float, str], None]) -> None:
    """Of 200 cycles, tori, chaotic motions and transients at most one is named falsely, 90 % of each class rightly."""
    right: Counter[str] = Counter()
    false = []
    for response in responses(11, EACH):
        found = classify(response.samples, resolution=response.resolution, swing=response.swing)
        right[response.group] += found.kind == response.kind and found.order == response.order
        if found.kind not in (response.kind, "undecided") or found.order not in (response.order, None):
            false.append(f"{response.group}, {response.recipe}: {found.kind}. {found.reason}")
    total = len(CLASSES) * EACH
    measured("kind of motion of 200 responses: share false", len(false) / total, "at most 0.005")
    measured(
        "kind of motion of 200 responses: share undecided",
        1 - (sum(right.values()) + len(false)) / total,
        "0.05",
    )
    assert len(false) <= 0.005 * total, false
    assert all(right[group] >= 0.9 * EACH for group in CLASSES), right


@pytest.mark.slow
def test_kinds_of_other_responses(measured: Callable[[str, float, str], None]) -> None:
    """Of 160 oscillators, maps, noisy tones, noise, drifts and slow oscillations at most one is named falsely."""
    false, total = [], 0
    for response in others(11, sized(20, 2)):
        found = classify(response.samples, resolution=response.resolution)
        total += 1
        if found.kind != "undecided" and (found.kind, found.order) not in response.right:
            false.append(f"{response.name}: {found.kind} of order {found.order}. {found.reason}")
    measured("kind of motion of 160 other responses: share false", len(false) / total, "at most 0.01")
    assert len(false) <= 0.01 * total, false
