"""Responses of other origin: oscillators, maps, tones, noise and drifts, each with the verdicts that are not false.

Every response has 400 to 2000 periods and a resolution of 1e-6 to 1e-3 of its size; "undecided" is never false.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chaotic_orbits import henon, logistic

Floats = NDArray[np.float64]
Random = np.random.Generator

DUFFING = {0.20: 1, 0.28: 2, 0.29: 4, 0.37: 5, 0.50: 0, 0.65: 2}
"""Order of the motion of x'' + 0.3 x' - x + x^3 = force cos(1.2 t) by its force, 0 for chaos: the textbook cascade."""


@dataclass(frozen=True)
class Other:
    """A response, what it is, and the verdicts besides "undecided" that are not false (kind, and order of a cycle)."""

    name: str
    samples: Floats
    resolution: float
    right: tuple[tuple[str, int | None], ...]


TORUS, CHAOS, TRANSIENT = ("quasi-periodic", None), ("chaotic", None), ("transient", None)


def others(seed: int, each: int) -> Iterator[Other]:
    """Yield ``each`` responses of every origin."""
    for number, make in enumerate(
        (duffing, tones, noisy, noise, drifting, swinging, turning_map, standard_map)
    ):
        for i in range(each):
            yield make(np.random.default_rng([seed, number, i]))


def _sized(random: Random) -> tuple[int, Floats, float]:
    periods = int(random.integers(400, 2001))
    return periods, np.arange(periods, dtype=np.float64), 10.0 ** random.uniform(-6.0, -3.0)


def _tone(random: Random, n: Floats) -> Floats:
    """Return a tone whose frequency, with the forcing's 1, is far from all ratios of small numbers."""
    turns = (0.5 * (math.sqrt(5.0) - 1.0) * int(random.integers(1, 9))) % 1.0
    return np.asarray(np.cos(2.0 * math.pi * turns * n + random.uniform(0.0, 6.0)))


def _cycle(random: Random, n: Floats) -> tuple[Floats, int]:
    order = int(random.integers(2, 10))
    pattern = np.cos(2.0 * math.pi * np.arange(order) / order + 0.3) + 0.1 * random.normal(size=order)
    return np.resize(pattern, len(n)), order


def _oscillator(
    slope: Callable[[float, float, float], float], period: float, start: Floats, periods: int
) -> Floats:
    """Return position and speed once per period after 300 periods, by Runge and Kutta's method with 64 steps a period."""
    steps, (x, v) = 64, start.tolist()
    h, kept = period / steps, np.empty((periods, 2))
    for n in range(-300, periods):
        if n >= 0:
            kept[n] = x, v
        for step in range(steps):
            t = step * h
            a = slope(t, x, v)
            b = slope(t + 0.5 * h, x + 0.5 * h * v, v + 0.5 * h * a)
            c = slope(t + 0.5 * h, x + 0.5 * h * (v + 0.5 * h * a), v + 0.5 * h * b)
            d = slope(t + h, x + h * (v + 0.5 * h * b), v + h * c)
            x, v = x + h * v + h * h / 6.0 * (a + b + c), v + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return kept


def duffing(random: Random) -> Other:
    """Return a motion of Duffing's oscillator, or of van der Pol's, weakly forced: a torus."""
    start = random.uniform(-0.5, 0.5, 2)
    if random.random() < 0.25:
        force, frequency = random.uniform(0.05, 0.3), random.uniform(1.7, 1.9)
        samples = _oscillator(
            lambda t, x, v: 0.3 * (1.0 - x * x) * v - x + force * math.cos(frequency * t),
            2.0 * math.pi / frequency, start, 500,
        )  # fmt: skip
        return Other(f"van der Pol {force:.3f}, {frequency:.3f}", samples, 1e-4, (TORUS,))
    force = float(random.choice(list(DUFFING)))
    order = DUFFING[force]
    samples = _oscillator(
        lambda t, x, v: x - x**3 - 0.3 * v + force * math.cos(1.2 * t), 2.0 * math.pi / 1.2, start, 500
    )
    right = (("periodic", order), ("at rest", order)) if order else (CHAOS,)
    return Other(f"Duffing {force}", samples, 1e-4, right)


def tones(random: Random) -> Other:
    """Return two tones of incommensurate frequencies, or a cycle and one, with noise of up to three resolutions."""
    _, n, resolution = _sized(random)
    base = _tone(random, n) if random.random() < 0.5 else _cycle(random, n)[0]
    angle = 2.0 * math.pi * math.sqrt(2.0) * n
    samples = base + 10.0 ** random.uniform(-1.5, 0.0) * np.cos(angle + 1.0)
    samples = samples + resolution * random.uniform(0.0, 3.0) * random.normal(size=len(n))
    return Other("two tones", samples, resolution, (TORUS,))


def noisy(random: Random) -> Other:
    """Return a cycle or chaos whose noise is up to six times the resolution."""
    periods, n, resolution = _sized(random)
    noise = resolution * random.uniform(0.0, 6.0) * random.normal(size=periods)
    pick = random.random()
    if pick < 0.5:
        clean, order = _cycle(random, n)
        return Other("noisy cycle", clean + noise, resolution, (("periodic", order),))
    if pick < 0.75:
        return Other("noisy Henon", henon(1.4, 0.3, 0.2, periods)[:, 0] + noise, resolution, (CHAOS,))
    return Other("noisy logistic", logistic(3.9, 0.3, periods) + noise, resolution, (CHAOS,))


def noise(random: Random) -> Other:
    """Return white or coloured noise alone or about a cycle, far above the resolution, or a random walk."""
    periods, n, resolution = _sized(random)
    white = random.normal(size=periods)
    memory = float(random.choice([0.0, 0.5, 0.9, 1.0]))
    samples = white.copy()
    for i in range(1, periods):
        samples[i] += memory * samples[i - 1]
    if memory < 1.0 and random.random() < 0.3:
        samples = samples + _cycle(random, n)[0]
    return Other(f"noise with memory {memory}", samples, resolution, (TRANSIENT,) if memory == 1.0 else ())


def drifting(random: Random) -> Other:
    """Return a cycle, a torus or chaos whose mean or size drifts by 2 to 50 % over the record."""
    periods, n, resolution = _sized(random)
    drift = random.uniform(0.02, 0.5) * n / periods
    pick = int(random.integers(3))
    clean = (_cycle(random, n)[0], _tone(random, n), henon(1.4, 0.3, 0.2, periods)[:, 0])[pick]
    samples = clean + drift if random.random() < 0.5 else clean * (1.0 + drift)
    name = ("cycle", "torus", "chaos")[pick]
    return Other(
        f"drifting {name} by {drift[-1]:.3f}",
        samples,
        resolution,
        (TRANSIENT, CHAOS) if pick == 2 else (TRANSIENT,),
    )


def swinging(random: Random) -> Other:
    """Return a cycle with a slow oscillation of its mean or size that turns 0.3 to 1.5 times, or 4 to 20 times, in the record."""
    periods, n, resolution = _sized(random)
    slow = random.random() < 0.5
    turns = random.uniform(0.3, 1.5) if slow else random.uniform(4.0, 20.0)
    oscillation = random.uniform(0.3, 1.0) * np.cos(
        2.0 * math.pi * turns * n / periods + random.uniform(0.0, 6.0)
    )
    clean = _cycle(random, n)[0]
    samples = clean + oscillation if random.random() < 0.5 else clean * (1.0 + oscillation)
    return Other(
        f"slow oscillation, {turns:.2f} turns", samples, resolution, (TRANSIENT,) if slow else (TORUS,)
    )


def turning_map(random: Random) -> Other:
    """Return the circle map at weak coupling, seen as cosine and sine: a torus."""
    periods, _, resolution = _sized(random)
    turns, coupling = (
        (0.5 * (math.sqrt(5.0) - 1.0), math.sqrt(2.0) - 1.0)[int(random.integers(2))],
        random.uniform(0.0, 0.5),
    )
    angle, kept = random.uniform(), np.empty(periods)
    for i in range(periods):
        kept[i] = angle
        angle += turns - coupling / (2.0 * math.pi) * math.sin(2.0 * math.pi * angle)
    angles = 2.0 * math.pi * kept
    return Other(
        f"circle map {coupling:.3f}", np.stack([np.cos(angles), np.sin(angles)], axis=1), resolution, (TORUS,)
    )


def standard_map(random: Random) -> Other:
    """Return the standard map: regular in the island at coupling 0.5, chaotic at 5 to 9."""
    periods, _, resolution = _sized(random)
    regular = random.random() < 0.5
    coupling = 0.5 if regular else random.uniform(5.0, 9.0)
    theta = math.pi + (random.uniform(0.3, 1.2) if regular else random.uniform(0.5, 1.0))
    momentum, kept = 0.0, np.empty((periods, 2))
    for i in range(periods):
        momentum = math.remainder(momentum + coupling * math.sin(theta), 2.0 * math.pi)
        theta = (theta + momentum) % (2.0 * math.pi)
        kept[i] = math.cos(theta), math.sin(theta)
    return Other(f"standard map {coupling:.2f}", kept, resolution, (TORUS,) if regular else (CHAOS,))
