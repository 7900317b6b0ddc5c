"""Orbits of systems that are chaotic: the logistic and the Henon map, the Lorenz system."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Random = np.random.Generator


def logistic(rate: float, start: float, periods: int, cut: int = 2000) -> Floats:
    """Return an orbit of x -> rate x (1 - x), without its first ``cut`` values."""
    x, orbit = start, np.empty(periods)
    for _ in range(cut):
        x = rate * x * (1.0 - x)
    for i in range(periods):
        orbit[i] = x
        x = rate * x * (1.0 - x)
    return orbit


def henon(a: float, b: float, start: float, periods: int, cut: int = 1000) -> Floats:
    """Return an orbit of (x, y) -> (1 - a x^2 + y, b x), shape [period, 2]."""
    x, y, orbit = start, 0.1, np.empty((periods, 2))
    for i in range(-cut, periods):
        if i >= 0:
            orbit[i] = x, y
        x, y = 1.0 - a * x * x + y, b * x
    return orbit


def exponent_of_logistic(rate: float) -> float:
    """Return the Lyapunov exponent of the logistic map per iteration, the mean of log |rate (1 - 2 x)|."""
    orbit = logistic(rate, 0.37, 20_000, cut=20_000)
    return float(np.mean(np.log(np.abs(rate * (1.0 - 2.0 * orbit)) + 1e-300)))


def chaotic_rate(random: Random) -> tuple[float, str, int]:
    """Return a rate of the logistic map at which it is chaotic, its name, and the fewest periods to show it."""
    pick = random.random()
    if pick < 0.12:
        return 3.58 + random.uniform(-5e-4, 5e-4), "four bands", 500
    if pick < 0.22:
        return random.uniform(3.6, 3.67), "two bands", 300
    if pick < 0.32:
        return 3.828427 - random.uniform(1.5e-4, 1e-3), "intermittent", 1000
    if pick < 0.40:
        return 4.0 - 1e-9, "full", 300
    if pick < 0.46:
        return random.uniform(3.572, 3.5755), "weak", 1000
    while True:
        rate = random.uniform(3.6, 4.0)
        if exponent_of_logistic(rate) > 0.05:
            return rate, "chosen", 300


def bands_left(orbit: Floats) -> tuple[float, int]:
    """Return the smallest share of its standard deviation that folding by up to 100 orders leaves of an orbit, and the order.

    Of orders that leave about the same the smallest counts.
    """
    left = []
    for order in range(1, min(100, len(orbit) // 3) + 1):
        folded = orbit[: len(orbit) // order * order].reshape(-1, order)
        square = np.sum((folded - folded.mean(axis=0)) ** 2) / (folded.size - order)
        left.append(float(np.sqrt(square) / np.std(orbit)))
    best = int(np.flatnonzero(np.array(left) <= 1.3 * min(left))[0])
    return left[best], best + 1


def lorenz_orbits(
    every: Floats, rho: Floats, start: Floats, periods: int, cut: int = 60, substeps: int = 32
) -> Floats:
    """Return orbits of the Lorenz system sampled ``every`` so often, shape [sample, 3, orbit], all integrated at once.

    By the classical Runge-Kutta method with 32 steps to the sample; ``start`` counts from (0, 0, 25), shape [3, orbit].
    """
    h, state = every / substeps, start + np.array([[0.0], [0.0], [25.0]])

    def slope(s: Floats) -> Floats:
        x, y, z = s
        return np.stack([10.0 * (y - x), x * (rho - z) - y, x * y - 8.0 / 3.0 * z])

    orbit = np.empty((periods, *start.shape))
    for i in range(-cut, periods):
        if i >= 0:
            orbit[i] = state
        for _ in range(substeps):
            k_1 = slope(state)
            k_2 = slope(state + 0.5 * h * k_1)
            k_3 = slope(state + 0.5 * h * k_2)
            k_4 = slope(state + h * k_3)
            state = state + h / 6.0 * (k_1 + 2.0 * (k_2 + k_3) + k_4)
    return orbit
