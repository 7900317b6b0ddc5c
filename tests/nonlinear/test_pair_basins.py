"""Basins of attraction of the literature's pair in its own coordinates, x and x'."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearplay as gp
from gearplay.model.torsional_pair import NATURAL_FREQUENCY
from gearplay.nonlinear.pair_coordinates import pair_coordinates
from gearplay.solver.flow import Flow
from gearplay.solver.observables import Observables

OMEGA, F_M, F_A, ZETA, PHI = 0.6, 0.1, 0.05, 0.05, 0.7
PAIR = gp.torsional_pair(OMEGA, mean_force=F_M, force=F_A, damping_ratio=ZETA, force_phase=PHI)


def equation(tau: float, state: np.ndarray) -> list[float]:
    """Kahraman and Singh 1990, eq. (10)."""
    x, rate = state
    f = x - 1.0 if x > 1.0 else x + 1.0 if x < -1.0 else 0.0
    return [rate, F_M + F_A * math.cos(OMEGA * tau + PHI) - 2.0 * ZETA * rate - f]


def settled(x: float, rate: float, periods: int) -> np.ndarray:
    """Return x and x' after some periods by an integrator of another library."""
    end = periods * 2.0 * math.pi / OMEGA
    found = solve_ivp(equation, (0.0, end), [x, rate], method="LSODA", rtol=1e-8, atol=1e-10)
    return np.asarray(found.y[:, -1])


def test_coordinates__are_those_of_the_motion() -> None:
    """The rate of the signal x along a motion, at any time, is x'."""
    flow = Flow(PAIR)
    pair, observe = pair_coordinates(flow), Observables(flow.packed, ["x"])
    assert pair is not None
    course, step = flow.begin(flow.start()), 1e-8
    seen = []
    for t in (3.1e-4, 3.1e-4 + step, 3.1e-4 + 2.0 * step):
        course.advance(t)
        seen.append(float(observe(course.time, course.state)[0]))
        if len(seen) == 2:
            now = pair.at(course.time, flow.seen(course.time, course.state))
    assert now[0] == pytest.approx(seen[1], rel=1e-12)
    assert now[1] == pytest.approx((seen[2] - seen[0]) / (2.0 * step) / NATURAL_FREQUENCY, rel=1e-5)
    assert abs(now[1]) > 1e-3


@pytest.mark.slow
def test_basins__are_those_of_the_equation(tmp_path: Path) -> None:
    """Each start of the grid ends at the attractor that an independent integration of the equation finds."""
    found = gp.basins(PAIR, ("x", -1.5, 2.5, 6), ("x'", -1.0, 1.0, 5), settle=150)
    assert len(found.attractors) == 2
    assert found.entries == ("x", "x'")
    assert set(found.labels.ravel().tolist()) == {0, 1}
    ends = np.array([[settled(x, rate, 150) for x in found.first] for rate in found.second])
    distance = np.array([np.abs(ends - each[0]).max(axis=-1) for each in found.attractors])
    assert np.array_equal(np.argmin(distance, axis=0), found.labels)
    assert distance.min(axis=0).max() < 1e-3
    found.save(tmp_path / "basins.nc")
    again = gp.read_result(tmp_path / "basins.nc")
    assert again.names == ("x", "x'")
    assert np.array_equal(again.attractors[1], found.attractors[1])
    ax = found.plot().axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [1]", "x' [1]")
    assert ax.get_xlim() == pytest.approx((-1.9, 2.9))


def test_basins__refuse_x_where_there_is_none() -> None:
    with pytest.raises(gp.InputError, match=r"must be an entry of the state .* Choose from: ring\.x, "):
        gp.basins("han2021", ("x", -1, 1, 2), ("ring.vx", -1, 1, 2), period="mesh")
    with pytest.raises(gp.InputError, match=r"Choose from: x, x', wheel\.theta, wheel\.omega"):
        gp.basins(PAIR, ("y", -1, 1, 2), ("x'", -1, 1, 2))
    with pytest.raises(gp.InputError, match="must be another entry than the first"):
        gp.basins(PAIR, ("x", -1, 1, 2), ("wheel.theta", -1, 1, 2))
