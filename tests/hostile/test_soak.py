"""Ten minutes of runs in one process: memory does not grow."""

import gc
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import gearplay as gp
from depth import TORTURE

pytestmark = [
    pytest.mark.hostile,
    pytest.mark.skipif(not TORTURE, reason="lasts ten minutes: make torture"),
    pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is told by Linux"),
]
LASTS = 600.0  # s
GROWTH = 20e6  # B


def resident() -> int:
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_memory_does_not_grow(tmp_path: Path, tried: Callable[[int], None]) -> None:
    """A run with its signals, one that is written and read, one that is refused; growth after a tenth of the time."""
    file, end = tmp_path / "run.nc", time.monotonic() + LASTS
    early, count = 0, 0
    while time.monotonic() < end:
        run = gp.simulate("han2021", duration=0.05, transient=0.0, sampling=1e4, ensemble=2)
        assert run.success
        run.save(file, overwrite=True)
        assert gp.read_result(file).ds.sizes == run.ds.sizes
        with pytest.raises(gp.InputError):
            gp.simulate("han2021", duration=-1.0)
        count += 1
        if not early and time.monotonic() > end - 0.9 * LASTS:
            early = resident()
    growth = resident() - early
    assert growth < GROWTH
    tried(count)
