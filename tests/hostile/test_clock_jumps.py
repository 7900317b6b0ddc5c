"""The wall clock is set while gearplay works: durations, limits and progress count on a clock that nobody can set."""

import itertools
import time
from pathlib import Path

import pytest

import gearplay as gp

SOURCE = Path(gp.__file__).parent


@pytest.fixture(autouse=True, params=[3600.0, -3600.0], ids=["forward", "back"])
def jumping(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the clock an hour on, or back, each time it is looked at."""
    now, looks = time.time(), itertools.count()
    monkeypatch.setattr(time, "time", lambda: now + request.param * next(looks))
    monkeypatch.setattr(time, "time_ns", lambda: int(1e9 * (now + request.param * next(looks))))


def test_a_limit_of_wall_time_is_not_reached_by_a_clock_that_is_set() -> None:
    case = gp.replace(gp.load_case("han2021"), {"run.max_wall_time": 300.0})
    run = gp.simulate(case, duration=0.5, transient=0.0, sampling=1e4)
    assert run.success, run.message
    assert 0.0 <= run.ds.attrs["wall_time"] < 300.0


def test_a_sweep_and_its_estimate_count_on_no_wall_clock(tmp_path: Path) -> None:
    told: list[tuple[float, float]] = []
    plan = {
        "case": "han2021",
        "axes": [{"name": "vx", "path": "rotors.ring.initial.vx", "values": [0.1, 0.2, 0.3]}],
        "set": {"run.duration": 0.02, "run.transient": 0.0},
        "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}],
    }
    found = gp.sweep(
        plan, out=tmp_path / "sweep", progress=lambda what, done, total: told.append((done, total))
    )
    assert told[-1][0] == told[-1][1] == 3
    assert found.account.finished == 3
