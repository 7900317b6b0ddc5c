import numpy as np
import pytest

from gearplay.surrogates.polynomials import Emulator, design, nearness, terms

GENERATOR = np.random.default_rng(1)
UNITS = GENERATOR.random((120, 3))


def quadratic(u: np.ndarray) -> np.ndarray:
    return np.stack([1.0 + u[:, 0] - 2.0 * u[:, 1] * u[:, 2], u[:, 2] ** 2 - 0.5 * u[:, 0]], axis=1)


def test_a_polynomial_is_reproduced_exactly() -> None:
    emulator = Emulator.fit(UNITS, quadratic(UNITS))
    elsewhere = GENERATOR.random((50, 3))
    assert emulator.degree >= 2
    assert np.allclose(emulator(elsewhere), quadratic(elsewhere), atol=1e-10)


def test_terms_are_those_of_total_degree() -> None:
    assert len(terms(7, 3)) == 120  # (7 + 3)! / (7! 3!)
    assert design(UNITS, 2).shape == (120, 10)


def test_the_scatter_is_that_of_leaving_each_trial_out() -> None:
    noisy = quadratic(UNITS)[:, :1] + 0.1 * GENERATOR.normal(size=(120, 1))
    emulator = Emulator.fit(UNITS, noisy)
    table = design(UNITS, emulator.degree)
    left_out = []
    for i in range(len(UNITS)):
        others = np.arange(len(UNITS)) != i
        coefficients = np.linalg.lstsq(table[others], noisy[others], rcond=None)[0]
        left_out.append(float(noisy[i, 0] - (table[i] @ coefficients)[0]))
    assert emulator.scatter[0] == pytest.approx(np.sqrt(np.mean(np.square(left_out))))


def test_noise_does_not_raise_the_degree() -> None:
    assert Emulator.fit(UNITS, 0.2 * UNITS[:, :1] + GENERATOR.normal(size=(120, 1))).degree == 1


def test_weights_follow_the_objective() -> None:
    weights = nearness(np.array([10.0, 12.0, 14.0, 100.0, 10.0]))
    assert weights[0] == weights[4] == 1.0
    assert weights[1] > weights[2] > weights[3] > 0.0
