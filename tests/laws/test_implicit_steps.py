"""Implicit steps of contacts that stay pressed: the method's order, its damping, its work, and that nothing is lost by it."""

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.integrate import implicit
from gearplay.integrate import run as kernel
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course

LOADED = {"gravity.1": -9.81, "rotors.ring.load.torque": 1.0}


def test_coefficients_meet_their_order_conditions() -> None:
    """Collocation: every stage integrates polynomials of degree 2 exactly, the end those of degree 4 (order 5)."""
    for k in range(1, 4):
        assert implicit.A @ implicit.C ** (k - 1) == pytest.approx(implicit.C**k / k, abs=1e-15)
    for k in range(1, 6):
        assert implicit.A[2] @ implicit.C ** (k - 1) == pytest.approx(1.0 / k, abs=1e-15)
    assert abs(implicit.A[2] @ implicit.C**5 - 1.0 / 6.0) > 1e-4


def test_what_is_too_fast_for_a_step_dies() -> None:
    """R(z) = det(I - z A + z 1 b) / det(I - z A): |R| <= 1 on the imaginary axis, and R goes to 0 (L-stability)."""

    def growth(z: complex) -> float:
        one = np.eye(3)
        above = one - z * implicit.A + z * np.outer(np.ones(3), implicit.A[2])
        return float(abs(np.linalg.det(above) / np.linalg.det(one - z * implicit.A)))

    assert max(growth(1j * w) for w in np.geomspace(1e-3, 1e4, 200)) < 1.0 + 1e-12
    assert growth(-1e8) < 1e-6


def started(
    case: gp.Case, lead: float = 0.3, *, tolerance: float, patience: int = implicit.FIRST_BACKOFF
) -> Course:
    """Return a motion that is computed at 1e-11 until ``lead``, and from there at a tolerance, its first steps explicit."""
    flow = Flow(gp.replace(case, {"run.tolerance": 1e-11}))
    course = flow.begin(flow.start())
    course.advance(lead)
    run = course.run
    run.implicit.numbers[implicit.IN_USE] = run.implicit.numbers[implicit.QUIET] = 0
    run.implicit.numbers[implicit.BACKOFF] = patience
    run.clock[kernel.TOLERANCE] = tolerance
    run.scale[:] = tolerance * run.natural
    return course


def difference(one: Course, two: Course) -> float:
    """Return the largest difference of positions [m], rotations over the toothing's radius."""
    n, natural = one.state.size // 2, one.packed.natural
    return float(np.max(np.abs((one.state - two.state)[:n] / natural[:n])) * natural[0])


NEVER = 2**60  # explicit steps before the first implicit one


def test_a_pair_under_gravity_and_torque_takes_few_steps(measured: Measured) -> None:
    case = gp.replace(gp.load_case("han2021"), LOADED)
    quiet, explicit = started(case, tolerance=1e-9), started(case, tolerance=1e-13, patience=NEVER)
    before = quiet.steps
    for course in (quiet, explicit):
        course.advance(0.4)
    rate, error = (quiet.steps - before) / 0.1, difference(quiet, explicit)
    assert quiet.run.implicit.numbers[implicit.IN_USE] == 1
    assert rate < 5000.0
    assert error < 1e-13
    measured("steps per second of the article's pair under 1 g and 1 N m at 1e-9", rate, "5000")
    measured("their error after 0.1 s [m]", error, "1e-13")


def test_a_pair_at_rest_takes_hardly_any(measured: Measured) -> None:
    """Under gravity, its drive at no speed, its swing damped: steps grow as long as they may."""
    changes = {"gravity.1": -9.81, "rotors.pinion.drive.speed": 0.0, "rotors.ring.radial_damping": 100.0}
    course = started(gp.replace(gp.load_case("han2021"), changes), 1.0, tolerance=1e-9)
    before = course.steps
    course.advance(2.0)
    assert course.steps - before < 500
    measured("steps per second of a pair at rest at 1e-9", float(course.steps - before), "500")


def rippling_pair() -> gp.Case:
    """Return the loaded external pair behind a drive whose speed ripples, three times a turn and with the teeth."""
    ripple = [{"order": 3, "amplitude": 0.01}, {"order": 20, "amplitude": 0.002, "phase": 0.5}]
    drive = {"kind": "speed", "speed": "1000 rpm", "ripple": ripple}
    return gp.replace(gp.load_case("external-pair"), {"rotors.input.drive": drive})


def test_a_drive_that_ripples_takes_few_steps(measured: Measured) -> None:
    """Its rotation, a function of time alone, is exact at the end of a step, and mesh and bearings follow as they should."""
    quiet, explicit = (
        started(rippling_pair(), tolerance=1e-9),
        started(rippling_pair(), tolerance=1e-13, patience=NEVER),
    )
    before = quiet.steps
    for course in (quiet, explicit):
        course.advance(0.4)
    assert quiet.run.implicit.numbers[implicit.IN_USE] == 1
    rate, error = (quiet.steps - before) / 0.1, difference(quiet, explicit)
    assert rate < 50_000.0  # 103 000 without
    assert error < 1e-12
    n, pinion = quiet.state.size // 2, 2
    assert quiet.state[pinion] == explicit.state[pinion]
    assert quiet.state[n + pinion] == explicit.state[n + pinion]
    measured("steps per second of a loaded pair behind a rippling drive at 1e-9", rate, "50 000")
    measured("their error after 0.1 s [m]", error, "1e-12")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["external-pair", "two-stage-reducer", "pinion-idler-ring", "rippling"])
def test_it_equals_the_explicit_method(name: str, measured: Measured) -> None:
    """The same state over 2 ms at the default tolerance and, explicit throughout, at 1e-13; of the chaotic chain from five."""
    case, errors, used = rippling_pair() if name == "rippling" else gp.load_case(name), [], []
    for lead in np.arange(0.3, 0.345 if name == "pinion-idler-ring" else 0.305, 0.01):
        quiet = started(case, lead, tolerance=1e-6)
        explicit = started(case, lead, tolerance=1e-13, patience=NEVER)
        assert np.array_equal(quiet.state, explicit.state)
        for course in (quiet, explicit):
            course.advance(lead + 0.002)
        used.append(quiet.run.implicit.numbers[implicit.TRIED])
        assert explicit.run.implicit.numbers[implicit.IN_USE] == 0
        errors.append(difference(quiet, explicit))
    assert np.median(used) > 2
    assert np.median(errors) < 1e-9
    measured("implicit steps at 1e-6 against explicit ones at 1e-13 over 2 ms [m]", np.median(errors), "1e-9")


def test_contact_changes_between_them_are_the_explicit_method_s(measured: Measured) -> None:
    """A chain whose flanks part and meet: quiet steps come and go, every change is there, at its instant."""
    case = gp.load_case("pinion-idler-ring")
    logs, used = [], []
    for course in (started(case, tolerance=1e-9), started(case, tolerance=1e-13, patience=NEVER)):
        course.log.clear()
        numbers, passed = course.run.implicit.numbers, 0
        while course.time < 0.305:
            before = numbers[implicit.IN_USE]
            course.take_chunk(0.305, 1)
            passed += int(before == 1 and numbers[implicit.IN_USE] == 0)
        logs.append(course.whole_log)
        used.append(passed)
    assert used[0] > 0
    assert used[1] == 0
    assert len(logs[0]) == len(logs[1]) > 10
    assert np.array_equal(logs[0][:, 1:3], logs[1][:, 1:3])
    apart = float(np.max(np.abs(logs[0][:, 0] - logs[1][:, 0])))
    assert apart < 1e-8
    measured("instants of contact changes between implicit steps [s]", apart, "1e-8")


def test_a_step_too_long_for_newton_is_taken_shorter(measured: Measured) -> None:
    """At a loose tolerance steps grow until their equations are not solved: then by shorter ones, not 200 explicit ones."""
    course = started(gp.replace(gp.load_case("han2021"), LOADED), tolerance=3e-4)
    taken = [course.steps]
    for tenth in range(4, 14):  # explicit steps so long may shake the contacts loose for one or another
        course.advance(0.1 * tenth)
        taken.append(course.steps)
    steps = float(np.median(np.diff(taken)))
    assert steps < 150.0  # 700 of them where one failure is enough to give up
    measured("steps of the article's pair under 1 g and 1 N m in 0.1 s at 3e-4, median of ten", steps, "150")


@pytest.mark.parametrize(
    ("name", "least", "most"), [("external-pair", 0.9, 1.0), ("two-stage-reducer", 0.0, 0.2)]
)
def test_only_steps_that_pay_are_implicit(name: str, least: float, most: float, measured: Measured) -> None:
    """The reducer's ones would be a third longer than explicit ones and cost twice as much."""
    course, steps, quiet = started(gp.load_case(name), tolerance=1e-6), 0, 0
    while course.time < 0.35:
        course.take_chunk(0.35, 1)
        steps += 1
        quiet += int(course.run.implicit.numbers[implicit.IN_USE] == 1)
    assert least < quiet / steps < most
    measured(f"share of implicit steps, {name} at 1e-6", quiet / steps, f"{least} to {most}")
