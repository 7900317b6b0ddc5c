"""The exact derivative of the flow against differences of the flow itself, over contacts, switches and free flight."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.cross.random_systems import FEATURES, random_case

import gearplay as gp
from gearplay.solver.flow import Flow

Floats = NDArray[np.float64]
RUN = {"duration": 0.01, "transient": 0.0, "sampling": 1e4, "tolerance": 1e-12}
LEAD, SPAN = 0.0005, 0.006


def flow_of(seed: int, **changes: Any) -> Flow:
    return Flow(gp.replace(gp.load_case({**random_case(seed), "run": RUN}), changes))


def unit_changes(flow: Flow) -> Floats:
    """Return a change of each free state, shape [free, state + sleeve]."""
    changes = np.zeros((len(flow.free), flow.size + flow.impact_count))
    changes[np.arange(len(flow.free)), flow.free] = 1.0
    return changes


def scaled(flow: Flow, changes: Floats) -> Floats:
    """Return the derivative of the free states by those at the start, both in their natural sizes, shape [end, start]."""
    sizes = flow.natural[flow.free]
    return np.asarray(changes[:, flow.free].T * sizes[None, :] / sizes[:, None])


def by_differences(flow: Flow, start: Floats, impact_speeds: Floats, span: float, step: float) -> Floats:
    """Return the same by central differences of fourth order with a step in natural sizes."""
    columns = []
    for at in flow.free:
        ends = []
        for side in (1.0, -1.0, 0.5, -0.5):
            moved = start.copy()
            moved[at] += side * step * flow.natural[at]
            ends.append(flow.go(moved, span, impact_speeds=impact_speeds).state[flow.free])
        columns.append(
            (8.0 * (ends[2] - ends[3]) - (ends[0] - ends[1])) / (6.0 * step * flow.natural[flow.free])
        )
    return np.array(columns).T


def tangent_error(flow: Flow) -> float:
    """Return the relative error of the derivative from a state off every edge, over contacts and switches, by differences.

    The best of three steps counts: a difference over a long step may pass another sequence of contacts.
    """
    lead = flow.go(flow.start(), LEAD)
    found = flow.go(lead.state, SPAN, impact_speeds=lead.impact_speeds, changes=unit_changes(flow))
    plain = flow.go(lead.state, SPAN, impact_speeds=lead.impact_speeds)
    assert np.array_equal(found.state, plain.state)
    assert found.events == plain.events >= 4
    exact = scaled(flow, found.changes)
    errors = [
        np.max(np.abs(by_differences(flow, lead.state, lead.impact_speeds, SPAN, step) - exact))
        / np.max(np.abs(exact))
        for step in (1e-4, 1e-5, 1e-6)
    ]
    return float(min(errors))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20), ids=lambda seed: f"{seed}-{FEATURES[seed]['pair']}")
def test_the_tangent_is_the_derivative_of_the_flow(seed: int, measured: Any) -> None:
    """Twenty systems with all laws, drives and formulations."""
    error = tangent_error(flow_of(seed))
    measured("derivative of the flow over contacts against differences", error, "1e-6")
    assert error < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3, 8])
def test_the_tangent_on_a_housing_that_shakes(seed: int, measured: Any) -> None:
    """Its acceleration changes the speeds at which sleeves are hit, and which they remember."""
    shaking = {"kind": "harmonic", "amplitude": 300.0, "frequency": 300.0, "direction": 0.7}
    error = tangent_error(flow_of(seed, base={"acceleration": shaking}))
    measured("derivative of the flow on a housing that shakes against differences", error, "1e-6")
    assert error < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 3, 5, 9, 17])
def test_the_tangent_over_jumps_of_constant_damping(seed: int, measured: Any) -> None:
    """The force jumps to C dp/dt at every touch, as published at every release too: the saltation of T24."""
    damping = {"maximum": 300.0, "law": "constant"}
    changes = {f"meshes.{j}.damping": damping for j in range(len(random_case(seed)["meshes"]))}
    error = tangent_error(flow_of(seed, **changes))
    measured("derivative of the flow over jumps of constant damping against differences", error, "1e-6")
    assert error < 1e-6


@pytest.mark.parametrize("seed", [4, 6, 11, 12])
def test_volumes_shrink_by_the_divergence(seed: int, measured: Any) -> None:
    """Liouville: the determinant is the exponential of the divergence on the way, where no sleeve remembers its impact speed."""
    restitution = {f"sleeves.{name}.restitution": 1.0 for name in random_case(seed)["sleeves"]}
    flow = flow_of(seed, **restitution)
    found = flow.go(flow.start(), SPAN, changes=unit_changes(flow), divergence=True)
    assert found.events >= 4
    sign, logarithm = np.linalg.slogdet(scaled(flow, found.changes))
    error = abs(logarithm - found.divergence)
    measured("logarithm of the volume against the divergence", error, "1e-6")
    assert sign == 1.0
    assert error < 1e-6


def test_changes_add_up() -> None:
    """The tangent is linear, and what is moved on twice is moved on once over both spans."""
    flow = flow_of(2)
    free = unit_changes(flow)
    whole = flow.go(flow.start(), 2.0 * LEAD, changes=free)
    mixed = flow.go(flow.start(), 2.0 * LEAD, changes=(2.0 * free[0] - 3.0 * free[1])[None, :])
    assert np.allclose(mixed.changes[0], 2.0 * whole.changes[0] - 3.0 * whole.changes[1], rtol=1e-7, atol=0.0)
