"""Orbits of systems that are chaotic: the logistic and the Henon map, the Lorenz system."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Random = np.random.Generator


@njit(cache=True)
def logistic(rate: float, start: float, periods: int, cut: int = 2000) -> Floats:
    """Return an orbit of x -> rate x (1 - x), without its first ``cut`` values."""
    x, orbit = start, np.empty(periods)
    for _ in range(cut):
        x = rate * x * (1.0 - x)
    for i in range(periods):
        orbit[i] = x
        x = rate * x * (1.0 - x)
    return orbit


@njit(cache=True)
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


@njit(cache=True)
def lorenz_orbits(
    every: Floats, rho: Floats, start: Floats, periods: int, cut: int = 60, substeps: int = 32
) -> Floats:
    """Return orbits of the Lorenz system sampled ``every`` so often, shape [sample, 3, orbit].

    By the classical Runge-Kutta method with 32 steps to the sample; ``start`` counts from (0, 0, 25), shape [3, orbit].
    """
    orbit = np.empty((periods, *start.shape))
    for at in range(start.shape[1]):
        h, r = every[at] / substeps, rho[at]
        x, y, z = start[0, at], start[1, at], start[2, at] + 25.0
        for i in range(-cut, periods):
            if i >= 0:
                orbit[i, 0, at], orbit[i, 1, at], orbit[i, 2, at] = x, y, z
            for _ in range(substeps):
                dx, dy, dz = 0.0, 0.0, 0.0
                sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
                for part, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
                    u, v, w = x + part * h * dx, y + part * h * dy, z + part * h * dz
                    dx, dy, dz = 10.0 * (v - u), u * (r - w) - v, u * v - 8.0 / 3.0 * w
                    sum_x, sum_y, sum_z = sum_x + weight * dx, sum_y + weight * dy, sum_z + weight * dz
                x, y, z = x + h / 6.0 * sum_x, y + h / 6.0 * sum_y, z + h / 6.0 * sum_z
    return orbit
