"""Limits: where models agree, where runs must stop, and what may not change a run's numbers."""

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import (
    Document,
    case_of,
    floating_document,
    free_pair_case,
    merged,
    mesh_at,
    pair_document,
    run_of,
    simulate_one,
    single_rotor_document,
)
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.model.pack import pack
from gearplay.parts.mesh.geometry import P_B, P_D
from gearplay.solver import integration as course_module
from gearplay.solver.simulate import run_batch, run_members
from gearplay.solver.status import WORDS, Status

# -- where the models agree --------------------------------------------------------------------------------


def penetrations(document: Document, y: np.ndarray) -> tuple[float, float]:
    """Return (p_d, p_b) [m] of a document's first mesh at a state."""
    out = mesh_at(pack(case_of(document)), 0, y)
    return float(out[P_D]), float(out[P_B])


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_drive_flanks_agree_to_first_order(kind: str) -> None:
    """Coupled minus uncoupled p_d is of second order in the displacement: a tenth of it gives a hundredth."""
    rng = np.random.default_rng(2)
    for _ in range(5):
        direction = np.zeros(12)
        direction[[0, 1, 3, 4]] = rng.standard_normal(4)
        gaps = []
        for size in (1e-4, 1e-5):
            p = [
                penetrations(pair_document(kind, backlash_model=m), size * direction)[0]
                for m in ("coupled", "uncoupled")
            ]
            gaps.append(p[0] - p[1])
        assert abs(gaps[0]) < 20.0 * (1e-4) ** 2 / 0.08 * 10.0
        assert gaps[1] == pytest.approx(gaps[0] / 100.0, rel=0.05, abs=1e-16)


@pytest.mark.parametrize("kind", ["internal", "external"])
@pytest.mark.parametrize("moved", [0.0, 2e-4])
def test_models_agree_on_rigid_centres(kind: str, moved: float) -> None:
    """Where no centre moves, coupled and uncoupled are one model, at any centre distance."""
    document = pair_document(kind, mesh={"transmission_error": [{"order": 1, "amplitude": 2e-5}]})
    wheel = document["meshes"][0]["driven"]
    document["sleeves"] = {}
    distance = 0.16 if kind == "external" else -0.08
    document["rotors"]["pinion"] |= {"drive": {"kind": "speed", "speed": 50.0}, "position": [0.0, 0.0]}
    document["rotors"][wheel] |= {
        "load": {"torque": 3.0},
        "position": [distance * (1.0 - moved / abs(distance)), 0.0],
    }
    if kind == "external":
        document["rotors"][wheel]["position"] = [distance + moved, 0.0]
    runs = [simulate_one({**document, "backlash_model": m}, duration=2e-2) for m in ("coupled", "uncoupled")]
    assert len(runs[0].log) > 3
    np.testing.assert_allclose(
        runs[1].signal("backlash", f"pinion-{wheel}"),
        runs[0].signal("backlash", f"pinion-{wheel}"),
        rtol=1e-10,
    )
    np.testing.assert_allclose(
        runs[1].signal("theta", wheel), runs[0].signal("theta", wheel), rtol=0.0, atol=1e-11
    )


# -- where runs stop ---------------------------------------------------------------------------------------


def stopped(document: Document, status: Status, **policy: Any) -> str:
    """Run a document that must stop with ``status``; return its message, which names the time."""
    run = run_members(case_of(document), [0], signals=["x"], **policy)[0]
    assert (run.status, run.success) == (status, False)
    assert WORDS[status] in run.message
    assert "Stopped at t =" in run.message
    assert np.all(np.isfinite(run.values[: len(run.time)]))
    return run.message


def test_teeth_out_of_mesh() -> None:
    """Two free gears that fly apart stop where their tips leave each other, two modules off."""
    document = floating_document("external")
    document["rotors"]["wheel"]["initial"] = {"vx": 20.0}
    message = stopped(document, Status.CANNOT_MESH)
    assert "centre distance" in message
    assert message.endswith("It is pinion-wheel.")
    run = run_members(case_of(document), [0])[0]
    assert run.reached == pytest.approx(8e-3 / 20.0, rel=1e-6)


def test_internal_pair_leaves_mesh_when_its_centres_meet() -> None:
    """An internal pair's tips leave each other when the centres approach by two modules."""
    document = floating_document("internal", mesh={"module": 1e-3})
    document["rotors"]["ring"]["teeth"] = 260  # c0 is 7.2 mm below A0 = 120 mm: the tips part first
    document["rotors"]["pinion"]["initial"] = {"vx": -20.0}
    run = run_members(case_of(document), [0])[0]
    assert run.status == Status.CANNOT_MESH
    assert run.reached == pytest.approx(2e-3 / 20.0, rel=1e-6)


def test_acceleration_for_ever() -> None:
    """A free disc under absurd gravity is stopped as a blow-up."""
    disc = {"mass": 1.0, "inertia": 1.0, "floating": True}
    document = {"rotors": {"disc": disc}, "gravity": [1e6, 0.0], "run": {"duration": 2.0, "sampling": 10.0}}
    assert "accelerates for ever" in stopped(document, Status.BLOW_UP)


def test_not_a_number() -> None:
    """A state that turns NaN stops the run with its own status."""
    case = case_of(
        {"rotors": {"disc": {"mass": 1.0, "inertia": 1.0, "floating": True}}, "run": {"duration": 1.0}}
    )
    packed = pack(case)
    for poison in (np.nan, np.inf):
        motion = run_of(case, packed)
        motion.clock[kernel.T_END] = 1.0
        motion.active_set.origin[3] = poison
        assert stepper.advance(packed.system, motion, 1000) == kernel.NOT_FINITE
        motion.y[3] = poison
        assert stepper.begin(packed.system, motion) == kernel.NOT_FINITE
    assert "NaN" in WORDS[Status.NOT_FINITE]


def test_step_below_the_resolution_of_time() -> None:
    """An absurdly stiff and light contact needs steps that time cannot resolve."""
    sleeve = {"radial_clearance": 1e-6, "stiffness": 1e24, "law": "hunt-crossley", "restitution": 1.0}
    disc = {"mass": 1e-20, "inertia": 1.0, "initial": {"x": 1e-4}}
    document = {
        "rotors": {"disc": disc},
        "sleeves": {"disc": sleeve},
        "run": {"duration": 1.0, "sampling": 10.0},
    }
    assert "below the resolution" in stopped(document, Status.STEP_TOO_SMALL)


def test_endless_chatter() -> None:
    """The printed dead band with b_t < 0 pushes towards g = 0 from both sides: chatter, not a hang."""
    document = pair_document("external", mesh={"damping": {"maximum": 3000.0}}, formulation="as_published")
    document["sleeves"], document["run"]["duration"] = {}, 0.2
    document["rotors"]["pinion"] |= {"drive": {"kind": "speed", "speed": 10.0}, "position": [0.0, 0.0]}
    document["rotors"]["wheel"] |= {
        "drive": {"kind": "torque", "torque": -100.0},
        "position": [0.16 - 2e-4, 0.0],
    }
    assert "switch endlessly" in stopped(document, Status.CHATTER)


def test_limits_of_the_run() -> None:
    """Limits on steps and wall time end a run and keep what was computed."""
    document = free_pair_case("internal", "coupled", 1)
    document["run"]["duration"] = 2.0
    stopped(merged(document, {"run": {"max_steps": 1000}}), Status.TOO_MANY_STEPS)
    stopped(merged(document, {"run": {"max_wall_time": 1e-6}}), Status.OUT_OF_TIME)


def test_every_status_has_words() -> None:
    """Each status of the kernels and the solver is said in a sentence."""
    assert set(WORDS) == set(Status)
    assert all(words.endswith(".") and len(words) > 4 for words in WORDS.values())


# -- what may not change a run -----------------------------------------------------------------------------

SCRIPT = """
import json, sys
from gearplay.model.case import Case
from gearplay.solver.simulate import run_members
run = run_members(Case.model_validate(json.loads(sys.argv[1])), [1], signals=["x", "theta"])[0]
print(json.dumps([int(run.status), run.final_state.tolist(), run.log.tolist()]))
"""


@pytest.mark.slow
def test_interpreted_kernels_give_the_same_numbers() -> None:
    """GEARPLAY_INTERPRETED=1: the same state and contact log to 1e-12 after 2 ms of rattle."""
    document = free_pair_case("internal", "coupled", 1)
    document["run"] |= {"duration": 2e-3, "tolerance": 1e-8}
    document["meshes"][0]["damping"] = {"ratio": 0.05}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps(document)],
        env={**os.environ, "GEARPLAY_INTERPRETED": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    status, state, log = json.loads(done.stdout)
    run = simulate_one(document, member=1, signals=["x", "theta"])
    assert status == run.status
    assert len(run.log) >= 6
    np.testing.assert_allclose(state, run.final_state, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(log, run.log, rtol=1e-9, atol=1e-12)


def test_ensembles_do_not_depend_on_threads_or_company() -> None:
    """Members are bit-identical on one thread, on many, in any order and alone."""
    case = case_of(
        merged(free_pair_case("internal", "coupled", 1), {"run": {"ensemble": 5, "duration": 5e-3}})
    )
    alone = run_members(case, range(5), threads=1)
    together = run_members(case, range(5), threads=5)
    backwards = run_members(case, reversed(range(5)), threads=2)[::-1]
    single = [run_members(case, [i])[0] for i in range(5)]
    for runs in (together, backwards, single):
        for a, b in zip(alone, runs, strict=True):
            np.testing.assert_array_equal(a.values, b.values)
            np.testing.assert_array_equal(a.final_state, b.final_state)
            np.testing.assert_array_equal(a.log, b.log)
    assert not np.array_equal(alone[1].final_state, alone[2].final_state)


def test_lists_of_cases_equal_their_single_runs() -> None:
    """Cases of different size on one pool, in any order: bit-identical to each alone."""
    policy = {"run": {"duration": 3e-3, "ensemble": 2}}
    cases = [case_of(merged(free_pair_case("internal", "coupled", seed), policy)) for seed in (1, 2)]
    sleeve = {"radial_clearance": 1e-4, "stiffness": 1e10, "exponent": 1.5, "restitution": 0.9}
    cases += [case_of(merged(single_rotor_document(sleeve), policy))]
    jobs = [(case, range(case.run.ensemble)) for case in cases]
    together = run_batch(jobs, threads=3)
    backwards = run_batch(jobs[::-1], threads=1)[::-1]
    assert [len(runs) for runs in together] == [2, 2, 2]
    for case, runs, others in zip(cases, together, backwards, strict=True):
        for run, other, alone in zip(runs, others, run_members(case, range(2)), strict=True):
            np.testing.assert_array_equal(run.values, alone.values)
            np.testing.assert_array_equal(run.values, other.values)
    assert [result.success for result in gp.simulate(cases)] == [True, True, True]
    assert run_batch([]) == []


@pytest.mark.parametrize("steps", [1, 3, 50])
def test_chunks_leave_no_trace(steps: int) -> None:
    """Returning after every few steps and coming back gives the same bits as one go."""
    case = case_of(free_pair_case("internal", "coupled", 1))
    packed = pack(case)
    ends = []
    for chunk in (10_000_000, steps):
        motion = run_of(case, packed)
        motion.clock[kernel.T_END] = 0.02
        while (status := stepper.advance(packed.system, motion, chunk)) == kernel.PAUSED:
            pass
        assert status == kernel.DONE
        ends.append((motion.y.copy(), motion.log.copy(), motion.counts.copy()))
    for a, b in zip(*ends, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("chunk", [1, 7, 1000])
@pytest.mark.parametrize("capacity", [40, 16_384])
def test_emptying_the_log_leaves_no_trace(chunk: int, capacity: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A recorded run is bit-identical however often its log of contacts is emptied on the way."""
    document = merged(free_pair_case("internal", "coupled", 1), {"run": {"duration": 5e-3, "sampling": 1e6}})
    monkeypatch.setattr(course_module, "LOG_CAPACITY", capacity)
    whole = simulate_one(document)
    monkeypatch.setattr(course_module, "CHUNK_STEPS", chunk)
    parts = simulate_one(document)
    np.testing.assert_array_equal(parts.final_state, whole.final_state)
    np.testing.assert_array_equal(parts.values, whole.values)
    np.testing.assert_array_equal(parts.log, whole.log)


def test_a_drive_without_a_ramp_keeps_its_speed_beside_one_that_ramps() -> None:
    """Only what follows the ramp starts at rest: a prescribed speed is prescribed from the first instant."""
    case = gp.load_case("external-pair")
    document = case.model_dump(mode="json", exclude_unset=True)
    steady = {"kind": "speed", "speed": "300 rpm"}
    document["rotors"]["fan"] = {"mass": 1.0, "inertia": 0.01, "drive": steady}
    run = simulate_one(
        gp.replace(case_of(document), {"run.duration": 0.2, "run.transient": 0.0, "run.sampling": 1e3})
    )
    assert np.allclose(run.signal("omega", "fan"), 10.0 * np.pi, rtol=1e-12)
    expected = np.minimum(run.time / 0.1, 1.0) * 1000.0 / 30.0 * np.pi
    assert np.allclose(run.signal("omega", "input"), expected, rtol=1e-9, atol=1e-9)


def test_a_ramp_that_has_ended_turns_nothing_on() -> None:
    """A pinion that is pressed in its sleeve is integrated: from the end of its ramp on it keeps the speed of its drive."""
    case = gp.load_case("han2021")
    document = case.model_dump(mode="json", exclude_unset=True)
    document["gravity"] = [0.0, -9.81]
    document["sleeves"]["pinion"] = dict(document["sleeves"]["ring"])
    document["rotors"]["pinion"]["drive"] = {"kind": "speed", "speed": "120 rpm", "ramp": "10 ms"}
    run = simulate_one(
        gp.replace(case_of(document), {"run.duration": 0.05, "run.transient": 0.0, "run.sampling": 1e4})
    )
    expected = np.minimum(run.time / 0.01, 1.0) * 4.0 * np.pi
    assert np.allclose(run.signal("omega", "pinion"), expected, rtol=1e-9, atol=1e-9)
    assert np.mean(run.signal("sleeve_penetration", "pinion") > 0.0) > 0.1
