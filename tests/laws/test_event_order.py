"""The order of the method through an impact: five with located contact changes, and no more without."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from building import Floats, Measured, case_of, single_rotor_document
from gearplay.integrate.active_set import make_active_set
from gearplay.integrate.right_hand_side import make_loads, right_hand_side
from gearplay.integrate.runge_kutta import NODES, WEIGHTS
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import LOADED, OPEN
from gearplay.model.pack import pack

CLEARANCE, STIFFNESS, MASS, SPEED, SPAN, START = 1e-4, 1e8, 0.5, 0.05, 0.9e-3, 8e-5
SLEEVE = {
    "radial_clearance": CLEARANCE,
    "law": "hunt-crossley",
    "stiffness": STIFFNESS,
    "exponent": 1.0,
    "restitution": 1.0,
}
PACKED = pack(case_of(single_rotor_document(SLEEVE)))


def exact(t: float) -> float:
    """Return x(t) [m] of a disc that flies to a linear wall, bounces off and comes back."""
    flight = (CLEARANCE - START) / SPEED
    omega = math.sqrt(STIFFNESS / MASS)
    touch = math.pi / omega
    if t <= flight:
        return START + SPEED * t
    if t <= flight + touch:
        return CLEARANCE + SPEED / omega * math.sin(omega * (t - flight))
    return CLEARANCE - SPEED * (t - flight - touch)


class FixedSteps:
    """The fifth-order formula on the kernels' right-hand side, with equal steps."""

    def __init__(self) -> None:
        system = PACKED.system
        self.active_set, self.branch = make_active_set(system, 6), make_branch(system)
        self.branch.impact_speeds[:] = 1.0
        self.loads, self.dy = make_loads(system), np.zeros(6)

    def rate(self, y: Floats, mode: int | None) -> Floats:
        """Return dy/dt on a branch, or (mode None) on the branch that the state chooses."""
        chosen = LOADED if math.hypot(y[0], y[1]) > CLEARANCE else OPEN
        self.branch.modes[0] = chosen if mode is None else mode
        assert right_hand_side(PACKED.system, self.active_set, 0.0, y, self.branch, self.dy, self.loads) == 0
        return self.dy.copy()

    def step(self, y: Floats, h: float, mode: int | None) -> Floats:
        """Return the state one step later."""
        stages: list[Floats] = []
        for row in WEIGHTS[:6]:
            stages.append(
                self.rate(y + h * sum((w * k for w, k in zip(row, stages, strict=False)), np.zeros(6)), mode)
            )
        return y + h * sum((w * k for w, k in zip(WEIGHTS[6], stages, strict=False)), np.zeros(6))

    def run(self, steps: int, located: bool) -> float:
        """Return x at the end of the span."""
        y, h, mode = np.array([START, 0.0, 0.0, SPEED, 0.0, 0.0]), SPAN / steps, OPEN
        for _ in range(steps):
            left = h
            while left > 0.0:
                after = self.step(y, left, mode if located else None)
                beyond = (after[0] - CLEARANCE) * (1.0 if mode == OPEN else -1.0)
                if not located or beyond <= 1e-18:
                    y, left = after, 0.0
                    continue
                start, now = y, mode
                low = -1e-9 if mode == OPEN else 1e-12  # the release is not the touch it began with
                part = brentq(
                    lambda s, y=start, m=now: self.step(y, s, m)[0] - CLEARANCE,
                    low,
                    left,
                    xtol=1e-18,
                    rtol=1e-15,
                )
                y, left, mode = self.step(y, part, mode), left - part, LOADED if mode == OPEN else OPEN
                y[0] = CLEARANCE
        return float(y[0])


def order(located: bool) -> tuple[float, list[float]]:
    """Return the fitted order and the errors [m], each the largest of three neighbouring numbers of steps."""
    method = FixedSteps()
    counts = np.array([40, 60, 90, 135, 200])
    errors = [
        max(abs(method.run(int(n) + shift, located) - exact(SPAN)) for shift in (0, 1, 2)) for n in counts
    ]
    return -float(np.polyfit(np.log(counts), np.log(errors), 1)[0]), errors


def test_runge_kutta_nodes__are_first_same_as_last() -> None:
    """The sixth row of weights gives the solution, as the first-same-as-last property needs."""
    assert NODES[6] == 1.0
    assert sum(WEIGHTS[6]) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.slow
def test_order_through_an_impact_with_and_without_location(measured: Measured) -> None:
    """Located: the error falls with the fifth power of the step; without: with the second at best."""
    with_location, errors = order(True)
    without, worse = order(False)
    measured("order through an impact, changes located", with_location, "4.6 to 5.5")
    measured("order through an impact, changes not located", without, "below 2.5")
    measured(
        "error with the finest steps, changes located [m]", errors[-1], f"1/1000 of {worse[-1]:.1e} without"
    )
    assert 4.6 < with_location < 5.5
    assert without < 2.5
    assert all(a > b for a, b in pairwise(errors))
    assert worse[-1] > 1e3 * errors[-1]
