"""Signals over a periodic orbit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.orbits.period_map import common_period
from gearplay.solver.flow import Flow
from gearplay.solver.observables import Observables

if TYPE_CHECKING:
    from gearplay.nonlinear.orbits.results import PeriodicOrbit

Floats = NDArray[np.float64]


def trace(
    orbit: PeriodicOrbit, signals: Sequence[str], samples: int
) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Return times [s], shape [sample + 1], signals of an orbit, shape [sample + 1, signal], and their names."""
    flow = Flow(orbit.case)
    autonomous = math.isfinite(orbit.period)
    span = orbit.period if autonomous else orbit.order * common_period(flow.packed)
    free, full = len(flow.free), np.zeros(flow.size)
    full[flow.free] = orbit.states[0, :free]
    speeds = orbit.states[0, free : free + flow.impact_count]
    course = flow.begin(full, impact_speeds=speeds if flow.impact_count else None)
    observe, times = Observables(flow.packed, signals), span * np.arange(samples + 1) / samples
    values = []
    for t in times:
        if t > 0.0:
            course.advance(float(t))
        values.append(observe(float(t), course.state, course.run.branch))
    return times, np.array(values).reshape(len(times), -1), observe.names


def swing(values: Floats) -> float:
    """Return the peak-to-peak value of samples of a periodic curve whose last is its first, extremes by parabolas.

    >>> phase = np.arange(201) * 2.0 * np.pi / 200
    >>> abs(swing(np.sin(phase + 0.3)) - 2.0) < 1e-7
    True
    """
    once = values[:-1]
    return _peak(once) + _peak(-once)


def _peak(values: Floats) -> float:
    at = int(np.argmax(values))
    before, top, after = values[at - 1], values[at], values[(at + 1) % len(values)]
    bend = before - 2.0 * top + after
    return float(top - 0.125 * (after - before) ** 2 / bend) if bend < 0.0 else float(top)
