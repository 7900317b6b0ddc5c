"""Shaft angle over time, from a constant speed, a speed or angle channel, or tacho pulses; angular resampling."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.checks import TWO_PI, check_channel, check_count, check_positive, refuse

Floats = NDArray[np.float64]

SPEED_UNITS = {
    "rad/s": 1.0, "1/s": TWO_PI, "Hz": TWO_PI, "rev/s": TWO_PI, "rpm": TWO_PI / 60.0, "1/min": TWO_PI / 60.0,
    "rev/min": TWO_PI / 60.0, "deg/s": math.pi / 180.0,
}  # fmt: skip
ANGLE_UNITS = {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": TWO_PI}
MOST_SAMPLES = 60_000_000
"""Most samples over equal angles; more fill the memory."""


@dataclass(frozen=True)
class ShaftAngle:
    """Angle of a shaft over time: rising ``angle`` [rad] at ``time`` [s], both of shape [point], a cubic spline between.

    ``source`` is its origin as text.
    """

    time: Floats
    angle: Floats
    source: str

    def at(self, time: Floats) -> tuple[Floats, Floats]:
        """Return (angle [rad], speed [rad/s]) at times within the first and last point [s].

        >>> shaft = ShaftAngle(np.array([0.0, 1.0, 2.0]), np.array([0.0, 5.0, 10.0]), "test")
        >>> angle, speed = shaft.at(np.array([0.5]))
        >>> round(float(angle[0]), 12), round(float(speed[0]), 12)
        (2.5, 5.0)
        """
        return np.asarray(self._spline(time)), np.asarray(self._spline(time, 1))

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline

        return CubicSpline(self.time, self.angle)


@dataclass(frozen=True)
class AngleRecord:
    """A signal over equal steps of the shaft's angle.

    ``values`` [unit], ``time`` [s] and ``speed`` [rad/s] have shape [sample]; sample i lies at (``first`` + i) /
    ``samples_per_revolution`` revolutions of the shaft, counted from its angle zero. ``highest`` is the highest order kept.
    """

    values: Floats
    time: Floats
    speed: Floats
    samples_per_revolution: int
    first: int
    highest: float
    unit: str
    source: str
    name: str = ""

    @property
    def revolutions(self) -> float:
        """Length of the record in turns of the shaft [rev]."""
        return self.values.size / self.samples_per_revolution

    def channel(self) -> Channel:
        """Return the record as a channel whose "sampling" is per revolution, so that its "hertz" are orders."""
        per = float(self.samples_per_revolution)
        return Channel(self.name, self.values, per, self.unit, self.first / per)


def _rising(path: str, angle: Floats) -> None:
    bad = np.flatnonzero(~(np.diff(angle) > 0.0))
    if bad.size:
        found = f"stands or turns back at point {bad[0]}, {bad.size} in all"
        rule = "must turn forwards throughout, at a speed greater than 0"
        refuse(path, found, rule, "Cut the standstill off")


def _factor(channel: Channel, units: dict[str, float]) -> float:
    if channel.unit not in units:
        rule = "must be a unit of it that is known"
        refuse(f"{channel.name}.unit", channel.unit, rule, f"One of: {', '.join(units)}")
    return units[channel.unit]


def angle_from_speed(speed: Channel) -> ShaftAngle:
    """Return the shaft's angle, zero at the first sample, as the integral of a spline through a speed channel.

    Parameters
    ----------
    speed
        Speed in rad/s, rpm, 1/min, rev/min, Hz, 1/s, rev/s or deg/s, shape [time].

    Returns
    -------
    ShaftAngle
        Angle [rad] over time [s].

    Raises
    ------
    InputError
        For another unit, samples that are too few or not finite, or a speed that is not positive.

    Examples
    --------
    >>> shaft = angle_from_speed(Channel("n", np.full(11, 60.0), 10.0, "rpm"))
    >>> round(float(shaft.angle[-1]) / (2.0 * np.pi), 9)  # one second at one turn a second
    1.0

    """
    from scipy.interpolate import CubicSpline

    values = check_channel(speed) * _factor(speed, SPEED_UNITS)
    bad = np.flatnonzero(values <= 0.0)
    if bad.size:
        found = f"{speed.values[bad[0]]} {speed.unit} at sample {bad[0]}, {bad.size} in all"
        refuse(f"{speed.name}.values", found, "must be greater than 0", "Cut the standstill off")
    angle = np.asarray(CubicSpline(speed.time, values).antiderivative()(speed.time), dtype=np.float64)
    _rising(f"{speed.name}.values", angle)
    return ShaftAngle(speed.time, angle, f"speed channel {speed.name}")


def angle_from_angle(channel: Channel, *, wrapped: bool = False) -> ShaftAngle:
    """Return the shaft's angle of an angle channel in rad, deg or rev; ``wrapped`` where it starts anew each turn.

    Parameters
    ----------
    channel
        Angle in rad, deg or rev, shape [time].
    wrapped
        Whether it starts anew each turn.

    Returns
    -------
    ShaftAngle
        Angle [rad] over time [s].

    Raises
    ------
    InputError
        For another unit, samples that are too few or not finite, or an angle that does not rise.

    Examples
    --------
    >>> shaft = angle_from_angle(Channel("phi", (100.0 * np.arange(12)) % 360.0, 1.0, "deg"), wrapped=True)
    >>> round(float(np.degrees(shaft.angle[-1])), 9)
    1100.0

    """
    angle = check_channel(channel) * _factor(channel, ANGLE_UNITS)
    if wrapped:
        angle = np.asarray(np.unwrap(angle), dtype=np.float64)
    _rising(f"{channel.name}.values", angle)
    return ShaftAngle(channel.time, angle, f"angle channel {channel.name}")


def pulse_times(tacho: Channel, *, threshold: float | None = None, hysteresis: float = 0.2) -> Floats:
    """Return the times [s] at which a tacho signal rises through ``threshold``, shape [pulse], resolved between samples.

    The threshold is midway between the 1st and 99th percentile unless given [tacho.unit]; a pulse counts only after the
    signal has fallen below it by ``hysteresis`` times their distance, so that noise on an edge makes no second pulse.

    Raises `InputError` for samples that are too few, not finite or constant.

    >>> tacho = Channel("tacho", np.tile([0.0, 0.0, 1.0, 1.0], 5), 4.0, "V")
    >>> pulse_times(tacho)[:2].tolist()
    [0.375, 1.375]
    """
    values = check_channel(tacho)
    low, high = (float(v) for v in np.percentile(values, [1.0, 99.0]))
    if high <= low:  # pulses may be rarer than one sample in a hundred
        low, high = float(values.min()), float(values.max())
    if high <= low:
        rule = "must hold tacho pulses"
        refuse(f"{tacho.name}.values", f"{low} throughout", rule, "Check the tacho's wiring")
    level = 0.5 * (low + high) if threshold is None else threshold
    rearm = level - hysteresis * (high - low)
    # +1 on the sample that reaches the level, -1 where re-armed, 0 between; a pulse is a change of the last known state.
    state = np.where(values >= level, 1, np.where(values < rearm, -1, 0))
    known = np.flatnonzero(state)
    rises = known[1:][(state[known][1:] == 1) & (state[known][:-1] == -1)]
    before, after = values[rises - 1], values[rises]
    return np.asarray(tacho.start + (rises - (after - level) / (after - before)) / tacho.sampling)


def angle_from_tacho(
    tacho: Channel, pulses: int, *, threshold: float | None = None, hysteresis: float = 0.2
) -> ShaftAngle:
    """Return the shaft's angle from tacho pulses, ``pulses`` of them per revolution, equally spaced; zero at the first.

    Source: Fyfe and Munck, Mech. Syst. Signal Process. 11 (1997) 187. Arguments as `pulse_times`.

    Parameters
    ----------
    tacho
        Pulses, shape [time].
    pulses
        Pulses per revolution.
    threshold, hysteresis
        As `pulse_times` takes them.

    Returns
    -------
    ShaftAngle
        Angle [rad] over time [s], zero at the first pulse.

    Raises
    ------
    InputError
        For fewer than 4 pulses, or samples that are too few or not finite.

    Examples
    --------
    >>> tacho = Channel("tacho", np.tile([0.0, 0.0, 1.0, 1.0], 9), 4.0, "V")
    >>> shaft = angle_from_tacho(tacho, 2)
    >>> [float(v) / np.pi for v in shaft.angle[:3]]
    [0.0, 1.0, 2.0]

    """
    check_count("pulses", pulses, 1, 100_000, "Give the pulses per revolution")
    times = pulse_times(tacho, threshold=threshold, hysteresis=hysteresis)
    if times.size < 4:
        rule = "must hold at least 4 pulses"
        refuse(f"{tacho.name}.values", f"{times.size} pulses", rule, "Set the threshold")
    angle = np.arange(times.size, dtype=np.float64) * (TWO_PI / pulses)
    return ShaftAngle(times, angle, f"tacho {tacho.name}, {pulses} pulses per turn")


def shaft_angle(channel: Channel, speed: "float | Channel | ShaftAngle") -> ShaftAngle:
    """Return the shaft's angle for a signal from a constant speed [rad/s], a speed or angle channel, or an angle known.

    With a constant speed the angle is zero at the signal's first sample. A channel is taken by its unit.

    Raises `InputError` as the functions it calls.

    >>> shaft_angle(Channel("acc", np.zeros(100), 100.0), 2.0 * np.pi).source
    'constant speed, 60 rpm'
    """
    if isinstance(speed, ShaftAngle):
        return speed
    if isinstance(speed, Channel):
        return angle_from_angle(speed) if speed.unit in ANGLE_UNITS else angle_from_speed(speed)
    omega = check_positive("speed", speed, "rad/s")
    n = check_channel(channel).size
    time = np.linspace(channel.start, channel.start + (n - 1) / channel.sampling, 5)
    source = f"constant speed, {60.0 * omega / TWO_PI:.6g} rpm"
    return ShaftAngle(time, omega * (time - channel.start), source)
