"""Plain steps of one length: exact between contacts, first order at them, the same motion in the limit, no derivative."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.reading import replace
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_one
from gearplay.vocabulary.errors import InputError

SIGNALS = ["ring.x", "ring.vx", "ring.omega"]


def case(**changes: Any) -> gp.Case:
    brief = {
        "run.duration": 4e-3,
        "run.transient": 0.0,
        "run.sampling": 1e5,
        "run.tolerance": 1e-9,
        "sleeves.ring.law": "hunt-crossley",
    }
    return gp.replace(gp.load_case("han2021"), brief | changes)


def values(of: gp.Case, step: float | None) -> np.ndarray:
    run = run_one(replace(of, {"run.fixed_step": step}), signals=SIGNALS)
    assert run.success
    return run.values


@pytest.fixture(autouse=True, scope="module")
def compiled() -> None:
    prepare(case())


def test_between_contacts_steps_add_nothing() -> None:
    """Nothing is touched and nothing pulls: uniform motion, which any consistent formula keeps to rounding."""
    free = gp.load_case(
        {
            "rotors": {"disc": {"mass": 0.5, "inertia": 1e-3, "initial": {"vx": 3e-3, "omega": 2.0}}},
            "sleeves": {"disc": {"radial_clearance": 1e-3, "law": "hunt-crossley", "stiffness": 1e8}},
            "run": {"duration": 4e-3, "sampling": 1e5},
        }
    )
    prepare(free)
    run = run_one(replace(free, {"run.fixed_step": 1e-5}), signals=["disc.x", "disc.vx", "disc.omega"])
    assert np.ptp(run.values[:, 1:], axis=0) == pytest.approx([0.0, 0.0], abs=1e-15)
    assert run.values[-1, 0] - run.values[0, 0] == pytest.approx(3e-3 * 399e-5, rel=1e-12)


def test_a_tenth_of_the_step_leaves_about_a_tenth_of_the_error() -> None:
    """Contacts are noticed late by up to a step: the error falls with the step, and the limit is the located motion."""
    pressed = case(**{"rotors.ring.initial": {"vx": 2e-3}, "sleeves.ring.radial_clearance": 2e-6})
    located = values(pressed, None)
    speed = np.max(np.abs(located[:, 1]))
    errors = [np.max(np.abs(values(pressed, h)[:, 1] - located[:, 1])) / speed for h in (1e-6, 1e-7, 1e-8)]
    assert errors[0] < 0.05
    assert errors[2] < 0.05 * errors[0]
    assert errors[2] < 1e-4


def test_every_step_has_its_length() -> None:
    run = run_one(replace(case(), {"run.fixed_step": 1e-6}), signals=SIGNALS)
    assert run.counters.steps == 4000
    assert run.counters.rejected_steps == 0


def test_pieces_do_not_change_the_motion() -> None:
    """The course of a flow, followed in pieces that are whole steps, is that of the run, bit for bit."""
    plain = replace(case(**{"rotors.ring.initial": {"vx": 2e-3}}), {"run.fixed_step": 2.0**-19})
    flow = Flow(plain)
    whole, pieces = flow.begin(flow.start()), flow.begin(flow.start())
    whole.advance(2.0**-9)
    for n in range(1, 9):
        pieces.advance(n * 2.0**-12)
    np.testing.assert_array_equal(whole.state, pieces.state)


def test_shares_of_time_are_those_of_located_contacts() -> None:
    """A pair pressed together by its load: statistics hold with either method."""
    pair = gp.torsional_pair(0.7, mean_force=0.1, force=0.1, damping_ratio=0.1)
    located = run_one(pair, signals=["wheel.omega"])
    plain = run_one(replace(pair, {"run.fixed_step": 2e-6}), signals=["wheel.omega"])
    assert plain.statistics.impacts_per_second == pytest.approx(
        located.statistics.impacts_per_second, rel=0.02
    )
    assert plain.statistics.share_of_time == pytest.approx(located.statistics.share_of_time, rel=1e-3)
    assert np.std(plain.values) == pytest.approx(np.std(located.values), rel=1e-3)


def test_there_is_no_exact_derivative() -> None:
    plain = replace(case(), {"run.fixed_step": 1e-6})
    prepare(case(), derivative=True)
    with pytest.raises(InputError, match=r"run\.fixed_step = 1e-06: must be absent where the derivative"):
        gp.lyapunov(plain, duration=1.0)
    with pytest.raises(InputError, match=r"run\.fixed_step"):
        gp.periodic_orbit(plain)


@pytest.mark.parametrize("step", [0.0, -1e-6, 2.0, float("nan")])
def test_a_step_is_a_time_above_zero(step: float) -> None:
    with pytest.raises(InputError, match=r"run\.fixed_step"):
        case(**{"run.fixed_step": step})


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
