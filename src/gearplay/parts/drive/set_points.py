"""Set-points of drives over time: a step, a sine, a trapezoid, a table (docs/theory, section 4)."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, Final, Generic, TypeVar, get_args

from pydantic import model_validator

from gearplay.schema.fields import Listed, Measure, Part, Problem, refuse
from gearplay.vocabulary import quantities as q

Value = TypeVar("Value", bound=float)
Piece = tuple[float, float, float, float]
"""Begin [s], value, rate, half of the second derivative."""

Time = Annotated[float, Measure(q.TIME, "time from the start of the integration", ge=0.0)]
Span = Annotated[float, Measure(q.TIME, "duration", ge=0.0)]
MOST_POINTS: Final = 10_000
JUMP: Final = 1e-14
"""Length of the step over a jump, relative to its time."""


class OfQuantity(Part, Generic[Value]):
    """Base of the parts of a set-point, which are named after the quantity of their values: ``TorqueStep``."""

    @classmethod
    def model_parametrized_name(cls, params: tuple[Any, ...]) -> str:
        """Return the name of the class for values of a type."""
        quantities = [each.quantity.name for each in get_args(params[0])[1:]]
        words = "_".join(quantities).split("_")
        return "".join(word.capitalize() for word in words) + cls.__name__

    @classmethod
    def __pydantic_init_subclass__(cls, **given: Any) -> None:
        """Give a class for one quantity the description of that for all."""
        cls.__doc__ = cls.__doc__ or cls.__mro__[1].__doc__


class Step(OfQuantity[Value], Generic[Value]):
    """A step at a time, from a value before it."""

    time: Time
    value: Value
    before: Value = 0.0  # type: ignore[assignment]


class Sine(OfQuantity[Value], Generic[Value]):
    """``mean + amplitude sin(2 pi frequency t + phase)``."""

    amplitude: Value
    frequency: Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]
    phase: Annotated[float, Measure(q.ANGLE, "phase at t = 0")] = 0.0
    mean: Value = 0.0  # type: ignore[assignment]


class Trapezoid(OfQuantity[Value], Generic[Value]):
    """A value that rises from 0, holds and falls to 0 again; of an angle its speed does so, and the angle ends at the value."""

    value: Value
    start: Time = 0.0
    rise: Span
    hold: Span = 0.0
    fall: Span

    @model_validator(mode="after")
    def _check(self) -> "Trapezoid[Value]":
        if self.rise + self.hold + self.fall <= 0.0:
            refuse(
                [Problem(("rise",), "must be above 0 s, or hold or fall", "Give the duration of the move")]
            )
        return self


class SetPoint(OfQuantity[Value], Generic[Value]):
    """A set-point over time: one of step, sine, trapezoid and table.

    A table holds points (time, value), linear between them; the first and the last value hold before and after it.
    """

    step: Step[Value] | None = None
    sine: Sine[Value] | None = None
    trapezoid: Trapezoid[Value] | None = None
    table: Annotated[
        tuple[Annotated[tuple[Time, Value], Listed(2, 2, "time and value")], ...],
        Listed(0, MOST_POINTS, "points of the set-point over time"),
    ] = ()

    @model_validator(mode="after")
    def _check(self) -> "SetPoint[Value]":
        given = [
            name for name in ("step", "sine", "trapezoid", "table") if getattr(self, name) not in (None, ())
        ]
        if len(given) != 1:
            rule = "must have one of step, sine, trapezoid and table"
            refuse([Problem((), rule, "Give one of them" if not given else f"Remove {' or '.join(given)}")])
        times = [time for time, _ in self.table]
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                rule = "must have a time later than that of the point before"
                refuse([Problem(("table", k), rule, "Order the points by time")])
        return self

    @property
    def nominal(self) -> float:
        """The value at the end of a step, a move or a table, of a sine its mean; where that is 0 the largest in magnitude."""
        if self.sine is not None:
            return float(self.sine.mean)
        if self.step is not None:
            return float(self.step.value or self.step.before)
        if self.trapezoid is not None:
            return float(self.trapezoid.value)
        values = [float(value) for _, value in self.table]
        return values[-1] or max(values, key=abs)

    @property
    def at_start(self) -> float:
        """The value at t = 0."""
        if self.sine is not None:
            return float(self.sine.mean + self.sine.amplitude * math.sin(self.sine.phase))
        return self.pieces()[0][1]

    @property
    def constant(self) -> float:
        """Constant part of the set-point, in addition to its pieces: the mean of a sine."""
        return 0.0 if self.sine is None else float(self.sine.mean)

    @property
    def largest(self) -> float:
        """A bound of the magnitude of the value."""
        swing = 0.0 if self.sine is None else abs(float(self.sine.amplitude))
        ends = [abs(p[1]) for p in self.pieces()] or [0.0]
        return max(swing + abs(self.constant), abs(self.nominal), *ends)

    def wave(self) -> tuple[float, float, float] | None:
        """Return angular frequency [rad/s], amplitude and phase [rad] of the sine, None without one."""
        if self.sine is None:
            return None
        return 2.0 * math.pi * self.sine.frequency, float(self.sine.amplitude), self.sine.phase

    def pieces(self, *, of_speed: bool = False) -> list[Piece]:
        """Return its pieces, none of a sine; with ``of_speed`` the trapezoid is that of the rate."""
        if self.step is not None:
            before = [(0.0, float(self.step.before), 0.0, 0.0)] if self.step.time > 0.0 else []
            return [*before, (self.step.time, float(self.step.value), 0.0, 0.0)]
        if self.trapezoid is not None:
            return _move(self.trapezoid) if of_speed else _pulse(self.trapezoid)
        return _lines([(time, float(value)) for time, value in self.table])

    def integral(self, constant: float) -> list[Piece]:
        """Return the pieces of the integral from 0 of a value that is linear on each piece, less a ``constant``."""
        found: list[Piece] = []
        pieces, total = self.pieces(), 0.0
        for k, (begin, value, rate, _) in enumerate(pieces):
            found.append((begin, total, value - constant, 0.5 * rate))
            if k + 1 < len(pieces):
                u = pieces[k + 1][0] - begin
                total += u * (value - constant + 0.5 * rate * u)
        return found

    def stops(self, *, of_speed: bool = False) -> set[float]:
        """Return the times [s] that no step may pass: where a piece begins, and just before where the value jumps.

        A step of its own, as short as can be resolved, passes a jump, so that it ends where a limit is reached there.
        """
        pieces, found = self.pieces(of_speed=of_speed), set[float]()
        for one, (t, value, *_) in pairwise(pieces):
            found.add(t)
            if abs(_end(one, t) - value) > 1e-12 * max(abs(value), abs(one[1])):
                found.add(t - JUMP * max(t, 1e-6))
        return found

    def steepest(self, *, lead: float = 0.0, of_speed: bool = False) -> float:
        """Return a bound of the magnitude of its rate, with ``lead`` [s] times that of the rate of its rate."""
        wave, bound = self.wave(), 0.0
        if wave is not None:
            bound = abs(wave[1]) * wave[0] * (1.0 + lead * wave[0])
        pieces = self.pieces(of_speed=of_speed)
        for k, (t, _, rate, half) in enumerate(pieces):
            u = pieces[k + 1][0] - t if k + 1 < len(pieces) else 0.0
            bound = max(bound, abs(rate) + 2.0 * abs(half) * (u + lead))
        return bound


def _end(piece: Piece, t: float) -> float:
    begin, value, rate, half = piece
    return value + (t - begin) * (rate + (t - begin) * half)


def _lines(points: Sequence[tuple[float, float]]) -> list[Piece]:
    """Return the pieces of a curve that is linear between points."""
    found: list[Piece] = []
    for (t, v), (t_1, v_1) in pairwise(points):
        found.append((t, v, (v_1 - v) / (t_1 - t), 0.0))
    if points and points[0][0] > 0.0:
        found.insert(0, (0.0, points[0][1], 0.0, 0.0))
    return [*found, (points[-1][0], points[-1][1], 0.0, 0.0)] if points else found


def _pulse(given: Trapezoid[Value]) -> list[Piece]:
    """Return the pieces of a value that rises, holds and falls."""
    top, t = float(given.value), given.start
    found: list[Piece] = [(0.0, 0.0, 0.0, 0.0)] if t > 0.0 else []
    if given.rise > 0.0:
        found.append((t, 0.0, top / given.rise, 0.0))
    t += given.rise
    if given.hold > 0.0:
        found.append((t, top, 0.0, 0.0))
    t += given.hold
    if given.fall > 0.0:
        found.append((t, top, -top / given.fall, 0.0))
    return [*found, (t + given.fall, 0.0, 0.0, 0.0)]


def _move(given: Trapezoid[Value]) -> list[Piece]:
    """Return the pieces of an angle whose speed rises, holds and falls."""
    speed = float(given.value) / (0.5 * given.rise + given.hold + 0.5 * given.fall)
    found: list[Piece] = [(0.0, 0.0, 0.0, 0.0)] if given.start > 0.0 else []
    t, angle = given.start, 0.0
    if given.rise > 0.0:
        found.append((t, angle, 0.0, 0.5 * speed / given.rise))
        t, angle = t + given.rise, angle + 0.5 * speed * given.rise
    if given.hold > 0.0:
        found.append((t, angle, speed, 0.0))
        t, angle = t + given.hold, angle + speed * given.hold
    if given.fall > 0.0:
        found.append((t, angle, speed, -0.5 * speed / given.fall))
    return [*found, (t + given.fall, float(given.value), 0.0, 0.0)]
