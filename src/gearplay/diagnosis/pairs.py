"""Two causes that occur together, as variants of a case to simulate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.suspects import Suspect


def pairs_of(told: Sequence[Hypothesis], ranked: Sequence[Suspect]) -> list[Suspect]:
    """Return the causes to simulate for the first two stated hypotheses, one for each severity of the first; none without two.

    ``ranked`` are the simulated causes, the best agreement first, of which the first one of each hypothesis is taken, of rattle
    a wear.
    """
    if len(told) < 2:
        return []
    chosen = [next((s for s in ranked if _stands_for(s, h)), None) for h in told[:2]]
    if chosen[0] is None or chosen[1] is None:
        return []
    one, other = chosen[0], chosen[1]
    if {*one.levels[0]} & {*other.levels[0]} - {"faults"}:
        return []  # both change the same field
    return [
        Suspect(
            f"{one.name} together with {other.name}",
            f"{one.kind} {other.kind}",
            tuple(h.name for h in told[:2]),
            other.quantity,
            other.sizes,
            tuple(_merged(level, more) for more in other.levels),
            replace(one, sizes=(size,), levels=(level,)),
        )
        for size, level in zip(one.sizes, one.levels, strict=True)
    ]


def _stands_for(suspect: Suspect, h: Hypothesis) -> bool:
    return h.name in suspect.hypotheses or (suspect.kind == h.kind == "rattle")


def _merged(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return the changes of both causes; each has the faults of the case, and its own as the last one."""
    both = {**one, **other}
    if "faults" in one and "faults" in other:
        both["faults"] = [*one["faults"], other["faults"][-1]]
    return both
