"""Check of hypotheses against simulated records of the case."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.comparison import AGREES, Deviation, compared
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.explanations import ALIKE
from gearplay.diagnosis.features import background, features_of
from gearplay.diagnosis.hypotheses import stated
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.pairs import pairs_of
from gearplay.diagnosis.shaft_speed import FoundSpeed
from gearplay.diagnosis.simulated_records import Simulated, Simulations, at_speed, length_of, loads_of
from gearplay.diagnosis.suspects import AS_IT_IS, WORN, Suspect, suspects_of
from gearplay.files.record import Channel
from gearplay.model.case import Case
from gearplay.rig.plan import Rig
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary.progress import Progress
from gearplay.vocabulary.quantities import ACCELERATION

Floats = NDArray[np.float64]

CHECKED: Final = 3
"""Hypotheses that are simulated, the likeliest first."""
POSSIBLE: Final = 0.01
"""Confidence from which a hypothesis is simulated."""
PIECES: Final = 4
"""Most pieces of a record, each as long as a simulated one."""


@dataclass(frozen=True)
class Check:
    """Agreement of a record with one simulated cause: see `Deviation`; ``level`` has its severity in words."""

    name: str
    kind: str
    hypotheses: tuple[str, ...]
    level: str
    result: Deviation


@dataclass(frozen=True)
class Checks:
    """Simulated causes, the best agreement first, with their features [decades], shape [feature], and sentences.

    A cause that agrees best at severity 0, as the case, is no row; ``absent`` has the names of the hypotheses of such ones.
    ``record`` and ``spread`` are the features of the record, and the standard deviation over simulated members; ``doubts`` are
    questions that the simulations leave open.
    """

    rows: tuple[Check, ...] = ()
    features: tuple[str, ...] = ()
    record: Floats | None = None
    spread: Floats | None = None
    doubts: tuple[str, ...] = ()
    conclusion: str = ""
    absent: tuple[str, ...] = ()

    @property
    def told(self) -> Check | None:
        """The only cause that agrees with the record, None where none does or several are alike."""
        alike = [row for row in self.rows if row.result.alike]
        return alike[0] if len(alike) == 1 and alike[0].result.deviation <= AGREES else None


def checked(
    record: Channel,
    healthy: Channel | None,
    case: Case,
    rig: Rig,
    machine: Machine,
    speed: FoundSpeed,
    healthy_speed: FoundSpeed,
    every: Sequence[Hypothesis],
    *,
    members: int,
    threads: int | None,
    progress: Progress | None,
    stop: threading.Event | None,
) -> Checks:
    """Return the agreement of a record with simulated ones of the likeliest hypotheses, of wear, and of the case as it is.

    ``speed`` is that of the first shaft. With a healthy record changes against it are compared, with those that the
    simulations show against the case as it is.
    """
    factor = _acceleration(record.unit)
    taken = _in_si(record, factor)
    duration = length_of(
        machine, speed.frequency, min(taken.duration, healthy.duration if healthy else math.inf)
    )
    assert machine.speed is not None, "of a case"
    turned, found = at_speed(case, speed.frequency / machine.speed)
    said = [] if found else ["The drive of the case has no constant speed: it is simulated as it is."]
    likely = [h for h in every if h.kind != "none" and h.confidence >= POSSIBLE][:CHECKED]
    suspects, left = suspects_of(turned, machine, likely, loads_of(turned, stop))
    if not suspects:
        return Checks(doubts=(*left, *said))
    sensor = record.name.rpartition(".")[0]
    simulations = Simulations(
        turned,
        [{}, *(level for each in suspects for level in each.levels)],
        members,
        rig.model_copy(update={"collector": _collector(rig, taken.sampling)}),
        sensor if sensor in rig.accelerometers else next(iter(rig.accelerometers)),
        machine,
        speed,
        duration,
        background(taken) if factor is not None else 0.0,
        factor is not None,
    )
    rows = simulations.run(threads, progress, stop)
    pieces = _pieces(taken, machine, speed, duration, levels=factor is not None)
    before = None
    if healthy is not None:
        sound = _in_si(healthy, factor)
        before = _pieces(sound, machine, healthy_speed, duration, levels=factor is not None)
    if factor is None:
        said.append(
            f"The record's unit, {record.unit or 'none'}, is no acceleration: its levels are not compared with the case."
        )
    alone = _weighed(suspects, rows, members, pieces, before, [*left, *said])
    names = [row.name for row in alone.rows if row.hypotheses or row.kind == "rattle"]
    nearest = sorted((s for s in suspects if s.name in names), key=lambda s: names.index(s.name))
    pairs = pairs_of(stated(every), nearest)
    if not pairs:
        return alone
    more = replace(simulations, variants=[level for each in pairs for level in each.levels])
    rows += more.run(threads, progress, stop)
    return _weighed([*suspects, *pairs], rows, members, pieces, before, [*left, *said])


def revised(every: Sequence[Hypothesis], checks: Checks) -> list[Hypothesis]:
    """Return the hypotheses with at most `ALIKE` as the confidence of those that the simulations do not support.

    These are where a simulated cause agrees with the record: hypotheses further off than that one, and, where the case as it is
    agrees alike, all that were simulated.
    """
    if not checks.rows or checks.rows[0].result.deviation > AGREES:
        return list(every)
    alike = [row for row in checks.rows if row.result.alike]
    supported = (
        set()
        if any(row.kind == "none" for row in alike)
        else {name for row in alike for name in row.hypotheses}
    )
    doubtful = {*(name for row in checks.rows for name in row.hypotheses), *checks.absent} - supported
    found = [replace(h, confidence=min(h.confidence, ALIKE)) if h.name in doubtful else h for h in every]
    return sorted(found, key=lambda h: -h.confidence)


def _acceleration(unit: str) -> float | None:
    """Return the factor from a unit to m/s^2, None where it is no acceleration."""
    try:
        return parse_quantity(f"1 {unit}", ACCELERATION) if unit else None
    except UnitError:
        return None


def _in_si(channel: Channel, factor: float | None) -> Channel:
    return channel if factor is None else replace(channel, values=channel.values * factor, unit="m/s^2")


def _collector(rig: Rig, sampling: float) -> Any:
    """Return the collector of a rig at another sampling rate; `InputError` where that does not fit."""
    given = rig.collector.model_dump(mode="json") | {"sampling": sampling, "duration": None}
    return Rig.model_validate({"collector": given}).collector


def _pieces(
    channel: Channel, machine: Machine, speed: FoundSpeed, duration: float, *, levels: bool
) -> list[dict[str, float]]:
    """Return the features of the pieces of a record, each as long as a simulated one."""
    size = min(channel.size, round(duration * channel.sampling))
    count = min(PIECES, channel.size // size)
    starts = np.linspace(0, channel.size - size, count).astype(int)
    return [
        features_of(replace(channel, values=channel.values[at : at + size]), machine, speed, levels=levels)
        for at in starts
    ]


def _weighed(
    suspects: Sequence[Suspect],
    rows: Sequence[Sequence[Simulated]],
    members: int,
    pieces: Sequence[dict[str, float]],
    before: Sequence[dict[str, float]] | None,
    said: Sequence[str],
) -> Checks:
    """Return the checks from the features of the pieces of the record, of the healthy one, and of the simulated ones."""
    failed = next((each.reason for each in rows[0] if each.features is None), "")
    if failed:
        return Checks(doubts=(*said, f"The case as it is cannot be simulated at this speed: {failed}"))
    kept, groups, at = [Suspect(AS_IT_IS, "none", (), "", (), ())], [[rows[0]]], 1
    said, places = list(said), dict[tuple[str, float], int]()
    for each in suspects:
        own = rows[at : at + len(each.levels)]
        places |= {(each.name, size): at + k for k, size in enumerate(each.sizes) if each.beside is None}
        at += len(each.levels)
        if each.beside is not None:  # begins where the other cause is alone
            own = [rows[places[each.beside.name, each.beside.sizes[0]]], *own]
        reason = next((s.reason for level in own for s in level if s.features is None), "")
        if reason:
            said.append(f"{each.name} cannot be simulated: {reason}")
            continue
        kept.append(each)
        groups.append([*own])
    tables = [s.features or {} for group in groups for level in group for s in level]
    names = [n for n in pieces[0] if all(n in table for table in (*tables, *pieces, *(before or ())))]
    record = np.array([[table[n] for n in names] for table in pieces])
    causes = [
        np.array([[[(s.features or {})[n] for n in names] for s in level] for level in group])
        for group in groups
    ]
    if before is not None:
        change = np.mean(causes[0], axis=(0, 1)) - np.mean(
            [[table[n] for n in names] for table in before], axis=0
        )
        record = record + change
    found = compared(record, causes)
    results = [*zip(kept, found, strict=True)]
    there = [(s, d) for s, d in results if s.name == AS_IT_IS or d.place > (1.0 if s.beside else 0.0)]
    rows_of = [Check(s.name, s.kind, s.hypotheses, _level(s, d.place), d) for s, d in there]
    every = sorted(rows_of, key=lambda row: (row.result.deviation, row.name))
    every = [row for k, row in enumerate(every) if row.name not in [other.name for other in every[:k]]]
    absent = tuple(name for s, d in results if d.place == 0.0 for name in s.hypotheses)
    spread = np.sqrt(np.mean(np.concatenate([np.var(c, axis=1, ddof=1) for c in causes]), axis=0))
    conclusion, doubt = _conclusion(every)
    return Checks(
        tuple(every), tuple(names), np.mean(record, axis=0), spread, (*said, *doubt), conclusion, absent
    )


def _level(suspect: Suspect, place: float) -> str:
    """Return the severity at a place between levels in words, empty where there is none."""
    if not suspect.sizes:
        return ""
    if suspect.beside is not None:
        return f"{_level(suspect.beside, 1.0)}; {_level(replace(suspect, beside=None), place - 1.0)}"
    sizes = np.log([suspect.sizes[0] / WORN[0], *suspect.sizes])
    size = math.exp(float(np.interp(place, range(sizes.size), sizes)))
    if suspect.hypotheses and place < 1.0:  # a fault begins at nothing
        size = place * suspect.sizes[0]
    return f"{suspect.quantity} {1e6 * size:.3g} um"


def _conclusion(rows: Sequence[Check]) -> tuple[str, list[str]]:
    """Return the conclusion of the checks as a sentence, and the questions left open."""
    first, alike = rows[0], [row for row in rows if row.result.alike]
    said = f"deviation {first.result.deviation:.2f} ± {first.result.spread:.2f}"
    if first.result.deviation > AGREES:
        return (
            f"No simulated record of the case agrees with it: nearest is {_named(first)}, {said}, where up to {AGREES:g} counts.",
            ["The case does not describe this record: calibrate it, or give a healthy record."],
        )
    sound = next(row for row in rows if row.kind == "none")
    if sound.result.alike:
        return (
            f"Simulated records of the case as it is agree with it, {_of(sound)}: no simulated cause is needed.",
            [],
        )
    if len(alike) > 1:
        names = " and ".join(f"{_named(row)}, {_of(row)}" for row in alike)
        return f"Simulated records explain it alike: {names}.", [
            f"{' and '.join(row.name for row in alike)}: which of them it is cannot be told from simulated records."
        ]
    second = next((row for row in rows if row is not first), None)
    against = "" if second is None else f"; next is {_named(second)}, {_of(second)}"
    return f"Simulated records with {_named(first)} agree with it, {_of(first)}{against}.", []


def _named(row: Check) -> str:
    return f"{row.name} ({row.level})" if row.level else row.name


def _of(row: Check) -> str:
    return f"deviation {row.result.deviation:.2f} ± {row.result.spread:.2f}"
