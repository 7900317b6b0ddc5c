"""The reference's friction of the teeth: where it acts, what it takes, and its mean force in closed form.

Steady rolling on fixed centres under a load torque T on the driven gear 2 of base radius r; p = pi m cos(alpha)
is the base pitch, x from -p/2 to p/2 the contact's way along the line of action since the pitch point, x_T the
place of the driven gear's tangent point there.  With l = sign(omega_2 (omega_2 - omega_1)) (+1: external pairs,
and a ring that drives; -1: a pinion that drives a ring) the torques on the driven gear balance where

    T = F (r + mu l sign(x) (x_T - x)).

The part with x_T is odd in x, so the mean lever arm over a mesh period is r - l mu p / 4.  A force that stays
constant, as where the mesh vibrates slowly against the mesh frequency, is therefore

    F = T / (r - l mu p / 4).

A mesh that follows without delay carries the mean of T over the lever arm instead: more by about
T / r (mu x_T / r)^2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cross.reference import Reference
from cross.reference_friction import ToothFriction
from cross.test_reference_self import ALPHA, momenta, pair_case

MU = 0.2
MODULE = 4e-3
BASE = 0.5 * MODULE * math.cos(ALPHA)  # m, base radius of one tooth
PITCH = 2.0 * math.pi * BASE
PAIRS = pytest.mark.parametrize(
    ("inner", "ring_drives"), [(False, False), (False, True), (True, False), (True, True)]
)


def rubbing(inner: bool, wheel_drives: bool, **mesh: Any) -> dict[str, Any]:
    """Return the free undamped pair 20/60 with friction of its teeth; each gear may be the driver."""
    case = pair_case(inner)
    case["meshes"][0] |= {"friction_coefficient": MU, "friction_phase": 0.4, **mesh}
    if wheel_drives:
        case["meshes"][0] |= {"driver": "wheel", "driven": "pinion"}
        case["rotors"]["wheel"]["initial"][
            "theta"
        ] *= -1.0  # in the gap too, as the flanks change their names
    return case


def acting(reference: Reference, t: float, state: np.ndarray) -> dict[str, Any]:
    """Return what the reference takes for the first mesh in a state, its branches chosen by the state."""
    reference.signs = {}
    reference._refresh(t, state)
    z, mesh = state.tolist(), reference.meshes[0]
    motion = reference._mesh_motion(mesh, t, z)
    normal = reference._mesh_forces(0, motion)
    bodies = {"a": reference.body(mesh.a, t, z), "b": reference.body(mesh.b, t, z)}
    centres = {
        name: np.add(reference.rotors[i].position, (bodies[name].x, bodies[name].y))
        for name, i in (("a", mesh.a), ("b", mesh.b))
    }
    return {
        "motion": motion,
        "normal": normal,
        "bodies": bodies,
        "centres": centres,
        "pitch": np.array(reference._pitch_point(mesh, motion, z)),
        "frictions": [(np.array(p), np.array(f)) for p, f in reference.tooth_frictions(0, z, motion, normal)],
    }


def speed_at(now: dict[str, Any], name: str, point: np.ndarray) -> np.ndarray:
    """Return the velocity of a body's material at a point [m/s]."""
    body, (rx, ry) = now["bodies"][name], point - now["centres"][name]
    return np.array([body.vx - body.omega * ry, body.vy + body.omega * rx])


def pressed_and_rolling(
    rng: np.random.Generator, reference: Reference, back: bool, speed: float
) -> np.ndarray:
    """Return a state with centres at rest beside their places, gears that roll, and one flank pressed."""
    state = reference.initial_state()
    n, mesh = reference.n, reference.meshes[0]
    driver, driven = mesh.driver, mesh.a + mesh.b - mesh.driver
    state[3 * n :] = 0.0
    state[:2], state[3:5] = rng.uniform(-4e-5, 4e-5, (2, 2))
    state[3 * driver + 2] = rng.uniform(-3.0, 3.0)
    rho = {mesh.a: mesh.rho_a, mesh.b: mesh.rho_b}
    state[3 * driven + 2] = -state[3 * driver + 2] * rho[driver] / rho[driven]
    state[3 * n + 3 * driver + 2] = speed
    state[3 * n + 3 * driven + 2] = -speed * rho[driver] / rho[driven]
    motion = reference._mesh_motion(mesh, 0.0, state.tolist())
    miss = 2e-6 - (motion.p_b if back else motion.p_d)
    state[3 * driven + 2] += (-1.0 if back else 1.0) * miss / (mesh.sigma * rho[driven])
    return state


# ---------------------------------------------------------------------- where and how it acts


@PAIRS
@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("speed", [40.0, -40.0, 0.1])
def test_friction_acts_on_the_line_of_action_and_takes_what_slides(
    inner: bool, ring_drives: bool, back: bool, speed: float
) -> None:
    """Power -mu F |s|, smoothed, with s = (omega_b - omega_a) x of rolling gears; the contact goes with both flanks."""
    rng = np.random.default_rng([1, inner, ring_drives, back])
    reference = Reference(rubbing(inner, ring_drives, friction_speed=5e-3))
    mesh = reference.meshes[0]
    sides = set()
    for _ in range(30):
        state = pressed_and_rolling(rng, reference, back, speed)
        now = acting(reference, 0.0, state)
        force = now["normal"][1 if back else 0]
        assert force == pytest.approx(100.0, rel=1e-6)
        assert now["normal"][0 if back else 1] == 0.0
        ((point, friction),) = now["frictions"]
        nu = np.array(now["motion"].grad_b if back else now["motion"].grad_d)
        assert np.hypot(*nu) == pytest.approx(1.0, rel=1e-12)
        for name, rho in (("a", mesh.rho_a), ("b", mesh.rho_b)):  # the line touches both base circles
            arm = point - now["centres"][name]
            assert abs(arm[0] * nu[1] - arm[1] * nu[0]) == pytest.approx(abs(rho), rel=1e-10)
        x = float(np.hypot(*(point - now["pitch"])))
        assert x <= 0.5 * PITCH * (1.0 + 1e-12)
        assert friction @ nu == pytest.approx(0.0, abs=1e-12)
        turn = now["bodies"]["b"].omega - now["bodies"]["a"].omega
        u = abs(turn) * x / 5e-3
        smooth = 1.0 if u >= 1.0 else 1.5 * u - 0.5 * u**3
        sliding = speed_at(now, "b", point) - speed_at(now, "a", point)
        assert friction @ sliding == pytest.approx(-MU * force * x * abs(turn) * smooth, rel=1e-9, abs=1e-16)
        assert np.hypot(*friction) == pytest.approx(MU * force * smooth, rel=1e-12)
        sides.add(np.sign(-(point - now["pitch"]) @ nu))
        # The contact goes along the normal as fast as the flanks that make it do.
        later = state.copy()
        later[3 * mesh.driver + 2] += 1e-7
        shift = acting(reference, 0.0, later)["frictions"]
        gone = (shift[0][0] - point) @ nu / 1e-7 * now["bodies"]["ab"[mesh.driver == mesh.b]].omega
        for name in "ab":
            assert gone == pytest.approx(speed_at(now, name, point) @ nu, rel=1e-5)
    assert sides == {-1.0, 1.0}


def test_pairs_of_teeth_hand_over_half_a_pitch_behind_the_pitch_point() -> None:
    friction = ToothFriction(0.1, 0.3, 1e-3, 2e-3)
    for y in np.random.default_rng(5).uniform(-40.0, 40.0, 200):
        pair = math.floor(y / (2.0 * math.pi) + 0.5)
        parity = 1.0 if friction.wave(y - 0.3) >= 0.0 else -1.0
        assert parity == (-1.0) ** pair
        assert friction.wrapped(y - 0.3, parity) == pytest.approx(y - 2.0 * math.pi * pair, abs=1e-12)


# ---------------------------------------------------------------------- free pairs


@pytest.mark.slow
@PAIRS
@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_a_free_pair_keeps_its_momentum_and_loses_energy(inner: bool, ring_drives: bool, model: str) -> None:
    """Linear and angular momentum stay; the energy falls at the power of friction and by nothing else."""
    case = rubbing(inner, ring_drives) | {"backlash_model": model}
    sign = 1.0 if inner else -1.0
    case["rotors"]["pinion"]["initial"] |= {"omega": 61.3}
    case["rotors"]["wheel"]["initial"] |= {"omega": sign * 20.0}
    for rotor in case["rotors"].values():
        rotor["initial"] |= {"vx": 0.0, "vy": 0.0}
    if model == "coupled":
        case["rotors"]["pinion"]["runout"] = {"amplitude": 1e-5, "phase": 0.7}
    reference = Reference(case)
    motion = reference.trajectory(np.linspace(0.0, 0.01, 401))
    moments = np.array([momenta(reference, y, t) for t, y in zip(motion["t"], motion["state"], strict=True)])
    which = slice(None) if model == "coupled" else slice(2)  # normals of fixed direction give a torque
    assert np.ptp(moments[:, which], axis=0).max() < 1e-12
    energies = np.array([reference.energy(y, t) for t, y in zip(motion["t"], motion["state"], strict=True)])
    assert energies[-1] < energies[0] * (1.0 - 1e-5)
    pressed = 0
    for t, y in zip(motion["t"], motion["state"], strict=True):
        now = acting(reference, float(t), y)
        if not now["frictions"]:
            continue
        pressed += 1
        ((point, force),) = now["frictions"]
        power = force @ (speed_at(now, "b", point) - speed_at(now, "a", point))
        assert power <= 0.0
        rate, h = np.array(reference._right_hand_side(float(t), y)), 1e-8
        gained = reference.energy(y + h * rate, t + h) - reference.energy(y - h * rate, t - h)
        assert gained / (2.0 * h) == pytest.approx(power, rel=1e-4, abs=1e-4)
    assert pressed >= 5
    assert {key[2] for _, key, _ in reference.events} <= {"drive", "back", "parity", "above", "below"}


# ---------------------------------------------------------------------- steady rolling


def loaded(
    inner: bool, ring_drives: bool, torque: float, ratio: float
) -> tuple[dict[str, Any], float, float]:
    """Return a case of steady rolling, the driven base radius and l of this module's docstring.

    ``ratio`` is the natural frequency over the mesh frequency; the damping is half the critical one.
    """
    driver, driven = ("wheel", "pinion") if ring_drives else ("pinion", "wheel")
    case = rubbing(inner, ring_drives)
    teeth = {"pinion": 20, "wheel": 60}
    for rotor in case["rotors"].values():
        del rotor["initial"], rotor["floating"]
    rate, radius = 12000.0, BASE * teeth[driven]  # rad/s of the mesh phase
    mass = case["rotors"][driven]["inertia"] / radius**2
    mean = mass * (ratio * rate) ** 2
    case["meshes"][0]["stiffness"]["mean"] = mean
    case["meshes"][0]["damping"] = {"maximum": mass * ratio * rate, "depth": 1e-9}
    case["rotors"][driver]["drive"] = {"kind": "speed", "speed": rate / teeth[driver]}
    sense = -1.0 if inner and not ring_drives else 1.0
    force = torque / (radius - sense * MU * PITCH / 4.0)
    # The load opposes the driven gear's turning, which lags by the penetration.
    way = 1.0 if inner else -1.0
    case["rotors"][driven] |= {
        "load": {"torque": torque},
        "initial": {"theta": -way * force / mean / radius},
    }
    return case, radius, sense


def mean_force(case: dict[str, Any], first: int, samples: int) -> float:
    """Return the mean normal force over the mesh period after so many [N]."""
    reference = Reference(case)
    period = 2.0 * math.pi / 12000.0
    times = period * (first + (np.arange(samples) + 0.5) / samples)
    motion = reference.trajectory(times)
    meshes = [reference.forces(t, y)["mesh"] for t, y in zip(times, motion["state"], strict=True)]
    forces = [next(iter(mesh.values())) for mesh in meshes]
    assert all(each["F_d"] > 0.0 and each["F_b"] == 0.0 for each in forces)
    changes = [t for t, key, _ in reference.events if key == ("mesh", 0, "parity")]
    k = np.arange(1, len(changes) + 1)
    np.testing.assert_allclose(changes, (math.pi * (2 * k - 1) - 0.4) / 12000.0, rtol=1e-12)
    assert len(changes) in (first, first + 1)
    return float(np.mean([each["F_d"] for each in forces]))


@pytest.mark.slow
@PAIRS
def test_a_slowly_vibrating_mesh_carries_the_load_over_the_mean_lever_arm(
    inner: bool, ring_drives: bool
) -> None:
    """Friction shakes the mesh by some mm/s and so moves the zero of sliding off the pitch point: 1e-4 of the force."""
    case, radius, sense = loaded(inner, ring_drives, 5.0, 1.0 / 15.0)
    expected = 5.0 / (radius - sense * MU * PITCH / 4.0)
    assert abs(expected * radius / 5.0 - 1.0) > 5e-3  # what friction changes
    assert mean_force(case, 40, 100) == pytest.approx(expected, rel=1.5e-4)


@pytest.mark.slow
@PAIRS
def test_a_stiff_mesh_carries_the_mean_of_the_load_over_the_lever_arm(inner: bool, ring_drives: bool) -> None:
    case, radius, sense = loaded(inner, ring_drives, 5.0, 60.0)
    x = PITCH * ((np.arange(4000) + 0.5) / 4000 - 0.5)
    tangent = sense * radius * math.tan(ALPHA)
    lever = radius + sense * MU * np.sign(x) * (tangent - x)
    expected = 5.0 * float(np.mean(1.0 / lever))
    assert expected * (radius - sense * MU * PITCH / 4.0) > 5.0 * 1.004
    assert mean_force(case, 3, 400) == pytest.approx(expected, rel=4e-4)


def test_the_published_formulation_has_no_friction() -> None:
    with pytest.raises(ValueError, match="no friction"):
        Reference(rubbing(False, False) | {"formulation": "as_published"})
