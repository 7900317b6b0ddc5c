"""Damping of the teeth: closed forms of the constant law, ramps of any depth, default depth and damping ratio under load."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import (
    ALPHA,
    Document,
    case_of,
    floating_document,
    forum_pair,
    merged,
    pair_document,
    run_of,
    simulate_one,
)
from depth import some
from gearplay.integrate import restart, stepper
from gearplay.integrate import run as kernel
from gearplay.integrate.trial_step import attempt
from gearplay.model.check import check_case
from gearplay.model.pack import pack
from gearplay.parts.mesh.tooth_deflections import damping_depths
from gearplay.parts.mesh.tooth_loads import tooth_loads
from gearplay.parts.registry import MESH

BASE = 0.002 * math.cos(ALPHA)  # base radius per tooth [m]
J_1, J_2, K = 1.88e-4, 9.0e-3, 1.3e8  # kg m^2, N/m
MASS = 1.0 / ((20 * BASE) ** 2 / J_1 + (60 * BASE) ** 2 / J_2)  # kg, along the line of action


def impact(zeta: float, flank: int, **run: Any) -> Document:
    """Return an external pair on rigid centres whose flanks meet at 0.5 * 60 BASE [m/s], damped by a constant."""
    spin = -1.0 / 3.0 + (0.5 if flank == 0 else -0.5)
    document = merged(
        pair_document("external", mesh={"damping": {"ratio": zeta, "law": "constant"}}),
        {
            "rotors": {
                "pinion": {"initial": {"omega": 1.0, "theta": -5e-5 / (20 * BASE)}},
                "wheel": {"initial": {"omega": spin, "theta": 0.0}},
            },
            "run": {"duration": 4e-3, "tolerance": 1e-12, **run},
        },
    )
    document["sleeves"] = {}
    return document


@pytest.mark.parametrize("flank", [0, 1])
@pytest.mark.parametrize("zeta", [0.07, 0.5, 0.9])
def test_constant_damping_has_the_restitution_of_the_linear_oscillator(zeta: float, flank: int) -> None:
    """Force K p + C p' until it is 0, at t = 2 arccos(zeta) / w_d, where p' = -v e^(-zeta w t); then the teeth are free.

    So e = exp(-2 zeta arccos(zeta) / sqrt(1 - zeta^2)), and the flanks part C / K later, from p = C |p'| / K.
    """
    run = simulate_one(impact(zeta, flank), signals=["pinion.omega", "wheel.omega"])
    speed, omega = 0.5 * 60 * BASE, math.sqrt(K / MASS)
    damped = math.sqrt(1.0 - zeta**2)
    contact = 2.0 * math.acos(zeta) / (damped * omega)
    rebound = speed * math.exp(-zeta * omega * contact)
    onset, release = run.log[0], run.log[1]
    assert (onset[1], onset[2], release[1], release[2]) == (flank, 1.0, flank, 0.0)
    assert onset[3] == pytest.approx(speed, rel=1e-9)
    assert release[3] == pytest.approx(-rebound, rel=1e-8)
    assert release[0] - onset[0] == pytest.approx(contact + 2.0 * zeta / omega, rel=1e-8)
    parting = abs(run.values[:, 0] * 20 * BASE + run.values[:, 1] * 60 * BASE)
    assert parting[np.argmax(run.time > release[0])] == pytest.approx(rebound, rel=1e-8)


def test_constant_damping_jumps_at_a_touch_and_never_pulls() -> None:
    """F = C v at the first instant, then K p + C p' while that pushes, 0 behind it; the teeth lose what the rotors lose."""
    zeta = 0.5
    run = simulate_one(impact(zeta, 0, sampling=1e7, duration=1.2e-3), signals=None)
    label = "pinion-wheel"
    p, force = (run.signal(f"drive_{name}", label) for name in ("penetration", "force"))
    touching = np.flatnonzero(p > 0.0)
    omega, speed = math.sqrt(K / MASS), 0.5 * 60 * BASE
    C = 2.0 * zeta * math.sqrt(K * MASS)
    since = run.time[touching] - run.log[0, 0]
    damped = omega * math.sqrt(1.0 - zeta**2)
    exact_p = speed / damped * np.exp(-zeta * omega * since) * np.sin(damped * since)
    rate = speed * np.exp(-zeta * omega * since) * np.cos(damped * since) - zeta * omega * exact_p
    pushes = since < 2.0 * math.acos(zeta) / damped
    exact = np.where(pushes, K * exact_p + C * rate, 0.0)
    assert np.max(np.abs(force[touching] - exact)) < 1e-7 * C * speed
    assert np.count_nonzero(~pushes) > 100  # still in touch, without a force
    assert abs(force[touching[0]] - C * speed) < 2e-2 * C * speed
    spent = float(np.sum(run.signal("mesh_power_loss", label)) / 1e7)
    e = math.exp(-2.0 * zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
    assert spent == pytest.approx(0.5 * MASS * speed**2 * (1.0 - e**2), rel=1e-2)


STEEP = [
    (ratio, depth, tolerance)
    for ratio in (0.2, 1.0, 2.0)
    for depth in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
    for tolerance in (1e-4, 1e-6, 1e-9, 1e-12)
]


def test_steep_ramps_do_not_break_steps() -> None:
    """Ramps of 1 nm to 10 um at any tolerance; the centres are held, so nothing can go out of mesh."""
    for ratio, depth, tolerance in [*some(STEEP, 15), (0.2, 1e-8, 1e-9), (1.0, 1e-8, 1e-6)]:
        run = simulate_one(forum_pair({"ratio": ratio, "depth": depth}, tolerance=tolerance))
        assert run.success, (ratio, depth, tolerance, run.message)


def test_a_steep_ramp_is_the_constant_law() -> None:
    """Forces of ramps go to those of the constant law linearly with the depth: 1 nm within 0.1 N of 2011 N."""
    constant = simulate_one(forum_pair({"ratio": 0.2, "law": "constant"}, tolerance=1e-11)).signal(
        "drive_force", "g-p"
    )
    assert np.min(constant) == 0.0
    assert np.max(constant) == pytest.approx(2011.0918, abs=1e-3)
    ends = [
        np.max(
            simulate_one(forum_pair({"ratio": 0.2, "depth": d}, tolerance=1e-11)).signal("drive_force", "g-p")
        )
        for d in (1e-7, 1e-9)
    ]
    assert abs(ends[0] - np.max(constant)) < 0.1
    assert abs(ends[1] - np.max(constant)) < 0.05 * abs(ends[0] - np.max(constant))


@pytest.mark.parametrize(("ahead", "status"), [(1e-3, kernel.STEP_TOO_SMALL), (1e-9, kernel.CANNOT_MESH)])
def test_a_failed_step_names_its_cause(ahead: float, status: int) -> None:
    """A trial step that takes gears out of mesh is too long, unless the accepted motion leaves mesh right away."""
    document = floating_document("external")
    document["rotors"]["wheel"]["initial"] = {"vx": 20.0, "x": 8e-3 - ahead}
    case = case_of(document)
    packed = pack(case)
    run = run_of(case, packed)
    run.clock[kernel.T_END] = 1.0
    assert stepper.begin(packed.system, run) == kernel.DONE
    run.active_set.acting[:2] = 1, 0  # as if its flanks touched
    run.active_set.active[:3] = 2, 0, 1
    run.active_set.states[0] = 12
    run.active_set.states[1:13] = np.arange(12)
    run.active_set.body_states[:] = 1
    assert attempt(packed.system, run, 1e-3) == 1
    assert restart.failure(packed.system, run) == status


# -- the depth that is not given ---------------------------------------------------------------------------


def loaded_pair(load: float, damping: Document, inertia: float = 3e-4, **drive: Any) -> Document:
    """Return a pair 23/31 on held centres, driven at a speed or a torque, with a load torque [N m]."""
    return {
        "rotors": {
            "a": {
                "teeth": 23,
                "mass": 0.7,
                "inertia": inertia,
                "drive": drive or {"kind": "speed", "speed": 60.0},
            },
            "b": {"teeth": 31, "mass": 1.0, "inertia": 1.2e-3, "load": {"torque": load}},
        },
        "meshes": [
            {
                "driver": "a",
                "driven": "b",
                "module": 3e-3,
                "pressure_angle": ALPHA,
                "backlash": 1e-4,
                "stiffness": {"kind": "harmonic", "mean": 1e8},
                "damping": damping,
            }
        ],
        "run": {"duration": 2e-3, "sampling": 1e6},
    }


def test_the_default_depth_is_half_the_deflection_under_load() -> None:
    """F = T / r_b over 2 k_m; at least 0.01 um; 1 um without a load; a given depth stays."""
    radius = 0.5 * 31 * 3e-3 * math.cos(ALPHA)
    for load, depth in ((20.0, 20.0 / radius / 2e8), (1e-3, 1e-8), (0.0, 1e-6)):
        case = case_of(loaded_pair(load, {"ratio": 0.07}))
        assert damping_depths(case)[0] == pytest.approx(depth, rel=1e-9)
        assert pack(case).system.records[MESH][0].depth == damping_depths(case)[0]
    assert damping_depths(case_of(loaded_pair(20.0, {"ratio": 0.07, "depth": 3e-6})))[0] == 3e-6


def test_loads_of_a_train_that_accelerates() -> None:
    """A torque T on the first of two free gears presses J_2 r_1 T / (J_1 r_2^2 + J_2 r_1^2)."""
    case = case_of(loaded_pair(0.0, {"ratio": 0.07}, kind="torque", torque=2.0))
    r_1, r_2 = (0.5 * z * 3e-3 * math.cos(ALPHA) for z in (23, 31))
    expected = 1.2e-3 * r_1 * 2.0 / (3e-4 * r_2**2 + 1.2e-3 * r_1**2)
    assert tooth_loads(case)[0] == pytest.approx(expected, rel=1e-9)


def test_planets_share_the_load() -> None:
    """Every mesh of the bundled reducer carries what the torque of its load gives each of three planets."""
    case = gp.load_case("planetary-reducer").operating
    loads = tooth_loads(case)
    assert len(loads) == 6
    np.testing.assert_allclose(loads, loads[0], rtol=1e-9)
    run = gp.simulate(case)
    mean = run.ds.drive_force.mean("time").values
    assert np.mean(mean[:3]) == pytest.approx(loads[0], rel=0.02)


@pytest.mark.parametrize("inertia", [3e-5, 3e-4, 3e-3, 3.0])
def test_a_prescribed_rotation_counts_as_infinite_inertia(inertia: float) -> None:
    """The mode under load is damped by the ratio, whatever the inertia behind the prescribed rotation."""
    modes = gp.modes(case_of(loaded_pair(20.0, {"ratio": 0.07}, inertia)))
    assert float(modes.ds.damping_ratio[0]) == pytest.approx(0.07, rel=1e-6)


@pytest.mark.parametrize("law", [{}, {"law": "constant"}])
def test_the_ratio_is_delivered_at_light_load(law: Document) -> None:
    """At 0.05 N m, 0.01 um of deflection, both laws have the whole ratio; with a depth of 1 um next to nothing is left."""
    document = loaded_pair(0.05, {"ratio": 0.05, **law}, kind="torque", torque=0.05 * 23 / 31)
    assert float(gp.modes(case_of(document)).ds.damping_ratio[-1]) == pytest.approx(0.05, rel=1e-6)
    document["meshes"][0]["damping"] = {"ratio": 0.05, "depth": 1e-6}
    assert float(gp.modes(case_of(document)).ds.damping_ratio[-1]) < 1e-4


@pytest.mark.parametrize(
    ("load", "damping", "severity", "words"),
    [
        (20.0, {"ratio": 0.07}, "note", "the damping is full from 2.29 um on"),
        (
            20.0,
            {"ratio": 0.07, "depth": 1e-4},
            "warning",
            "a ratio of 0.00043, not 0.07. Leave damping.depth out",
        ),
        (20.0, {"maximum": 500.0, "depth": 1e-4}, "warning", "the damping is 0.0061 of its maximum"),
        (20.0, {"ratio": 0.07, "depth": 1e-8}, "warning", "458 times the depth of full damping, 0.01 um"),
        (0.0, {"ratio": 0.07}, "note", "full from 1 um of penetration on"),
        (0.002, {"ratio": 0.07}, "note", "the least that is taken, is 0.01 um"),
        (20.0, {"ratio": 0.07, "depth": 4e-6}, None, ""),
        (20.0, {"ratio": 0.07, "law": "constant"}, None, ""),
        (0.0, {"ratio": 0.07, "depth": 1e-4}, None, ""),
    ],
)
def test_check_names_depth_and_ratio_under_load(
    load: float, damping: Document, severity: str | None, words: str
) -> None:
    found = [f for f in check_case(case_of(loaded_pair(load, damping))) if f.path == "meshes.0.damping"]
    assert [f.severity for f in found] == ([severity] if severity else [])
    assert all(words in f.message for f in found), found
