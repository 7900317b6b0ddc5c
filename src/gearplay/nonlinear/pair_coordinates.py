"""Displacement x and velocity x' of the torsional pair of the literature as coordinates of its state."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.model.torsional_pair import HALF_BACKLASH, NATURAL_FREQUENCY
from gearplay.solver.flow import Flow
from gearplay.solver.observables import Observables, state_names

Floats = NDArray[np.float64]
NAMES: Final = ("x", "x'")
ENTRIES: Final = ("wheel.theta", "wheel.omega")
"""Entries of the state that they stand for."""
REACH: Final = 1e-3
"""Rotation [rad] over which the slope of x is taken; x is linear in it."""


class PairCoordinates:
    """x and x' = dx / d(omega_n t) at a time and a state of a torsional pair with backlash.

    x = 1 + drive_penetration / (b / 2) is linear in the wheel's rotation; the transmission error e(t), which makes the
    alternating force, is part of it: x' = (slope omega + e' / (b / 2)) / omega_n.
    """

    def __init__(self, flow: Flow) -> None:
        self._observe, names = Observables(flow.packed, ["x"]), state_names(flow.packed)
        self._state, self._place = np.zeros(flow.size), names.index(ENTRIES[0])
        self.slope = (self._x(0.0, REACH) - self._x(0.0, -REACH)) / (2.0 * REACH)
        self._errors = flow.case.meshes[0].transmission_error
        pair = flow.case.torsional_pair
        self._rate = 0.0 if pair is None else pair.frequency * NATURAL_FREQUENCY

    def _x(self, t: float, theta: float) -> float:
        self._state[self._place] = theta
        return float(self._observe(t, self._state)[0])

    def _error_rate(self, t: float) -> float:
        """Return e' / (b / 2) [1/s]."""
        return sum(
            each.amplitude * self._rate * each.order * math.cos(each.order * self._rate * t + each.phase)
            for each in self._errors
        ) / HALF_BACKLASH  # fmt: skip

    def at(self, t: float, states: Floats) -> Floats:
        """Return x and x' of rotations [rad] and speeds [rad/s] of the wheel at t [s], shapes [..., 2]."""
        x = self._x(t, 0.0) + self.slope * states[..., 0]
        rate = (self.slope * states[..., 1] + self._error_rate(t)) / NATURAL_FREQUENCY
        return np.stack([x, rate], axis=-1)

    def entry(self, name: str, values: Floats) -> Floats:
        """Return the rotations or speeds of the wheel, relative to the nominal ones, at which x or x' has values at t = 0."""
        if name == NAMES[0]:
            return np.asarray((values - self._x(0.0, 0.0)) / self.slope)
        return np.asarray((NATURAL_FREQUENCY * values - self._error_rate(0.0)) / self.slope)


def pair_coordinates(flow: Flow) -> PairCoordinates | None:
    """Return the coordinates of a torsional pair, None of any other case and without backlash."""
    return PairCoordinates(flow) if NAMES[0] in flow.packed.half_backlashes else None
