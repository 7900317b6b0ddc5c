"""Synthetic hysteresis curves: a spring in stages with play, and Coulomb friction, sample by sample."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gearplay as gp

ARCMIN = 180.0 * 60.0 / np.pi
ENDS = (14.0, 48.0)


@dataclass(frozen=True)
class Truth:
    """A spring in stages between two rotors: play [rad], stiffnesses [N m/rad], friction of the output [N m]."""

    play: float = 1e-3
    stages: tuple[float, float, float] = (1.5e4, 2e4, 3e4)
    friction: float = 2.0

    def angle(self, effective: float) -> float:
        """Return the rotation [rad] under a torque less friction [N m]."""
        size = abs(effective)
        edges = [0.0, *ENDS, np.inf]
        twist = sum(
            (min(max(size, low), high) - low) / k
            for low, high, k in zip(edges, edges[1:], self.stages, strict=False)
        )
        return float(np.sign(effective)) * (0.5 * self.play + twist)

    def case(self) -> gp.Case:
        """Return the same as a case, the play as a stage without torque."""
        points = [[0.5 * self.play, 0.0], *([self.angle(each), each] for each in (*ENDS, 1000.0))]
        body = {"mass": 1.0, "inertia": 1e-2}
        rotors = {"motor": body, "arm": {**body, "load": {"friction": self.friction}}}
        coupling = {"between": ["motor", "arm"], "torque": points}
        return gp.load_case({"rotors": rotors, "couplings": [coupling], "run": {"duration": 0.1}})


def record(
    path: Path, truth: Truth, *, noise: float, torque_noise: float = 0.0, seed: int = 0, rated: float = 100.0
) -> Path:
    """Write two cycles of 400 samples from no torque; noise of the rotation's amplitude, and of the rated torque."""
    rng = np.random.default_rng(seed)
    rise = np.linspace(0.0, rated, 100, endpoint=False)
    one = np.concatenate([rise, np.linspace(rated, -rated, 200, endpoint=False), rise - rated])
    torque, last, angles = np.tile(one, 2), 0.0, []
    for each in torque.tolist():
        last = min(max(last, each - truth.friction), each + truth.friction)
        angles.append(truth.angle(last))
    angle = np.array(angles)
    angle += 1e-3 + noise * 0.5 * np.ptp(angle) * rng.standard_normal(angle.size)
    torque = torque + torque_noise * rated * rng.standard_normal(torque.size)
    lines = [
        f"{k},{t!r},{ARCMIN * a!r}"
        for k, (t, a) in enumerate(zip(torque.tolist(), angle.tolist(), strict=True))
    ]
    path.write_text("time,Torque [N m],Output Poisition [arcmin]\n" + "\n".join(lines) + "\n")
    return path
