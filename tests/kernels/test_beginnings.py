"""The first step after a contact change: as long as those before it have turned out to be able to be."""

import pytest

import gearplay as gp
from gearplay.kernels.run import H_BEGIN, H_RESTART
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course


def rattled(tolerance: float) -> Course:
    """Return 20 ms of the bundled chain, whose flanks part and meet again some hundred times."""
    flow = Flow(gp.replace(gp.load_case("pinion-idler-ring"), {"run.tolerance": tolerance}))
    course = flow.begin(flow.start())
    course.advance(0.02)
    return course


@pytest.mark.parametrize(
    ("tolerance", "least", "most"), [(1e-4, 4.0, 64.0), (1e-6, 2.0, 16.0), (1e-13, 1.0, 1.0)]
)
def test_its_length_is_learnt(tolerance: float, least: float, most: float) -> None:
    """An explicit step of order 5 errs as its fifth power or so: 2.5 times as long where errors may be 100 times as large."""
    clock = rattled(tolerance).run.clock
    assert least <= clock[H_BEGIN] / clock[H_RESTART] <= most
