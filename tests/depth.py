"""Three depths of the tests: `make test` has the whole width at small size, `make test-all` full depth, `make torture` more.

A test that repeats something many times asks here how often; one that is marked `deep` is left to the full depth; of a test
marked `many`, which pytest repeats for many parameters, the small size keeps every tenth. `make test-beyond` runs in full depth
only what `make test` left out or did small: after `make test` it makes the rest of `make test-all`. What is repeated more often
still, or lasts for minutes, is left to `make torture`.
"""

import os
from collections.abc import Sequence
from typing import TypeVar

TORTURE = os.environ.get("GEARPLAY_DEEP") == "torture"
BEYOND = os.environ.get("GEARPLAY_DEEP") == "beyond"
DEEP = BEYOND or TORTURE or os.environ.get("GEARPLAY_DEEP") == "1"
SHARE = 10

Each = TypeVar("Each")


def sized(full: int, least: int = 1, *, torture: int | None = None) -> int:
    """Return how often to repeat: ``full`` times, or a tenth of that, never fewer than ``least``; for `make torture` its own."""
    if TORTURE and torture is not None:
        return torture
    return full if DEEP else min(full, max(least, -(-full // SHARE)))


def some(whole: Sequence[Each], least: int = 1) -> Sequence[Each]:
    """Return all of a sequence, or so many of it spread evenly."""
    count = sized(len(whole), least)
    return [whole[at * len(whole) // count] for at in range(count)]
