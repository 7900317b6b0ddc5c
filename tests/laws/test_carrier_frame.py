"""Planetary sets seen from their turning carrier: mesh period, derivative of the map, broken symmetry; starts on a resonance."""

import math

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.model.families import along
from gearplay.model.pack import pack
from gearplay.nonlinear.orbits.continuation import resonant_value
from gearplay.nonlinear.orbits.period_map import StrobeMap, common_period
from gearplay.parts.mesh.train.rolling import mesh_frequency, nominal_speeds
from gearplay.solver.flow import Flow
from planetary_sets import planetary_document

SUN = {"floating": True, "radial_damping": 500.0}


def small(**changes: object) -> gp.Case:
    """Return a set of two planets, few states, computed sharply."""
    document = planetary_document(planets={"count": 2}, **{"sun": SUN, **changes})
    document["run"]["tolerance"] = 1e-11
    return gp.load_case(document)


def test_the_common_period_is_the_mesh_period() -> None:
    case = small()
    assert common_period(pack(case)) == pytest.approx(1.0 / mesh_frequency(case), rel=1e-12)
    assert common_period(pack(small(pin_errors=[{"planet": 1, "tangential": 5e-5}]))) == common_period(
        pack(case)
    )
    turn = 2.0 * math.pi / nominal_speeds(case)[2]
    heavy = gp.replace(case, {"gravity": [0.0, -9.81]})
    assert common_period(pack(heavy)) == pytest.approx(turn, rel=1e-9)
    uneven = small(sun={"floating": False, "support": {"stiffness": [1e8, 2e8]}})
    assert common_period(pack(uneven)) == pytest.approx(turn, rel=1e-9)
    assert (
        common_period(pack(small(sun={"floating": False, "support": {"stiffness": [1e8, 1e8]}})))
        < 0.02 * turn
    )
    runout = common_period(
        pack(small(sun={**SUN, "runout": {"amplitude": 1e-6}}))
    )  # 20 meshes a turn of the sun beside it
    assert runout == pytest.approx(20.0 / mesh_frequency(case), rel=1e-9)


@pytest.mark.slow
def test_a_settled_set_repeats_beside_its_carrier(measured: Measured) -> None:
    case = small()
    flow = Flow(case)
    period, course = common_period(flow.packed), flow.begin(flow.start())
    course.advance(400 * period)
    first = flow.seen(course.time, course.state)
    course.advance(403 * period)
    second = flow.seen(course.time, course.state)
    size = flow.natural[flow.free]
    measured("three mesh periods later", float(np.max(np.abs(second - first) / size)), "natural sizes")
    assert np.max(np.abs(second - first) / size) < 1e-6
    moved = np.abs(course.state - flow.start())[flow.free] / size
    assert np.max(moved) > 100.0  # in fixed axes the planets have gone round


@pytest.mark.slow
def test_the_derivative_of_the_map_is_that_of_differences() -> None:
    case = small()
    family = StrobeMap(lambda _: case, 0.0)
    state = family.settle(family.start(0.0), 0.0, 50)
    image = family(state, 0.0)
    for at in range(0, state.size, 3):
        step = 1e-4 * family.scale[at]
        ahead, behind = state.copy(), state.copy()
        ahead[at] += step
        behind[at] -= step
        slope = (family(ahead, 0.0).state - family(behind, 0.0).state) / (2.0 * step)
        error = np.abs(slope - image.matrix[:, at]) * family.scale[at] / family.scale
        assert np.max(error) < 1e-4


@pytest.mark.slow
def test_a_branch_starts_on_a_resonance_and_keeps_the_load() -> None:
    held = {
        "floating": False,
        "support": {"stiffness": [1e8, 1e8]},
    }  # between two planets it would fall to one side
    case = small(carrier={"load": {"torque": 40.0, "drag": 0.5}}, sun=held)
    path = "planetary.stage.sun.drive.speed"
    found = gp.frequency_response(
        case, force="stage.sun-stage.planet1.transmission_error", at="stage.carrier.theta",
        frequencies=np.linspace(200.0, 3000.0, 400),
    )  # fmt: skip
    speed = resonant_value(case, path, found)
    resonance = found.resonances["stage.carrier.theta"]
    assert mesh_frequency(gp.replace(case, {path: speed})) == pytest.approx(resonance, rel=1e-9)
    kept, plain = along(case, path, keep_load=True)(speed), along(case, path)(speed)
    carriers = [nominal_speeds(each)[2] for each in (case, plain)]
    assert kept.rotors["stage.carrier"].drive.torque == pytest.approx(0.5 * (carriers[1] - carriers[0]))
    shares = [gp.load_sharing(each).ds["sun_force"].values.sum() for each in (case, kept, plain)]
    assert shares[1] == pytest.approx(shares[0], rel=1e-6)
    assert shares[2] > 1.2 * shares[0]
    branch = gp.branch(
        case, path, 0.9 * speed, 1.1 * speed, start=found, keep_load=True, settle=100, orbits=3
    )
    assert branch.parameters[0] == pytest.approx(speed)
    with pytest.raises(gp.InputError, match="must be the speed of a drive"):
        gp.branch(case, "planetary.stage.carrier.load.torque", 10.0, 50.0, start=found)
