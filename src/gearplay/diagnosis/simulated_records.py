"""Simulated records of a case with each cause, through the rig of the measured one."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from gearplay.diagnosis.features import background, features_of
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.shaft_speed import FoundSpeed
from gearplay.files.record import Channel
from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.rig.measurement import measure
from gearplay.rig.plan import Rig
from gearplay.solver.simulate import run_members
from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.progress import Progress
from gearplay.work.engine import run_threads

TURNS: Final = 24
"""Turns of the first shaft in a simulated record."""
SLOWEST: Final = 12
"""Turns of the slowest shaft, so that averages over its turn are compared too."""
LEAST: Final = 0.5
"""Least length of a simulated record [s], where the measured one is as long."""
LONGEST: Final = 8.0
"""Greatest length of a simulated record [s]."""


class Simulated(NamedTuple):
    """Features of a simulated record by its number; None and the reason where it failed."""

    job: int
    features: dict[str, float] | None
    reason: str


def length_of(machine: Machine, speed: float, duration: float) -> float:
    """Return the length of simulated records [s] for a measured one of some duration at a speed of the first shaft [Hz]."""
    slowest = min(shaft.order for shaft in machine.shafts) * speed
    return min(duration, LONGEST, max(LEAST, TURNS / speed, SLOWEST / slowest))


def at_speed(case: Case, ratio: float) -> tuple[Case, bool]:
    """Return a case with its driven speeds times a ratio, and whether there was one."""
    changes = {
        f"{'rotors' if name.partition('.')[0] not in case.planetary else 'planetary'}.{name}.drive.speed": speed
        * ratio
        for name, rotor in case.rotors.items()
        if isinstance(speed := getattr(rotor.drive, "speed", None), float) and speed != 0.0
    }
    return (replace(case, changes) if changes else case), bool(changes)


def loads_of(case: Case, stop: threading.Event | None) -> dict[str, float]:
    """Return the direction [rad] in which each rotor in a rolling bearing is displaced on average, that of its load."""
    names = [name for name in case.bearings if name in case.rotors]
    if not names:
        return {}
    signals = [f"{name}.{axis}" for name in names for axis in "xy"]
    run = run_members(case, [0], signals=signals, duration=0.1, sampling=2000.0, stop=stop)[0]
    if not run.success:
        return {}
    means = {signal: float(np.mean(run.signal(*signal.split(".")[::-1]))) for signal in signals}
    return {name: math.atan2(means[f"{name}.y"], means[f"{name}.x"]) for name in names}


@dataclass(frozen=True)
class Simulations:
    """Simulated records of variants of a case, each ``members`` times: the task whose pieces are their features.

    The rig's noise is each one's own; white noise fills up to the ``noise`` of the measured record [m/s^2].
    """

    case: Case
    variants: Sequence[Mapping[str, Any]]
    members: int
    rig: Rig
    sensor: str
    machine: Machine
    speed: FoundSpeed
    duration: float
    noise: float
    levels: bool

    def evaluate(self, job: int, stop: threading.Event | None = None) -> list[Simulated]:
        """Simulate a record, return its features; nothing once stopped."""
        variant, member = divmod(job, self.members)
        try:
            case = replace(self.case, self.variants[variant])
            taken = measure(
                case, self.rig, duration=self.duration, member=1 + member, seed=1 + variant, stop=stop
            )
        except KeyboardInterrupt:
            return []
        except GearplayError as error:
            return [Simulated(job, None, " ".join(str(error).split()))]
        channel = taken.channel(f"{self.sensor}.recorded")
        missing = math.sqrt(max(self.noise**2 - background(channel) ** 2, 0.0))
        noise = missing * np.random.default_rng([2, job]).standard_normal(channel.size)
        filled = Channel(channel.name, channel.values + noise, channel.sampling, channel.unit)
        return [Simulated(job, features_of(filled, self.machine, self.speed, levels=self.levels), "")]

    def run(
        self, threads: int | None, progress: Progress | None, stop: threading.Event | None
    ) -> list[list[Simulated]]:
        """Return the simulated records of each variant; `KeyboardInterrupt` once stopped."""
        total, done = len(self.variants) * self.members, list[Simulated]()
        with closing(run_threads(self, range(total), workers=threads, stop=stop)) as pieces:
            for found in pieces:
                done += found
                if progress is not None:
                    progress("simulated records", len(done), total)
        if len(done) < total:
            raise KeyboardInterrupt
        done.sort()
        return [done[k : k + self.members] for k in range(0, total, self.members)]
