"""What implicit steps are made of: the guess of their accelerations, and their Jacobian."""

import numpy as np
import pytest

import gearplay as gp
from gearplay.integrate import implicit, radau
from gearplay.integrate.implicit_stages import predict
from gearplay.integrate.jacobian import differentiate
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import Run, T
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
def test_the_jacobian_is_that_of_differences(name: str) -> None:
    """Of the whole right-hand side, by steps to both sides; outside the envelope there is nothing."""
    document = planetary_document() if name == "planets" else name
    course = pressed(gp.load_case(document))
    run: Run = course.run
    system, kept, h, t = course.packed.system, run.implicit, 1e-5, run.clock[T]
    lists = run.active_set.acting.copy(), run.active_set.active.copy()
    middle = t + radau.C[kept.numbers[implicit.METHOD], radau.STAGES[kept.numbers[implicit.METHOD]] // 2] * h
    predict(system, run, h, True)
    assert differentiate(system, run, t, h) == 0
    assert np.array_equal(run.active_set.acting, lists[0])
    assert np.array_equal(run.active_set.active, lists[1])
    count = kept.places[0]
    places, y = kept.places[1 : count + 1], run.y_new.copy()
    rates = np.zeros((2, y.size))
    for found, columns, far in (
        (kept.positions, places - y.size // 2, 1e-6),
        (kept.velocities, places, 1e-4),
    ):
        exact = np.zeros((count, count))
        for c, column in enumerate(columns):
            for side, sign in enumerate((1.0, -1.0)):
                moved = y.copy()
                moved[column] += sign * far * run.natural[column]
                assert (
                    rates_of(system, run.active_set, middle, moved, run.branch, rates[side], run.loads) == 0
                )
            exact[:, c] = (rates[0] - rates[1])[places] / (2.0 * far * run.natural[column])
        largest = np.max(np.abs(exact), axis=0)
        assert np.all(np.abs(found[:count, :count] - exact) <= 1e-5 * largest + 1e-9 * np.max(largest))
        outside = np.arange(count)[None, :] < kept.first[:count, None]
        assert not np.any(found[:count, :count][outside])
        assert not np.any(found[:count, :count][outside.T])
    assert (implicit.pairs_of(kept) < count * count) == (name != "external-pair")
