"""Synthetic vibration of the bundled planetary reducer at a sensor on its ring, under ten conditions, made of formulas.

Three planets pass the sensor one after another, each with the waves of its two meshes; sun and carrier turn, the ring stands.
"""

import numpy as np
from numpy.typing import NDArray

import gearplay as gp
from gearplay.signals import bearing_orders
from machine_records import event_times, ringing

RATE, SECONDS = 12_800.0, 16.0
CASE = "planetary-reducer"
PLANETS, SUN, PLANET, RING = 3, 17, 37, 91
BEARING = {
    "rolling_elements": 14,
    "element_diameter": "9.5 mm",
    "pitch_diameter": "68 mm",
    "stiffness": "1e10 N/m^1.5",
}
NAMES = {
    "healthy": "no damage that this record shows",
    "sun tooth": "damaged tooth on stage.sun",
    "planet tooth": "damaged tooth on stage.planet",
    "ring tooth": "damaged tooth on stage.ring",
    "worn pin": "uneven planets of stage",
    "eccentric carrier": "uneven planets of stage",
    "eccentric sun": "eccentric stage.sun",
    "eccentric planet": "eccentric stage.planet",
    "planet bearing, inner": "bearing of a planet of stage, inner ring",
    "planet bearing, outer": "bearing of a planet of stage, outer ring",
}
CONDITIONS = tuple(NAMES)
EVEN = tuple(2 * np.pi * i / PLANETS for i in range(PLANETS))

Floats = NDArray[np.float64]


def with_bearings() -> gp.Case:
    """Return the bundled reducer with rolling bearings in its planets."""
    return gp.replace(gp.load_case(CASE), {"planetary.stage.pin": None, "planetary.stage.bearing": BEARING})


def crossings(angle: Floats, place: float, t: Floats) -> Floats:
    """Return the times at which a rising angle passes ``place`` and whole turns beyond [s]."""
    turns = np.arange(
        np.ceil((angle[0] - place) / (2 * np.pi)), np.floor((angle[-1] - place) / (2 * np.pi)) + 1
    )
    return np.interp(place + 2 * np.pi * turns, angle, t)


def planetary_record(
    condition: str, seed: int, *, severity: float = 1.0, noise: float = 0.2, angles: tuple[float, ...] = EVEN
) -> tuple[gp.Channel, float]:
    """Return the acceleration of the reducer's ring in a condition, and the true speed of its sun [Hz], within 2 %.

    ``angles`` [rad] are those of the planets.
    """
    rng = np.random.default_rng([seed, CONDITIONS.index(condition), 7])
    n = int(RATE * SECONDS)
    t = np.arange(n) / RATE
    f = 800.0 / 60.0 * (1.0 + rng.uniform(-0.02, 0.02))
    f_c = f * SUN / (SUN + RING)
    carrier, sun = (2 * np.pi * each * t + rng.uniform(0, 2 * np.pi) for each in (f_c, f - f_c))
    planets = [carrier + each for each in angles]
    width, least = rng.uniform(0.6, 1.5), rng.uniform(0.2, 0.4)

    def passing(angle: Floats) -> Floats:
        """Return how much of a vibration at an angle from the sensor comes through."""
        return np.asarray(least + (1.0 - least) * np.exp(width * (np.cos(angle) - 1.0)))

    shares, phases = 1.0 + rng.uniform(-0.03, 0.03, PLANETS), rng.uniform(-0.03, 0.03, PLANETS)
    runout, runouts = rng.uniform(0.01, 0.05), rng.uniform(0.01, 0.03, PLANETS)
    if condition == "worn pin":
        shares[0] -= severity * rng.uniform(0.45, 0.65)
        shares[1:] += severity * 0.2
        phases[0] -= severity * rng.uniform(0.1, 0.4)
    elif condition == "eccentric carrier":
        wave = np.cos(np.array(angles) + rng.uniform(0, 2 * np.pi))
        shares += severity * rng.uniform(0.3, 0.5) * wave
        phases += severity * rng.uniform(0.1, 0.3) * wave
    elif condition == "eccentric sun":
        runout = severity * rng.uniform(0.35, 0.6)
    elif condition == "eccentric planet":
        runouts[0] = severity * rng.uniform(0.5, 0.8)
    place, resonance, decay = rng.uniform(0, 2 * np.pi), rng.uniform(1800, 4500), rng.uniform(500, 1200)
    amplitudes, high = (
        rng.uniform(0.7, 1.3, (2, 4)) * (1.0, 0.5, 0.3, 0.15),
        rng.uniform(0, 2 * np.pi, (2, 4)),
    )
    x = np.zeros(n)
    spin = RING / PLANET * carrier  # of the planets against the carrier
    for i, angle in enumerate(planets):
        towards = sun - angles[i] - place  # of a mark of the sun from the planet
        swing = 1.0 + runout * np.cos(towards) + runouts[i] * np.cos(spin - place)
        dip = np.zeros(n)
        if condition == "sun tooth":
            dip = _near(towards, SUN)
        elif condition == "planet tooth" and i == 0:
            dip = _near(spin - place, PLANET) + 0.7 * _near(spin - place + np.pi, PLANET)
        elif condition == "ring tooth":
            dip = _near(angle - place, RING)
        for h, (own, other) in enumerate(amplitudes.T, 1):
            wave = h * (RING * angle + phases[i] - 0.3 * severity * dip)
            x += shares[i] * passing(angle) * swing * (1.0 - 0.3 * severity * dip) * (
                own * np.cos(wave + 0.2 * h * runout * np.sin(towards) + high[0, h - 1]) + other * np.cos(wave + high[1, h - 1])
            )  # fmt: skip
    events: list[tuple[Floats, float, int]] = []
    if condition == "sun tooth":
        events = [(crossings(sun, place + angles[i], t), 1.0, i) for i in range(PLANETS)]
    elif condition == "planet tooth":
        events = [(crossings(spin, place, t), 1.0, 0), (crossings(spin, place + np.pi, t), 0.7, 0)]
    elif condition == "ring tooth":
        events = [(crossings(planets[i], place, t), 1.0, i) for i in range(PLANETS)]
    elif condition.startswith("planet bearing"):
        order = bearing_orders(14, 9.5e-3, 68e-3)
        line = (order.bpfi if condition.endswith("inner") else order.bpfo) * f_c * RING / PLANET
        times = event_times(line * (1.0 + rng.uniform(-0.01, 0.01)), SECONDS, 0.008, rng)
        events = [(times[times < t[-1]], 0.6, 0)]
    for times, height, i in events:
        load = passing(np.interp(times, t, planets[i]))
        if condition.endswith("outer"):  # turns under the load of its pin
            load = load * (1.0 + 0.7 * np.cos(np.interp(times, t, spin)))
        heights = 1.2 * severity * height * load * (1.0 + 0.15 * rng.standard_normal(times.size))
        x += ringing(times, heights, n, RATE, resonance, decay)
    x += 0.05 * np.cos(2 * np.pi * f * t + 1.0) + noise * rng.standard_normal(n)
    return gp.Channel("ring", x, RATE, "m/s^2"), f


def _near(angle: Floats, teeth: int) -> Floats:
    """Return 1 where one of so many teeth is in mesh, at angle 0, and 0 away from it."""
    off = (angle + np.pi) % (2 * np.pi) - np.pi
    return np.asarray(np.exp(-((off * teeth / (2 * np.pi)) ** 2) / (2 * 0.35**2)))
