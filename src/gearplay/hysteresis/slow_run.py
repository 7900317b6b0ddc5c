"""Hysteresis curve of a simulated motion under a slow torque, to compare with equilibria."""

from __future__ import annotations

import numpy as np

from gearplay.hysteresis.cycle import Curve
from gearplay.hysteresis.held import Held
from gearplay.parts.drive.schema import TorqueDrive
from gearplay.parts.drive.terms import Term
from gearplay.parts.tables import HOLDERS
from gearplay.results.simulate import simulate
from gearplay.schema.fields import FrozenTable
from gearplay.vocabulary.errors import SimulationError

QUARTER = 500
"""Samples in a quarter of the period."""


def slow_cycle(held: Held, rated: float, cycles: int, period: float) -> Curve:
    """Return the last of several cycles of the torque T_r sin(2 pi t / period) on the output of a held train.

    Raises `SimulationError` for a motion that does not reach its end.
    """
    still = held.smooth().case
    term = Term(frequency=1.0 / period, amplitude=rated)
    rotors = dict(still.rotors)
    drive = TorqueDrive(torque=0.0, terms=(term,))
    rotors[held.at] = rotors[held.at].model_copy(
        update={"drive": drive, "load": held.source.rotors[held.at].load}
    )
    n = 4 * QUARTER
    finer = max(1, int(np.ceil(period / n)))  # a case has at least one sample a second
    run = still.run.model_copy(
        update={
            "transient": cycles * period,
            "duration": (1.25 + 1.5 / n) * period,
            "sampling": finer * n / period,
            "ensemble": 1,
        }
    )
    hot = held.source.operating
    damped = {table: getattr(hot, table) for table in HOLDERS} | {"meshes": hot.meshes}
    moving = still.model_copy(update={"rotors": FrozenTable(rotors), "run": run, **damped})
    result = simulate(moving, signals=[f"{held.at}.theta"])
    if not result.success:
        raise SimulationError(f"the slow run did not reach its end: {result.message}")
    theta = np.asarray(result.signal("theta", held.at, 0))[::finer]
    torque = rated * np.sin(2.0 * np.pi * np.arange(-QUARTER, QUARTER + 1) / n)
    unloading = theta[QUARTER : 3 * QUARTER + 1][::-1]
    loading = theta[3 * QUARTER : 5 * QUARTER + 1]
    torque[QUARTER] = 0.0
    angle = np.array([unloading, loading])
    with np.errstate(divide="ignore"):
        tangent = 1.0 / np.gradient(angle, torque, axis=1)
    return Curve(torque, angle, tangent, float(-np.trapezoid(unloading - loading, torque)))
