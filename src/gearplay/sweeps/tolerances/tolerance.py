"""Tolerance analysis of one measure: distribution, exceedance, sensitivity indices, critical end of each range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.plans.design import Design
from gearplay.sweeps.tolerances.statistics import Distribution, Exceedance, distribution, exceedance
from gearplay.sweeps.variance import Indices, as_table, independent_rows, indices_of

Floats = NDArray[np.float64]
PART = 0.2
"""Share of the points that a cut leaves out."""
FEWEST = 20
"""Points that a cut needs at least."""


@dataclass(frozen=True)
class Cut:
    """What it brings to leave out the lowest or highest fifth of a parameter's draws.

    ``bound`` is the value where the cut is, ``probability`` the exceedance of what is left, with its interval.
    """

    name: str
    end: str
    bound: float
    probability: float
    low: float
    high: float


@dataclass(frozen=True)
class Answers:
    """Results of a sample for one measure and its limit."""

    distribution: Distribution
    exceedance: Exceedance
    indices: Indices
    cuts: tuple[Cut, ...]


def answers_of(
    design: Design, drawn: Floats, values: Floats, limit: float, *, confidence: float = 0.95, seed: int = 0
) -> Answers:
    """Return the answers from a design's drawn points, shape [sample, parameter], and the measure there, shape [sample, ...].

    Of a saltelli design only the independent points are used for the distribution; all points are used for the indices.
    """
    rows, table = independent_rows(design), as_table(values)
    names = [p.name for p in design.parameters]
    return Answers(
        distribution(table[rows], confidence),
        exceedance(table[rows], limit, confidence),
        indices_of(design, table, confidence=confidence, seed=seed),
        cuts_of(names, drawn[rows], table[rows], limit, confidence),
    )


def cuts_of(
    names: Sequence[str], drawn: Floats, values: Floats, limit: float, confidence: float = 0.95
) -> tuple[Cut, ...]:
    """Return for each parameter the better of its two cuts, that which helps most first; empty where nothing exceeds.

    The end is chosen by the same sample, so a small gain may be luck: compare the intervals.
    """
    table = as_table(values)
    if len(table) < FEWEST or not np.any(table > limit):
        return ()
    count = round(PART * len(table))
    found = []
    for at, name in enumerate(names):
        order = np.argsort(drawn[:, at], kind="stable")
        for end, left in (("low", order[count:]), ("high", order[:-count])):
            kept = exceedance(table[left], limit, confidence)
            bound = float(drawn[left[0 if end == "low" else -1], at])
            found.append(Cut(name, end, bound, kept.probability, kept.low, kept.high))
    known = [
        cut for cut in found if cut.probability == cut.probability
    ]  # not those whose rest failed throughout
    best: dict[str, Cut] = {}
    for cut in sorted(known, key=lambda cut: cut.probability):
        best.setdefault(cut.name, cut)
    return tuple(best.values())
