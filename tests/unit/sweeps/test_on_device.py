"""Sweeps whose cases run together on a device: the product of threads, failures with their reasons, chains refused."""

import threading
from pathlib import Path

import numpy as np
import pytest
from tests.emulated_device import Emulated
from tests.sweep_products import BACKLASH, PLAY, SHORT, plan_of

import gearplay as gp
from gearplay.solver import on_device
from gearplay.solver.status import Status
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running import engines
from gearplay.sweeps.running.engines import Engine
from gearplay.sweeps.running.evaluate import REFUSED, Sweep
from gearplay.vocabulary.errors import InputError


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Emulated:
    made = Emulated()
    monkeypatch.setattr(on_device, "cuda", lambda: made.devices)
    monkeypatch.setattr(engines, "TOGETHER", 10)
    return made


def test_the_product_is_that_of_threads(device: Emulated, tmp_path: Path) -> None:
    far = {
        "name": "far",
        "path": "rotors.ring.initial.x",
        "values": ["0 um", "8 mm"],
    }  # where teeth cannot mesh
    limit = {"name": "limit", "path": "run.max_steps", "values": [1, 1000]}
    plan = plan_of(far, limit, BACKLASH, members=3)
    ours = gp.sweep(plan, folder=tmp_path / "device", engine=Engine("cuda")).ds
    theirs = gp.sweep(plan, folder=tmp_path / "threads").ds
    assert 2 <= max(device.threads) <= 10  # those that were not refused
    assert {REFUSED, Status.TOO_MANY_STEPS, Status.DONE} <= set(theirs.status.values.ravel().tolist())
    assert set(ours) == set(theirs)
    for name in ("rms", "hits", "status"):
        np.testing.assert_array_equal(ours[name], theirs[name])


def test_what_was_stopped_is_not_kept(device: Emulated) -> None:
    sweep, stop = Sweep(load_sweep(plan_of(PLAY))), threading.Event()
    stop.set()
    assert sweep.evaluate_together(range(4), stop) == []
    assert list(engines.run_cuda(sweep, range(4), stop=stop)) == []


def test_chains_are_refused(device: Emulated) -> None:
    carried = {
        "name": "speed",
        "path": "rotors.pinion.drive.speed",
        "low": "60 rpm",
        "high": "90 rpm",
        "count": 3,
    }
    sweep = Sweep(
        load_sweep(
            plan_of(carried, carry={"axis": "speed", "ramp": "1 ms"}, set={**SHORT, "run.transient": 0.01})
        )
    )
    with pytest.raises(InputError, match="must be threads or processes for a sweep whose cases go on"):
        list(engines.run_cuda(sweep, range(1)))


def test_another_engine_is_refused() -> None:
    with pytest.raises(InputError, match="must be threads, processes or cuda"):
        Engine("tpu")
