"""Periodic orbits and their multipliers against closed forms: linear pairs, Meissner's chart, a two-sided contact."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.torsional_pair import BASE_RADIUS, HALF_BACKLASH
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.orbits.shooting import find_orbit
from gearplay.nonlinear.torsional import torsional_pair
from gearplay.vocabulary.errors import SimulationError

Floats = NDArray[np.float64]


def linear(frequency: float, **more: Any) -> Case:
    return torsional_pair(frequency, **{"backlash": False, "tolerance": 1e-12, **more})


def stroke(stiffness: float, time: float) -> Floats:
    """Return the propagator of x'' + k x = 0."""
    w = math.sqrt(stiffness)
    c, s = math.cos(w * time), math.sin(w * time)
    return np.array([[c, s / w], [-w * s, c]])


@pytest.mark.parametrize(("frequency", "zeta"), [(0.8, 0.05), (1.7, 0.01), (0.31, 0.3)])
def test_multipliers_of_the_damped_linear_pair(frequency: float, zeta: float, measured: Any) -> None:
    """They are exp((-zeta +- i sqrt(1 - zeta^2)) T)."""
    period_map = StrobeMap(lambda f: linear(f, damping_ratio=zeta, mean_force=2.0, force=0.3), frequency)
    orbit = find_orbit(period_map, period_map.start(frequency), frequency)
    root = np.exp((-zeta + 1j * math.sqrt(1.0 - zeta**2)) * 2.0 * math.pi / frequency)
    error = max(np.min(np.abs(orbit.multipliers - each)) for each in (root, root.conjugate()))
    measured("Floquet multipliers of the linear pair", error, "1e-8")
    assert error < 1e-8
    assert orbit.stable


@pytest.mark.slow
def test_stability_chart_of_meissner(measured: Any) -> None:
    """X'' + (1 +- a) x = 0 in equal halves of the period: unstable where the trace is beyond +-2; all of 400 points."""
    right = counted = 0
    worst = 0.0
    for amplitude in np.linspace(0.05, 0.6, 20):
        for frequency in np.linspace(0.3, 2.5, 20):
            half = math.pi / frequency
            trace = np.trace(stroke(1.0 - amplitude, half) @ stroke(1.0 + amplitude, half))
            period_map = StrobeMap(
                lambda f, a=amplitude: linear(
                    f, damping_ratio=0.0, mean_force=0.5, square=True, stiffness_amplitude=a, tolerance=1e-10
                ),
                frequency,
            )
            start = period_map.start(frequency)
            start[0] += (
                0.5 * HALF_BACKLASH / BASE_RADIUS
            )  # in contact: a start at the edge would fly for a nanosecond
            matrix = period_map(start, frequency).matrix
            worst = max(worst, abs(np.trace(matrix) - trace))
            if abs(abs(trace) - 2.0) > 0.005 * 2.0:
                counted += 1
                right += (abs(trace) > 2.0) == (abs(np.trace(matrix)) > 2.0)
    measured("Meissner's chart: share of points that agree, edges left out", right / counted, "all")
    measured("trace over a period of the square wave", worst, "1e-6")
    assert right == counted > 370
    assert worst < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frequency", "force", "zeta", "order"), [(0.7, 0.1, 0.05, 1), (0.5, 0.15, 0.1, 1), (0.8, 0.2, 0.1, 2)]
)
def test_an_orbit_that_rattles_is_reached_by_waiting(
    frequency: float, force: float, zeta: float, order: int, measured: Any
) -> None:
    """The orbit that Newton's method finds is where the motion settles, and it settles as its multipliers say."""
    period_map = StrobeMap(
        lambda f: torsional_pair(f, mean_force=0.1, force=force, damping_ratio=zeta, tolerance=1e-12),
        frequency,
    )
    orbit = find_orbit(
        period_map, period_map.settle(period_map.start(frequency), frequency, 100), frequency, order=order
    )
    assert len(orbit.contacts) >= 2
    assert orbit.stable
    settled = period_map.settle(orbit.states[0] + 0.01 * period_map.scale, frequency, 100 * order)
    error = np.min(np.max(np.abs(settled - orbit.states) / period_map.scale, axis=1))
    measured("orbit by shooting against where the motion settles [scaled]", error, "1e-8")
    assert error < 1e-8
    moved = orbit.states[0] + 1e-6 * period_map.scale
    decayed = period_map.settle(moved, frequency, order) - orbit.states[0]
    assert np.allclose(
        decayed, orbit.matrix @ (1e-6 * period_map.scale), rtol=1e-3, atol=1e-9 * period_map.scale.max()
    )


def test_an_unstable_orbit_within_chaos_repels() -> None:
    period_map = StrobeMap(lambda f: torsional_pair(f, mean_force=0.1, force=0.2, damping_ratio=0.1), 0.6)
    orbit = find_orbit(period_map, period_map.settle(period_map.start(0.6), 0.6, 20), 0.6)
    assert abs(orbit.multipliers[0]) > 1.0
    left = period_map.settle(orbit.states[0] + 1e-6 * period_map.scale, 0.6, 100) - orbit.states[0]
    assert np.max(np.abs(left) / period_map.scale) > 0.1


def linear_response(frequency: float, zeta: float, force: float) -> float:
    """Return the amplitude of x of the linear pair: F_a / |1 - Omega^2 + 2 i zeta Omega|."""
    return force / abs(1.0 - frequency**2 + 2j * zeta * frequency)


@pytest.mark.slow
def test_contact_is_first_lost_where_the_linear_response_reaches_the_static_deflection(measured: Any) -> None:
    """Grazing of the driven one-sided contact: F_m = |X|. Just below it contact is kept, just above it is not."""
    frequency, zeta, mean = 0.9, 0.05, 0.1
    edge = mean / linear_response(frequency, zeta, 1.0)

    def map_at(force: float) -> StrobeMap:
        return StrobeMap(
            lambda f: torsional_pair(f, mean_force=mean, force=force, damping_ratio=zeta, tolerance=1e-12),
            frequency,
        )

    rest, gentle = (
        find_orbit(each, each.settle(each.start(frequency), frequency, 40), frequency).states[0]
        for each in (map_at(0.0), map_at(0.5 * edge))
    )

    def keeps_contact(force: float) -> bool:
        guess = rest + (gentle - rest) * force / (0.5 * edge)  # a rattling orbit coexists: stay off it
        try:
            return len(find_orbit(map_at(force), guess, frequency).contacts) == 0
        except SimulationError:  # the branch turns back where it grazes
            return False

    low, high = 0.9 * edge, 1.1 * edge
    assert keeps_contact(low)
    assert not keeps_contact(high)
    while high - low > 1e-10 * edge:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if keeps_contact(middle) else (low, middle)
    error = abs(0.5 * (low + high) - edge) / edge
    measured("force at which the one-sided contact grazes", error, "1e-8")
    assert error < 1e-8
