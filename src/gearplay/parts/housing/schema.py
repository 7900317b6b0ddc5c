"""Motion of the housing: a sine, a shock, random vibration of a spectral density, a measured record."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Tag, model_validator

from gearplay.kernels import housing_motion
from gearplay.schema.fields import ByKind, Listed, Measure, Part, Problem, refuse
from gearplay.schema.finding import Finding
from gearplay.schema.records import cubic_pieces
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
Amplitude = Annotated[float, Measure(q.ACCELERATION, "amplitude (half peak to peak) of the acceleration")]
Direction = Annotated[float, Measure(q.ANGLE, "direction of the motion, counter-clockwise from +x")]
DensityFrequency = Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]
Density = Annotated[float, Measure(q.SPECTRAL_DENSITY, "one-sided spectral density", gt=0.0)]

DENSITY = "base.acceleration.density"
"""Path of a field within a case."""
FINE = 16
"""Steps of a made record in a period of its highest frequency; its spline is then true to 1e-4."""
FEWEST_LINES = 16
"""Lines of a made record at least: a shorter run sees a part of one that has as many."""
MOST_STEPS = 4_000_000
"""Steps of a made record at most."""


@dataclass(frozen=True)
class Member:
    """Identity of a run of a case: the seed of its ensemble, and its number in it."""

    seed: int
    number: int


FIRST = Member(0, 0)


class Harmonic(Part):
    """``amplitude sin(2 pi frequency t + phase)``, t from the start of the integration."""

    kind: Literal["harmonic"] = "harmonic"
    amplitude: Amplitude
    frequency: Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]
    phase: Annotated[float, Measure(q.ANGLE, "phase at t = 0")] = 0.0
    direction: Direction = 0.0

    def fill(self, slots: Floats, span: float, _: Member) -> Floats:
        """Write the parameters of the motion for a run of ``span`` [s]; return the pieces of its record, none for a sine."""
        slots[housing_motion.KIND] = housing_motion.HARMONIC
        slots[housing_motion.AMPLITUDE], slots[housing_motion.PHASE] = self.amplitude, self.phase
        slots[housing_motion.RATE] = 2.0 * math.pi * self.frequency
        slots[housing_motion.END] = math.inf
        return np.zeros((0, 4))


class HalfSine(Part):
    """A shock: ``amplitude sin(pi (t - start) / duration)`` for ``duration``, 0 before and after it."""

    kind: Literal["half-sine"] = "half-sine"
    amplitude: Amplitude
    duration: Annotated[float, Measure(q.TIME, "duration of the half sine", gt=0.0)]
    start: Annotated[float, Measure(q.TIME, "when it begins, from the start of the integration", ge=0.0)] = (
        0.0
    )
    direction: Direction = 0.0

    def fill(self, slots: Floats, span: float, _: Member) -> Floats:
        """Fill the kernels' slots for a run of ``span`` [s]; return the pieces of a record, none here."""
        slots[housing_motion.KIND] = housing_motion.HALF_SINE
        slots[housing_motion.AMPLITUDE], slots[housing_motion.RATE] = self.amplitude, math.pi / self.duration
        slots[housing_motion.START], slots[housing_motion.END] = self.start, self.start + self.duration
        return np.zeros((0, 4))


class SpectralDensity(Part):
    """Random vibration: a Gaussian record of a one-sided spectral density, straight between its points on logarithmic scales.

    The record is as long as the run, transient included, and repeats after that; a short run sees a part of one that holds 16
    lines of the density. The seed decides it. All members of an ensemble
    stand on the same housing, unless each has a record of its own (``per_member``), which ``run.seed`` and its number decide too.
    """

    kind: Literal["spectral-density"] = "spectral-density"
    density: Annotated[
        tuple[Annotated[tuple[DensityFrequency, Density], Listed(2, 2, "frequency and density")], ...],
        Listed(2, 100, "points of the spectral density"),
    ]
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, description="seed of the record")] = 0
    direction: Direction = 0.0
    per_member: Annotated[
        bool,
        Field(
            description="each member of an ensemble has a record of its own; member 0 has that of the seed"
        ),
    ] = False

    @model_validator(mode="after")
    def _check(self) -> SpectralDensity:
        frequencies = [frequency for frequency, _ in self.density]
        if any(later <= earlier for earlier, later in pairwise(frequencies)):
            refuse([Problem(("density",), "must have rising frequencies", "Sort the points")])
        return self

    def at(self, frequencies: Floats) -> Floats:
        """Return the density [(m/s^2)^2/Hz] at frequencies [Hz], shape [frequency]; 0 outside its points."""
        points = np.log(np.array(self.density))
        inside = (frequencies >= self.density[0][0]) & (frequencies <= self.density[-1][0])
        found = np.exp(np.interp(np.log(np.where(inside, frequencies, 1.0)), points[:, 0], points[:, 1]))
        return np.where(inside, found, 0.0)

    def rms(self) -> float:
        """Return the root of the integral of the density [m/s^2], in closed form between its points."""
        total = 0.0
        for (f_1, s_1), (f_2, s_2) in pairwise(self.density):
            slope = math.log(s_2 / s_1) / math.log(f_2 / f_1)
            if abs(slope + 1.0) < 1e-9:
                total += s_1 * f_1 * math.log(f_2 / f_1)
            else:
                total += (s_2 * f_2 - s_1 * f_1) / (slope + 1.0)
        return math.sqrt(total)

    def record(self, span: float, member: Member = FIRST) -> tuple[float, Floats]:
        """Return the step [s] and the values [m/s^2] of a periodic record of at least ``span`` [s], of one member.

        Every line k / span within the density has a complex normal amplitude of variance S df.

        Raises `InputError` where that takes more than ``MOST_STEPS`` steps.
        """
        highest = self.density[-1][0]
        span = max(span, FEWEST_LINES / (highest - self.density[0][0]))
        if not math.ceil(FINE * highest * span) <= MOST_STEPS:
            rule = "must be at most 4 000 000 steps of a record long, 16 in a period of the highest frequency"
            cure = "Shorten the run, or end the density at a lower frequency"
            raise InputError.of(DENSITY, "its record", rule, cure)
        count = max(math.ceil(FINE * highest * span), 2 * FINE)
        frequencies = np.arange(count // 2 + 1) / span
        own = self.per_member and member.number > 0
        generator = np.random.default_rng([self.seed, member.seed, member.number] if own else self.seed)
        normal = generator.standard_normal((frequencies.size, 2)) @ np.array([1.0, 1.0j])
        lines = 0.5 * np.sqrt(self.at(frequencies) / span) * normal
        return span / count, np.fft.irfft(lines, count) * count

    def fill(self, slots: Floats, span: float, member: Member) -> Floats:
        """Fill the kernels' slots for a run of ``span`` [s]; return the pieces of its record, shape [piece, 4]."""
        step, values = self.record(span, member)
        slots[housing_motion.RATE] = 2.0 * math.pi * self.density[-1][0]
        return _pieces(slots, step, np.append(values, values[0]), 0.0, periodic=True)


class MeasuredRecord(Part):
    """A record of equal steps, a cubic spline between its values, 0 before and after it."""

    kind: Literal["record"] = "record"
    values: Annotated[tuple[Amplitude, ...], Listed(4, 200_000, "values of the acceleration")]
    sampling: Annotated[float, Measure(q.FREQUENCY, "values per second", gt=0.0)]
    start: Annotated[float, Measure(q.TIME, "when it begins, from the start of the integration", ge=0.0)] = (
        0.0
    )
    direction: Direction = 0.0

    def fill(self, slots: Floats, span: float, _: Member) -> Floats:
        """Fill the kernels' slots for a run of ``span`` [s]; return the pieces of its record, shape [piece, 4]."""
        slots[housing_motion.RATE] = 0.5 * math.pi * self.sampling
        return _pieces(slots, 1.0 / self.sampling, np.array(self.values), self.start, periodic=False)


def _pieces(slots: Floats, step: float, values: Floats, start: float, *, periodic: bool) -> Floats:
    """Fill the slots of a record; return its pieces (c0, c1, c2, c3) of u from 0 to 1."""
    slots[housing_motion.KIND], slots[housing_motion.STEP] = housing_motion.RECORD, step
    slots[housing_motion.START] = start
    slots[housing_motion.END] = start + step * (values.size - 1)
    slots[housing_motion.COUNT] = values.size - 1
    pieces = cubic_pieces(values, periodic=periodic)
    slots[housing_motion.AMPLITUDE] = np.max(np.abs(pieces @ _CORNERS), initial=0.0)
    return pieces


_CORNERS = np.array(
    [[1.0, 1.0, 1.0, 1.0], [0.0, 1 / 3, 2 / 3, 1.0], [0.0, 0.0, 1 / 3, 1.0], [0.0, 0.0, 0.0, 1.0]]
)
"""From a piece's coefficients to those of Bernstein's polynomials, between which it lies."""


Acceleration = Annotated[
    Annotated[Harmonic, Tag("kind:harmonic")]
    | Annotated[HalfSine, Tag("kind:half-sine")]
    | Annotated[SpectralDensity, Tag("kind:spectral-density")]
    | Annotated[MeasuredRecord, Tag("kind:record")],
    ByKind("harmonic", "half-sine", "spectral-density", "record"),
]


class Base(Part):
    """Acceleration of the housing in its plane; positions, speeds and accelerations of a result are relative to it."""

    acceleration: Acceleration

    @property
    def random(self) -> SpectralDensity | None:
        """The motion if it is random, else None."""
        return self.acceleration if isinstance(self.acceleration, SpectralDensity) else None

    @property
    def is_per_member(self) -> bool:
        """Whether the record differs between members of an ensemble."""
        return self.random is not None and self.random.per_member

    def pack(self, span: float, member: Member) -> tuple[Floats, Floats]:
        """Return the kernels' slots and the pieces of a record, for a member's run of ``span`` [s], transient included.

        Raises `InputError` where a record gets too long.
        """
        slots = still()
        direction = self.acceleration.direction
        slots[housing_motion.COSINE], slots[housing_motion.SINE] = math.cos(direction), math.sin(direction)
        return slots, self.acceleration.fill(slots, span, member)

    def findings(self, span: float) -> Iterator[Finding]:
        """Yield a note on a record that ends before a run of ``span`` [s], transient included."""
        record = self.acceleration
        if not isinstance(record, MeasuredRecord):
            return
        end = record.start + (len(record.values) - 1) / record.sampling
        if end < span:
            text = f"it ends at {end:.4g} s, the run at {span:.4g} s: from then on the housing is not accelerated"
            jump = abs(record.values[-1])
            if jump > 0.0:
                text += f"; it ends with {jump:.3g} m/s^2, which then stop at once"
            yield Finding("note", "base.acceleration.values", f"{text}.")


def still() -> Floats:
    """Return the kernels' slots of a housing that does not move."""
    slots = np.zeros(housing_motion.SLOTS)
    slots[housing_motion.KIND] = housing_motion.NONE
    return slots
