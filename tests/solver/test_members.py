"""Members on reused runs equal runs of their own, bit for bit; limits and cancellation in the middle of a batch."""

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from tests.building import case_of, floating_document

import gearplay as gp
from gearplay.integrate import members as kernel
from gearplay.kernels.layout import vx_of
from gearplay.model.initial import Starts
from gearplay.model.pack import pack
from gearplay.model.seeds import generators
from gearplay.solver import members as solver
from gearplay.solver.job import Simulation
from gearplay.solver.members import Pool, ReusedRun
from gearplay.solver.simulate import run_few, run_members, run_one
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, choose_columns
from gearplay.vocabulary.errors import InputError

CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "free pair": ("han2021", {"run.duration": 0.2, "run.transient": 0.1, "run.sampling": 1e3}),
    "no transient": ("han2021", {"run.duration": 0.05, "run.transient": 0.0, "run.start": "drawn"}),
    "ramp": ("han2021", {"run.duration": 0.2, "run.transient": 0.05, "rotors.pinion.drive.ramp": 0.1}),
    "loaded": ("external-pair", {"run.duration": 0.02, "run.transient": 0.01}),
    "planetary": ("planetary-reducer", {"run.duration": 0.01, "run.transient": 0.005}),
    "stages": ("two-stage-reducer", {"run.duration": 0.01, "run.transient": 0.005}),
    "fixed steps": ("han2021", {"run.duration": 5e-3, "run.transient": 2e-3, "run.fixed_step": 1e-6}),
    "contacts by stage": (
        "han2021",
        {
            "run.duration": 5e-3,
            "run.transient": 0.0,
            "run.fixed_step": 1e-6,
            "run.fixed_step_contacts": "stage",
        },
    ),
    "limited": ("han2021", {"run.duration": 0.5, "run.transient": 0.1, "run.max_steps": 100}),
}


@pytest.fixture(autouse=True)
def one_block(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all members of a thread be in one block, few as they are."""
    monkeypatch.setattr(solver, "BLOCKS_PER_THREAD", 1)


def named(name: str) -> gp.Case:
    source, changes = CASES[name]
    return gp.replace(gp.load_case(source), changes)


def assert_equal(one: Trajectory, other: Trajectory) -> None:
    """Everything but the wall time is the same to the last bit."""
    for name in ("member", "first_sample", "sampling", "columns", "status", "counters", "reached", "message"):
        assert getattr(one, name) == getattr(other, name), name
    for name in ("values", "log", "final_state"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for group in ("statistics", "end"):
        for name, value in getattr(one, group)._asdict().items():
            np.testing.assert_array_equal(value, getattr(getattr(other, group), name), err_msg=name)


@pytest.mark.parametrize("name", sorted(CASES))
def test_members_equal_runs_of_their_own(name: str) -> None:
    case, numbers = named(name), [3, 0, 7, 1, 2]
    together = run_members(case, numbers, threads=1)
    for member, run in zip(numbers, together, strict=True):
        assert_equal(run, run_one(case, member))


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_threads_and_blocks_change_nothing(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    case, expected = named("free pair"), run_members(named("free pair"), range(20), threads=1)
    monkeypatch.setattr(solver, "MOST_MEMBERS", 3)
    for run, other in zip(run_members(case, range(20), threads=threads), expected, strict=True):
        assert_equal(run, other)


@pytest.mark.parametrize("capacity", [40, 64])
def test_a_log_that_fills_up_loses_nothing(capacity: int, monkeypatch: pytest.MonkeyPatch) -> None:
    case = named("free pair")
    expected = run_members(case, range(36), threads=1)
    monkeypatch.setattr(solver, "LOG_CAPACITY", capacity)
    found = run_members(case, range(36), threads=1)
    assert sum(len(run.log) for run in found) > 2 * capacity
    for run, other in zip(found, expected, strict=True):
        assert_equal(run, other)


@pytest.mark.parametrize("name", ["free pair", "loaded", "stages"])
def test_reused_run__leaves_nothing_to_the_next_member(name: str) -> None:
    """Garbage in all arrays of a reused run, those of samples included, does not change the results."""
    case = named(name)
    pool = Pool()
    expected = run_few(case, [1, 2], Pool())
    wanted = Simulation(
        case,
        pack(case),
        choose_columns(pack(case), None),
        case.run.sampling,
        case.run.duration,
        case.run.transient,
    )
    reused = ReusedRun(wanted.packed, wanted.kept[1])
    take = reused.take

    def spoil(given: Simulation) -> None:
        take(given)
        for _, array in kernel._arrays(reused.run):
            array[...] = np.nan if array.dtype.kind in "fc" else 1  # whole numbers are places, too
        for array in (reused.run.free_states, reused.run.shown, reused.run.log):
            array[:] = np.nan

    reused.take = spoil  # type: ignore[method-assign]
    pool.idle.append(reused)
    found = run_few(case, [1, 2], pool)
    assert pool.idle == [reused]
    for run, other in zip(found, expected, strict=True):
        assert_equal(run, other)


def test_a_reused_run_takes_over_the_numbers_of_another_case() -> None:
    """Cases of one build share a run; one of another build gets its own."""
    pool, base = Pool(), named("free pair")
    changes: list[dict[str, Any]] = [
        {"meshes.0.backlash": 5e-5},
        {"run.tolerance": 1e-8},
        {"rotors.ring.mass": 0.7},
        {"rotors.pinion.drive.speed": 20.0},
        {"run.fixed_step": 1e-5, "run.duration": 5e-3},
        {},
    ]
    run_few(base, [1], pool)
    (first,) = pool.idle
    for change in changes:
        case = gp.replace(base, change)
        assert_equal(run_few(case, [2], pool)[0], run_one(case, 2))
        assert pool.idle == [first]
    other = named("stages")
    assert_equal(run_few(other, [2], pool)[0], run_one(other, 2))
    assert len(pool.idle) == 1
    assert pool.idle[0] is not first


def stopped_after(count: int, members: int) -> Sequence[Trajectory]:
    """Return the runs of a batch that was cancelled in the middle of a member."""
    case, stop, calls = named("free pair"), threading.Event(), 0

    def tick(*_: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == count:
            stop.set()

    return run_members(case, range(members), threads=1, progress=tick, stop=stop)


def test_cancellation__keeps_computed_members(monkeypatch: pytest.MonkeyPatch) -> None:
    """Members before are complete, the present one ends where it is, those after it have not begun."""
    monkeypatch.setattr(solver, "next_steps", lambda steps, took: 30)
    found, expected = stopped_after(9, 12), run_members(named("free pair"), range(12))
    statuses = [run.status for run in found]
    ended = statuses.index(Status.INTERRUPTED)
    assert 0 < ended < 11
    assert set(statuses[:ended]) == {Status.DONE}
    assert set(statuses[ended:]) == {Status.INTERRUPTED}
    for run, other in zip(found[:ended], expected, strict=False):
        assert_equal(run, other)
    partial, whole = found[ended], expected[ended]
    assert 0.0 < partial.reached < whole.reached
    np.testing.assert_array_equal(partial.log, whole.log[: len(partial.log)])
    np.testing.assert_array_equal(partial.values, whole.values[: len(partial.values)])
    for k, run in enumerate(found[ended + 1 :], start=ended + 1):
        assert (run.reached, run.counters.steps, len(run.log), len(run.values)) == (0.0, 0, 0, 0)
        np.testing.assert_array_equal(
            run.final_state, Starts(named("free pair"), pack(named("free pair"))).state(k)
        )


def test_no_time_is_left_in_the_middle() -> None:
    case = gp.replace(
        gp.load_case("han2021"), {"run.duration": 20.0, "run.transient": 0.0, "run.max_wall_time": 0.02}
    )
    statuses = [run.status for run in run_members(case, range(50), signals=[])]
    assert statuses[0] in (Status.DONE, Status.OUT_OF_TIME)
    assert statuses[-1] == Status.OUT_OF_TIME


def test_a_member_that_fails_leaves_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Free gears, of which two members fly apart and one blows up: as alone, and the others as without them."""
    case = case_of(floating_document("external"))
    place = vx_of(pack(case).system, list(case.rotors).index("wheel"))
    drawn = Starts.of_members

    def pushed(starts: Starts, numbers: Sequence[int]) -> Any:
        found = drawn(starts, numbers)
        for m, number in enumerate(numbers):
            found[m, place] += {1: 20.0, 3: np.inf, 4: 30.0}.get(number, 0.0)
        return found

    expected = [
        Status.DONE,
        Status.CANNOT_MESH,
        Status.DONE,
        Status.NOT_FINITE,
        Status.CANNOT_MESH,
        Status.DONE,
    ]
    good = run_members(case, [0, 2, 5], duration=2e-3)
    monkeypatch.setattr(Starts, "of_members", pushed)
    monkeypatch.setattr(Starts, "of_member", lambda starts, number: pushed(starts, [number])[0])
    runs = run_members(case, range(6), duration=2e-3, threads=1)
    assert [run.status for run in runs] == expected
    assert runs[1].message.endswith("It is pinion-wheel.")
    for run, other in zip((runs[0], runs[2], runs[5]), good, strict=True):
        assert_equal(run, other)
    for member in (1, 3, 4):
        assert_equal(runs[member], run_one(gp.replace(case, {"run.duration": 2e-3}), member))


def test_the_limit_on_steps_is_of_each_member() -> None:
    limited, free = named("limited"), gp.replace(named("limited"), {"run.max_steps": None})
    runs, whole = run_members(limited, range(12)), run_members(free, range(12))
    for run, other in zip(runs, whole, strict=True):
        assert run.counters.steps == min(100, other.counters.steps)
        assert run.status == (Status.DONE if other.counters.steps <= 100 else Status.TOO_MANY_STEPS)
    assert {run.status for run in runs} == {Status.DONE, Status.TOO_MANY_STEPS}


@pytest.mark.parametrize("steps", [50, 2000])
def test_long_members_keep_states_on_the_way(steps: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Signals that are requested later are the same, whether states were stored during the run or after it."""
    case = gp.replace(named("free pair"), {"run.ensemble": 4})
    written = run_members(case, range(4))
    monkeypatch.setattr(solver, "CHUNK_STEPS", steps)
    for run, other in zip(gp.simulate(case, threads=2).runs, written, strict=True):
        assert_equal(run, other)


@pytest.mark.parametrize("seed", [0, 5, 2**31, 2**32, 2**40 + 3, 2**70 + 9, 2**200])
def test_generators_are_those_of_numpy(seed: int) -> None:
    members = [*range(1, 20), 2**31, 2**32 - 1]
    for member, generator in zip(members, generators(seed, members), strict=True):
        expected = np.random.default_rng([seed, member])
        np.testing.assert_array_equal(generator.random(5), expected.random(5))
        np.testing.assert_array_equal(generator.standard_normal(5), expected.standard_normal(5))


@pytest.mark.parametrize("name", ["free pair", "loaded", "planetary", "stages"])
def test_starts_do_not_depend_on_company(name: str) -> None:
    case = named(name)
    starts = Starts(case, pack(case))
    numbers = [4, 0, 9, *range(20, 40)]
    for member, start in zip(numbers, starts.of_members(numbers), strict=True):
        np.testing.assert_array_equal(start, Starts(case, pack(case)).of_member(member))


def test_a_batch_may_pause_at_any_step() -> None:
    """`advance_members` called step by step gives the results of one call."""
    case = named("free pair")
    packed = pack(case)
    wanted = Simulation(case, packed, choose_columns(packed, []), 1e3, 0.2, 0.1, sample=False)
    ends = []
    for steps in (1, 7, 10**6):
        reused = Pool().take(wanted)
        times = np.array([0.1, 0.3, 1e-3])
        batch = kernel.make_batch(
            reused.run, reused.words, reused.fresh, wanted.starts.of_members([1, 2, 3]), times, 0, 10**9
        )
        while kernel.advance_members(packed.system, reused.run, batch, steps) != Status.DONE:
            pass
        ends.append((batch.states, batch.tallies, batch.counts, batch.log_ends))
    for found in ends[1:]:
        for one, other in zip(ends[0], found, strict=True):
            np.testing.assert_array_equal(one, other)


def test_given_centres_that_cannot_mesh_are_refused() -> None:
    case = named("free pair")
    with pytest.raises(InputError, match="able to mesh"):
        run_members(gp.replace(case, {"rotors.ring.initial.x": 0.05}), [0, 1])
