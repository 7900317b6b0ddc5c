"""What the reference knows of supports and couplings, against closed forms and conservation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from cross.discs import INERTIA, MASS, TIMES, decayed, disc, energies, moments, pair_of
from cross.reference import Reference
from cross.riding import ridden

# ---------------------------------------------------------------------- supports


def test_a_support_swings_in_both_axes_and_in_torsion() -> None:
    support = {
        "stiffness": [1e6, 3e6],
        "damping": [100.0, 0.0],
        "torsional_stiffness": 300.0,
        "torsional_damping": 0.2,
    }
    case = disc(support=support, initial={"x": 1e-5, "y": -2e-5, "theta": 0.01})
    motion = Reference(case).trajectory(TIMES)
    x = decayed(TIMES, math.sqrt(1e6 / MASS), 50.0 / MASS, 1e-5)
    theta = decayed(TIMES, math.sqrt(300.0 / INERTIA), 0.1 / INERTIA, 0.01)
    np.testing.assert_allclose(motion["x"][:, 0], x, atol=1e-16)
    np.testing.assert_allclose(motion["y"][:, 0], -2e-5 * np.cos(math.sqrt(3e6 / MASS) * TIMES), atol=1e-16)
    np.testing.assert_allclose(motion["theta"][:, 0], theta, atol=1e-13)


def test_torsional_keys_alone_free_no_centre() -> None:
    case = disc(support={"torsional_stiffness": 5.0}, initial={"x": 1e-5}, gravity=[0.0, -9.81])
    assert not Reference(case).trajectory([0.0, 0.01])["x"].any()


def test_a_support_adds_to_a_sleeve() -> None:
    """The journal lies 2 um deep in its bush: both forces at once."""
    sleeve = {
        "radial_clearance": 1e-5,
        "law": "lankarani-nikravesh",
        "stiffness": 1e10,
        "restitution": 1.0,
        "minimum_impact_speed": 1e-4,
    }
    case = disc(support={"stiffness": [1e6, 1e6]}, initial={"x": 1.2e-5}) | {"sleeves": {"disc": sleeve}}
    found = Reference(case).trajectory([0.0])["ax"][0, 0]
    assert found == pytest.approx(-(12.0 + 1e10 * 2e-6**1.5) / MASS, rel=1e-9)


def on_a_carrier(damping: float, *, unbalance: float = 0.0) -> dict[str, Any]:
    """Return a turning, floating arm with a disc on a skew elastic pin."""
    arm = {"floating": True, "initial": {"omega": 20.0, "vx": 0.01, "theta": 0.3}}
    planet = {"position": [0.03, 0.02], "initial": {"x": 1e-3, "vy": 0.5, "omega": 5.0, "theta": 0.4}}
    planet["unbalance"] = {"amount": unbalance, "phase": 0.7}
    support = {
        "stiffness": [2e4, 7e4],
        "damping": [damping, 3.0 * damping],
        "torsional_stiffness": 10.0,
        "torsional_damping": 1e-4 * damping,
        "on": "one",
    }
    return ridden(pair_of(arm, planet, supports={"two": support}))


@pytest.mark.slow
@pytest.mark.parametrize("unbalance", [0.0, 5e-3])
@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_a_support_on_a_carrier_keeps_momentum(damping: float, unbalance: float) -> None:
    reference = Reference(on_a_carrier(damping, unbalance=unbalance))
    motion = reference.trajectory(TIMES)
    total, energy = moments(reference, motion), energies(reference, motion)
    np.testing.assert_allclose(total, np.broadcast_to(total[0], total.shape), atol=1e-12, rtol=0.0)
    if damping:
        assert np.all(np.diff(energy) < 0.0)
    else:
        assert np.ptp(energy) < 1e-11 * energy[0]


def test_a_support_turns_with_its_carrier() -> None:
    """At a quarter turn of the arm its x axis points along y; the velocity of being carried is not damped."""
    support = {"stiffness": [1e4, 5e4], "damping": [10.0, 20.0], "on": "one"}
    arm = {"drive": {"kind": "speed", "speed": 100.0}}
    planet = {"position": [0.03, 0.0], "initial": {"x": 0.0, "y": 0.0}}
    reference = Reference(pair_of(arm, planet, supports={"two": support}))
    t = 0.5 * math.pi / 100.0
    state = reference.start()
    state[3:5] = -0.03, 0.03 + 1e-3  # carried to the y axis, and 1 mm along it
    state[9:11] = -100.0 * (0.03 + 1e-3), 0.5  # carried on, and 0.5 m/s along the turned x axis
    found = np.array(reference._right_hand_side(t, state)[9:11])
    np.testing.assert_allclose(found, [0.0, -(1e4 * 1e-3 + 10.0 * 0.5) / 0.5], atol=1e-9)


def test_forces_of_supports_and_couplings_are_gradients() -> None:
    """Mass times acceleration is -dU/dq, by differences of the energy, with everything undamped."""
    case = on_a_carrier(0.0)
    lateral = {"lateral_stiffness": 3e5, "torsional_stiffness": 40.0, "play": 1e-3}
    case["couplings"] = [{"between": ["one", "two"], **lateral}]
    case["rotors"]["two"]["position"] = [0.0, 0.0]
    reference = Reference(case)
    state = reference.start()
    state[[0, 1, 3, 4]] = 2e-3, 1e-3, -1e-3, 3e-3
    state[6:] = 0.0
    reference._refresh(0.0, state)
    found = np.array(reference._right_hand_side(0.0, state)[6:12])
    found *= [MASS, MASS, INERTIA, 0.5, 0.5, 3.0 * INERTIA]
    expected = []
    for j in range(6):
        step = np.zeros(12)
        step[j] = 1e-6
        expected.append(-(reference.energy(state + step, 0.0) - reference.energy(state - step, 0.0)) / 2e-6)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * np.abs(found).max())


# ---------------------------------------------------------------------- couplings


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, -2.0])
def test_coupled_inertias_swing_with_the_twist(ratio: float) -> None:
    coupling = {"between": ["one", "two"], "torsional_stiffness": 500.0, "ratio": ratio}
    reference = Reference(pair_of({"initial": {"theta": 1e-3}}, {}, couplings=[coupling]))
    motion = reference.trajectory(TIMES)
    rate = math.sqrt(500.0 * (1.0 / INERTIA + ratio**2 / (3.0 * INERTIA)))
    twist = motion["theta"][:, 0] - ratio * motion["theta"][:, 1]
    np.testing.assert_allclose(twist, 1e-3 * np.cos(rate * TIMES), atol=1e-14)


@pytest.mark.slow
def test_play_and_its_damping() -> None:
    """Free flight through the play; a damped end hits with c dp/dt at once and never pulls."""
    coupling = {
        "between": ["one", "two"],
        "torsional_stiffness": 500.0,
        "play": 4e-3,
        "torsional_damping": 0.3,
    }
    reference = Reference(pair_of({"initial": {"omega": 2.0}}, {}, couplings=[coupling]))
    motion = reference.trajectory([5e-4, 1.5e-3])
    assert motion["theta"][0, 0] == pytest.approx(1e-3, rel=1e-13)
    assert reference.events[0][0] == pytest.approx(1e-3, rel=1e-12)
    names = [(key[2], sign) for _, key, sign in reference.events]
    assert names[0] == ("forward", 1.0)
    reference.trajectory([0.02])
    names = [(key[2], sign) for _, key, sign in reference.events]
    assert names[:3] == [("forward", 1.0), ("push forward", -1.0), ("forward", -1.0)]
    # in contact p'' = -(k p + c p') / J_eff
    inertia = 0.75 * INERTIA
    matrix = np.array([[0.0, 1.0], [-500.0 / inertia, -0.3 / inertia]])
    depth = expm(5e-4 * matrix) @ [0.0, 2.0]
    assert motion["theta"][1, 0] - motion["theta"][1, 1] == pytest.approx(2e-3 + depth[0], rel=1e-11)


@pytest.mark.slow
def test_the_lateral_part_joins_two_centres() -> None:
    lateral = {"lateral_stiffness": 1e6, "lateral_damping": 50.0, "torsional_stiffness": 1.0}
    free = {"floating": True, "initial": {"x": 1e-5, "y": 2e-5}}
    case = pair_of(free, {"floating": True}, couplings=[{"between": ["one", "two"], **lateral}])
    reference = Reference(case)
    motion = reference.trajectory(TIMES)
    mass = MASS * 0.5 / (MASS + 0.5)
    gap = decayed(TIMES, math.sqrt(1e6 / mass), 25.0 / mass, 1e-5)
    np.testing.assert_allclose(motion["x"][:, 0] - motion["x"][:, 1], gap, atol=1e-16)
    np.testing.assert_allclose(motion["y"][:, 0] - motion["y"][:, 1], 2.0 * gap, atol=1e-16)
    assert np.abs(moments(reference, motion)[:, :2]).max() < 1e-15
    case["rotors"]["two"]["floating"] = False  # it frees no centre
    assert not Reference(case).trajectory(TIMES)["x"][:, 1].any()


def test_nominal_speeds_pass_couplings_and_stop_at_springs() -> None:
    coupling = {"between": ["one", "two"], "torsional_stiffness": 1.0, "ratio": -2.0, "play": 0.01}
    driven = {"drive": {"kind": "speed", "speed": 30.0}}
    speeds = [r.nominal_speed for r in Reference(pair_of(driven, {}, couplings=[coupling])).rotors]
    assert speeds == [30.0, -15.0]
    carried = {"two": {"torsional_stiffness": 2.0, "on": "one"}}
    assert [r.nominal_speed for r in Reference(pair_of(driven, {}, supports=carried)).rotors] == [30.0, 30.0]
    ground = {"two": {"torsional_stiffness": 2.0}}
    assert [r.nominal_speed for r in Reference(pair_of(driven, {}, supports=ground)).rotors] == [30.0, 0.0]
