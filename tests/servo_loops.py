"""Two inertias with play on a position loop: cases, and their motion by matrix exponentials. For tests alone."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import gearplay as gp


@dataclass(frozen=True)
class Axis:
    """Motor on a loop u = -Kp theta_2 - Kd omega_1 - Ki integral of theta_2, load behind a spring k with half play b [SI]."""

    J1: float
    J2: float
    k: float
    b: float
    d1: float
    d2: float
    Kp: float
    Kd: float
    Ki: float

    def case(self, tolerance: float = 1e-12) -> gp.Case:
        """Return the case, its load off its place."""
        drive = {
            "kind": "position",
            "angle": 0.0,
            "proportional_gain": self.Kp,
            "derivative_gain": self.Kd,
            "integral_gain": self.Ki,
            "torque_limit": 1e4,
            "sensor": "load",
            "speed_sensor": "motor",
        }
        still = {"theta": 0.0, "omega": 0.0}
        return gp.load_case(
            {
                "rotors": {
                    "motor": {"mass": 1.0, "inertia": self.J1, "load": {"drag": self.d1}, "initial": still, "drive": drive},
                    "load": {
                        "mass": 1.0, "inertia": self.J2, "load": {"drag": self.d2}, "initial": {"theta": -0.005, "omega": 0.0},
                    },
                },
                "couplings": [{"between": ["motor", "load"], "torsional_stiffness": self.k, "play": 2.0 * self.b}],
                "run": {"duration": 2.0, "tolerance": tolerance},
            }
        )  # fmt: skip

    def with_gain(self, gain: float) -> "Axis":
        """Return the same with another proportional gain."""
        return replace(self, Kp=gain)

    def generator(self, side: int) -> Any:
        """Return the matrix of the affine motion of (theta_1, omega_1, theta_2, omega_2, integral, 1) on a flank, 0 for none."""
        k, own = abs(side) * self.k, side * self.k * self.b
        return np.array(
            [
                [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
                [-k / self.J1, -(self.d1 + self.Kd) / self.J1, (k - self.Kp) / self.J1, 0.0, -self.Ki / self.J1, own / self.J1],
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
                [k / self.J2, 0.0, -k / self.J2, -self.d2 / self.J2, 0.0, -own / self.J2],
                [0.0, 0.0, 1.0 if self.Ki else 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            ]
        )  # fmt: skip


class ByExponentials:
    """The motion of an axis from within its play, contacts located by Brent's method on matrix exponentials."""

    STEP = 1e-3  # s

    def __init__(self, axis: Axis, state: Any) -> None:
        self.axis, self.time, self.state, self.side = axis, 0.0, np.append(state, 1.0), 0
        self.parts = {side: expm(axis.generator(side) * self.STEP) for side in (-1, 0, 1)}
        self.turns: list[float] = []  # angles of the load where it turns back [rad]

    def _beyond(self, state: Any) -> float:
        """Return how far the state is beyond the present side [rad]."""
        phi, b = state[0] - state[2], self.axis.b
        return float(abs(phi) - b if self.side == 0 else b - self.side * phi)

    def _beyond_after(self, h: float, made: Any, before: Any) -> float:
        return self._beyond(expm(made * h) @ before)

    def to_opening(self, side: int) -> Any:
        """Advance until a flank opens; return the state there."""
        while True:
            after, h = self.parts[self.side] @ self.state, self.STEP
            changes = self._beyond(after) > 0.0 and not (self.side == 0 and self._just_opened(after))
            made, before = self.axis.generator(self.side), self.state
            if changes:
                h = brentq(self._beyond_after, 1e-9, self.STEP, args=(made, before), xtol=1e-18, rtol=1e-15)
                after = expm(made * h) @ before
            if after[3] * before[3] < 0.0:
                turn = brentq(_load_speed_after, 0.0, h, args=(made, before), xtol=1e-16)
                self.turns.append(float((expm(made * turn) @ before)[2]))
            self.state, self.time = after, self.time + h
            if changes:
                opened, phi = self.side, after[0] - after[2]
                self.side = 0 if opened else int(np.sign(phi))
                if opened == side:
                    return self.state[:5].copy()

    def _just_opened(self, after: Any) -> bool:
        return self._beyond(self.state) >= -1e-15 and self._beyond(after) <= self._beyond(self.state)


def _load_speed_after(h: float, made: Any, before: Any) -> float:
    return float((expm(made * h) @ before)[3])


def cycle(axis: Axis, side: int = 1, returns: int = 60) -> tuple[Any, float, float]:
    """Return state at the opening of a flank, period [s] and half the swing of the load [rad] of the settled motion."""
    motion = ByExponentials(axis, np.array([-0.005, 0.0, -0.005, 0.0, 0.0]))
    for _ in range(returns):
        state = motion.to_opening(side)
    motion.turns.clear()
    began = motion.time
    state = motion.to_opening(side)
    return state, motion.time - began, 0.5 * (max(motion.turns) - min(motion.turns))


def multipliers(axis: Axis, state: Any, side: int = 1) -> Any:
    """Return the multipliers of the return map from one opening of a flank to the next, by differences of the exact motion."""
    own = [0, 1, 2, 3, 4] if axis.Ki else [0, 1, 2, 3]
    columns = []
    for c in own:
        ends = []
        for sign in (1.0, -1.0):
            start = state.copy()
            start[c] += sign * 1e-7
            motion = ByExponentials(axis, start)
            ends.append(motion.to_opening(side)[own])
        columns.append((ends[0] - ends[1]) / 2e-7)
    found = np.linalg.eigvals(np.array(columns).T)
    return found[np.argsort(-np.abs(found))]
