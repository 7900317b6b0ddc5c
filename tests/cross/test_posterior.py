"""The tempered posterior and its evidence against nested sampling by dynesty, on a problem that is not Gaussian."""

import dynesty
import numpy as np
import pytest

from gearplay.calibration.posterior import temper


def log_likelihood(at: np.ndarray) -> np.ndarray:
    """Two ridges of different weight and a bent valley in the unit cube."""
    x, y, z = at.T
    valley = -0.5 * ((y - x**2) / 0.05) ** 2 - 0.5 * ((x - 0.5) / 0.2) ** 2
    return valley + np.logaddexp(-0.5 * ((z - 0.2) / 0.04) ** 2, np.log(0.3) - 0.5 * ((z - 0.8) / 0.04) ** 2)


@pytest.mark.slow
def test_posterior_and_evidence_agree_with_nested_sampling() -> None:
    points, evidence, error = temper(log_likelihood, 3, 4000, np.random.default_rng(1))
    sampler = dynesty.NestedSampler(
        lambda cube: float(log_likelihood(cube[None])[0]),
        lambda cube: cube,
        3,
        nlive=250,
        rstate=np.random.default_rng(2),
    )
    sampler.run_nested(print_progress=False)
    found = sampler.results
    assert evidence == pytest.approx(found.logz[-1], abs=3.0 * np.hypot(error, found.logzerr[-1]))
    weights = np.exp(found.logwt - found.logz[-1])
    mean = np.average(found.samples, axis=0, weights=weights)
    spread = np.sqrt(np.average((found.samples - mean) ** 2, axis=0, weights=weights))
    assert np.mean(points, axis=0) == pytest.approx(mean, abs=0.03)
    assert np.std(points, axis=0) == pytest.approx(spread, rel=0.1)
    assert np.mean(points[:, 2] > 0.5) == pytest.approx(0.3 / 1.3, abs=0.04)
