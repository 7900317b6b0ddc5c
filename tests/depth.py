"""Four depths of the tests, chosen by ``GEARPLAY_TESTS``: quick, all, full and torture.

================ ============================ ============== =================================================
``make`` target  ``GEARPLAY_TESTS``           tests          repetitions (`sized`, `some`, mark ``many``)
================ ============================ ============== =================================================
``test``         ``quick``, the default       without `slow` a tenth, at least ``least``
``test-all``     ``all``                      without `deep` a tenth, at least ``least``
``test-full``    ``full``                     every one      all
``torture``      ``torture``                  ``hostile``    all, or the number given by ``torture=``
================ ============================ ============== =================================================
"""

import os
from collections.abc import Sequence
from typing import TypeVar

DEPTHS = ("quick", "all", "full", "torture")
DEPTH = DEPTHS.index(os.environ.get("GEARPLAY_TESTS", "quick"))
ALL, FULL, TORTURE = DEPTH >= 1, DEPTH >= 2, DEPTH >= 3
SHARE = 10

Each = TypeVar("Each")


def sized(full: int, least: int = 1, *, torture: int | None = None) -> int:
    """Return the number of repetitions: ``full``, or a tenth of it and at least ``least``; ``torture`` at that depth."""
    if TORTURE and torture is not None:
        return torture
    return full if FULL else min(full, max(least, -(-full // SHARE)))


def some(whole: Sequence[Each], least: int = 1) -> Sequence[Each]:
    """Return all of a sequence, or so many of it spread evenly."""
    count = sized(len(whole), least)
    return [whole[at * len(whole) // count] for at in range(count)]
