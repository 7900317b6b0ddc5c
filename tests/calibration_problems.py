"""Plans whose answer is known: what the sensor shows is a formula, with noise from the seed."""

from typing import Any

import numpy as np

from gearplay.calibration.observe import Observed
from gearplay.calibration.plan import Plan
from gearplay.calibration.reading import load_plan
from gearplay.calibration.trials import Observations, Problem, TrialError

NOISE = 0.02  # decades, of one member


PLAN: dict[str, Any] = {
    "title": "small",
    "case": "han2021",
    "set": {"run.tolerance": 1e-6},
    "sensor": {"rotor": "ring"},
    "parameters": [
        {"name": "drag", "path": "rotors.ring.load.drag", "low": "1e-4 N m s/rad", "high": "1e-3 N m s/rad"},
        {"name": "error", "path": "meshes.0.transmission_error.0.amplitude", "low": "0.1 um", "high": "2 um"},
    ],
    "models": [{"name": name, "set": {"backlash_model": name}} for name in ("coupled", "uncoupled")],
    "simulation": {"members": 2, "duration": "1 s", "transient": "0.1 s", "sampling": "500 Hz"},
    "effort": {"evaluations": 24, "startup": 16, "polish": 8, "polish_members": 2, "check_members": 2, "seed": 3},
    "targets": [
        {"kind": "hump", "name": "radial", "band": ["1 Hz", "8 Hz"]},
        {"kind": "line", "name": "mesh", "order": 1, "search": 0.1},
    ],
    "conditions": [
        {"name": "slow", "set": {"rotors.pinion.drive.speed": "60 rpm"},
         "measured": {"radial": {"amplitude": 0.002, "frequency": 1.6}, "mesh": {"amplitude": 0.004}}},
        {"name": "fast", "set": {"rotors.pinion.drive.speed": "120 rpm"},
         "measured": {"radial": {"amplitude": 0.004, "frequency": 2.8}, "mesh": {"amplitude": 0.008}}},
    ],
}  # fmt: skip
"""A plan that is simulated within seconds: two parameters, models and conditions, a hump and a line."""


def small_plan(**changes: Any) -> Plan:
    """Return the plan of a `KnownProblem`."""
    spans = (("1e-4 N m s/rad", "1e-2 N m s/rad"), ("10 nm", "1 um"))
    document = {
        **{name: PLAN[name] for name in ("case", "sensor")},
        "uncertainty": 0.02,
        "frequency_uncertainty": 0.02,
        "discrepancy": False,
        "parameters": [each | {"low": low, "high": high} for each, (low, high) in zip(PLAN["parameters"], spans, strict=True)],
        "simulation": {"members": 4, "duration": "0.5 s", "transient": "0.05 s", "sampling": "500 Hz"},
        "effort": {"evaluations": 60, "startup": 16, "polish": 12, "polish_members": 8, "check_members": 16, "seed": 5},
        "targets": [PLAN["targets"][0] | {"band": [2.0, 12.0]}, PLAN["targets"][1]],
        "conditions": [each | {"measured": seen} for each, seen in zip(PLAN["conditions"], (MEASURED, FAST), strict=True)],
    }  # fmt: skip
    return load_plan({**document, **changes})


# What `KnownProblem` shows at 0.4 and 0.6 of the parameters' ranges.
MEASURED = {"radial": {"amplitude": 0.01585, "frequency": 3.981}, "mesh": {"amplitude": 0.01406}}
FAST = {"radial": {"amplitude": 0.03162, "frequency": 5.012}, "mesh": {"amplitude": 0.02805}}


class KnownProblem(Problem):
    """Frequencies go with the root of the first parameter, amplitudes of the mesh with the second."""

    def observe(
        self, unit: Any, *, seed: int | None = None, members: int | None = None, **_: Any
    ) -> Observations:
        u, v = unit
        if u > 0.97:
            raise TrialError("the shaft is stuck")
        count = members or self.plan.simulation.members
        size = NOISE / np.sqrt(count)
        generator = np.random.default_rng([seed or 0, int(1e9 * u), int(1e9 * v)])

        def seen(log: float) -> Observed:
            return Observed(float(10.0 ** (log + size * generator.normal())), size)

        return {
            condition.name: {
                "radial": {
                    "amplitude": seen(-2.0 + 0.3 * shift + 0.5 * u),
                    "displacement": seen(-5.0 + 0.5 * u),
                    "frequency": seen(0.2 + u + 0.1 * shift),
                },
                "mesh": {
                    "amplitude": seen(-2.5 + v + 0.2 * u * v + 0.3 * shift),
                    "displacement": seen(-7.0 + v),
                    "frequency": seen(1.3 + 0.3 * shift),
                },
            }
            for shift, condition in enumerate(self.plan.conditions)
        }


class ListStore:
    """Keeps trials in memory; refuses to go on after a number of new ones, as a kill does."""

    def __init__(self) -> None:
        self.trials: list[Any] = []
        self.patience: int | None = None

    def read(self) -> list[Any]:
        return list(self.trials)

    def add(self, trial: Any) -> None:
        if self.patience is not None:
            if self.patience == 0:
                raise KeyboardInterrupt
            self.patience -= 1
        self.trials.append(trial)
