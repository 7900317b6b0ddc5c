"""Which causes explain the evidence of others, and the confidence in each, alone or together with others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Final

from gearplay.diagnosis.bearing_combs import PARTS, SLIP, coincide, strongest_line
from gearplay.diagnosis.evidence import NONE, Hypothesis
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import Measures

CEILING: Final = 0.95
"""Largest confidence; of `HEALTHY` it is `ABSENCE`, since damage may hide."""
ABSENCE: Final = 0.65
BLIND: Final = 0.4
"""Largest confidence of `HEALTHY` where the speed, and with it the gears, stay unknown."""
BY_SPEED: Final = ("tooth", "eccentric", "planets", "rattle")
"""Kinds whose evidence stands at multiples of the speed; where that stays unknown their largest confidence is `ALIKE`."""
ALIKE: Final = 0.6
"""Largest confidence of a part of a bearing whose lines another part has too, less than `TWIN` weaker, or a shaft's turn."""
TWIN: Final = 0.9
"""Difference of the strengths [decades] of two parts with lines at one place, below which either may be the cause."""
OF_CAGE: Final = 1.0
"""Strength of a cage from which lines of the outer ring are taken for its multiples [decades]."""
LEFT: Final = 0.03
"""Height of a comb of envelope lines, relative to that of a stronger one, that the latter's smeared lines and sidebands leave."""
PARTLY: Final = 0.3
"""Part of the evidence [decades] that a tooth and an eccentricity of one gear explain of each other, and others of rattle."""
TOGETHER: Final = 3
"""Most causes that occur together."""
RARE: Final = 0.5
"""Odds of a further cause in a machine that has one, relative to those of a cause."""


def with_confidences(machine: Machine, found: Measures, every: list[Hypothesis]) -> list[Hypothesis]:
    """Return the hypotheses with strengths less what others explain, and confidences, the likeliest first; the last is none.

    The weight of a cause is 10^(2 strength), of none 1; of up to `TOGETHER` causes, the strongest among them, the product of
    theirs and of `RARE` for each further one, their strengths less what the others of them explain. Causes that explain the same
    evidence, as parts of bearings whose lines coincide, exclude each other. The confidence is the weight of all sets of causes
    that hold a cause, over that of all sets. None is stated of a record whose rms is less than a step of its quantisation.
    """
    none = every[-1]
    every = [replace(h, strength=NONE) if _is_leakage(found, h, every) else h for h in every]
    doubtful = {h.name for h in every if _has_twin(machine, h, every) or on_a_turn(machine, found, h)}
    causes, lead = _explained(machine, every[:-1])
    weights = [10.0 ** (2.0 * h.strength) if h.strength > NONE else 0.0 for h in causes]
    total = 1.0 + sum(weights)
    for others, weight in _sets(machine, causes, lead):
        total += weight
        for k in others:
            weights[k] += weight
    blind = bool(machine.meshes) and not found.speed.known
    if found.quantised and found.statistics.rms < found.step:
        doubtful |= {h.name for h in causes}
    most = {"none": BLIND, **dict.fromkeys(BY_SPEED, ALIKE)} if blind else {"none": ABSENCE}
    best = [
        replace(h, confidence=min(ALIKE if h.name in doubtful else most.get(h.kind, CEILING), weight / total))
        for h, weight in zip([*causes, none], [*weights, 1.0], strict=True)
    ]
    return sorted(best, key=lambda each: -each.confidence)


def _explained(machine: Machine, every: list[Hypothesis]) -> tuple[list[Hypothesis], Hypothesis | None]:
    """Return the hypotheses without the evidence that the strongest one explains, and that one, None without any."""
    lead = max(every, key=lambda h: h.strength, default=None)
    if lead is None or lead.strength <= 0.0:
        return every, None
    # BPFO is a multiple of FTF, of which a dented ring shows no other ones.
    lead = next((h for h in every if h.strength >= OF_CAGE and _holds_lines_of(h, lead)), lead)
    highest = max((h.evidence[0].value for h in every if has_lines(machine, h)), default=0.0)
    less = [
        h if h is lead else replace(h, strength=h.strength - _share(machine, lead, h, highest)) for h in every
    ]
    return less, lead


def _sets(
    machine: Machine, causes: Sequence[Hypothesis], lead: Hypothesis | None
) -> Iterator[tuple[tuple[int, ...], float]]:
    """Yield the sets of two causes and more with the strongest one, as their places, and their weights."""
    first = next((k for k, h in enumerate(causes) if h is lead), None)
    if first is None:
        return
    others = [
        k
        for k, h in enumerate(causes)
        if h.strength > 0.0 and k != first and not _exclude(machine, causes[first], h)
    ]
    for count in range(1, TOGETHER):
        for chosen in combinations(sorted(others, key=lambda k: -causes[k].strength), count):
            members = [causes[k] for k in chosen]
            if any(_exclude(machine, one, other) for one, other in combinations(members, 2)):
                continue
            less = sum(_share(machine, one, other) for one, other in combinations(members, 2))
            strength = causes[first].strength + sum(h.strength for h in members) - less
            yield (first, *chosen), RARE**count * 10.0 ** (2.0 * strength)


def _exclude(machine: Machine, one: Hypothesis, other: Hypothesis) -> bool:
    """Return whether two causes explain the same evidence: lines that coincide, or gears that turn alike.

    A tooth of a planetary set has lines at so many turns, each with sidebands, that some are those of a planet's bearing, and the
    mesh is a multiple of them.
    """
    if any(h.kind == "tooth" and has_lines(machine, h) for h in (one, other)) and "rattle" in (
        one.kind,
        other.kind,
    ):
        return True
    if has_lines(machine, one) and has_lines(machine, other):
        of_planet = any(h.kind in PARTS and machine.bearings[h.place].carrier > 0.0 for h in (one, other))
        return look_alike(machine, one, other) or (of_planet and "tooth" in (one.kind, other.kind))
    gears = ("tooth", "eccentric")
    if one.kind not in gears or other.kind not in gears or one.place == other.place:
        return False
    return abs(machine.gears[one.place].order / machine.gears[other.place].order - 1.0) < 1e-6


def _share(machine: Machine, lead: Hypothesis, h: Hypothesis, highest: float = 0.0) -> float:
    """Return how much of the evidence of a hypothesis a stronger one explains [decades]; ``highest`` is that of all combs."""
    if has_lines(machine, lead) and has_lines(machine, h):
        if look_alike(machine, lead, h) and not _holds_lines_of(lead, h):
            return 0.0  # lines at one place cannot be told apart
        return math.log10(1.0 + LEFT * max(lead.evidence[0].value, highest))
    if {lead.kind, h.kind} == {"tooth", "eccentric"}:
        # An event modulates too, a modulation leaves a difference.
        return PARTLY if lead.place == h.place else 0.0
    # Other impacts are shocks, too, and modulate the mesh.
    return max(PARTLY, math.log10(1.0 + LEFT * highest)) if h.kind == "rattle" else 0.0


def _holds_lines_of(one: Hypothesis, other: Hypothesis) -> bool:
    """Return whether the frequency of ``other`` is a multiple of that of ``one``: BPFO is Z times FTF of the same bearing."""
    return one.kind == "cage" and other.kind == "outer" and one.place == other.place


def _is_leakage(found: Measures, h: Hypothesis, every: Sequence[Hypothesis]) -> bool:
    """Return whether a cage's comb is so far below that of its outer ring that the ring's smeared lines leave it.

    By the height over chance or, in a record without noise, by the depth of modulation.
    """
    for ring in every:
        if _holds_lines_of(h, ring):
            own, whole = found.bearings[h.place, h.kind], found.bearings[ring.place, ring.kind]
            return own.height <= LEFT * whole.height or own.depth <= LEFT * whole.depth
    return False


def look_alike(machine: Machine, one: Hypothesis, other: Hypothesis) -> bool:
    """Return whether the strongest lines of two parts of bearings, or teeth, may coincide: within the slip, or as multiples."""
    if one.kind in PARTS and other.kind in PARTS:
        return coincide(machine, (one.place, one.kind), (other.place, other.kind))
    ratio = _strongest_line(machine, other) / _strongest_line(machine, one)
    if not {one.kind, other.kind} & {*PARTS}:  # teeth do not slip
        return any(abs(k * ratio - 1.0) < 1e-3 for h in (1.0, 2.0, 3.0, 4.0) for k in (h, 1.0 / h))
    return any(abs(k * ratio - 1.0) < 1.25 * SLIP for k in (0.5, 1.0, 2.0))


def has_lines(machine: Machine, h: Hypothesis) -> bool:
    """Return whether the evidence is a comb of envelope lines: of a part of a bearing, or a tooth of a planetary set."""
    if h.kind != "tooth" or machine.gears[h.place].shaft is not None:
        return h.kind in PARTS
    own = machine.set_of(h.place)
    return own is None or h.place != own.gears[2]


def _has_twin(machine: Machine, one: Hypothesis, every: list[Hypothesis]) -> bool:
    """Return whether another part of a bearing, or tooth of a planetary set, explains the same lines nearly as well."""
    others = [h for h in every if has_lines(machine, h) and h is not one] if has_lines(machine, one) else []
    return any(h.strength > max(0.0, one.strength - TWIN) and look_alike(machine, one, h) for h in others)


def on_a_turn(machine: Machine, found: Measures, h: Hypothesis) -> bool:
    """Return whether the lines of a bearing part are, to a line of the envelope, multiples of a turn, which others excite too."""
    if h.kind not in PARTS:
        return False
    f, comb = found.speed.frequency, found.bearings[h.place, h.kind]
    line = comb.frequency * (2.0 if h.kind == "element" else 1.0)
    turns = [k * shaft.order * f for shaft in machine.shafts for k in range(1, 7)]
    return any(abs(line - turn) * found.rest.duration < 1.0 for turn in turns)


def _strongest_line(machine: Machine, h: Hypothesis) -> float:
    """Return the order of the strongest envelope line of a part of a bearing, or of a tooth of a planetary set."""
    return strongest_line(machine, (h.place, h.kind)) if h.kind in PARTS else machine.gears[h.place].order
