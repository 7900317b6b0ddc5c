"""Couplings: against closed forms of the two-inertia system, and random ones for the tests of all elements."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from gearplay.kernels.elements import coupling
from gearplay.kernels.elements.table import COUPLING
from gearplay.model.pack import Packed
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import InputError

K, J_1, J_2 = 2e3, 2e-3, 5e-3  # N m/rad, kg m^2


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return two discs and a coupling, with or without play, of any ratio, with or without a lateral part."""
    damping = float(rng.choice([0.0, 0.05])) if damped else 0.0
    ratio = float(rng.choice([1.0, -2.0, 0.4]))
    lateral = {"lateral_stiffness": float(rng.uniform(1e4, 1e6)), "lateral_damping": 400.0 * damping}
    document = shafts(
        torsional_stiffness=float(rng.uniform(50.0, 500.0)),
        torsional_damping=damping,
        play=float(rng.choice([0.0, 4e-4, 2e-3])),
        ratio=ratio,
        **(lateral if ratio == 1.0 and rng.random() < 0.5 else {}),
    )
    for rotor in document["rotors"].values():
        rotor["floating"] = True
    if not plain:
        for rotor in document["rotors"].values():
            rotor["drive"] = {"kind": "torque", "torque": float(rng.uniform(-1.0, 1.0))}
    return document


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of all couplings."""
    total = 0.0
    for n, each in enumerate(packed.system.records[COUPLING]):
        phi, _ = coupling.twist(packed.system, n, 0.0, y)
        total += 0.5 * each.stiffness * max(abs(phi) - each.half_play, 0.0) ** 2
        apart = [y[3 * each.a + axis] - y[3 * each.b + axis] for axis in range(2)]
        total += 0.5 * each.lateral_stiffness * (apart[0] ** 2 + apart[1] ** 2)
    return total


def shafts(omega: tuple[float, float] = (0.0, 0.0), theta: float = 0.0, **fields: Any) -> Document:
    """Return two free discs and a coupling between them."""
    return {
        "rotors": {
            "one": {"mass": 1.0, "inertia": J_1, "initial": {"theta": theta, "omega": omega[0]}},
            "two": {"mass": 1.0, "inertia": J_2, "initial": {"theta": 0.0, "omega": omega[1]}},
        },
        "couplings": [{"between": ["one", "two"], "torsional_stiffness": K, **fields}],
        "run": {"duration": 0.05, "sampling": 1e5, "tolerance": 1e-12},
    }


@pytest.mark.compiled
@pytest.mark.parametrize("ratio", [1.0, -2.0])
def test_two_inertias_swing_at_their_natural_frequency(ratio: float, measured: Measured) -> None:
    """w^2 = k (1/J_1 + ratio^2/J_2), by the run to 1e-6 and by the slopes to 1e-9."""
    exact = math.sqrt(K * (1.0 / J_1 + ratio**2 / J_2))
    document = shafts(theta=1e-3, ratio=ratio)
    run = simulate_one(document)
    twist = run.signal("coupling_twist", "one-two")
    assert np.max(np.abs(twist - 1e-3 * np.cos(exact * run.time))) < 1e-9
    down = np.flatnonzero((twist[:-1] > 0.0) & (twist[1:] <= 0.0))
    crossings = run.time[down] + 1e-5 * twist[down] / (twist[down] - twist[down + 1])
    frequency = 2.0 * math.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    measured(f"natural frequency by run, ratio {ratio:g}", abs(frequency / exact - 1.0), "1e-6")
    assert frequency == pytest.approx(exact, rel=1e-6)
    flow = Flow(case_of(document))
    span = 1e-4
    changes = np.eye(flow.size)
    found = flow.go(np.zeros(flow.size), span, changes=changes)
    matrix = found.changes[:, :].T
    free = [2, 5, 8, 11]
    eigenvalues = np.linalg.eigvals(matrix[np.ix_(free, free)])
    by_slopes = np.max(np.abs(np.angle(eigenvalues))) / span
    measured(f"natural frequency by slopes, ratio {ratio:g}", abs(by_slopes / exact - 1.0), "1e-9")
    assert by_slopes == pytest.approx(exact, rel=1e-9)


def test_play_gives_free_motion_and_impacts_in_closed_form(measured: Measured) -> None:
    """Free within the play, then half a period of the spring: touch and release to 1e-9 s, the twist to 1e-9 rad."""
    play, speed = 2e-3, 4.0
    run = simulate_one(shafts(omega=(speed, 0.0), play=play))
    omega = math.sqrt(K * (1.0 / J_1 + 1.0 / J_2))
    flight, touch = play / speed, math.pi / omega
    times, end = [], 0.5 * flight
    while end < 0.05:
        times += [end, end + touch]
        end += touch + flight
    expected = np.array([t for t in times if t < 0.05])
    assert len(run.log) == len(expected) > 20
    worst = float(np.max(np.abs(run.log[:, 0] - expected)))
    measured("play: instants of touch and release [s]", worst, "1e-9")
    assert worst < 1e-9
    phase = (run.time - 0.5 * flight) % (2.0 * (touch + flight))
    inside = (run.time < 0.5 * flight) | ((phase % (touch + flight)) > touch)
    sign = np.where((phase < touch + flight), 1.0, -1.0)
    within = phase % (touch + flight)
    twist = np.where(
        run.time < 0.5 * flight,
        speed * run.time,
        sign
        * np.where(
            inside, 0.5 * play - speed * (within - touch), 0.5 * play + speed / omega * np.sin(omega * within)
        ),
    )
    difference = float(np.max(np.abs(run.signal("coupling_twist", "one-two") - twist)))
    measured("play: twist [rad]", difference, "1e-9")
    assert difference < 1e-9


def test_energy_and_momentum_are_kept_with_play() -> None:
    result = gp.simulate(case_of(shafts(omega=(4.0, -1.0), play=1e-3)))
    omega = result.ds.omega.values
    torque = result.ds.coupling_torque.values[:, 0]
    energy = 0.5 * (J_1 * omega[:, 0] ** 2 + J_2 * omega[:, 1] ** 2) + 0.5 * torque**2 / K
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-9
    momentum = J_1 * omega[:, 0] + J_2 * omega[:, 1]
    assert np.max(np.abs(momentum / momentum[0] - 1.0)) < 1e-9


def test_speeds_and_senses_pass_through_couplings() -> None:
    document = shafts(ratio=-2.0)
    document["rotors"]["one"] |= {"drive": {"kind": "speed", "speed": 10.0}, "initial": {}}
    document["rotors"]["two"]["initial"] = {}
    run = simulate_one(document)
    assert np.max(np.abs(run.signal("omega", "two") + 5.0)) < 1e-9
    assert np.max(np.abs(run.signal("coupling_torque", "one-two"))) < 1e-6


def test_a_rotor_behind_a_coupling_starts_unstrained() -> None:
    """A given rotation passes on, and flanks are put into touch with both ends turned."""
    document = shafts(theta=0.3)
    document["rotors"]["two"]["initial"] = {}
    assert Flow(case_of(document)).start()[5] == pytest.approx(0.3)


def test_two_rotors_on_one_axis_share_their_centre() -> None:
    document = shafts()
    document["rotors"]["one"]["position"], document["rotors"]["two"]["position"] = [0.0, 0.0], [0.01, 0.0]
    with pytest.raises(InputError, match=r"one axis.* or place it at \[0 mm, 0 mm\]"):
        gp.simulate(gp.load_case(document))
    document["rotors"]["two"]["position"] = [0.9e-7, 0.0]
    assert gp.simulate(gp.load_case(document), duration=1e-4).success
