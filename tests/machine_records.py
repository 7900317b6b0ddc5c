"""Synthetic vibration of a gear pair with two bearings under twelve conditions, made of formulas."""

import numpy as np
from numpy.typing import NDArray

import gearplay as gp
from gearplay.signals import bearing_orders

RATE, SECONDS = 20_000.0, 6.0
TEETH = (23, 61)
BEARINGS = ("8, 7.9mm, 33.5mm", "9, 7.94mm, 39.04mm @2")
CONDITIONS = ("healthy", "tooth 1", "tooth 2", "eccentric 1", "eccentric 2", "rattle", "inner 1", "outer 1", "element 1",
              "cage 1", "inner 2", "outer 2")  # fmt: skip
NAMES = {
    "healthy": "no damage that this record shows",
    "tooth 1": "damaged tooth on gear 1 (23 teeth)",
    "tooth 2": "damaged tooth on gear 2 (61 teeth)",
    "eccentric 1": "eccentric gear 1 (23 teeth)",
    "eccentric 2": "eccentric gear 2 (61 teeth)",
    "rattle": "rattle of the flanks",
    "inner 1": "bearing 1, inner ring",
    "outer 1": "bearing 1, outer ring",
    "element 1": "bearing 1, rolling element",
    "cage 1": "bearing 1, cage",
    "inner 2": "bearing 2, inner ring",
    "outer 2": "bearing 2, outer ring",
}
ORDERS = (bearing_orders(8, 7.9e-3, 33.5e-3), bearing_orders(9, 7.94e-3, 39.04e-3))

Floats = NDArray[np.float64]


def ringing(times: Floats, heights: Floats, n: int, rate: float, frequency: float, decay: float) -> Floats:
    """Return impacts of some heights at some times [s], each a decaying oscillation."""
    shocks = np.zeros(n)
    place = times * rate
    at = np.floor(place).astype(int)
    inside = (at >= 0) & (at < n - 1)
    np.add.at(shocks, at[inside], heights[inside] * (1.0 - (place - at)[inside]))
    np.add.at(shocks, at[inside] + 1, heights[inside] * (place - at)[inside])
    t = np.arange(int(8.0 / decay * rate)) / rate
    from scipy.signal import fftconvolve

    return np.asarray(fftconvolve(shocks, np.exp(-decay * t) * np.sin(2 * np.pi * frequency * t))[:n])


def event_times(frequency: float, seconds: float, slip: float, rng: np.random.Generator) -> Floats:
    """Return the times [s] of events whose intervals vary by a share ``slip``, as those of slipping elements do."""
    count = int(seconds * frequency * 1.1) + 2
    return rng.random() / frequency + np.cumsum((1.0 + slip * rng.standard_normal(count)) / frequency)


def machine_record(
    condition: str, seed: int, *, severity: float = 1.0, noise: float = 0.3
) -> tuple[gp.Channel, float]:
    """Return the acceleration of a machine in a condition, and its true speed [Hz], within 2 % of 25 Hz.

    Conditions that occur together are joined by " + ": "inner 1 + eccentric 2".
    """
    together = condition.split(" + ")
    rng = np.random.default_rng([seed, *map(CONDITIONS.index, together)])
    n = int(RATE * SECONDS)
    t = np.arange(n) / RATE
    f = 25.0 * (1.0 + rng.uniform(-0.02, 0.02))
    turns = (f, f * TEETH[0] / TEETH[1])
    phase = [rng.uniform(0, 2 * np.pi) for _ in range(2)]
    angle = [2 * np.pi * turns[k] * t + phase[k] for k in range(2)]
    depth = [rng.uniform(0.02, 0.07), rng.uniform(0.02, 0.07)]
    kinds = [each.partition(" ")[::2] for each in together]
    for kind, which in kinds:
        if kind == "eccentric":
            depth[int(which) - 1] = severity * rng.uniform(0.35, 0.6)
    swing = (1.0 + depth[0] * np.cos(angle[0])) * (1.0 + depth[1] * np.cos(angle[1]))
    mesh = TEETH[0] * angle[0]
    turn = sum(0.5 * depth[k] * np.sin(angle[k] + rng.uniform(0, 6)) for k in range(2))
    x = np.zeros(n)
    dip = np.zeros(n)
    for kind, which in kinds:
        if kind == "tooth":
            k = int(which) - 1
            place = rng.uniform(0, 2 * np.pi)
            off = (angle[k] - place + np.pi) % (2 * np.pi) - np.pi
            dip = dip + np.exp(-((off * TEETH[k] / (2 * np.pi)) ** 2) / (2 * 0.35**2))
    for h, a in enumerate((1.0, 0.6, 0.35, 0.2, 0.1), 1):
        loss = 1.0 - 0.35 * severity * dip
        x += a * rng.uniform(0.7, 1.3) * swing * loss * np.cos(h * (mesh + 0.3 * turn - 0.25 * severity * dip)
                                                               + rng.uniform(0, 6))  # fmt: skip
    x += 0.1 * np.cos(angle[0] + 1.0) + 0.05 * np.cos(2 * angle[0]) + 0.1 * np.cos(angle[1])
    for kind, which in kinds:
        place, decay = rng.uniform(2800, 5500), rng.uniform(500, 1200)
        if kind == "tooth":
            own = turns[int(which) - 1]
            times = (np.arange(int(SECONDS * own)) + (rng.random())) / own
            heights = 0.8 * severity * (1.0 + 0.2 * rng.standard_normal(times.size))
            x += ringing(times, heights, n, RATE, place, decay)
        elif kind == "rattle":
            times = (np.arange(int(SECONDS * TEETH[0] * f)) + 0.5) / (TEETH[0] * f)
            times = times + rng.normal(0.0, 0.06, times.size) / (TEETH[0] * f)
            x += ringing(times, severity * rng.exponential(0.8, times.size), n, RATE, place, decay)
        elif kind in ("inner", "outer", "element", "cage"):
            orders = ORDERS[int(which) - 1]
            shaft = turns[int(which) - 1]
            real = 1.0 + rng.uniform(-0.01, 0.01)
            order = {
                "inner": orders.bpfi,
                "outer": orders.bpfo,
                "element": 2 * orders.bsf,
                "cage": orders.ftf,
            }
            times = event_times(order[kind] * shaft * real, SECONDS, 0.008, rng)
            load = {"inner": 1.0 + 0.7 * np.cos(2 * np.pi * shaft * times), "outer": np.ones(times.size),
                    "element": 1.0 + 0.7 * np.cos(2 * np.pi * orders.ftf * real * shaft * times),
                    "cage": np.full(times.size, 1.5)}[kind]  # fmt: skip
            heights = severity * 0.7 * load * (1 + 0.1 * rng.standard_normal(times.size))
            x += ringing(times, heights, n, RATE, place, decay)
    x += noise * rng.standard_normal(n)
    return gp.Channel("acc", x, RATE, "m/s^2"), f


def bearing_record(
    part: str = "inner", seed: int = 0, *, speed: float = 1797 / 60, noise: float = 0.05
) -> gp.Channel:
    """Return ten seconds at 12 kHz of a motor's bearing 6205, as the public records: impacts through a resonance, noise.

    Inner ring: 5.415 impacts a turn, load-modulated, slip 0.3 %; lines of the turns and of the mains beside them.
    """
    rng = np.random.default_rng(seed)
    rate, seconds = 12_000.0, 10.0
    n = int(rate * seconds)
    t = np.arange(n) / rate
    own = bearing_orders(9, 0.3126 * 0.0254, 1.537 * 0.0254)
    order = {"inner": own.bpfi, "outer": own.bpfo, "element": 2 * own.bsf}[part]
    times = event_times(0.998 * order * speed, seconds, 0.003, rng)
    load = 1.0 + {"inner": 0.6, "outer": 0.0, "element": 0.0}[part] * np.cos(2 * np.pi * speed * times)
    heights = 0.5 * load * (1.0 + 0.15 * rng.standard_normal(times.size))
    x = ringing(times, heights, n, rate, 3200.0, 900.0) + noise * rng.standard_normal(n)
    for k, a in ((1, 0.03), (2, 0.05), (3, 0.02)):
        x += a * np.cos(2 * np.pi * k * speed * t + rng.uniform(0, 6))
    return gp.Channel("X105_DE_time", x + 0.02 * np.cos(2 * np.pi * 120.0 * t), rate, "g")
