"""What `--dry-run` foretells, against what a sweep then takes. Bounds are wide: other work on the machine comes and goes."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running import forecast as forecasting
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.folder import jobs_left, run_in
from gearplay.work.engine import Engine
from gearplay.work.rows import Outcome


@pytest.mark.slow
def test_memory_estimate__data_loaded_once_count_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first case of a second and all others of 20 ms, which workers share: 184 cases take half as long on two workers."""
    made = Sweep(load_sweep("space-temperature"))
    first = iter([1.0])

    def slow(self: Sweep, job: int, stop: Any = None) -> Any:
        time.sleep(next(first, 0.02))
        return [object_of(job)]

    def object_of(job: int) -> Outcome:
        return Outcome(job, job.to_bytes(32), 0, "", np.zeros(made.reducer.size), 0.02)

    monkeypatch.setattr(Sweep, "evaluate", slow)
    monkeypatch.setattr(forecasting, "worker_count", lambda: 2)
    found = forecasting.forecast(made, duration=0.5)
    assert 0.4 < found.seconds / (184 * 0.02 / 2) < 3.0
    assert found.workers == 2
    alone = forecasting.forecast(made, workers=1, duration=0.5)
    assert 0.4 < alone.seconds / (184 * 0.02) < 3.0


@pytest.mark.deep
@pytest.mark.parametrize(("name", "shard"), [("space-temperature", None), ("han2021-tolerances", (1, 24))])
def test_bundled_plans_take_what_was_foretold(
    tmp_path: Path, name: str, shard: tuple[int, int] | None
) -> None:
    made = Sweep(load_sweep(name))
    foretold = forecasting.forecast(made, duration=3.0)
    chosen = Engine("threads", None, None, None, shard)
    left = jobs_left(made, tmp_path, chosen)
    began = time.monotonic()
    count = run_in(made, tmp_path, chosen, left)
    taken = time.monotonic() - began
    assert 0.2 < taken / (foretold.seconds * count / foretold.cases) < 5.0
