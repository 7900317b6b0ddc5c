"""Limits of a diagnosis: questions that the record cannot decide."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from gearplay.diagnosis.bearing_combs import PARTS
from gearplay.diagnosis.checks import Checks
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.explanations import look_alike, on_a_turn
from gearplay.diagnosis.hypotheses import MODULATION, TOLD, stated
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import Measures
from gearplay.diagnosis.planetary_measures import APART, HARMONICS, SetMeasure
from gearplay.diagnosis.planetary_set import PlanetarySet
from gearplay.diagnosis.separation import LEAST_TURNS
from gearplay.diagnosis.shaft_speed import NO_LINE

FURTHER: Final = 0.2
"""Confidence from which a further cause that is not stated is mentioned."""

CAGE_LINES: Final = 6
"""Multiples of FTF of which more than half must stand apart to show a cage: as many as are sought."""
CAGE_APART: Final = 2.0
"""Least distance of these from others, in lines of an envelope, which are two wide."""


def doubts(
    machine: Machine, found: Measures, every: Sequence[Hypothesis], healthy: Measures | None, checks: Checks
) -> list[str]:
    """Return the questions that the record, and simulated ones, cannot decide, a sentence each."""
    further = _further(every)
    simulated = checks.told
    own = [
        sentence
        for h in (*(stated(every) or every[:1]), *further)
        if simulated is None or (h.kind != simulated.kind and h.name not in simulated.hypotheses)
        for sentence in _left_open(machine, found, h, every)
    ]
    also = [
        f"Whether {h.name} occurs as well cannot be told: confidence {h.confidence:.2f}." for h in further
    ]
    said = [*_speed(machine, found), *_gears(machine, found), *also, *dict.fromkeys(own), *checks.doubts]
    if found.quantised and machine.meshes:
        rms, unit = float(np.std(found.rest.values)), f" {found.rest.unit}".rstrip()
        said.append(
            f"Rattle cannot be told: what repeats with no shaft, {rms:.3g}{unit}, may be quantisation, in steps of "
            f"{found.step:.3g}{unit}."
        )
    if not machine.bearings:
        said.append("Bearings cannot be told: no geometry of one is given.")
    elif not found.rest.size or found.band[1] == 0.0:
        said.append(
            "Bearings cannot be told: the record is too short, or sampled too slowly, for an envelope."
        )
    if not machine.meshes:
        said.append("Gears cannot be told: no teeth are given.")
    if healthy is not None and machine.meshes and not healthy.speed.known:
        said.append(f"The healthy record is no measure of the gears: {NO_LINE}.")
    if healthy is None and found.gears:
        share = 100.0 * MODULATION
        said.append(
            f"Without a healthy record an eccentric gear counts from {share:.0f} % of modulation; slow changes cannot be told."
        )
    return said


def _speed(machine: Machine, found: Measures) -> list[str]:
    if found.speed.known or not machine.meshes:
        return []
    return [f"Damaged teeth and eccentric gears cannot be told: {NO_LINE}."]


def _gears(machine: Machine, found: Measures) -> list[str]:
    said = []
    planetary = [
        gear.name for k, gear in enumerate(machine.gears) if gear.shaft is None and machine.set_of(k) is None
    ]
    if planetary:
        said.append(
            f"Eccentricity cannot be told of {', '.join(planetary)}: neither sun nor ring stands; "
            "gearplay.signals.planetary_average takes windows."
        )
    for each, own in zip(machine.sets, found.sets, strict=False):
        said += [
            f"{words} of {each.name} cannot be told: {why}." for words, why in _unseen(machine, each, own)
        ]
    seldom = [g.name for k, g in enumerate(machine.gears) if k not in found.gears and g.shaft is not None]
    if seldom and found.speed.known:
        said.append(
            f"Damage cannot be told of {', '.join(seldom)}: the shaft turns less than {LEAST_TURNS + 1} times, or its "
            "teeth pass faster than a quarter of the sampling rate."
        )
    gears = [(k, machine.gears[k]) for k in found.gears]
    for i, (_, one) in enumerate(gears):
        for _, other in gears[i + 1 :]:
            if abs(one.order / other.order - 1.0) < 1e-6:
                said.append(f"{one.name} and {other.name} turn alike: which of them it is cannot be told.")
    return said


def _unseen(machine: Machine, each: PlanetarySet, own: SetMeasure) -> Iterator[tuple[str, str]]:
    """Yield what a record does not show of a planetary set, with the reason."""
    long = (
        f"their lines lie nearer than {APART:g} of the spectrum's to others; a longer record separates them"
    )
    if not any(each.uneven(h) for h in range(1, HARMONICS + 1)):
        yield "Uneven planets", "even ones at these angles leave lines at every turn of the carrier"
    elif math.isnan(own.uneven):
        yield "Uneven planets", long
    for value, words in (
        (own.sun, "An eccentric sun"),
        (own.planet, "Eccentric planets"),
    ):
        if math.isnan(value):
            yield words, long
    ring = machine.gears[each.gears[2]]
    if math.isnan(own.ring):
        stands = ring.teeth == each.teeth
        few = f"the carrier turns less than {LEAST_TURNS + 1} times, or teeth pass faster than an eighth of the sampling rate"
        yield "A damaged tooth of the ring", few if stands else "it turns past the sensor"


def _further(every: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the causes that may occur together with the stated ones."""
    told = stated(every)
    return [h for h in every if told and h.kind != "none" and FURTHER <= h.confidence < TOLD]


def _left_open(
    machine: Machine, found: Measures, first: Hypothesis, every: Sequence[Hypothesis]
) -> list[str]:
    """Return the questions that a hypothesis leaves open."""
    of_planet = first.kind in ("tooth", "eccentric") and any(
        first.place == each.gears[1] for each in machine.sets
    )
    which = (
        [f"Which planet it is cannot be told: {first.name}, of any of them, has the same lines."]
        if of_planet
        else []
    )
    if first.kind == "planets":
        return [
            "A pin that is worn or off its place, an eccentric carrier and a planet unlike the others put lines at the same "
            "places: which it is, and of which planet, cannot be told."
        ]
    if first.kind == "tooth":
        return [
            *which,
            "Crack, spall and chip of a tooth look alike in one record: which of them it is cannot be told.",
        ]
    if first.kind == "eccentric":
        return [
            *which,
            "Eccentricity, a bent shaft and a load that changes with the turn look alike: which it is cannot be told.",
        ]
    if first.kind == "rattle":
        return [
            "Backlash and the clearance of a bush rattle alike: which of them it is cannot be told from one record."
        ]
    if first.kind not in PARTS:
        return []
    said = []
    if on_a_turn(machine, found, first):
        said.append(
            f"The lines of {first.name} lie on multiples of a shaft's turn: other sources of these cannot be ruled out."
        )
    if machine.bearings[first.place].carrier > 0.0:
        said.append("Of which planet the bearing is cannot be told: all have the same lines.")
    for h in every:
        if h is first or h.kind not in PARTS or not look_alike(machine, first, h):
            continue
        if h.place != first.place or {h.kind, first.kind} != {"cage", "outer"}:
            said.append(
                f"With slip, {h.name}, has a line at the place of {first.name}: it cannot be ruled out."
            )
        elif (
            h.kind == "outer"
            or min(h.strength, h.evidence[0].strength) > 0.0
            or not _shows_cage(machine, found, h.place)
        ):
            said.append(f"BPFO is a multiple of FTF: {h.name}, cannot be ruled out.")
    return said


def _shows_cage(machine: Machine, found: Measures, bearing: int) -> bool:
    """Return whether multiples of FTF that are none of BPFO would stand apart from 0 and the turns in an envelope."""
    own = machine.bearings[bearing].orders
    line = found.bearings[bearing, "cage"].frequency
    turns = [shaft.order * found.speed.frequency for shaft in machine.shafts]
    multiples = [k * line for k in range(1, CAGE_LINES + 1) if k % round(own.bpfo / own.ftf)]
    apart = [
        min(f, *(abs(math.remainder(f, turn)) for turn in turns)) * found.rest.duration for f in multiples
    ]
    return sum(each >= CAGE_APART for each in apart) > CAGE_LINES // 2
