"""Plain steps of one length: exact between contacts, first order at them, the same motion in the limit, no derivative.

Both ways of scripts: contacts frozen over a step, and judged at every stage of it.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.reading import replace
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_members, run_one
from gearplay.vocabulary.errors import InputError

SIGNALS = ["ring.x", "ring.vx", "ring.omega"]
SCHEMES = ["step", "stage"]
HEAVY, LIGHT = {"mass": 0.5, "inertia": 2e-3}, {"mass": 0.5, "inertia": 1e-3}


def case(**changes: Any) -> gp.Case:
    brief = {
        "run.duration": 4e-3,
        "run.transient": 0.0,
        "run.sampling": 1e5,
        "run.tolerance": 1e-9,
        "sleeves.ring.law": "hunt-crossley",
    }
    return gp.replace(gp.load_case("han2021"), brief | changes)


def values(of: gp.Case, step: float | None, contacts: str = "step") -> np.ndarray:
    changes = {"run.fixed_step": step, "run.fixed_step_contacts": contacts}
    run = run_one(replace(of, changes), signals=SIGNALS)
    assert run.success
    return run.values


@pytest.mark.parametrize("contacts", SCHEMES)
def test_between_contacts_steps_add_nothing(contacts: str) -> None:
    """Nothing is touched and nothing pulls: uniform motion, which any consistent formula keeps to rounding."""
    free = gp.load_case(
        {
            "rotors": {"disc": {"mass": 0.5, "inertia": 1e-3, "initial": {"vx": 3e-3, "omega": 2.0}}},
            "sleeves": {"disc": {"radial_clearance": 1e-3, "law": "hunt-crossley", "stiffness": 1e8}},
            "run": {"duration": 4e-3, "sampling": 1e5},
        }
    )
    changes = {"run.fixed_step": 1e-5, "run.fixed_step_contacts": contacts}
    run = run_one(replace(free, changes), signals=["disc.x", "disc.vx", "disc.omega"])
    assert np.ptp(run.values[:, 1:], axis=0) == pytest.approx([0.0, 0.0], abs=1e-15)
    assert run.values[-1, 0] - run.values[0, 0] == pytest.approx(3e-3 * 399e-5, rel=1e-12)


def smooth_cases() -> dict[str, gp.Case]:
    """Cases in which nothing touches or lets go.

    A journal lies in its bush, a servo takes samples, a ramp ends between two steps.
    """
    run = {"duration": 0.04, "sampling": 1e4}
    servo = {
        "kind": "position", "angle": "5 deg", "proportional_gain": 2.0, "derivative_gain": 0.02,
        "integral_gain": 10.0, "torque_limit": 0.1, "sample_time": 1e-3,
    }  # fmt: skip
    ramp = {"kind": "speed", "speed": 20.0, "ramp": 0.01004}
    bush = {"radial_clearance": 1e-5, "law": "hunt-crossley", "stiffness": 1e7, "exponent": 1.0}
    lying = {"disc": LIGHT | {"initial": {"y": -1.06e-5}}}
    shaft = [{"between": ["a", "b"], "torsional_stiffness": 50.0, "torsional_damping": 1e-3}]
    return {
        "lying": gp.load_case({"gravity": [0.0, -9.81], "rotors": lying, "sleeves": {"disc": bush}, "run": run}),
        "sampled": gp.load_case({"rotors": {"disc": LIGHT | {"drive": servo}}, "run": run}),
        "ramp": gp.load_case({"rotors": {"a": LIGHT | {"drive": ramp}, "b": HEAVY}, "couplings": shaft, "run": run}),
    }  # fmt: skip


@pytest.mark.parametrize("name", list(smooth_cases()))
def test_free_motion__does_not_depend_on_where_contacts_are_evaluated(name: str) -> None:
    """The stages take no samples of a servo."""
    smooth = smooth_cases()[name]
    frozen, judged = (
        run_one(replace(smooth, {"run.fixed_step": 3e-5, "run.fixed_step_contacts": contacts}))
        for contacts in SCHEMES
    )
    assert frozen.success
    assert np.all(frozen.statistics.impacts_per_second == 0.0)
    scale = np.max(np.abs(frozen.values), axis=0) + 1e-12
    assert np.max(np.abs(judged.values - frozen.values) / scale) < 1e-11


STAGES = [
    [],
    [1 / 5],
    [3 / 40, 9 / 40],
    [44 / 45, -56 / 15, 32 / 9],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
]


Rates = Callable[[np.ndarray, np.ndarray, list[float]], list[float]]


def script(rates: Rates, start: list[float], h: float, steps: int) -> np.ndarray:
    """Follow y' = rates(y, y at the step's start, memory) as a plain script does, the formula written out once more."""
    states, memory = [np.array(start)], [0.0]
    for _ in range(steps):
        slopes: list[np.ndarray] = []
        for weights in STAGES:
            y = states[-1] + h * sum(
                (w * k for w, k in zip(weights, slopes, strict=True)), np.zeros(len(start))
            )
            slopes.append(np.array(rates(y, states[-1], memory)))
        states.append(y)
    return np.array(states)


def bouncing(y: np.ndarray, begun: np.ndarray, impact: list[float]) -> list[float]:
    """Disc of 0.5 kg between two walls 20 um apart that damp by the speed with which it came: x, v."""
    side, force = math.copysign(1.0, y[0]), 0.0
    delta, rate = abs(y[0]) - 1e-5, side * y[1]
    if delta > 0.0:
        if abs(begun[0]) - 1e-5 <= 0.0:
            impact[0] = max(rate, 1e-4)
        force = -side * 1e7 * delta * max(1.0 + 1.5 * (1.0 - 0.8) * rate / impact[0], 0.0)
    return [y[1], force / 0.5]


def rattling(y: np.ndarray, begun: np.ndarray, memory: list[float]) -> list[float]:
    """Two discs joined by a damped spring with 2 mrad of play that does not pull: their angles, their speeds."""
    twist, rate, torque = y[0] - y[1], y[2] - y[3], 0.0
    for sign in (1.0, -1.0):
        depth = sign * twist - 1e-3
        if depth > 0.0:
            torque += sign * max(4000.0 * depth + 0.2 * sign * rate, 0.0)
    return [y[2], y[3], -torque / 1e-3, torque / 2e-3]


WALL = {"law": "hunt-crossley", "stiffness": 1e7, "exponent": 1.0, "restitution": 0.8}
PLAY = {"between": ["a", "b"], "torsional_stiffness": 4000.0, "torsional_damping": 0.2, "play": 2e-3}
DISC = {
    "rotors": {"disc": LIGHT | {"initial": {"vx": 0.03}}},
    "sleeves": {"disc": {"radial_clearance": 1e-5} | WALL},
}
DISCS = {
    "rotors": {"a": LIGHT | {"initial": {"omega": 4.0}}, "b": HEAVY | {"initial": {"omega": 0.0}}},
    "couplings": [PLAY],
}


@pytest.mark.parametrize(
    ("parts", "signals", "rates", "start", "h"),
    [
        (DISC, ["disc.x", "disc.vx"], bouncing, [0.0, 0.03], 2.0**-13),
        (DISCS, ["a.theta", "b.theta", "a.omega", "b.omega"], rattling, [0.0, 0.0, 4.0, 0.0], 2.0**-13),
        (DISC, ["disc.x", "disc.vx"], bouncing, [0.0, 0.03], 2.0**-11),
    ],
)
def test_a_step_judged_at_every_stage_is_that_of_a_script(
    parts: dict[str, Any], signals: list[str], rates: Rates, start: list[float], h: float
) -> None:
    """Contacts begin, pull and end many times within 100 steps; some steps end with a contact that pulls at once."""
    run = {"duration": 100.5 * h, "sampling": 1.0 / h, "fixed_step": h, "fixed_step_contacts": "stage"}
    judged = gp.load_case(parts | {"run": run})
    found = run_one(judged, signals=signals)
    assert found.success
    assert np.sum(found.statistics.impacts_per_second) * 100 * h > 3
    expected = script(rates, start, h, 100)
    scale = np.max(np.abs(expected), axis=0)
    assert np.max(np.abs(found.values[:101] - expected) / scale) < 1e-12
    frozen = run_one(replace(judged, {"run.fixed_step_contacts": "step"}), signals=signals)
    assert not frozen.success or np.max(np.abs(frozen.values[:101] - expected) / scale) > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("contacts", SCHEMES)
def test_a_tenth_of_the_step_leaves_about_a_tenth_of_the_error(contacts: str) -> None:
    """Contacts are noticed late by up to a step: the error falls with the step, and the limit is the located motion."""
    start = {"rotors.ring.initial": {"vx": 2e-3}, "sleeves.ring.radial_clearance": 2e-6}
    pressed = case(**{"run.tolerance": 1e-12} | start)
    located = values(pressed, None)
    speed = np.max(np.abs(located[:, 1]))
    errors = [
        np.max(np.abs(values(pressed, h, contacts)[:, 1] - located[:, 1])) / speed for h in (1e-6, 1e-7, 1e-8)
    ]
    assert errors[0] < 0.05
    assert errors[2] < 0.05 * errors[0]
    assert errors[2] < 1e-4


@pytest.mark.parametrize("contacts", SCHEMES)
def test_every_step_has_its_length(contacts: str) -> None:
    changes = {"run.fixed_step": 1e-6, "run.fixed_step_contacts": contacts}
    run = run_one(replace(case(), changes), signals=SIGNALS)
    assert run.counters.steps == 4000
    assert run.counters.rejected_steps == 0


@pytest.mark.parametrize("contacts", SCHEMES)
def test_motion__does_not_depend_on_chunks(contacts: str) -> None:
    """The course of a flow, followed in pieces that are whole steps, is that of the run, bit for bit."""
    changes = {"run.fixed_step": 2.0**-19, "run.fixed_step_contacts": contacts}
    plain = replace(case(**{"rotors.ring.initial": {"vx": 2e-3}}), changes)
    flow = Flow(plain)
    whole, pieces = flow.begin(flow.start()), flow.begin(flow.start())
    whole.advance(2.0**-9)
    for n in range(1, 9):
        pieces.advance(n * 2.0**-12)
    np.testing.assert_array_equal(whole.state, pieces.state)


@pytest.mark.parametrize("contacts", SCHEMES)
def test_shares_of_time_are_those_of_located_contacts(contacts: str) -> None:
    """A pair pressed together by its load: statistics hold with either method."""
    pair = gp.torsional_pair(0.7, mean_force=0.1, force=0.1, damping_ratio=0.1)
    located = run_one(pair, signals=["wheel.omega"])
    changes = {"run.fixed_step": 2e-6, "run.fixed_step_contacts": contacts}
    plain = run_one(replace(pair, changes), signals=["wheel.omega"])
    assert plain.statistics.impacts_per_second == pytest.approx(
        located.statistics.impacts_per_second, rel=0.02
    )
    assert plain.statistics.share_of_time == pytest.approx(located.statistics.share_of_time, rel=1e-3)
    assert np.std(plain.values) == pytest.approx(np.std(located.values), rel=1e-3)


def test_there_is_no_exact_derivative() -> None:
    plain = replace(case(), {"run.fixed_step": 1e-6})
    with pytest.raises(InputError, match=r"run\.fixed_step = 1e-06: must not be given where the derivative"):
        gp.lyapunov(plain, duration=1.0)
    with pytest.raises(InputError, match=r"run\.fixed_step"):
        gp.periodic_orbit(plain)


@pytest.mark.parametrize("step", [0.0, -1e-6, 2.0, float("nan")])
def test_a_step_is_a_time_above_zero(step: float) -> None:
    with pytest.raises(InputError, match=r"run\.fixed_step"):
        case(**{"run.fixed_step": step})


def test_contacts_are_judged_at_steps_or_stages_of_fixed_steps() -> None:
    with pytest.raises(InputError, match=r"run\.fixed_step_contacts = \"half\": must be one of"):
        case(**{"run.fixed_step": 1e-6, "run.fixed_step_contacts": "half"})
    with pytest.raises(
        InputError, match=r"run\.fixed_step_contacts = \"stage\": must not be given without fixed_step"
    ):
        case(**{"run.fixed_step_contacts": "stage"})
    with pytest.raises(
        InputError, match=r"fixed_step_contacts = \"stage\": must not be given without fixed_step"
    ):
        gp.Policy(fixed_step_contacts="stage")


def test_contacts_by_stage__are_stated_by_such_a_case_only() -> None:
    """Digests of cases from before there was the choice stay."""
    frozen = case(**{"run.fixed_step": 1e-6, "run.fixed_step_contacts": "step"})
    judged = replace(frozen, {"run.fixed_step_contacts": "stage"})
    assert "fixed_step_contacts" not in frozen.resolved()["run"]
    assert frozen.sha256 == case(**{"run.fixed_step": 1e-6}).sha256 != judged.sha256
    assert gp.load_case(judged.resolved()) == judged
    assert judged.policy.fixed_step_contacts == "stage"


@pytest.mark.slow
def test_a_force_that_jumps_feeds_steps_that_freeze_contacts_more() -> None:
    """The published formulation at 200/100 um: the step decides how hard teeth hit, and so does where contacts are judged."""
    changes = {"formulation": "as_published", "sleeves.ring.radial_clearance": 2e-4, "run.sampling": 1e3}
    published = replace(gp.load_case("han2021"), changes | {"run.duration": 1.0})

    def speed(step: float | None, contacts: str) -> float:
        method = {"run.fixed_step": step, "run.fixed_step_contacts": contacts}
        runs = run_members(replace(published, method), range(1, 7), signals=["ring.omega"])
        return float(np.mean([run.statistics.rms_impact_speed[1] for run in runs if run.success]))

    located, frozen, judged = speed(None, "step"), speed(5e-6, "step"), speed(5e-6, "stage")
    assert frozen > 2.5 * judged
    assert judged > 1.5 * located


def test_too_many_steps_are_refused_before_they_start() -> None:
    long = replace(
        gp.load_case("han2021"), {"run.fixed_step": 1e-9, "run.duration": 100.0, "run.sampling": 10.0}
    )
    with pytest.raises(gp.ResourceError, match="steps"):
        run_one(long)


def test_a_step_that_cannot_resolve_a_contact_is_warned_of() -> None:
    def said(step: float | None) -> list[str]:
        return [
            str(each)
            for each in gp.check_case(case(**{"run.fixed_step": step}))
            if each.path == "run.fixed_step"
        ]

    assert said(None) == said(1e-6) == []
    (words,) = said(1e-3)
    assert "1000 us is" in words
    assert "Shorten it" in words
