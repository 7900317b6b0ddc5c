"""A hypothesis about a machine, with its evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

MOST: Final = 1.5
"""Largest strength [decades]."""
NONE: Final = -2.0
"""Strength [decades] of a cause without evidence, the least."""


@dataclass(frozen=True)
class Evidence:
    """A figure for or against a hypothesis: ``value`` against the ``threshold`` from which it counts, in ``unit``."""

    words: str
    value: float
    threshold: float
    unit: str = "1"

    @property
    def strength(self) -> float:
        """Decades above the threshold."""
        if self.value <= 0.0:
            return NONE
        return min(MOST, max(NONE, math.log10(self.value / self.threshold)))


@dataclass(frozen=True)
class Hypothesis:
    """A possible cause, its evidence, and the confidence that it is the cause; ``place`` is that of the gear or bearing."""

    name: str
    kind: str
    evidence: tuple[Evidence, ...]
    strength: float
    confidence: float = 0.0
    place: int = -1

    @property
    def strongest(self) -> Evidence:
        """The evidence furthest above its threshold."""
        return max(self.evidence, key=lambda each: each.strength)
