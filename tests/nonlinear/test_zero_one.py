"""The 0-1 test: its limits for chaos and regular motion, and the displacement against the source's sums."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from chaotic_orbits import logistic
from gearplay.nonlinear.kinds.zero_one import displacement, zero_one

Floats = NDArray[np.float64]
N = np.arange(2000.0)[:, None]


def orbit(rate: float, periods: int = 2000) -> Floats:
    return logistic(rate, 0.3, periods, cut=0)[:, None]


def written_out(series: Floats, c: float) -> Floats:
    """Return D_c(n) as the source writes it: sums over j, less the oscillating term of the mean."""
    j = np.arange(1, len(series) + 1)
    p, q = np.cumsum(series * np.cos(j * c)), np.cumsum(series * np.sin(j * c))
    longest = len(series) // 10
    spans, moved = len(series) - longest, []
    for n in range(1, longest + 1):
        square = (p[n : n + spans] - p[:spans]) ** 2 + (q[n : n + spans] - q[:spans]) ** 2
        oscillating = np.mean(series) ** 2 * (1.0 - math.cos(n * c)) / (1.0 - math.cos(c))
        moved.append(np.mean(square) - oscillating)
    return np.array(moved)


def test_k_is_one_for_chaos_and_noise_and_zero_for_regular_motion() -> None:
    assert zero_one(orbit(4.0 - 1e-12)) > 0.98
    assert zero_one(np.random.default_rng(1).normal(size=(2000, 1))) > 0.98
    assert abs(zero_one(np.cos(N) + 0.3 * np.cos(2.3 * N))) < 0.06
    assert abs(zero_one(orbit(3.5))) < 0.06
    assert zero_one(np.zeros((200, 1))) == 0.0


def test_k_depends_on_neither_scale_nor_mean() -> None:
    series = orbit(3.8, 500)
    assert zero_one(-1e8 * series) == pytest.approx(zero_one(series), abs=1e-9)
    assert zero_one(series + 1e5) == pytest.approx(zero_one(series), abs=1e-6)


def test_displacement_is_the_sum_of_the_source() -> None:
    """Without a mean for every n; with one as far as a long record goes."""
    series, angles = orbit(3.9, 400), np.array([0.7, 1.1, 1.9, 2.4])
    centred = series - series.mean()
    for moved, c in zip(displacement(centred, angles), angles, strict=True):
        assert moved == pytest.approx(written_out(centred[:, 0], c), rel=1e-9, abs=1e-12)
    series = orbit(3.9, 20_000)
    moved = displacement(series, angles[:1])[0]
    assert moved == pytest.approx(written_out(series[:, 0], float(angles[0])), rel=0.02, abs=0.05)


def test_displacements_of_signals_add() -> None:
    table, angles = np.hstack([orbit(3.9, 300), np.cos(N[:300])]), np.array([0.7, 1.1, 1.9])
    both = displacement(table, angles)
    assert both == pytest.approx(displacement(table[:, :1], angles) + displacement(table[:, 1:], angles))
