"""Hypotheses about a machine, ranked by the evidence of a record."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

from gearplay.diagnosis.bearing_combs import PARTS, SLIP, coincide, strongest_line
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import Measures

HEALTHY: Final = "no damage that this record shows"
RATTLE: Final = "rattle of the flanks"

EVENT: Final = 2.2
"""Ratio of a tooth's event to its surroundings, of which 1 is noise, from which it counts."""
MODULATION: Final = 0.2
"""Sum of both first sidebands over the mesh harmonics, from which it counts without a healthy record."""
COMB: Final = 1.0
"""Summed prominence of an envelope's comb over what noise reaches by chance, from which it counts."""
DEPTH: Final = 0.06
"""Depth of an envelope's modulation at the mesh, from which impacts of the flanks count."""
WAVEFORM: Final = 7.0
"""Kurtosis of the mean mesh period, from which impacts of the flanks count."""
LEAST_REST: Final = 1e-4
"""Least share of what repeats with no shaft in the mean square, in which rattle is sought: below it is left of the averages."""
UNEVEN: Final = 0.15
"""Lines of a planetary set that even planets do not have over those that they have, from which they count."""
RING: Final = 2.2
"""Event of a tooth of a standing ring over the teeth beside it, from which it counts."""
WORSE: Final = 1.6
"""Factor over the healthy record, from which a measure counts."""
MOST: Final = 1.5
"""Largest strength [decades]."""
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
SHOCKS: Final = 3.0
"""Kurtosis of the most impulsive band, less that of noise, in every quarter of a record, from which shocks count."""
APERIODIC: Final = 0.3
"""Largest strength of shocks without a period, which other sources make as well."""
TOLD: Final = 0.7
"""Confidence from which a hypothesis is said; no first hypothesis of the test records that was wrong had as much."""


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
            return -2.0
        return min(MOST, max(-2.0, math.log10(self.value / self.threshold)))


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


def ranked(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    """Return all hypotheses, the likeliest first.

    The strength of each is its evidence in decades above a threshold, which a healthy record raises to `WORSE` times its own
    value. What one cause explains of the evidence of another is taken off. Confidences are the weights 10^(2 strength) over the
    sum of all, with 1 for none of them.
    """
    every = [
        *_teeth(machine, found, healthy),
        *_eccentric(machine, found, healthy),
        *_planets(machine, found, healthy),
        *_bearings(machine, found, healthy),
        *_rattle(machine, found, healthy),
    ]
    doubtful = {h.name for h in every if _has_twin(machine, h, every) or on_a_turn(machine, found, h)}
    every = _explained(machine, every)
    weights = [10.0 ** (2.0 * each.strength) if each.strength > -2.0 else 0.0 for each in every]
    total = 1.0 + sum(weights)
    every.append(Hypothesis(HEALTHY, "none", (), 0.0))
    shares = [*(w / total for w in weights), 1.0 / total]
    blind = bool(machine.meshes) and not found.speed.known
    most = {"none": BLIND, **dict.fromkeys(BY_SPEED, ALIKE)} if blind else {"none": ABSENCE}
    best = [
        replace(h, confidence=min(ALIKE if h.name in doubtful else most.get(h.kind, CEILING), share))
        for h, share in zip(every, shares, strict=True)
    ]
    return sorted(best, key=lambda each: -each.confidence)


def _threshold(plain: float, before: Any, measure: str, *, least: float = 0.5) -> float:
    """Return the threshold of a measure: ``plain``, or with a healthy record `WORSE` times its value."""
    return plain if before is None else max(least * plain, WORSE * float(getattr(before, measure)))


def _teeth(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    largest = max((each.size for each in found.gears.values()), default=0.0)
    hypotheses = []
    for k, gear in found.gears.items():
        before = healthy.gears.get(k) if healthy is not None else None
        words = f"event at tooth {gear.tooth} of {machine.gears[k].teeth}, counted from the start, over the rest of the turn"
        event = Evidence(words, gear.event, _threshold(EVENT, before, "event", least=0.8))
        moment = Evidence("FM4 of the difference signal, 3 of noise", gear.indicators.fm4, 5.0)
        # An average that holds the other gear's turn too shows its events, smaller ones.
        strength = event.strength - (1.0 if gear.size < 0.7 * largest else 0.0)
        name = f"damaged tooth on {machine.gears[k].name}"
        hypotheses.append(Hypothesis(name, "tooth", (event, moment), strength, place=k))
    for k, comb in found.events.items():
        old = healthy.events.get(k) if healthy is not None else None
        words = f"envelope lines of one tooth's contacts, {comb.frequency:.5g} Hz and multiples, over chance"
        lines = Evidence(
            words,
            comb.height,
            _threshold(COMB, old, "height"),
        )
        name = f"damaged tooth on {machine.gears[k].name}"
        hypotheses.append(Hypothesis(name, "tooth", (lines,), lines.strength, place=k))
    return hypotheses


def _eccentric(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    hypotheses = []
    for k, gear in found.gears.items():
        before = healthy.gears.get(k) if healthy is not None else None
        words = f"first sidebands of the mesh harmonics at the turn of {machine.gears[k].name}, over these"
        limit = _threshold(MODULATION, before, "modulation")
        sides = Evidence(words, gear.modulation, limit)
        # Half a decade of modulation is as much as a decade of an event.
        strength = min(MOST, 2.0 * sides.strength)
        hypotheses.append(
            Hypothesis(f"eccentric {machine.gears[k].name}", "eccentric", (sides,), strength, place=k)
        )
    return hypotheses


def _planets(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    """Return the hypotheses of planetary sets: uneven planets, an eccentric sun or planet, a tooth of the standing ring."""
    hypotheses = []
    for k, own in enumerate(found.sets):
        each, before = machine.sets[k], healthy.sets[k] if healthy is not None and healthy.sets else None
        sun, planet, ring = each.gears
        lines = f"lines of {each.name} over those that even planets have"
        for measure, name, kind, place, words in (
            ("uneven", f"uneven planets of {each.name}", "planets", k, f"{lines}: between these, at the carrier's turns"),
            ("sun", f"eccentric {each.name}.sun", "eccentric", sun, f"{lines}: at the sun's turns against the carrier"),
            ("planet", f"eccentric {each.name}.planet", "eccentric", planet, f"{lines}: at a planet's turns against the carrier"),
            ("ring", f"damaged tooth on {each.name}.ring", "tooth", ring, "event of each planet at one tooth, over those beside"),
        ):  # fmt: skip
            value, tooth = getattr(own, measure), measure == "ring"
            if not math.isnan(value):
                limit = _threshold(RING if tooth else UNEVEN, before, measure, least=0.8 if tooth else 0.5)
                evidence = Evidence(words, value, limit)
                strength = min(MOST, (1.0 if tooth else 2.0) * evidence.strength)
                hypotheses.append(Hypothesis(name, kind, (evidence,), strength, place=place))
    return hypotheses


def _bearings(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    hypotheses = []
    for (k, part), comb in found.bearings.items():
        before = healthy.bearings.get((k, part)) if healthy is not None else None
        line = {"outer": "BPFO", "inner": "BPFI", "element": "BSF", "cage": "FTF"}[part]
        words = f"envelope lines of {line} near {comb.frequency:.5g} Hz, {comb.low:.0f} to {comb.high:.0f} Hz, over chance"
        lines = Evidence(
            words,
            comb.height,
            _threshold(COMB, before, "height"),
        )
        off = Evidence(
            f"distance from the kinematic {line}, which slip explains up to 0.01", abs(comb.off), 0.01
        )
        # Slip beyond 1 % is rare, and such a line may be another bearing's.
        strength = lines.strength - 0.25 * (comb.off / 0.01) ** 2
        name = f"{machine.bearings[k].name}, {PARTS[part]}"
        hypotheses.append(Hypothesis(name, part, (lines, off), strength, place=k))
    return hypotheses


def _rattle(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    if not machine.meshes:
        return []
    combs = [*zip(found.mesh, machine.meshes, strict=True)]
    comb, mesh = max(combs, key=lambda pair: min(pair[0].height / COMB, pair[0].depth / DEPTH))
    at = machine.meshes.index(mesh)
    before = healthy.mesh[at] if healthy is not None else None
    share = 1.0 if found.rest_share >= LEAST_REST else 0.0
    lines = Evidence(f"envelope lines at {mesh.name} of what repeats with no shaft, over chance",
                     share * comb.height, _threshold(COMB, before, "height"))  # fmt: skip
    depth = Evidence("depth of the envelope's modulation at the mesh", share * comb.depth,
                     _threshold(DEPTH, before, "depth"))  # fmt: skip
    wave = Evidence("kurtosis of the mean mesh period, 1.5 of a sine", found.waveform,
                    _threshold(WAVEFORM, healthy, "waveform"))  # fmt: skip
    shocks = Evidence("kurtosis of the most impulsive band, less that of noise, in every quarter of the record",
                      share * found.impulsive, _threshold(SHOCKS, healthy, "impulsive"))  # fmt: skip
    strength = max(min(lines.strength, depth.strength), wave.strength, min(APERIODIC, shocks.strength))
    return [Hypothesis(RATTLE, "rattle", (lines, depth, wave, shocks), strength)]


def _explained(machine: Machine, every: list[Hypothesis]) -> list[Hypothesis]:
    """Return the hypotheses without the evidence that the strongest one explains."""
    lead = max(every, key=lambda h: h.strength, default=None)
    if lead is None or lead.strength <= 0.0:
        return every
    # BPFO is a multiple of FTF, of which a dented ring shows no other ones.
    lead = next((h for h in every if h.strength >= OF_CAGE and _holds_lines_of(h, lead)), lead)
    return [h if h is lead else replace(h, strength=h.strength - _share(machine, lead, h)) for h in every]


def _share(machine: Machine, lead: Hypothesis, h: Hypothesis) -> float:
    """Return how much of the evidence of a hypothesis the leading one explains [decades]."""
    if lead.kind in PARTS and h.kind in PARTS:
        # Harmonics and sidebands pass lines of the other parts; lines at one place cannot be told apart.
        return 0.0 if look_alike(machine, lead, h) and not _holds_lines_of(lead, h) else 0.7
    if {lead.kind, h.kind} == {"tooth", "eccentric"}:
        return 0.5  # an event modulates too, a modulation leaves a difference
    return 0.3 if lead.kind == "rattle" or {lead.kind, h.kind} & {*PARTS} else 0.0


def _holds_lines_of(one: Hypothesis, other: Hypothesis) -> bool:
    """Return whether the frequency of ``other`` is a multiple of that of ``one``: BPFO is Z times FTF of the same bearing."""
    return one.kind == "cage" and other.kind == "outer" and one.place == other.place


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
