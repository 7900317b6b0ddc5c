"""Every contact is on the side of zero that its mode says: no touch is missed, no spring appears compressed."""

import numpy as np
import pytest

import gearplay as gp
from building import Document, pair_document
from depth import sized
from gearplay.integrate import dispatch, stepper
from gearplay.integrate import run as kernel
from gearplay.integrate.right_hand_side import make_loads
from gearplay.kernels.layout import OPEN, PENETRATION
from gearplay.model.case import Case
from gearplay.model.initial import Starts
from gearplay.model.pack import pack
from gearplay.solver.integration import Course
from gearplay.solver.status import Status
from gearplay.solver.trajectory import choose_columns
from random_trains import broken_contacts, train

STOPPED = (Status.MISSED_SWITCH, Status.NOT_FINITE, Status.STEP_TOO_SMALL)


def depth_of(tolerance: float) -> float:
    """Return how deep [m] a contact may be before it counts: the error of a touch, at least rounding of the pictures of it."""
    return max(3e-10, 1e-4 * tolerance)


def course_of(case: Case, signals: list[str] | None = None, samples: int = 0) -> Course:
    """Return the motion of a case's first member, to be followed step by step, with room for samples of signals."""
    packed = pack(case, span=case.run.transient + case.run.duration)
    _, places = choose_columns(packed, signals or [])
    rows = np.empty((len(places), samples))
    course = Course(case, packed, Starts(case, packed).of_member(0), places=places, rows=rows)
    course.run.clock[kernel.T_END] = case.run.transient + case.run.duration
    return course


def servo_behind_a_coupling(tolerance: float) -> Document:
    """Return a motor, a coupling, a pinion in a sleeve without clearance, a free wheel: an ordinary servo drive.

    The pull of the sleeve touches zero on the interpolant of a step alone, again and again; the touches of the flanks that came
    after it in such steps were missed at 1e-4 and 1e-6.
    """
    terms = [{"frequency": 689.3527424782635, "amplitude": 1.6533631985266295}]
    drive = {"kind": "torque", "torque": -4.145349961321745, "terms": terms}
    stiffness = {"kind": "square", "single": 1e8, "double": 157182433.20644197}
    return {
        "rotors": {
            "motor": {"mass": 1.0, "inertia": 0.00010531002769312281, "drive": drive},
            "p": {"teeth": 29, "mass": 0.5, "inertia": 2e-4, "radial_damping": 20.0},
            "w": {"mass": 1.5, "inertia": 2e-3, "teeth": 36},
        },
        "sleeves": {
            "p": {
                "radial_clearance": 0.0,
                "stiffness": 3e9,
                "restitution": 0.8135058353434417,
                "exponent": 1.0,
            }
        },
        "couplings": [
            {
                "between": ["motor", "p"],
                "torsional_stiffness": 3113.4508103089174,
                "torsional_damping": 0.02,
            }
        ],
        "meshes": [
            {"driver": "p", "driven": "w", "module": 2e-3, "backlash": 2e-5, "stiffness": stiffness},
        ],
        "run": {"duration": 0.01, "sampling": 5e4, "tolerance": tolerance},
    }


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6, 1e-8])
def test_teeth_beside_a_loaded_sleeve_touch(tolerance: float) -> None:
    """Undamped flanks carry K p wherever they press; some 29 rad/s at every tolerance, up to 56 where missed."""
    result = gp.simulate(gp.load_case(servo_behind_a_coupling(tolerance)))
    assert result.success
    assert broken_contacts(result, depth_of(tolerance)) == []
    assert float(np.abs(result.ds.omega.sel(rotor="p")).max()) == pytest.approx(29.1, abs=1.5)


def test_every_accepted_state_of_random_trains_keeps_the_invariant() -> None:
    """Modes agree with penetrations at the end of every step, to the error of a touch."""
    for seed in range(sized(60, 6)):
        rng = np.random.default_rng([41, seed])
        tolerance = float(10.0 ** rng.uniform(-9.0, -3.0))
        course = course_of(gp.load_case(train(rng, tolerance)))
        system, run, loads = course.system, course.run, make_loads(course.system)
        most = max(tolerance, 1e-6) * system.contacts["natural"]
        for _ in range(3000):
            status = Status(stepper.advance(system, run, 1))
            stepper.synchronise(system, run)
            for e in range(system.elements.size):
                dispatch.contact_kinematics(system, e, float(run.clock[kernel.T]), run.y, run.branch, loads)
            p, closed = loads.contacts[:, PENETRATION], run.branch.modes[: system.contacts.size] != OPEN
            assert not (~closed & (p > most)).any(), (seed, run.clock[kernel.T])
            assert not (closed & (p < -most)).any(), (seed, run.clock[kernel.T])
            run.counts[kernel.LOGGED] = 0
            if status != Status.PAUSED:
                assert status not in STOPPED, seed
                break


@pytest.mark.slow
def test_no_sample_of_random_trains_shows_a_missed_touch() -> None:
    """Loaded sleeves, offsets, no clearance, couplings, friction, tables, dampings, drives, a shaken housing."""
    for seed in range(sized(600, 60, torture=100_000)):
        rng = np.random.default_rng([42, seed])
        tolerance = float(10.0 ** rng.uniform(-9.0, -3.0))
        result = gp.simulate(gp.load_case(train(rng, tolerance)), threads=1)
        assert result.runs[0].status not in STOPPED, (seed, result.message)
        assert broken_contacts(result, depth_of(tolerance)) == [], seed


def test_a_contact_that_comes_late_stops_the_run() -> None:
    """A flank that presses while its mode is open would appear compressed at its touch: the run stops with that sentence."""
    document = pair_document("external") | {"sleeves": {}}
    document["rotors"]["pinion"] |= {"drive": {"kind": "speed", "speed": 50.0}}
    document["rotors"]["wheel"] |= {"load": {"torque": 3.0}}
    course = course_of(gp.load_case(document))
    system, run = course.system, course.run
    while run.loads.contacts[:, PENETRATION].max() < 1e-7:
        assert Status(stepper.advance(system, run, 1)) == Status.PAUSED
    k = int(run.loads.contacts[:, PENETRATION].argmax())
    run.branch.modes[k] = OPEN
    run.g_0[system.switches["contact"] == k] *= -1.0
    assert Status(stepper.advance(system, run, 1)) == Status.MISSED_SWITCH


def test_samples_on_the_way_leave_no_trace() -> None:
    """The motion of trains with friction is the same to the last bit whatever is sampled of it.

    Located on what a sample had left behind, the edge of the band of slow sliding was a matter of the sampling.
    """
    for seed in range(sized(100, 15)):
        document = train(np.random.default_rng([48, seed]), 1e-5, friction=True)
        document["run"] |= {"duration": 1e-3, "max_steps": 3000}
        case = gp.load_case(document)
        plain, sampling = course_of(case), course_of(case, ["drive_force", "drive_penetration"], 501)
        sampling.sample_from(0.0, 5e5)
        ends = [course.follow(1e-3) for course in (plain, sampling)]
        assert ends[0] == ends[1], seed
        np.testing.assert_array_equal(plain.state, sampling.state, err_msg=str(seed))
        assert plain.steps == sampling.steps, seed
