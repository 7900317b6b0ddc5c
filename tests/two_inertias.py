"""Two inertias with play between them, exactly: matrix exponentials between contacts, contacts by bisection. For tests alone."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import gearplay as gp


@dataclass(frozen=True)
class Pair:
    """Inertias [kg m^2], stiffness [N m/rad], damping and drags [N m s/rad], total play [rad], step [s], torque [N m]."""

    J1: float
    J2: float
    k: float
    c: float
    play: float
    d1: float
    d2: float
    dt: float
    a: float
    w: float

    def torque(self, i: int) -> float:
        """Return the motor's torque in step i."""
        return float(self.a * np.sin(self.w * i) + 0.3 * self.a * np.sign(np.sin(2.1 * self.w * i + 0.4)))

    def case(self, tolerance: float) -> gp.Case:
        """Return the case, at rest in the middle of its play."""
        still = {"theta": 0.0, "omega": 0.0}
        return gp.load_case(
            {
                "rotors": {
                    "motor": {
                        "mass": 1.0,
                        "inertia": self.J1,
                        "drive": {"kind": "torque", "torque": 0.0},
                        "load": {"drag": self.d1},
                        "initial": still,
                    },
                    "load": {"mass": 1.0, "inertia": self.J2, "load": {"drag": self.d2}, "initial": still},
                },
                "couplings": [
                    {
                        "between": ["motor", "load"],
                        "torsional_stiffness": self.k,
                        "torsional_damping": self.c,
                        "play": self.play,
                    }
                ],
                "run": {"duration": 1.0, "tolerance": tolerance},
            }
        )


D1 = Pair(1e-3, 4e-3, 2000.0, 0.5, 4e-3, 1e-3, 0.0, 1e-3, 0.5, 0.35)
D2 = Pair(2e-5, 3e-4, 150.0, 0.02, 6e-3, 2e-5, 1e-4, 1e-4, 0.05, 0.13)


class Exact:
    """The motion of a pair: state (theta_1, omega_1, theta_2, omega_2); ``side`` is the flank whose spring acts, 0 for none."""

    def __init__(self, pair: Pair) -> None:
        self.pair, self.state, self.side = pair, np.zeros(4), 0

    def _generator(self, side: int, torque: float) -> Any:
        """Return the matrix of the affine motion of (state, 1)."""
        p, k, c = self.pair, abs(side) * self.pair.k, abs(side) * self.pair.c
        own = side * self.pair.k * 0.5 * self.pair.play
        return np.array(
            [
                [0.0, 1.0, 0.0, 0.0, 0.0],
                [-k / p.J1, -(c + p.d1) / p.J1, k / p.J1, c / p.J1, (torque + own) / p.J1],
                [0.0, 0.0, 0.0, 1.0, 0.0],
                [k / p.J2, c / p.J2, -k / p.J2, -(c + p.d2) / p.J2, -own / p.J2],
                [0.0, 0.0, 0.0, 0.0, 0.0],
            ]
        )

    def _margin(self, state: Any) -> float:
        """Return what is positive as long as the present flank, or none, acts."""
        p = self.pair
        phi, rate = state[0] - state[2], state[1] - state[3]
        if self.side == 0:
            return self._gap(phi)
        return p.k * (self.side * phi - 0.5 * p.play) + p.c * self.side * rate

    def _margin_after(self, h: float, made: Any, before: Any) -> float:
        return self._margin(expm(made * h) @ before)

    def _gap(self, phi: float) -> float:
        return float(0.5 * self.pair.play - abs(phi))

    def step(self, torque: float, span: float | None = None) -> Any:
        """Advance by a step, or over a span [s]."""
        left, fine = self.pair.dt if span is None else span, 400
        while left > 0.0:
            made = self._generator(self.side, torque)
            part = expm(made * (self.pair.dt / fine))
            start = np.append(self.state, 1.0)
            at, before, ended = 0.0, start, False
            while at < left and not ended:
                h = min(self.pair.dt / fine, left - at)
                after = (part if h == self.pair.dt / fine else expm(made * h)) @ before
                if self._margin(after) < 0.0 and not self._opens(before, after):
                    h = brentq(self._margin_after, 0.0, h, args=(made, before), xtol=1e-18, rtol=1e-15)
                    after, ended = expm(made * h) @ before, True
                at, before = at + h, after
            self.state, left = before[:-1].copy(), left - at
            if ended:
                phi = self.state[0] - self.state[2]
                self.side = 0 if self.side else int(np.sign(phi))
        return self.state

    def _opens(self, before: Any, after: Any) -> bool:
        """Return whether a released flank only parts: it still presses, without a force, just after its release."""
        if self.side:
            return False
        gaps = [self._gap(state[0] - state[2]) for state in (before, after)]
        return gaps[1] >= gaps[0] and gaps[0] < 0.0


class Lagged(Exact):
    """The same with the torque behind a current loop of first order, its time constant in s, as fifth state."""

    def __init__(self, pair: Pair, lag: float) -> None:
        super().__init__(pair)
        self.lag, self.state = lag, np.zeros(5)

    def _generator(self, side: int, torque: float) -> Any:
        own = super()._generator(side, 0.0)
        made = np.zeros((6, 6))
        made[:4, :4], made[:4, 5] = own[:4, :4], own[:4, 4]
        made[1, 4] = 1.0 / self.pair.J1
        made[4, 4], made[4, 5] = -1.0 / self.lag, torque / self.lag
        return made
