"""Convergence: the error of a run follows its tolerance, through impacts as on smooth arcs."""

import numpy as np
import pytest

from building import Document, Floats, Measured, free_pair_case, merged, states_along
from gearplay.integrate.run import CALLS, EVENTS
from gearplay.integrate.runge_kutta import DENSE, ERROR, NODES, WEIGHTS

TOLERANCES = 10.0 ** -np.arange(5.0, 13.0)


def end_state(document: Document, tolerance: float, time: float) -> tuple[Floats, int, int]:
    """Return the scaled end state, the right-hand sides evaluated and the events of a run."""
    packed, states, motion = states_along(
        merged(document, {"run": {"tolerance": tolerance}}), np.array([time])
    )
    return states[-1] / packed.natural, int(motion.counts[CALLS]), int(motion.counts[EVENTS])


@pytest.mark.parametrize("kind", ["internal", "external"])
@pytest.mark.parametrize("seed", [1, 4])
def test_error_falls_with_the_tolerance_through_impacts(kind: str, seed: int, measured: Measured) -> None:
    """Over 5 ms with located events: error <= 1e4 tolerance, in proportion to it where it is small."""
    document = free_pair_case(kind, "coupled", seed)
    reference, _, events = end_state(document, 1e-13, 5e-3)
    assert events >= 8
    errors = np.array([np.max(np.abs(end_state(document, tol, 5e-3)[0] - reference)) for tol in TOLERANCES])
    assert np.all(errors < 1e4 * TOLERANCES)
    assert errors[-1] < 1e-4 * errors[0]
    # the slope of a fifth-order pair whose step follows its error
    slope = np.polyfit(np.log10(TOLERANCES[-5:]), np.log10(errors[-5:]), 1)[0]
    measured("slope of log error over log tolerance, 1e-8 to 1e-12", float(slope), "0.7 to 1.2")
    measured("error over 5 ms with impacts at tolerance 1e-5, scaled", float(errors[0]), "0.1")
    measured("the same at tolerance 1e-12", float(errors[-1]), "1e-8")
    assert 0.7 < slope < 1.2


def test_work_grows_as_the_fifth_root_of_the_tolerance() -> None:
    """On smooth arcs a fifth-order method needs ten times the steps for 1e-5 of the tolerance."""
    document = free_pair_case("internal", "coupled", 1)
    document["meshes"][0]["backlash"] = 0.0  # wedged from the start: no free flight, few events
    calls = [end_state(document, tolerance, 2e-3)[1] for tolerance in (1e-8, 1e-13)]
    assert 5.0 < calls[1] / calls[0] < 15.0


def test_runge_kutta_coefficients_meet_their_order_conditions() -> None:
    """Dormand-Prince 5(4): quadrature conditions to order 5, error weights of a fourth-order companion."""
    b = np.append(WEIGHTS[6], 0.0)
    np.testing.assert_allclose(np.sum(WEIGHTS, axis=1), NODES, atol=1e-14)
    for k in range(1, 6):
        assert b @ NODES ** (k - 1) == pytest.approx(1.0 / k, abs=1e-14)
    companion = b - ERROR
    for k in range(1, 5):
        assert companion @ NODES ** (k - 1) == pytest.approx(1.0 / k, abs=1e-14)
    assert abs(companion @ NODES**4 - 0.2) > 1e-4
    A = np.hstack([WEIGHTS, np.zeros((7, 1))])
    assert b @ A @ NODES**3 == pytest.approx(1.0 / 20.0, abs=1e-14)
    assert b @ (NODES * (A @ NODES**2)) == pytest.approx(1.0 / 15.0, abs=1e-14)
    assert b @ A @ A @ NODES**2 == pytest.approx(1.0 / 60.0, abs=1e-14)
    assert abs(np.sum(DENSE)) < 1e-13
