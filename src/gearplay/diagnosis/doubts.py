"""Limits of a diagnosis: questions that the record cannot decide."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from gearplay.diagnosis.bearing_combs import PARTS
from gearplay.diagnosis.checks import Checks
from gearplay.diagnosis.hypotheses import MODULATION, Hypothesis, look_alike, on_a_turn
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import Measures
from gearplay.diagnosis.planetary_measures import APART, SetMeasure
from gearplay.diagnosis.planetary_set import PlanetarySet
from gearplay.diagnosis.separation import LEAST_TURNS
from gearplay.diagnosis.shaft_speed import NO_LINE


def doubts(
    machine: Machine, found: Measures, every: Sequence[Hypothesis], healthy: Measures | None, checks: Checks
) -> list[str]:
    """Return the questions that the record, and simulated ones, cannot decide, a sentence each."""
    first = (
        [] if checks.told is not None and checks.told.kind == every[0].kind else _first(machine, found, every)
    )
    said = [*_speed(machine, found), *_gears(machine, found), *first, *checks.doubts]
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
            f"Eccentricity cannot be told of {', '.join(planetary)}: their planets are not evenly spaced, or neither sun nor "
            "ring stands; gearplay.signals.planetary_average takes windows."
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
    for value, words in (
        (own.uneven, "Uneven planets"),
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


def _first(machine: Machine, found: Measures, every: Sequence[Hypothesis]) -> list[str]:
    """Return the questions that the leading hypothesis leaves open."""
    first = every[0]
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
    on_turn = [
        f"The lines of {first.name} lie on multiples of a shaft's turn: other sources of these cannot be ruled out."
    ]
    planets = ["Of which planet the bearing is cannot be told: all have the same lines."]
    on_turn = on_turn if on_a_turn(machine, found, first) else []
    return (
        on_turn
        + (planets if machine.bearings[first.place].carrier > 0.0 else [])
        + [
            (
                f"BPFO is a multiple of FTF: {h.name}, cannot be ruled out."
                if h.place == first.place and {h.kind, first.kind} == {"cage", "outer"}
                else f"With slip, {h.name}, has a line at the place of {first.name}: it cannot be ruled out."
            )
            for h in every[1:]
            if h.kind in PARTS and look_alike(machine, first, h)
        ]
    )
