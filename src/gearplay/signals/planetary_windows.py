"""Planetary sets with a fixed ring: times between the contacts of one tooth, and tooth-by-tooth averages of planet and sun."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.angle import AngleRecord, ShaftAngle, shaft_angle
from gearplay.signals.checks import TWO_PI, check_count, check_positive, check_real, refuse
from gearplay.signals.resampling import resampled
from gearplay.signals.synchronous import SynchronousAverage

Floats = NDArray[np.float64]

GEARS = ("sun", "planet")


@dataclass(frozen=True)
class EventPeriods:
    """Times between contacts of one tooth of a planetary set with a fixed ring [s]; ``mesh_frequency`` [Hz].

    ``sun``: of one sun tooth with any planet; ``planet``: of one flank of a planet's tooth (it meets the sun with one flank and
    the ring with the other); ``ring``: of one ring tooth with any planet; ``hunting``: of the same two teeth of sun and planet.
    """

    mesh_frequency: float
    sun: float
    planet: float
    ring: float
    hunting: float


def _check_set(sun: int, planet: int, ring: int, planets: int) -> None:
    for name, teeth in (("sun", sun), ("planet", planet), ("ring", ring)):
        check_count(name, teeth, 3, 10_000, "Give its number of teeth")
    check_count("planets", planets, 1, 100, "Give the number of planets")
    if ring <= sun:
        refuse(
            "ring", ring, f"must have more teeth than the sun, {sun}", "Check the order: sun, planet, ring"
        )


def event_periods(sun: int, planet: int, ring: int, planets: int, speed: float) -> EventPeriods:
    """Return the times between contacts of one tooth in a planetary set whose ring stands and whose sun turns at ``speed``.

    The carrier turns at f_c = f_s z_s / (z_s + z_r), teeth mesh at f_m = z_r f_c. One sun tooth meets planets every
    1 / (N (f_s - f_c)), a flank of a planet's tooth its partner every z_p / f_m, a ring tooth planets every 1 / (N f_c), the same
    teeth of sun and planet meet every lcm(z_s, z_p) / f_m.

    Source: McFadden, J. Sound Vib. 144 (1991) 163.

    Parameters
    ----------
    sun, planet, ring
        Teeth.
    planets
        Number of planets.
    speed
        Of the sun [rad/s].

    Returns
    -------
    EventPeriods
        Periods [s].

    Raises
    ------
    InputError
        For an invalid number of teeth or an invalid speed.

    Examples
    --------
    >>> found = event_periods(24, 30, 84, 4, 1200 * 2.0 * np.pi / 60)
    >>> [round(each, 6) for each in (found.mesh_frequency, found.sun, found.planet, found.ring, found.hunting)]
    [373.333333, 0.016071, 0.080357, 0.05625, 0.321429]

    """
    _check_set(sun, planet, ring, planets)
    f_s = check_positive("speed", speed, "rad/s") / TWO_PI
    f_c = f_s * sun / (sun + ring)
    f_m = f_c * ring
    hunting = math.lcm(sun, planet) / f_m
    return EventPeriods(f_m, 1.0 / (planets * (f_s - f_c)), planet / f_m, 1.0 / (planets * f_c), hunting)


def planetary_average(
    channel: Channel,
    carrier: float | Channel | ShaftAngle,
    sun: int,
    planet: int,
    ring: int,
    planets: int,
    *,
    gear: str = "planet",
    number: int = 1,
    teeth: int = 2,
    place: float = 0.0,
) -> SynchronousAverage:
    """Return the average of a planet or of the sun, tooth by tooth, from a sensor on the standing ring.

    Whenever the planet passes the sensor, a window of some teeth is taken and added where its teeth lie on the gear: at pass n
    the gear is n z_r mod z teeth further. The average is the sum over that of the windows (Hann), from the tooth in mesh at the
    first pass. All teeth are reached only if the step, gcd(z_r, z), is below the width of the window.

    Source: McFadden, J. Sound Vib. 144 (1991) 163; Samuel and Pines, J. Sound Vib. 282 (2005) 475 (windows of several teeth).

    Parameters
    ----------
    channel
        Signal of a sensor on the ring, shape [time].
    carrier
        Speed of the carrier: a constant [rad/s], a speed channel, or a `ShaftAngle`.
    sun, planet, ring
        Teeth.
    planets
        Number of planets, equally spaced.
    gear
        "planet", or "sun", as seen through the planet ``number``.
    number
        Of the planet, 1 to ``planets``; they follow against the carrier's turn, so that number 2 passes 1/N of a turn later.
    teeth
        Width of a window [teeth].
    place
        Angle of the carrier at which planet 1 is at the sensor [rad].

    Returns
    -------
    SynchronousAverage
        Over one turn of the gear relative to the carrier; ``error`` is nan, ``residual_share`` of the windows.

    Raises
    ------
    InputError
        For teeth that windows of this width do not reach, too short a record, a speed that is not positive, and other gears.

    Examples
    --------
    >>> t = np.arange(40_000) / 2000.0
    >>> mesh = 2.0 * np.pi * 91.0 * 2.0 * t  # carrier at 2 Hz, planet of 37 teeth
    >>> found = planetary_average(Channel("acc", np.cos(3.0 * mesh / 37), 2000.0), 4.0 * np.pi, 17, 37, 91, 3)
    >>> bool(np.max(np.abs(found.average - np.cos(3.0 * found.angle))) < 1e-3)
    True

    """
    _check_set(sun, planet, ring, planets)
    if gear not in GEARS:
        refuse("gear", gear, "must be a gear that the window follows", f"Choose from: {', '.join(GEARS)}")
    check_real("place", place, -1e6, 1e6, "Give the angle of the carrier in radians")
    check_count("number", number, 1, planets, "Count the planets from 1")
    z = planet if gear == "planet" else sun
    check_count("teeth", teeth, 1, min(z, ring // planets), "2 is usual")
    step = math.gcd(ring, z)
    if step > teeth:
        rule = f"must be {step} or more, by which the {gear} steps from pass to pass, or some of its teeth are never seen"
        refuse("teeth", teeth, rule, "Widen the window, or choose another gear")
    shaft = shaft_angle(channel, carrier)
    highest = 0.4 * channel.sampling * TWO_PI / float(np.max(shaft.at(shaft.time)[1]))
    m = math.ceil(2.5 * highest / ring) + 1
    record = resampled(channel, shaft, highest=highest, samples_per_revolution=m * ring)
    middle = round((place / TWO_PI % 1.0 + (number - 1) / planets) * m * ring)
    return _windowed(record, channel.name, m, ring, z, teeth, middle)


def _windowed(
    record: AngleRecord, name: str, m: int, ring: int, z: int, teeth: int, middle: int
) -> SynchronousAverage:
    """Return the average of windows of ``teeth`` over a gear of ``z`` teeth, ``m`` samples each, first at sample ``middle``."""
    values, first = record.values, record.first
    turn, width = m * ring, teeth * m + 1
    weights = np.hanning(width + 2)[1:-1]
    passes = range(math.ceil((first - middle) / turn), (first + values.size - 1 - middle) // turn + 1)
    total, weight, square = (np.zeros(z * m) for _ in range(3))
    count = 0
    for n in passes:
        begin = middle + n * turn - width // 2 - first
        if begin < 0 or begin + width > values.size:
            continue
        x = values[begin : begin + width]
        at = (n * turn - width // 2 + np.arange(width)) % (z * m)
        np.add.at(total, at, weights * x)
        np.add.at(weight, at, weights)
        np.add.at(square, at, weights * x * x)
        count += 1
    if count < 1 or float(np.min(weight)) <= 0.0:
        rule = f"must last until every tooth has passed the sensor, {z // math.gcd(ring, z)} turns of the carrier and one more"
        refuse("channel", f"{values.size / turn:.4g} turns", rule, "Take a longer record")
    average: Floats = total / weight
    left = float(np.sum(square - weight * average**2)) / float(np.sum(weight))
    held = (
        float(np.sum(square)) / float(np.sum(weight)) - float(np.sum(total)) ** 2 / float(np.sum(weight)) ** 2
    )
    left = max(left, 0.0)
    return SynchronousAverage(
        TWO_PI / average.size * np.arange(average.size, dtype=np.float64), average, np.full(average.size, math.nan), count, 1,
        math.sqrt(left), left / held if held > 0.0 else 0.0, record.unit,
        f"windows of {teeth} teeth at each pass of the sensor; {record.source}", name,
    )  # fmt: skip
