"""Responses whose kind is known by construction, sampled once per forcing period, the same for the same seed.

Five classes of equally many: cycles, tori, chaos of maps, chaos of the Lorenz system, and transients. Records have 300 to 3000
periods and one to four signals of very different sizes; about half carry Gaussian noise of the resolution.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chaotic_orbits import bands_left, chaotic_rate, exponent_of_logistic, henon, logistic, lorenz_orbits

Floats = NDArray[np.float64]
Random = np.random.Generator

CLASSES = ("periodic", "torus", "map chaos", "Lorenz", "transient")
KINDS = dict(zip(CLASSES, ("periodic", "quasi-periodic", "chaotic", "chaotic", "transient"), strict=True))
ORDERS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24)
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class Labelled:
    """A response and what it is; ``recipe`` says how it was made.

    ``samples`` has shape [period, signal], ``resolution`` and ``swing`` (within a period, where given) shape [signal].
    """

    group: str
    recipe: str
    samples: Floats
    resolution: Floats
    order: int | None = None
    swing: Floats | None = None

    @property
    def kind(self) -> str:
        return KINDS[self.group]


def responses(seed: int, each: int = 40) -> list[Labelled]:
    """Return ``each`` responses of each class."""
    made = []
    for number, (group, make) in enumerate(
        zip(CLASSES, (periodic, torus, map_chaos, None, transient), strict=True)
    ):
        if make is None:
            made += lorenz(np.random.default_rng([seed, number]), each)
        else:
            made += [make(np.random.default_rng([seed, number, i])) for i in range(each)]
        assert all(response.group == group for response in made[-each:])
    return made


def length(random: Random, least: int = 300, most: int = 3000) -> int:
    """Return a number of periods, as often short as long."""
    return round(math.exp(random.uniform(math.log(least), math.log(most))))


def seen(
    random: Random, clean: Floats, finest: float = 1e-7, coarsest: float = 5e-3
) -> tuple[Floats, Floats]:
    """Return signals with scales, offsets and perhaps noise, and their resolution, a share ``finest`` to ``coarsest`` of them."""
    signals = clean.shape[1]
    share = math.exp(random.uniform(math.log(finest), math.log(coarsest)))
    size = np.maximum(np.std(clean, axis=0), 0.1 * np.max(np.std(clean, axis=0)))
    resolution = share * np.where(size > 0.0, size, 1.0) * random.uniform(0.5, 1.0, signals)
    noise = resolution * random.normal(size=clean.shape) * (random.random() < 0.5)
    scale, offset = 10.0 ** random.uniform(-6.0, 3.0, signals), random.normal(0.0, 3.0, signals)
    return (clean + noise + offset) * scale, resolution * scale


def cycle(random: Random, order: int, signals: int) -> Floats:
    """Return one repeat of a cycle, shape [order, signal]: harmonics of 1 / order, the first one in every signal."""
    n, pattern = np.arange(order), np.zeros((order, signals))
    for harmonic in range(1, order // 2 + 1):
        size = 1.0 if harmonic == 1 else random.random() * (random.random() < 0.6)
        phase = random.uniform(0.0, 2.0 * math.pi, signals)
        size = size * random.uniform(0.3, 1.0, signals)
        phase = np.where(2 * harmonic == order, phase / 8.0, phase)  # the alternating one must not vanish
        pattern += size * np.cos(2.0 * math.pi * harmonic * n[:, None] / order + phase)
    return pattern


def periodic(random: Random) -> Labelled:
    """Return a cycle of harmonics, or one of the logistic map's."""
    signals, recipe = int(random.integers(1, 5)), "harmonics"
    if random.random() < 0.2:
        rate, order = [(3.2, 2), (3.5, 4), (3.55, 8), (3.5655, 16), (3.835, 3), (3.845, 6), (3.739, 5)][
            int(random.integers(7))
        ]
        pattern, recipe = logistic(rate, 0.4, order, cut=20_000)[:, None], f"logistic {rate}"
    else:
        order = int(random.choice(ORDERS))
        pattern = cycle(random, order, signals)
    periods = max(length(random), 12 * order)
    clean = np.tile(pattern, (periods // order + 1, 1))[:periods]
    samples, resolution = seen(random, clean, coarsest=3e-3)
    swing = resolution * random.uniform(50.0, 1e4) if order == 1 else None
    return Labelled("periodic", f"{recipe}, order {order}", samples, resolution, order, swing)


def winding(random: Random, periods: int) -> tuple[float, str]:
    """Return turns per period: far from simple ratios, or so near to one that the record holds 4 to 20 turns of the beat.

    Far means that the record holds two turns or more of the beat with each ratio of twentieths and below.
    """
    if random.random() < 0.25:
        order = int(random.integers(1, 8))
        part = int(random.integers(1, order + 1))
        beat = random.uniform(4.0, 20.0) / (periods * order)
        return part / order + float(random.choice([-1.0, 1.0])) * beat, f"near {part}/{order}"
    while True:
        turn = (GOLDEN * random.integers(1, 50) + random.uniform(-0.01, 0.01)) % 1.0
        if all(lowest(order * turn) >= 2.0 / periods for order in range(1, 21)):
            return turn, "far"


def turning(
    random: Random, periods: int, signals: int, turns: list[float], avoid: tuple[float, ...] = ()
) -> Floats:
    """Return a smooth function on a torus along its flow, shape [period, signal].

    Its lines are the frequencies themselves and ten of their combinations, all at least two turns per record apart from each
    other, from the mean and from ``avoid``: of nearer ones the record could not show the beat.
    """
    n, clean = np.arange(periods)[:, None], np.zeros((periods, signals))
    decay, lines = random.uniform(0.1, 0.5), [0.0, *avoid]
    many = [np.eye(len(turns), dtype=int)[i] for i in range(len(turns))]
    many += [np.abs(random.integers(-2, 4, len(turns))) for _ in range(10)]
    for count in many:
        line = lowest(float(np.dot(count, turns)))
        beats = any(0.0 < abs(line - other) < 2.0 / periods for other in lines)
        if count.sum() == 0 or (count.sum() > 1 and beats):
            continue
        lines.append(line)
        size = decay ** (float(count.sum()) - 1.0) * random.uniform(
            0.2 if count.sum() > 1 else 1.0, 1.0, signals
        )
        clean += size * np.cos(2.0 * math.pi * line * n + random.uniform(0.0, 2.0 * math.pi, signals))
    return clean


def lowest(turns: float) -> float:
    """Return the frequency in 0 to 1/2 that looks the same once a period."""
    return abs(math.remainder(turns, 1.0))


def distinct_turns(
    random: Random, periods: int, count: int, avoid: tuple[float, ...]
) -> tuple[list[float], list[str]]:
    """Return frequencies of a torus at least four turns per record from each other, from 0 and 1/2, and from ``avoid``."""
    turns: list[float] = []
    names: list[str] = []
    while len(turns) < count:
        turn, name = winding(random, periods)
        if all(abs(lowest(turn) - lowest(other)) >= 3.9 / periods for other in (0.0, 0.5, *avoid, *turns)):
            turns.append(turn)
            names.append(name)
    return turns, names


def torus(random: Random) -> Labelled:
    """Return a torus of two or three frequencies (the forcing is one), perhaps bent, perhaps thin around a cycle."""
    periods, signals = length(random), int(random.integers(1, 5))
    order, thin = 1, 1.0
    if random.random() < 0.35:
        order, thin = int(random.integers(1, 7)), math.exp(random.uniform(math.log(0.01), math.log(0.3)))
    avoid = tuple(j / order for j in range(1, order // 2 + 1))
    turns, recipe = distinct_turns(random, periods, 1 + (random.random() < 0.4), avoid)
    clean = turning(random, periods, signals, turns, avoid)
    if random.random() < 0.3:
        clean = np.tanh(random.uniform(0.3, 1.5) * clean)
        recipe.append("bent")
    if thin < 1.0:
        clean = thin * clean + np.tile(cycle(random, order, signals), (periods // order + 1, 1))[:periods]
        recipe.append(f"thin {thin:.2g} about order {order}")
    samples, resolution = seen(random, clean, coarsest=5e-3 * thin)
    return Labelled("torus", ", ".join(recipe), samples, resolution)


def embedded(random: Random, clean: Floats) -> Floats:
    """Return one to four smooth functions of an orbit and its last states, some with a cycle added."""
    past = np.hstack([clean, np.roll(clean, 1, axis=0), np.roll(clean, 2, axis=0)])[2:]
    past = (past - past.mean(axis=0)) / past.std(axis=0)
    signals = int(random.integers(1, 5))
    mixed = past @ random.normal(size=(past.shape[1], signals))
    mixed += random.uniform(0.0, 0.3, signals) * mixed**2
    if random.random() < 0.4:
        order = int(random.integers(2, 7))
        repeated = np.tile(cycle(random, order, signals), (len(mixed) // order + 1, 1))[: len(mixed)]
        mixed += random.uniform(0.0, 3.0, signals) * mixed.std(axis=0) * repeated
    return np.asarray(mixed)


def map_chaos(random: Random) -> Labelled:
    """Return chaos of the logistic or the Henon map, seen bare or through mixed signals; the resolution shows its bands."""
    start = random.uniform(0.1, 0.4)
    if random.random() < 0.65:
        rate, name, least = chaotic_rate(random)
        while name != "full" and exponent_of_logistic(rate) < 0.01:  # a window
            rate, name, least = chaotic_rate(random)
        clean = logistic(rate, start, length(random, least) + 2)[:, None]
        recipe = f"logistic {rate:.5f} ({name})"
    else:
        a = float(random.choice([1.4, 1.38, 1.28, 1.2, 1.15, 1.1]))
        clean, recipe = henon(a, 0.3, start, length(random) + 2), f"Henon {a}"
    left, bands = bands_left(clean[:, 0])
    if (
        bands > 16 or len(clean) < 20 * bands
    ):  # thin chaos of a window, which so few visits to a band cannot show
        return map_chaos(random)
    if random.random() < 0.6:
        clean, recipe = embedded(random, clean), recipe + ", mixed"
    samples, resolution = seen(random, clean, finest=1e-7 * min(left, 1.0), coarsest=5e-3 * min(left, 0.6))
    return Labelled("map chaos", recipe, samples, resolution)


def lorenz(random: Random, count: int) -> list[Labelled]:
    """Return responses of the Lorenz system at the classical parameters and beyond, sampled every 0.2 to 1 units of time."""
    every, rho = random.uniform(0.2, 1.0, count), random.choice([28.0, 28.0, 32.0, 40.0], count)
    periods = [length(random) for _ in range(count)]
    orbit = lorenz_orbits(every, rho, random.normal(size=(3, count)), max(periods))
    made = []
    for i in range(count):
        clean = orbit[: periods[i], :, i]
        pick = random.permutation(3)[: int(random.integers(1, 4))]
        samples, resolution = seen(random, clean[:, pick] / 10.0)
        names = "".join("xyz"[p] for p in pick)
        made.append(Labelled("Lorenz", f"{names} every {every[i]:.2f}, rho {rho[i]:g}", samples, resolution))
    return made


def transient(random: Random) -> Labelled:
    """Return a motion that has not settled: a slow decay or growth, or a jump between two regimes."""
    periods, signals = length(random), int(random.integers(1, 5))
    make = (fading, fading, fading, growing, jumping)[int(random.integers(5))]
    clean, recipe = make(random, periods, signals)
    samples, resolution = seen(random, clean, coarsest=1e-3)
    return Labelled("transient", recipe, samples, resolution)


def settled(random: Random, periods: int, signals: int, avoid: tuple[float, ...] = ()) -> tuple[Floats, str]:
    """Return what a motion settles on: a point, a cycle or a torus whose lines keep off ``avoid``."""
    pick = int(random.integers(3))
    if pick == 0:
        return np.zeros((periods, signals)), "a point"
    if pick == 1:
        order = int(random.integers(2, 9))
        repeated = np.tile(cycle(random, order, signals), (periods // order + 1, 1))[:periods]
        return repeated, f"order {order}"
    turns, _ = distinct_turns(random, periods, 1, avoid)
    return turning(random, periods, signals, turns, avoid), "a torus"


def mode(random: Random, periods: int, signals: int, rate: float) -> tuple[Floats, str, float]:
    """Return a motion that changes by exp(rate) per period, plain, alternating or turning, its name and its frequency."""
    n = np.arange(periods)[:, None]
    pick = int(random.integers(3))
    turn = (0.0, 0.5, lowest(GOLDEN * random.integers(1, 50)))[pick]
    phase = random.uniform(0.0, 2.0 * math.pi if pick == 2 else 0.7, signals)
    motion = random.uniform(0.3, 1.0, signals) * np.exp(rate * n) * np.cos(2.0 * math.pi * turn * n + phase)
    return motion, ("plain", "alternating", "turning")[pick], turn


def time_constant(random: Random, periods: int) -> float:
    """Return a time constant of a fifth of the record to five of them [period]."""
    return periods * math.exp(random.uniform(math.log(0.2), math.log(5.0)))


def fading(random: Random, periods: int, signals: int) -> tuple[Floats, str]:
    """Return a decay onto a point, a cycle or a torus."""
    time = time_constant(random, periods)
    part, how, turn = mode(random, periods, signals, -1.0 / time)
    base, name = settled(random, periods, signals, (turn,))
    size = random.uniform(0.2, 1.0)
    return base + size * part, f"{how} decay {size:.2f} to {name}, {time / periods:.2f} N"


def growing(random: Random, periods: int, signals: int) -> tuple[Floats, str]:
    """Return a growth away from a point, a cycle or a torus, up to its full size at the end."""
    time = time_constant(random, periods)
    part, how, turn = mode(random, periods, signals, 1.0 / time)
    base, name = settled(random, periods, signals, (turn,))
    size = random.uniform(0.2, 1.0) * math.exp(-periods / time)
    return base + size * part, f"{how} growth from {name}, {time / periods:.2f} N"


def jumping(random: Random, periods: int, signals: int) -> tuple[Floats, str]:
    """Return two regimes one after the other; the jump is in the middle half of the record."""
    makers: list[Callable[[], tuple[Floats, str]]] = [
        lambda: settled(random, periods, signals),
        lambda: settled(random, periods, signals),
        lambda: (_rough(random, periods, signals), "chaos"),
    ]
    (before, first), (after, second) = (makers[int(random.integers(3))]() for _ in range(2))
    if first == second == "chaos":
        after = random.uniform(0.2, 0.7) * after
    if first == second == "a point":
        after = after + 1.0
    at = round(periods * random.uniform(0.25, 0.75))
    joined = np.concatenate(
        [before[:at], after[at:] + random.normal(0.0, 0.5, signals) * (random.random() < 0.5)]
    )
    return joined, f"{first} to {second} at {at / periods:.2f}"


def _rough(random: Random, periods: int, signals: int) -> Floats:
    orbit = henon(1.4, 0.3, random.uniform(0.1, 0.4), periods)
    return orbit @ random.normal(size=(2, signals))
