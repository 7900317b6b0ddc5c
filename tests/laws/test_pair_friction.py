"""Friction of single pairs of teeth: sliding at the contact, moments at one state, loss of a loaded pair, energy."""

import math
from typing import Any

import numpy as np
import pytest

from building import Document, Floats, Measured, case_of, merged, simulate_one
from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import FORCE, LOADED, PENETRATION, Loads
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.pairs.friction import SLIDING, sliding_arms
from gearplay.parts.mesh.pairs.overlap import ON_FLANK, TIP_OF_1, TIP_OF_2
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.parts.registry import MESH
from gearplay.toothing.load_sharing import static_sharing
from gearplay.toothing.path_stiffness import path_stiffness
from tooth_pairs import document_of, pairs_at, placed

MU = 0.1


def rubbing(ring: bool, **mesh: Any) -> Document:
    """Return an external or internal pair with friction."""
    document = document_of(4e-3, (20, 60), (0.0, 0.3 if ring else 0.0), ring, 1e-4, 0.01)
    document["meshes"][0] |= {"friction_coefficient": MU, "friction_speed": 1e-3, **mesh}
    return document


def pressed(packed: Packed, y: Floats) -> Loads:
    """Return the loads of the mesh alone at a state, every overlapping contact loaded."""
    loads, branch = make_loads(packed.system), make_branch(packed.system)
    assert dispatch.contact_kinematics(packed.system, 0, 0.0, y, branch, loads) == 0
    touching = loads.contacts[:, PENETRATION] > 0.0
    branch.modes[: touching.size] = np.where(touching, LOADED, 0)
    acting = np.array([1, 0], dtype=np.int64)
    assert dispatch.apply_forces(packed.system, acting, 0.0, y, branch, loads, np.zeros(y.size)) == 0
    return loads


def turning(packed: Packed, y: Floats, spins: tuple[float, float]) -> Floats:
    """Return a state with speeds of both rotors [rad/s]."""
    moving = y.copy()
    moving[8], moving[11] = spins
    return moving


@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
def test_sliding__is_that_of_the_place_on_the_path(ring: bool) -> None:
    """|omega_1 -+ omega_2| times the way from the pitch point, with its sign; 0 there."""
    case = case_of(rubbing(ring))
    packed, pair = pack(case), pair_of(case, 0)
    (mesh,) = packed.system.records[MESH]
    way = 1.0 if ring else -1.0
    spins = 30.0, way * 30.0 * 20.0 / 60.0
    for share in (0.05, 0.3, 0.6, 0.95):
        place = pair.path.start + share * pair.path.length
        y = turning(packed, placed(packed, place, 1e-9), spins)
        found = [(each, 2 + k) for k, each in enumerate(pairs_at(packed, y)) if each.touching == ON_FLANK]
        assert found
        table = pressed(packed, y).contacts
        for each, k in found:
            expected = (spins[0] - spins[1]) * (each.rho_1 - pair.pitch_place)
            assert table[k, SLIDING] == pytest.approx(float(mesh.sigma) * expected, rel=1e-4, abs=1e-7)


@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
def test_arms_of_corners__are_those_of_the_tip_s_point(ring: bool) -> None:
    """Of the flank that it touches the arm is the tip's way from the base tangent point, found apart in the gap."""
    case = case_of(rubbing(ring))
    packed, pair = pack(case), pair_of(case, 0)
    (mesh,) = packed.system.records[MESH]
    seen = set()
    for at in (-0.3, -0.1, 0.1, 0.3):
        place = (pair.path.start if at < 0.0 else pair.path.end) + at * pair.first.base_pitch
        y = placed(packed, place, 0.0)
        for each in pairs_at(packed, y):
            if each.touching not in (TIP_OF_1, TIP_OF_2):
                continue
            seen.add(each.touching)
            arms = sliding_arms(
                mesh.s, pair.distance, mesh.tip_1, mesh.tip_2, each.touching, each.by_a, each.p_1, each.p_2, each.rho_1
            )  # fmt: skip
            own = arms[1] if each.touching == TIP_OF_2 else -mesh.s * arms[2]
            assert own == pytest.approx(each.length, rel=1e-9)
    assert TIP_OF_1 in seen
    assert ring or TIP_OF_2 in seen


@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
def test_moments__are_those_of_normal_force_and_friction(ring: bool) -> None:
    """Sum of F_j (r_b + mu sign(s_j) rho_j) on either gear; none at rest."""
    case = case_of(rubbing(ring))
    packed, pair = pack(case), pair_of(case, 0)
    (mesh,) = packed.system.records[MESH]
    y = placed(packed, pair.path.start + 0.2 * pair.path.length, 2e-5)
    still = pressed(packed, y)
    without = pressed(
        pack(
            case_of(merged(rubbing(ring), {"meshes": [rubbing(ring, friction_coefficient=0.0)["meshes"][0]]}))
        ),
        y,
    )
    assert np.array_equal(still.rotors, without.rotors)
    way = 1.0 if ring else -1.0
    moving = turning(packed, y, (30.0, way * 10.0))
    loads = pressed(packed, moving)
    moments = np.zeros(2)
    carrying = 0
    for k, each in enumerate(pairs_at(packed, moving)):
        force, sliding = loads.contacts[2 + k, FORCE], loads.contacts[2 + k, SLIDING]
        if force == 0.0:
            continue
        carrying += 1
        assert abs(sliding) > 1e-3
        grip = MU * math.copysign(1.0, sliding)
        moments[0] -= mesh.sigma * force * (mesh.base_1 + grip * each.rho_1)
        moments[1] -= mesh.sigma * force * (-mesh.s * mesh.base_2 - mesh.s * grip * each.rho_2)
    assert carrying == 2
    assert loads.rotors[:, 2] == pytest.approx(moments, rel=2e-4)
    assert abs(loads.rotors[0, 2] / still.rotors[0, 2] - 1.0) > 1e-3
    assert loads.rotors[0, :2] == pytest.approx(-loads.rotors[1, :2], rel=1e-12)


def test_loss__is_that_of_load_sharing_and_sliding(measured: Measured) -> None:
    """A slow pair under load: mu times the mean of sum F_j |s_j|, load sharing at rest found apart; near Ohlendorf's H_v."""
    torque, omega, mu = 100.0, 10.0, 0.01
    document = rubbing(False, friction_coefficient=mu, damping={"ratio": 0.3})
    document["rotors"]["one"] |= {"drive": {"kind": "speed", "speed": omega}}
    document["rotors"]["two"] |= {"load": {"torque": torque}}
    period = 2.0 * math.pi / (20.0 * omega)
    document["run"] = {"transient": period, "duration": period, "sampling": 800.0 / period, "tolerance": 1e-8}
    run = simulate_one(document)
    loss = float(np.mean(run.signal("mesh_power_loss", "one-two")[:800]))
    pair = pair_of(case_of(document), 0)
    force = torque / pair.second.base_radius
    phases = (np.arange(400) + 0.5) / 400.0
    stiffness = path_stiffness(pair, "iso6336", 206e9, 0.3, math.inf)
    _, forces, numbers = static_sharing(stiffness, force, phases)
    ways = (phases[:, None] + numbers) * pair.first.base_pitch
    expected = mu * omega * (1.0 + 20.0 / 60.0) * float(np.mean(np.sum(forces * np.abs(ways), axis=1)))
    measured(
        "friction of pairs of teeth: mean loss against load sharing at rest", loss / expected - 1.0, "1e-2"
    )
    assert loss == pytest.approx(expected, rel=1e-2)
    half = [
        (pair.pitch_place - pair.path.start) / pair.first.base_pitch,
        (pair.path.end - pair.pitch_place) / pair.first.base_pitch,
    ]
    factor = math.pi * (1.0 + 20.0 / 60.0) / 20.0 * (1.0 - sum(half) + half[0] ** 2 + half[1] ** 2)
    assert loss / (torque * omega * 20.0 / 60.0) == pytest.approx(mu * factor, rel=0.05)
