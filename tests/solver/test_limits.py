"""Limits and Ctrl-C during the integration, the computation of samples and their saving."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.solver import integration as course_module
from gearplay.solver.simulate import run_members, run_one
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import ResourceError, SimulationError

PATIENCE = 3.0
"""What a third of a second may cost [s of processor time]: a busy machine does not lengthen it."""


@pytest.fixture(scope="module")
def long() -> gp.Result:
    """Return a motion that is simulated at once and takes many seconds to sample."""
    return gp.simulate("han2021", duration=20.0, transient=0.0)


@contextmanager
def ctrl_c(after: float) -> Iterator[list[float]]:
    """Press Ctrl-C after a time [s]; yield when it was, on the clock of this process."""
    pressed: list[float] = []

    def press() -> None:
        pressed.append(time.process_time())
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    timer = threading.Timer(after, press)
    timer.start()
    try:
        yield pressed
    finally:
        timer.cancel()


@pytest.mark.hostile
def test_ctrl_c_ends_sampling(long: gp.Result) -> None:
    with ctrl_c(0.05) as pressed, pytest.raises(KeyboardInterrupt):
        assert long.runs[0].samples.values.any()
    assert time.process_time() - pressed[0] < PATIENCE


@pytest.mark.hostile
def test_ctrl_c_ends_the_writing_of_samples(tmp_path: Path) -> None:
    result = gp.simulate("han2021", duration=5.0, transient=0.0)
    assert result.runs[0].samples.values.any()
    assert result.ds.sizes["time"] == 500_000  # libraries are loaded
    with ctrl_c(0.05) as pressed, pytest.raises(KeyboardInterrupt):
        result.save(tmp_path / "run.nc", full=True)
    assert time.process_time() - pressed[0] < PATIENCE
    assert list(tmp_path.iterdir()) == []


def test_the_limit_on_wall_time_counts_the_samples_too(tmp_path: Path) -> None:
    case = gp.replace(gp.load_case("han2021"), {"run.duration": 20.0, "run.max_wall_time": 0.5})
    result = gp.simulate(case)
    assert result.success
    began = time.process_time()
    with pytest.raises(ResourceError, match="the motion itself is complete"):
        result.save(tmp_path / "run.nc", full=True)
    assert time.process_time() - began < 0.5 + PATIENCE
    assert list(tmp_path.iterdir()) == []
    assert len(result.signal("ring.ax", window=(1.0, 1.1))) == 10_000


def test_a_motion_alone_keeps_the_limit() -> None:
    case = gp.replace(gp.load_case("external-pair"), {"run.max_wall_time": 0.3})
    with pytest.raises(SimulationError, match="limit on wall time"):
        gp.lyapunov(case, duration=1000.0)


@pytest.mark.parametrize("longest", [1e-9, 1e-4])
def test_a_chunk_is_bounded_by_time_and_leaves_no_trace(
    longest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = gp.replace(gp.load_case("external-pair"), {"run.duration": 2e-3, "run.sampling": 1e6})
    whole = run_one(case)
    monkeypatch.setattr(course_module, "CHUNK_TIME", longest)
    parts = run_one(case)
    assert np.array_equal(parts.values, whole.values)
    assert np.array_equal(parts.log, whole.log)
    assert parts.counters == whole.counters


@pytest.mark.slow
def test_a_limit_ends_a_run_that_samples_on_the_way(tmp_path: Path) -> None:
    """At 4 MHz: what was sampled until then is there."""
    case = gp.replace(
        gp.load_case("han2021"),
        {"run.duration": 10.0, "run.sampling": "4 MHz", "run.max_wall_time": 0.5},
    )
    began = time.process_time()
    result = gp.Result(case, run_members(case, [0]))
    assert time.process_time() - began < 0.5 + PATIENCE
    assert result.status == Status.OUT_OF_TIME
    assert 0 < len(result.time()) < 40_000_000
