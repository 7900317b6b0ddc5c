"""The 0-1 test: its laws, its sums against the paper's written out, and what it refuses."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gearplay.nonlinear.kinds import zero_one
from gearplay.nonlinear.kinds.zero_one import displacement, draw_angles, zero_one_test
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
N = np.arange(2000.0)


def logistic(rate: float, periods: int = 2000) -> Floats:
    x, orbit = 0.3, np.empty(periods)
    for i in range(periods):
        x = rate * x * (1.0 - x)
        orbit[i] = x
    return orbit


def paper(series: Floats, c: float) -> Floats:
    """Return D_c(n) as the paper writes it: sums over j, less the oscillating term of the mean."""
    j = np.arange(1, len(series) + 1)
    p, q = np.cumsum(series * np.cos(j * c)), np.cumsum(series * np.sin(j * c))
    longest = len(series) // 10
    spans, moved = len(series) - longest, []
    for n in range(1, longest + 1):
        square = (p[n : n + spans] - p[:spans]) ** 2 + (q[n : n + spans] - q[:spans]) ** 2
        oscillating = np.mean(series) ** 2 * (1.0 - math.cos(n * c)) / (1.0 - math.cos(c))
        moved.append(np.mean(square) - oscillating)
    return np.array(moved)


def test_chaos_walks_and_regular_motion_stays() -> None:
    """K is near 1 for the full logistic map and for noise, near 0 for a torus, a cycle and a constant."""
    assert zero_one_test(logistic(4.0 - 1e-12)).k > 0.99
    assert zero_one_test(np.random.default_rng(1).normal(size=2000)).k > 0.99
    assert abs(zero_one_test(np.cos(N) + 0.3 * np.cos(2.3 * N)).k) < 0.05
    assert abs(zero_one_test(logistic(3.5)).k) < 0.05


def test_scale_and_mean_change_nothing() -> None:
    """K of each angle is that of the series scaled and shifted, however large the mean."""
    series = logistic(3.8, 500)
    plain = zero_one_test(series).values
    assert zero_one_test(1e-8 * series).values == pytest.approx(plain, abs=1e-9)
    assert zero_one_test(-3e200 * series).values == pytest.approx(plain, abs=1e-9)
    assert zero_one_test(series + 1e5).values == pytest.approx(plain, abs=1e-6)


def test_displacement_is_the_sum_that_the_paper_writes() -> None:
    """Without a mean the displacement is the paper's for every n; with one, as far as a long record goes."""
    series, angles = logistic(3.9, 400), draw_angles(3, 5)
    centred = series - series.mean()
    for moved, c in zip(displacement(centred, angles), angles, strict=True):
        assert moved == pytest.approx(paper(centred, c), rel=1e-9, abs=1e-12)
    series = logistic(3.9, 20_000)
    moved, written = displacement(series, angles[:1])[0], paper(series, float(angles[0]))
    assert moved == pytest.approx(written, rel=0.02, abs=0.05)


def test_displacements_of_signals_add() -> None:
    """Two signals move as far as each of them, squares added; batches of angles change nothing."""
    table = np.stack([logistic(3.9, 300), np.cos(N[:300])], axis=1)
    angles = draw_angles(0, 7)
    both = displacement(table, angles)
    assert both == pytest.approx(displacement(table[:, 0], angles) + displacement(table[:, 1], angles))
    assert both[:1] == pytest.approx(displacement(table, angles[:1]))


def test_batches_of_angles_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record too long for all angles at once gives the same displacements."""
    series, angles = logistic(3.9, 300), draw_angles(0, 7)
    whole = displacement(series, angles)
    monkeypatch.setattr(zero_one, "AT_ONCE", 700)
    assert np.array_equal(displacement(series, angles), whole)


@pytest.mark.parametrize("value", [0.0, 0.1, -1e300])
def test_a_constant_has_no_chaos(value: float) -> None:
    """K of a constant is 0, not a matter of rounding."""
    found = zero_one_test(np.full(200, value))
    assert (found.k, found.low, found.high) == (0.0, 0.0, 0.0)


def test_what_is_returned() -> None:
    """K is the median of the values, low and high are the quartiles; a seed gives its angles again, in the paper's range."""
    found = zero_one_test(logistic(3.7), seed=5, count=41)
    assert found.values.shape == found.angles.shape == (41,)
    assert (found.low, found.k, found.high) == tuple(np.quantile(found.values, [0.25, 0.5, 0.75]))
    assert np.all((found.angles > math.pi / 5.0) & (found.angles < 4.0 * math.pi / 5.0))
    assert np.array_equal(found.values, zero_one_test(logistic(3.7), seed=5, count=41).values)
    assert not np.array_equal(found.angles, zero_one_test(logistic(3.7), seed=6, count=41).angles)


@pytest.mark.parametrize(
    ("series", "words"),
    [
        (np.zeros(99), "at least 100 samples"),
        (np.append(np.zeros(200), np.nan), "nan at sample 200, 1 in all"),
        (np.append(np.inf, np.zeros(200)), "finite"),
        (np.zeros((200, 2)), "one series"),
        (np.zeros(200, dtype=complex), "real numbers"),
    ],
)
def test_refusals(series: Floats, words: str) -> None:
    """Short, damaged and shapeless series are refused in words."""
    with pytest.raises(InputError, match=words):
        zero_one_test(series)


@pytest.mark.parametrize("count", [0, -1, 2.5, True])
def test_no_angles_are_refused(count: int) -> None:
    with pytest.raises(InputError, match="count"):
        zero_one_test(np.zeros(200), count=count)
