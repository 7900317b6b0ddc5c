"""Laws that the reference adds to sleeves and meshes: what connects, supports and excites rotors.

Pure functions of the motion of single rotors, in SI units; `cross.reference` calls them.  The tables are
those of a case file: `supports`, `couplings`, `load.terms`, `drive.terms`, `unbalance`, `base` and a drive of
kind `position`.

Choices where the specification leaves room:

* A term has either a ``frequency`` or an ``order``; one with neither is refused.
* A support's ``damping`` alone acts on a centre that something else frees, and frees none itself.
* Without a proportional gain there is no back-calculation: such a servo is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

TWO_PI = 2.0 * math.pi
Pair = tuple[float, float]
Wrench = tuple[float, float, float]
"""Force along x and y [N] and torque about the rotor's axis [N m]."""


class Body(NamedTuple):
    """Motion of a rotor: displacement of its centre, full rotation, velocities [m, rad, m/s, rad/s]."""

    x: float
    y: float
    theta: float
    vx: float
    vy: float
    omega: float


def plain(value: Any) -> Any:
    """Return a case as nested dicts and lists, whether it came as such or as an object with these attributes.

    What has a method ``at`` (a base acceleration) is kept as it is.
    """
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if callable(getattr(value, "at", None)):
        return value
    fields = getattr(type(value), "model_fields", None)
    if fields is not None:
        return {name: plain(getattr(value, name)) for name in fields}
    return {name: plain(each) for name, each in vars(value).items()} if hasattr(value, "__dict__") else value


def number(table: Mapping[str, Any], name: str, default: float = 0.0) -> float:
    """Return a number of a table, or the default where it is missing or None."""
    value = table.get(name)
    return default if value is None else float(value)


def pair(table: Mapping[str, Any], name: str) -> Pair:
    """Return two numbers of a table, zeros where they are missing or None."""
    first, second = table.get(name) or (0.0, 0.0)
    return float(first), float(second)


def turned(angle: float, x: float, y: float) -> Pair:
    """Return a vector turned counter-clockwise by an angle [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


# ---------------------------------------------------------------------- torque terms


@dataclass(frozen=True, slots=True)
class Term:
    """``amplitude sin(2 pi frequency t + phase)`` or ``amplitude sin(order theta + phase)`` [N m]."""

    frequency: float | None  # Hz
    order: float | None
    amplitude: float
    phase: float

    def torque(self, t: float, theta: float) -> float:
        """Return the torque [N m] at a time [s] and a full rotation [rad]."""
        if self.frequency is not None:
            return self.amplitude * math.sin(TWO_PI * self.frequency * t + self.phase)
        assert self.order is not None
        return self.amplitude * math.sin(self.order * theta + self.phase)


def terms_of(table: Mapping[str, Any], factor: float) -> tuple[Term, ...]:
    """Return the terms of a drive or a load, their amplitudes times a factor (the sense)."""
    found = []
    for term in table.get("terms") or ():
        frequency, order = term.get("frequency"), term.get("order")
        if (frequency is None) == (order is None):
            raise ValueError("a term has a frequency or an order")
        found.append(Term(frequency, order, factor * float(term["amplitude"]), number(term, "phase")))
    return tuple(found)


# ---------------------------------------------------------------------- base motion


@dataclass(frozen=True, slots=True)
class Base:
    """Acceleration of the housing: ``at(t)`` [m/s^2], and the times [s] at which it is not smooth."""

    at: Callable[[float], Pair]
    kinks: tuple[float, ...] = ()


def base_of(table: Mapping[str, Any] | None) -> Base | None:
    """Return the housing's motion of the table ``base``, None where it stands still."""
    given = (table or {}).get("acceleration")
    if given is None:
        return None
    if not isinstance(given, Mapping):
        names = ("kind", "start", "duration")
        return Base(_called(given), _kinks({name: getattr(given, name, None) for name in names}))
    way = turned(number(given, "direction"), 1.0, 0.0)
    size = _harmonic(given) if given["kind"] == "harmonic" else _half_sine(given)
    return Base(lambda t: (size(t) * way[0], size(t) * way[1]), _kinks(given))


def _called(given: Any) -> Callable[[float], Pair]:
    def at(t: float) -> Pair:
        ax, ay = given.at(t)
        return float(ax), float(ay)

    return at


def _kinks(given: Mapping[str, Any]) -> tuple[float, ...]:
    if given.get("kind") != "half-sine":
        return ()
    start = number(given, "start")
    return start, start + float(given["duration"])


def _harmonic(given: Mapping[str, Any]) -> Callable[[float], float]:
    rate, phase = TWO_PI * float(given["frequency"]), number(given, "phase")
    return lambda t: float(given["amplitude"]) * math.sin(rate * t + phase)


def _half_sine(given: Mapping[str, Any]) -> Callable[[float], float]:
    if given["kind"] != "half-sine":
        raise ValueError(f"the reference knows no base motion {given['kind']!r}")
    start, duration = number(given, "start"), float(given["duration"])

    def size(t: float) -> float:
        inside = start <= t <= start + duration
        return float(given["amplitude"]) * math.sin(math.pi * (t - start) / duration) if inside else 0.0

    return size


# ---------------------------------------------------------------------- supports


@dataclass(frozen=True, slots=True)
class Support:
    """Linear bearing of a rotor on the ground (``carrier`` -1) or at a carrier's ``pin``."""

    rotor: int
    carrier: int
    stiffness: Pair  # N/m
    damping: Pair  # N s/m
    torsional_stiffness: float
    torsional_damping: float
    pin: Pair  # m, nominal place from the carrier's centre at its rotation of 0
    unstressed: Pair = (0.0, 0.0)  # m, beside that place

    def offset(self, own: Body, carrier: Body | None) -> tuple[Pair, Pair]:
        """Return displacement [m] and rate [m/s] of the rotor's centre in the support's own axes."""
        if carrier is None:
            return (own.x, own.y), (own.vx, own.vy)
        arm_x, arm_y = turned(carrier.theta, *self.pin)
        x = own.x - carrier.x - (arm_x - self.pin[0])
        y = own.y - carrier.y - (arm_y - self.pin[1])
        # The rate as the turning frame sees it: the whole arm to the journal's centre turns with the carrier.
        rate_x = own.vx - carrier.vx + carrier.omega * (arm_y + y)
        rate_y = own.vy - carrier.vy - carrier.omega * (arm_x + x)
        return turned(-carrier.theta, x, y), turned(-carrier.theta, rate_x, rate_y)

    def strain(self, place: Pair) -> Pair:
        """Return how far the springs are from their unstressed place [m]."""
        return place[0] - self.unstressed[0], place[1] - self.unstressed[1]

    def loads(self, own: Body, carrier: Body | None) -> tuple[Wrench, Wrench]:
        """Return what acts on the rotor and on its carrier, each about its own centre."""
        place, rate = self.offset(own, carrier)
        strain = self.strain(place)
        force = [-self.stiffness[k] * strain[k] - self.damping[k] * rate[k] for k in range(2)]
        theta, omega = own.theta, own.omega
        if carrier is None:
            torque = -self.torsional_stiffness * theta - self.torsional_damping * omega
            return (force[0], force[1], torque), (0.0, 0.0, 0.0)
        theta, omega = theta - carrier.theta, omega - carrier.omega
        torque = -self.torsional_stiffness * theta - self.torsional_damping * omega
        fx, fy = turned(carrier.theta, force[0], force[1])
        arm_x, arm_y = turned(carrier.theta, self.pin[0] + place[0], self.pin[1] + place[1])
        return (fx, fy, torque), (-fx, -fy, -torque - (arm_x * fy - arm_y * fx))


# ---------------------------------------------------------------------- couplings


@dataclass(frozen=True, slots=True)
class Coupling:
    """Spring between the rotations of two rotors, with or without play, and between their centres."""

    label: str
    a: int
    b: int
    ratio: float
    stiffness: float
    damping: float
    half_play: float  # rad; 0: acts in both senses
    lateral_stiffness: float
    lateral_damping: float

    def depth(self, side: float, phi: float, rate: float) -> tuple[float, float]:
        """Return penetration [rad] of the end that meets a twist of this sign, and its rate."""
        return side * phi - self.half_play, side * rate

    def lateral(self, a: Body, b: Body) -> Pair:
        """Return the force [N] on the first rotor's centre; the second feels its opposite."""
        fx = -self.lateral_stiffness * (a.x - b.x) - self.lateral_damping * (a.vx - b.vx)
        fy = -self.lateral_stiffness * (a.y - b.y) - self.lateral_damping * (a.vy - b.vy)
        return fx, fy


def coupling_of(table: Mapping[str, Any], index: Mapping[str, int]) -> Coupling:
    """Return a coupling of its table."""
    one, two = table["between"]
    ratio = number(table, "ratio", 1.0)
    lateral = number(table, "lateral_stiffness"), number(table, "lateral_damping")
    if ratio != 1.0 and any(lateral):
        raise ValueError("a coupling with a ratio has no lateral part")
    return Coupling(
        label=f"{one}-{two}",
        a=index[one],
        b=index[two],
        ratio=ratio,
        stiffness=float(table["torsional_stiffness"]),
        damping=number(table, "torsional_damping"),
        half_play=0.5 * number(table, "play"),
        lateral_stiffness=lateral[0],
        lateral_damping=lateral[1],
    )


# ---------------------------------------------------------------------- position servo


@dataclass(frozen=True, slots=True)
class PositionServo:
    """``T = sense (kp e + ki z - kd omega)`` of the sensor's rotor, limited."""

    angle: float  # rad, of the sensor's rotor
    kp: float
    kd: float
    ki: float
    limit: float
    sensor: int
    sense: float  # -1 where the sensor's rotor turns against the driven one
    sample_time: float  # s; 0: continuous

    def error(self, sensor: Body) -> float:
        """Return what the sensor's rotation lacks [rad]."""
        return self.angle - sensor.theta

    def raw(self, sensor: Body, integral: float) -> float:
        """Return the torque [N m] before its limit."""
        return self.sense * (self.kp * self.error(sensor) + self.ki * integral - self.kd * sensor.omega)

    def integral_rate(self, sensor: Body, raw: float, limited: float) -> float:
        """Return the rate of the integral, with back-calculation [rad]."""
        return self.error(sensor) + self.sense * (limited - raw) / self.kp

    def clipped(self, raw: float) -> float:
        """Return the torque within its limits [N m]."""
        return min(max(raw, -self.limit), self.limit)


def position_servo_of(drive: Mapping[str, Any], own: int, sensor: int, sense: float) -> PositionServo:
    """Return the servo of a drive's table; ``sense`` is that of the sensor's rotor against the driven one."""
    kp = float(drive["proportional_gain"])
    if kp <= 0.0:
        raise ValueError("a position servo needs a proportional gain")
    return PositionServo(
        angle=float(drive["angle"]),
        kp=kp,
        kd=number(drive, "derivative_gain"),
        ki=number(drive, "integral_gain"),
        limit=number(drive, "torque_limit", math.inf),
        sensor=sensor,
        sense=1.0 if sensor == own else sense,
        sample_time=number(drive, "sample_time"),
    )


# ---------------------------------------------------------------------- a planar body with an unbalance


def accelerations(
    mass: float,
    inertia: float,
    moment: Pair,
    omega: float,
    load: Sequence[float],
    field: Pair,
    movable: bool,
    alpha: float | None,
) -> tuple[float, float, float]:
    """Return the accelerations of the axis and of the rotation [m/s^2, rad/s^2].

    ``moment`` is mass times centre of mass from the axis [kg m], ``load`` force and torque about the axis,
    ``field`` gravity less the base's acceleration; ``alpha`` is given where the rotation is prescribed.
    """
    ux, uy = moment
    fx, fy, torque = load
    if not movable:
        turn = (torque + ux * field[1] - uy * field[0]) / inertia if alpha is None else alpha
        return 0.0, 0.0, turn
    if alpha is None:  # eliminate the centre from the third equation; the uniform field then falls out of it
        alpha = (torque - (ux * fy - uy * fx) / mass) / (inertia - (ux**2 + uy**2) / mass)
    ax = (fx + alpha * uy + omega**2 * ux) / mass + field[0]
    ay = (fy - alpha * ux + omega**2 * uy) / mass + field[1]
    return ax, ay, alpha
