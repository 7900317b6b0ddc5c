"""Implicit steps of contacts that stay pressed: the method's order, its damping, its work, and that nothing is lost by it."""

from itertools import pairwise

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.integrate import implicit, radau
from gearplay.integrate import run as kernel
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course

LOADED = {"gravity.1": -9.81, "rotors.ring.load.torque": 1.0}


@pytest.mark.parametrize("method", [radau.LOW, radau.HIGH])
def test_coefficients_meet_their_order_conditions(method: int) -> None:
    """Collocation: s stages integrate polynomials of degree s - 1 exactly, the end those of degree 2 s - 2 (order 2 s - 1)."""
    s = int(radau.STAGES[method])
    c, a = radau.C[method, :s], radau.A[method, :s, :s]
    for k in range(1, s + 1):
        assert a @ c ** (k - 1) == pytest.approx(c**k / k, abs=1e-15)
    for k in range(1, 2 * s):
        assert a[-1] @ c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-15)
    assert abs(a[-1] @ c ** (2 * s - 1) - 0.5 / s) > 1e-6
    inside = radau.DENSE[method, : s + 1, : s + 1]  # integrals of the polynomials through start and stages
    for x in (0.3, 0.9, 1.0):
        for k in range(1, s + 2):
            weights = inside.T @ x ** np.arange(1, s + 2)
            assert weights @ np.array([0.0, *c]) ** (k - 1) == pytest.approx(x**k / k, abs=1e-13)


@pytest.mark.parametrize("method", [radau.LOW, radau.HIGH])
def test_radau_methods__are_l_stable(method: int) -> None:
    """R(z) = det(I - z A + z 1 b) / det(I - z A): |R| <= 1 on the imaginary axis, and R goes to 0 (L-stability)."""
    s = int(radau.STAGES[method])
    a = radau.A[method, :s, :s]

    def growth(z: complex) -> float:
        above = np.eye(s) - z * a + z * np.outer(np.ones(s), a[-1])
        return float(abs(np.linalg.det(above) / np.linalg.det(np.eye(s) - z * a)))

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


def test_samples_inside_a_step_are_those_of_shorter_steps(measured: Measured) -> None:
    """Steps of five stages are some 40 samples long: their polynomial is as exact as their ends."""
    settings = {"run.duration": 0.01, "run.transient": 0.1, "run.sampling": 2e5}
    case = gp.replace(gp.load_case("external-pair"), settings)
    long, short = (gp.simulate(gp.replace(case, {"run.tolerance": each})) for each in (1e-8, 1e-11))
    assert short.work.steps > 2 * long.work.steps
    apart = max(float(np.abs(long.ds[name] - short.ds[name]).max()) for name in ("x", "y"))
    assert apart < 1e-14
    measured("samples inside steps at 1e-8 against those at 1e-11 [m]", apart, "1e-14")


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
    for course in (
        started(case, 0.34, tolerance=1e-10),
        started(case, 0.34, tolerance=1e-13, patience=NEVER),
    ):
        course.log.clear()
        numbers, passed = course.run.implicit.numbers, 0
        while course.time < 0.345:
            before = numbers[implicit.IN_USE]
            course.take_chunk(0.345, 1)
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
    ("name", "least", "most"), [("external-pair", 0.9, 1.0), ("two-stage-reducer", 0.0, 0.3)]
)
def test_only_steps_that_pay_are_implicit(name: str, least: float, most: float, measured: Measured) -> None:
    """The reducer's ones would be two or three times as long as explicit ones and cost three times as much."""
    course, steps, quiet = started(gp.load_case(name), tolerance=1e-6), 0, 0
    while course.time < 0.35:
        course.take_chunk(0.35, 1)
        steps += 1
        quiet += int(course.run.implicit.numbers[implicit.IN_USE] == 1)
    assert least < quiet / steps < most
    measured(f"share of implicit steps, {name} at 1e-6", quiet / steps, f"{least} to {most}")


def test_long_trains_take_implicit_steps_too() -> None:
    """A train of 30 gears, 89 unknowns: their matrices are banded, and what is outside the band costs nothing."""
    names = [f"gear{i}" for i in range(30)]
    rotors = {
        name: {"teeth": 20, "mass": 6.57, "inertia": 0.0365, "radial_damping": 2000.0} for name in names
    }
    rotors[names[0]]["drive"] = {"kind": "speed", "speed": "1000 rpm"}
    rotors[names[-1]]["load"] = {"torque": 300.0}
    sleeve = {"radial_clearance": 0.0, "exponent": 1.0, "stiffness": 1e8, "restitution": 1.0}
    mesh = {
        "module": 4e-3,
        "pressure_angle": "20 deg",
        "backlash": 2e-4,
        "stiffness": {"kind": "harmonic", "mean": 3e8, "amplitude": 3e7},
        "damping": {"ratio": 0.07, "depth": 1e-6},
    }
    meshes = [{"driver": a, "driven": b, **mesh} for a, b in pairwise(names)]
    run = {"duration": 0.1, "transient": 0.0}
    case = gp.load_case(
        {"rotors": rotors, "sleeves": dict.fromkeys(names, sleeve), "meshes": meshes, "run": run}
    )
    course = started(case, 0.05, tolerance=1e-6)
    course.advance(0.055)
    kept = course.run.implicit
    assert kept.numbers[implicit.IN_USE] == 1
    assert kept.places[0] == 89
    assert implicit.pairs_of(kept) < 12 * kept.places[0]
