"""Members on a device: what comes back is what a thread of the processor gives, bit for bit where its kernels are the same.

The device is one in the processor's memory (`emulated_device`); what only a CUDA device shows stands in `tests/cuda`.
"""

import threading
from collections.abc import Sequence

import numpy as np
import pytest
from tests.emulated_device import Emulated

import gearplay as gp
from gearplay.device.fleet import DeviceError
from gearplay.device.words import LANES, Words
from gearplay.model.pack import pack
from gearplay.solver import on_device, simulate
from gearplay.solver.course import Course
from gearplay.solver.job import Job, Watch
from gearplay.solver.simulate import job_of, run_batch, run_one
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import InputError, ResourceError

QUICK = ["run.duration=20ms", "run.transient=10ms", "run.sampling=10kHz"]


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Emulated:
    made = Emulated()
    monkeypatch.setattr(on_device, "cuda", lambda: made.devices)
    return made


def together(jobs: Sequence[Job], stop: threading.Event | None = None) -> list[Trajectory]:
    return simulate.run_on_cuda(jobs, stop)


def assert_same(one: Trajectory, other: Trajectory) -> None:
    assert one.status == other.status
    assert one.member == other.member
    assert one.counters == other.counters
    assert one.reached == other.reached
    assert np.array_equal(one.final_state, other.final_state)
    assert np.array_equal(one.end.memory, other.end.memory)
    assert np.array_equal(one.end.latch, other.end.latch)
    assert np.array_equal(one.log, other.log)
    assert np.array_equal(one.values, other.values)
    for field in ("share_of_time", "impacts_per_second", "max_impact_speed", "peak_force", "max_penetration"):
        assert np.array_equal(getattr(one.statistics, field), getattr(other.statistics, field)), field


@pytest.mark.parametrize("name", ["han2021", "external-pair", "pinion-idler-ring"])
def test_an_ensemble_is_that_of_the_processor(device: Emulated, name: str) -> None:
    case = gp.load_case(name, QUICK)
    members = range(LANES + 5)  # more than a tile, less than two
    theirs = run_batch([(case, members)], device="cuda")[0]
    for one, other in zip(theirs, run_batch([(case, members)])[0], strict=True):
        assert_same(one, other)
    assert not device.held  # all memory was given back


def test_cases_with_other_numbers_run_together_and_others_apart(device: Emulated) -> None:
    plays = [
        gp.load_case("han2021", [*QUICK, f"meshes.0.backlash={n}um", f"run.transient={5 * (n % 2)}ms"])
        for n in (50, 100, 151)
    ]
    cases = [plays[0], gp.load_case("external-pair", QUICK), *plays[1:]]
    jobs = [job_of(case, 1, signals=["ring.x", "wheel.x"][:1], place=n) for n, case in enumerate(plays)]
    jobs.insert(1, job_of(cases[1], 1, signals=[], place=3))
    found = together(jobs)
    assert max(device.threads) == 3  # those of one form
    for one, case in zip(found, cases, strict=True):
        assert_same(one, run_one(case, 1, signals=["ring.x"] if "ring" in case.rotors else []))


def test_a_member_goes_on_from_an_end(device: Emulated) -> None:
    case = gp.load_case("external-pair", QUICK)  # whose flanks stay pressed, with the speed of their impact
    end = run_one(case, 1, signals=[]).end
    assert end.latch.any()
    other = run_one(case, 2, signals=[]).end
    one, two = (
        job_of(case, 1, signals=["output.x"], origin=end),
        job_of(case, 1, signals=["output.x"], origin=other),
    )
    two.packed, two.place = one.packed, 1  # as those of one call share it
    for found, origin in zip(together([one, two]), (end, other), strict=True):
        assert_same(found, run_one(case, 1, signals=["output.x"], origin=origin))


def test_memory_for_few_runs_takes_several_waves(device: Emulated) -> None:
    case = gp.load_case("han2021", QUICK)
    course = Course(
        case, pack(case), np.zeros(12), places=np.zeros(0, dtype=np.int64), rows=np.empty((0, 200)), log=256
    )
    device.size = int(10.5 / 0.8 * 8 * Words(course.run).size)
    found = run_batch([(case, range(25))], signals=[], device="cuda")[0]
    assert max(device.threads) == 10
    assert [run.member for run in found] == list(range(25))
    for one, other in zip(found, run_batch([(case, range(25))], signals=[])[0], strict=True):
        assert_same(one, other)
    device.size = 100
    with pytest.raises(ResourceError, match="does not hold one run"):
        run_batch([(case, range(2))], device="cuda")


def test_a_device_that_fails_is_told_of(device: Emulated, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(size: int) -> int:
        if len(device.held) == 3:
            raise DeviceError("out of memory")
        return Emulated.allocate(device, size)

    monkeypatch.setattr(device, "allocate", full)
    with pytest.raises(ResourceError, match="device: out of memory, and what ran there is lost"):
        run_batch([(gp.load_case("han2021", QUICK), range(40))], device="cuda")
    assert not device.held


def test_a_log_longer_than_its_room_is_whole(device: Emulated, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_device, "LOG", 1)  # room for what one step may log, and little more
    case = gp.load_case("pinion-idler-ring", [*QUICK, "run.transient=0", "run.duration=80ms"])
    room = 8 * pack(case).system.switches.size + 8
    found = run_batch([(case, range(3))], signals=[], device="cuda")[0]
    for one, other in zip(found, run_batch([(case, range(3))], signals=[])[0], strict=True):
        assert len(other.log) > room
        assert_same(one, other)


def test_who_is_done_takes_no_turns(device: Emulated, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_device, "TURN_TIME", 0.0)  # a step a turn
    monkeypatch.setattr(on_device, "FIRST_STEPS", 1)
    case = gp.load_case("han2021", [*QUICK, "run.transient=0"])
    steps = sorted(run.counters.steps for run in run_batch([(case, range(6))], signals=[])[0])
    run_batch([(case, range(6))], signals=[], device="cuda")
    left = [sum(each > n for each in steps) for n in range(len(device.threads))]
    # a member is done in the turn of its last step, or in the one after it, which takes it to the end
    assert all(few <= there for few, there in zip(left, device.threads, strict=True))
    assert device.threads[-1] < 6
    assert sorted(device.threads, reverse=True) == device.threads


def test_limits_and_the_wish_to_stop_are_heard(device: Emulated) -> None:
    case = gp.load_case("external-pair", [*QUICK, "run.max_steps=40"])
    few, many = together([job_of(case, 1, signals=[]), job_of(case, 2, signals=[], place=1)])
    assert few.status == many.status == Status.TOO_MANY_STEPS
    assert few.counters.steps == 40
    stop = threading.Event()
    stop.set()
    (none,) = together([job_of(case, 1, signals=[])], stop)
    assert none.status == Status.INTERRUPTED
    assert none.reached == 0.0
    late = gp.load_case("han2021", [*QUICK, "run.max_wall_time=1ns"])
    (out,) = together([job_of(late, 1, signals=[])])
    assert out.status == Status.OUT_OF_TIME


def test_progress_is_told(device: Emulated) -> None:
    told: list[tuple[float, float]] = []
    watch = Watch(0.06, lambda done, total: told.append((done, total)), threading.Event())
    case = gp.load_case("han2021", QUICK)
    on_device.run_together([job_of(case, n, signals=[], place=n) for n in (1, 2)], watch)
    assert told[-1] == (pytest.approx(0.06), 0.06)


def test_a_device_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of cpu, cuda"):
        gp.simulate("han2021", duration=0.01, device="tpu")


def test_simulate_takes_the_device(device: Emulated) -> None:
    ours = gp.simulate("han2021", duration=0.01, transient=0.0, ensemble=3, device="cuda")
    theirs = gp.simulate("han2021", duration=0.01, transient=0.0, ensemble=3)
    assert device.threads
    for name in ("x", "ax"):
        assert np.array_equal(ours.ds[name], theirs.ds[name])
