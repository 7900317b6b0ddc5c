"""Clearance oscillators with closed forms: periods, event times, jumps of stiffness, grazing touches."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from building import (
    ALPHA,
    Document,
    Floats,
    case_of,
    merged,
    pair_document,
    simulate_one,
    single_rotor_document,
)
from gearplay.model.pack import pack
from gearplay.parts.mesh.flank import RAMP_AS_PRINTED, RAMP_SMOOTH, damping_ramp, flank_damping
from gearplay.parts.registry import MESH
from gearplay.solver.trajectory import Trajectory

LINEAR = {
    "radial_clearance": 5e-5,
    "law": "hunt-crossley",
    "stiffness": 5e7,
    "exponent": 1.0,
    "restitution": 1.0,
}
BASE = 0.002 * math.cos(ALPHA)  # base radius per tooth [m]


def disc(
    duration: float, sleeve: dict[str, Any] | None = None, gravity: float = 0.0, **initial: float
) -> Document:
    """Return a disc of 0.5 kg in a linear sleeve; gravity along -x."""
    document = single_rotor_document(merged(LINEAR, sleeve or {}), mass=0.5, initial=initial)
    return merged(document, {"gravity": [-gravity, 0.0], "run": {"duration": duration, "tolerance": 1e-12}})


def rigid_pair(mesh: dict[str, Any], duration: float, **rotors: dict[str, Any]) -> Document:
    """Return an external pair 20/60 with rigid centres: one degree of freedom between the flanks."""
    document = merged(
        pair_document("external", mesh=mesh),
        {"rotors": rotors, "run": {"duration": duration, "tolerance": 1e-12}},
    )
    document["sleeves"] = {}
    return document


def onsets(run: Trajectory, contact: int) -> Floats:
    """Return the times [s] at which a contact closed."""
    return run.log[(run.log[:, 1] == contact) & (run.log[:, 2] == 1.0), 0]


@pytest.mark.parametrize("speed", [0.01, 0.05, 0.4])
def test_period_across_a_diameter(speed: float) -> None:
    """A journal between two linear walls: period 2 pi / w_n + 4 c / v0."""
    omega = math.sqrt(5e7 / 0.5)
    period = 2.0 * math.pi / omega + 4.0 * 5e-5 / speed
    run = simulate_one(disc(6.2 * period, vx=speed), signals=["x"])
    times = onsets(run, 0)[::2]
    np.testing.assert_allclose(np.diff(times), period, rtol=1e-8)
    assert len(times) >= 6


def test_period_between_two_flanks() -> None:
    """Two gears on rigid centres: 2 pi / w_n + 2 b0 / v with w_n^2 = K (r_1^2/J_1 + r_2^2/J_2)."""
    start = {"omega": 1.0, "theta": -1e-5}
    document = rigid_pair(
        {}, 0.05, pinion={"initial": start}, wheel={"initial": {"omega": 0.0, "theta": 0.0}}
    )
    r_1, r_2 = 20 * BASE, 60 * BASE
    omega = math.sqrt(1.3e8 * (r_1**2 / 1.88e-4 + r_2**2 / 9.0e-3))
    period = 2.0 * math.pi / omega + 2.0 * 100e-6 / r_1
    times = onsets(simulate_one(document, signals=["x"]), 0)
    assert len(times) >= 8
    np.testing.assert_allclose(np.diff(times), period, rtol=1e-8)


@pytest.mark.parametrize("drag", [0.0, 300.0])
def test_free_motion_reaches_the_wall_on_time(drag: float) -> None:
    """Oblique flight under gravity and linear drag: |r(t)| = c at the logged time to 1e-12 s."""
    start = {"x": 1e-5, "y": -2e-5, "vx": 0.06, "vy": 0.03}
    document = merged(disc(5e-3, gravity=9.81, **start), {"rotors": {"disc": {"radial_damping": drag}}})
    rate = drag / 0.5

    def distance(t: float) -> float:
        decay, terminal = (-math.expm1(-rate * t) / rate, -9.81 / rate) if drag else (t, 0.0)
        x = start["x"] + (
            (start["vx"] - terminal) * decay + terminal * t if drag else start["vx"] * t - 0.5 * 9.81 * t**2
        )
        return math.hypot(x, start["y"] + start["vy"] * decay) - 5e-5

    expected = brentq(distance, 1e-5, 2e-3, xtol=1e-16, rtol=1e-14)
    assert abs(onsets(simulate_one(document, signals=["x"]), 0)[0] - expected) < 1e-12


# -- jumps of stiffness ------------------------------------------------------------------------------------


SQUARE = {"kind": "square", "single": 0.8e8, "double": 1.4e8, "contact_ratio": 1.6, "phase": 0.5}


def square_run(speed: float, p_0: float, times: Floats) -> Floats:
    """Simulate a loaded pair with square-wave stiffness; return its drive penetration [m]."""
    document = rigid_pair(
        {"stiffness": SQUARE},
        times[-1] + 0.5 * (times[1] - times[0]),
        pinion={"drive": {"kind": "speed", "speed": speed}},
        wheel={"load": {"torque": 300.0}, "initial": {"theta": p_0 / (60 * BASE)}},
    )
    document["run"]["sampling"] = 1.0 / (times[1] - times[0])
    run = simulate_one(document, signals=["drive_penetration"])
    return run.values[: len(times), 0]


def exact_square(speed: float, p: float, times: Floats) -> Floats:
    """Return p(t) of M p'' = T / r - K p, going from jump to jump of K."""
    M, force, turn = 9.0e-3 / (60 * BASE) ** 2, 300.0 / (60 * BASE), 2.0 * math.pi / (20.0 * speed)
    lag = SQUARE["phase"] / (2.0 * math.pi)
    edges = sorted((n + d - lag) * turn for n in range(int(times[-1] / turn) + 3) for d in (0.0, 0.6))
    t, v, result = 0.0, 0.0, np.zeros(len(times))
    for edge in [e for e in edges if e > 0.0]:
        middle = 0.5 * (t + edge)
        k = 1.4e8 if (middle / turn + lag) % 1.0 < 0.6 else 0.8e8
        w, rest = math.sqrt(k / M), force / k
        inside = (times >= t) & (times < edge)
        result[inside] = (
            rest + (p - rest) * np.cos(w * (times[inside] - t)) + v / w * np.sin(w * (times[inside] - t))
        )
        c, s = math.cos(w * (edge - t)), math.sin(w * (edge - t))
        p, v = rest + (p - rest) * c + v / w * s, -(p - rest) * w * s + v * c
        t = edge
    return result


def test_square_wave_stiffness_follows_its_piecewise_solution() -> None:
    """Each jump of K(psi) is met where it is: 190 half-waves agree with the exact piecewise oscillator."""
    times = np.arange(3001) * 1e-5
    speed, p_0 = 2.0 * math.pi * 160.0, 2.5e-5
    got, expected = square_run(speed, p_0, times), exact_square(speed, p_0, times)
    assert np.min(expected) > 1e-6, "the flank stays in touch"
    assert np.max(np.abs(got - expected)) < 1e-14 + 1e-9 * np.max(expected)


@pytest.mark.parametrize(("periods_per_jump", "unstable"), [(1.6, False), (2.02, True)])
def test_meissner_trace(periods_per_jump: float, unstable: bool) -> None:
    """Two neighbours part by tr d_n - d_(n-1) per mesh period: Meissner's trace, unstable where |tr| > 2."""
    M = 9.0e-3 / (60 * BASE) ** 2
    w = [math.sqrt(k / M) for k in (1.4e8, 0.8e8)]
    # total phase over one mesh period, as a multiple of pi / 2
    turn = periods_per_jump * 0.5 * math.pi / (0.6 * w[0] + 0.4 * w[1])
    a, b = 0.6 * w[0] * turn, 0.4 * w[1] * turn
    trace = 2.0 * math.cos(a) * math.cos(b) - (w[0] / w[1] + w[1] / w[0]) * math.sin(a) * math.sin(b)
    assert (abs(trace) > 2.0) == unstable
    times = np.arange(3) * turn
    d = square_run(2.0 * math.pi / (20.0 * turn), 3.01e-5, times) - square_run(
        2.0 * math.pi / (20.0 * turn), 3e-5, times
    )
    assert (d[2] + d[0]) / d[1] == pytest.approx(trace, rel=1e-6)


# -- damping -----------------------------------------------------------------------------------------------


def test_damping_ramp_is_smooth_from_zero_to_full() -> None:
    """C(p) = C_m u^2 (3 - 2u): 0 and flat at first touch, C_m and flat from full depth on."""
    document = rigid_pair({"damping": {"maximum": 400.0, "depth": 2e-6}}, 0.01)
    mesh = pack(case_of(document)).system.records[MESH][0]
    assert mesh.ramp == RAMP_SMOOTH
    assert [flank_damping(mesh, p, 0, f) for p in (0.0, 1e-6, 2e-6) for f in (0, 1)] == [
        0.0,
        0.0,
        200.0,
        200.0,
        400.0,
        400.0,
    ]
    assert flank_damping(mesh, 5e-6, 1, 1) == 400.0
    for u, slope in ((0.0, 0.0), (0.5, 1.5), (1.0, 0.0)):
        h = 1e-6
        ends = damping_ramp(u + h, 1 if u + h > 1.0 else 0) - damping_ramp(u - h, 0)
        assert ends / (2.0 * h) == pytest.approx(slope, abs=1e-5)
    document["meshes"][0]["damping"]["ramp"] = "literal"
    mesh = pack(case_of(document)).system.records[MESH][0]
    assert mesh.ramp == RAMP_AS_PRINTED
    # as printed: all of it at first touch, none at full depth, all again beyond, nothing on the back flank
    assert [flank_damping(mesh, p, 0, 0) for p in (0.0, 1e-6, 2e-6)] == [400.0, 200.0, 0.0]
    assert (flank_damping(mesh, 3e-6, 1, 0), flank_damping(mesh, 1e-6, 0, 1)) == (400.0, 0.0)


@pytest.mark.parametrize("flank", [0, 1])
def test_damped_flank_impact_has_the_rebound_of_its_scalar_equation(flank: int) -> None:
    """m_eq p'' = -K p - C(p) p', released when the force ends: same rebound as an independent integration."""
    C, depth, K = 3000.0, 1e-6, 1.3e8
    inverse = (20 * BASE) ** 2 / 1.88e-4 + (60 * BASE) ** 2 / 9.0e-3
    spin = -1.0 / 3.0 + (
        0.5 if flank == 0 else -0.5
    )  # slower than rolling hits the drive flank, faster the back
    document = rigid_pair(
        {"damping": {"maximum": C, "depth": depth}},
        4e-3,
        pinion={"initial": {"omega": 1.0, "theta": -5e-5 / (20 * BASE)}},
        wheel={"initial": {"omega": spin, "theta": 0.0}},
    )
    run = simulate_one(document, signals=["pinion.omega", "wheel.omega"])
    speed = 0.5 * 60 * BASE

    def force(p: float, v: float) -> float:
        u = min(max(p / depth, 0.0), 1.0)
        return K * p + C * u * u * (3.0 - 2.0 * u) * v

    def released(t: float, y: Floats) -> float:
        return force(y[0], y[1]) if t > 1e-9 else 1.0

    released.terminal, released.direction = True, -1.0  # type: ignore[attr-defined]
    scalar = solve_ivp(
        lambda t, y: [y[1], -force(y[0], y[1]) * inverse],
        (0.0, 1e-3),
        [0.0, speed],
        method="DOP853",
        events=released,
        rtol=1e-11,
        atol=[1e-16, 1e-12],
        max_step=1e-7,
    )
    rebound = -scalar.y_events[0][0][1]
    assert 0.2 * speed < rebound < 0.95 * speed
    parting = abs(run.values[:, 0] * 20 * BASE + run.values[:, 1] * 60 * BASE)
    first_gap = np.argmax(run.time > run.log[0, 0] + scalar.t_events[0][0] + 2e-5)
    assert run.log[0, 1] == flank
    assert parting[first_gap] == pytest.approx(rebound, rel=1e-7)


# -- grazing -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("excess", "touches"), [(1e-9, True), (1e-11, True), (1e-13, True), (-1e-13, False)])
def test_grazing_touch_is_not_missed(excess: float, touches: bool) -> None:
    """Thrown against gravity to 0.1 pm beyond the wall it touches, to 0.1 pm short it does not."""
    g = 9.81
    run = simulate_one(disc(6e-3, gravity=g, vx=math.sqrt(2.0 * g * (5e-5 + excess))), signals=["x"])
    apex = math.sqrt(2.0 * (5e-5 + excess) / g)
    hits = [t for t in onsets(run, 0) if abs(t - apex) < 2e-4]
    assert len(hits) == (1 if touches else 0)
    if touches:
        assert hits[0] == pytest.approx(apex - math.sqrt(2.0 * excess / g), abs=1e-8)


@pytest.mark.parametrize(("excess", "parts"), [(1e-6, True), (1e-8, True), (-1e-8, False)])
def test_grazing_release_is_not_missed(excess: float, parts: bool) -> None:
    """Resting on a spring and bouncing by just more than the static depth, the journal leaves it briefly."""
    g, static = 1000.0, 0.5 * 1000.0 / 5e7
    run = simulate_one(disc(2e-3, gravity=g, x=-5e-5 - static * (2.0 + excess)), signals=["x"])
    assert (np.count_nonzero(run.log[:, 2] == 0.0) > 0) == parts


@pytest.mark.parametrize(("excess", "touches"), [(1e-10, True), (1e-12, True), (-1e-12, False)])
def test_flank_grazed_by_the_transmission_error_is_not_missed(excess: float, touches: bool) -> None:
    """A gap of 5 um under a 5 um error wave: touched by a wave 1 pm higher, not 1 pm lower."""
    document = rigid_pair(
        {"transmission_error": [{"order": 1, "amplitude": 5e-6, "phase": 0.2}]},
        0.02,
        pinion={"drive": {"kind": "speed", "speed": 30.0}},
        wheel={"initial": {"theta": (-5e-6 + excess) / (60 * BASE)}},
    )
    run = simulate_one(document, signals=["x"])
    assert (len(onsets(run, 0)) > 0) == touches
    if touches:
        crest = (0.5 * math.pi - 0.2) / 600.0
        assert onsets(run, 0)[0] == pytest.approx(crest, abs=2.0 * math.sqrt(2.0 * excess / 5e-6) / 600.0)
