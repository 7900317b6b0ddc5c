"""What implicit steps are made of: the guess of their accelerations, and their Jacobian."""

import numpy as np
import pytest

import gearplay as gp
from gearplay.integrate import implicit
from gearplay.integrate.implicit_stages import predict
from gearplay.integrate.jacobian import differentiate
from gearplay.integrate.run import Run, T
from gearplay.integrate.slopes import linearise, make_slopes, rate_of_change
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course
from planetary_sets import planetary_document


def pressed(case: gp.Case) -> Course:
    """Return a motion in the middle of its first implicit steps."""
    flow = Flow(gp.replace(case, {"run.tolerance": 1e-9}))
    course = flow.begin(flow.start())
    while (
        course.run.implicit.numbers[implicit.TRACED] < 2 or course.run.implicit.numbers[implicit.IN_USE] == 0
    ):
        assert course.time < 0.3
        course.take_chunk(0.3, 5)
    return course


@pytest.fixture(scope="module")
def pair() -> Course:
    return pressed(gp.load_case("external-pair"))


@pytest.mark.parametrize("name", ["external-pair", "two-stage-reducer", "planets"])
def test_the_jacobian_is_the_exact_derivative(name: str) -> None:
    """Only elements beside a rotor are asked when it moves: what they leave out is nought."""
    document = planetary_document() if name == "planets" else name
    course = pressed(gp.load_case(document))
    run: Run = course.run
    system, kept, h, t = course.packed.system, run.implicit, 1e-5, run.clock[T]
    acting, middle = run.active_set.acting.copy(), t + implicit.C[1] * h
    predict(system, run, h)
    assert differentiate(system, run, t, h) == 0
    assert np.array_equal(run.active_set.acting, acting)
    slopes, z, dz = (
        make_slopes(system),
        np.zeros(run.y.size + run.branch.impact_speeds.size),
        np.zeros(run.y.size),
    )
    assert linearise(system, run.active_set, middle, run.y_new, run.branch, slopes, run.loads) == 0
    places = kept.places[1 : kept.places[0] + 1]
    for found, columns in ((kept.positions, places - run.y.size // 2), (kept.velocities, places)):
        exact = np.zeros((places.size, places.size))
        for c, column in enumerate(columns):
            z[:] = 0.0
            z[column] = 1.0
            rate_of_change(system, run.active_set, run.branch, slopes, z, dz)
            exact[:, c] = dz[places]
        largest = np.max(np.abs(exact), axis=0)
        assert np.all(
            np.abs(found[: places.size, : places.size] - exact) <= 2e-3 * largest + 1e-9 * np.max(largest)
        )
