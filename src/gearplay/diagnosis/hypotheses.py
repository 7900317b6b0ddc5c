"""Hypotheses about a machine, ranked by the evidence of a record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

from gearplay.diagnosis.bearing_combs import PARTS
from gearplay.diagnosis.evidence import MOST, Evidence, Hypothesis
from gearplay.diagnosis.explanations import with_confidences
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
SHOCKS: Final = 3.0
"""Kurtosis of the most impulsive band, less that of noise, in every quarter of a record, from which shocks count."""
APERIODIC: Final = 0.3
"""Largest strength of shocks without a period, which other sources make as well."""
TOLD: Final = 0.7
"""Confidence from which a hypothesis is said; no first hypothesis of the test records that was wrong had as much."""


def ranked(machine: Machine, found: Measures, healthy: Measures | None) -> list[Hypothesis]:
    """Return all hypotheses, the likeliest first: see `with_confidences`.

    The strength of each is its evidence in decades above a threshold, which a healthy record raises to `WORSE` times its own
    value.
    """
    every = [
        *_teeth(machine, found, healthy),
        *_eccentric(machine, found, healthy),
        *_planets(machine, found, healthy),
        *_bearings(machine, found, healthy),
        *_rattle(machine, found, healthy),
    ]
    return with_confidences(machine, found, [*every, Hypothesis(HEALTHY, "none", (), 0.0)])


def stated(every: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the damages with the stated confidence or more, the likeliest first: of several each occurs with the others."""
    return [h for h in every if h.kind != "none" and h.confidence >= TOLD]


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
    share = 1.0 if found.rest_share >= LEAST_REST and not found.quantised else 0.0
    lines = Evidence(f"envelope lines at {mesh.name} of what repeats with no shaft, over chance",
                     share * comb.height, _threshold(COMB, before, "height"))  # fmt: skip
    depth = Evidence("depth of the envelope's modulation at the mesh", share * comb.depth,
                     _threshold(DEPTH, before, "depth"))  # fmt: skip
    wave = Evidence("kurtosis of the mean mesh period, 1.5 of a sine", 1.5 if found.quantised else found.waveform,
                    _threshold(WAVEFORM, healthy, "waveform"))  # fmt: skip
    shocks = Evidence("kurtosis of the most impulsive band, less that of noise, in every quarter of the record",
                      share * found.impulsive, _threshold(SHOCKS, healthy, "impulsive"))  # fmt: skip
    strength = max(min(lines.strength, depth.strength), wave.strength, min(APERIODIC, shocks.strength))
    return [Hypothesis(RATTLE, "rattle", (lines, depth, wave, shocks), strength)]
