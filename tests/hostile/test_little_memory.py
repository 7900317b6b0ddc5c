"""Runs and sweeps whose samples do not fit in memory: one sentence, and nothing half written."""

import json
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gearplay.vocabulary.exit_codes import PARTLY, RESOURCE
from gearplay.vocabulary.memory import is_too_little_memory, too_little_memory

MEMORY = 3 * 1024**3
"""Address space of the child: enough for libraries and the motion, not for 4 GiB of samples."""
LARGE = ["--set", "run.duration=15s", "--set", "run.sampling=1MHz", "--set", "run.transient=0s"]
PLAN = """
case = "han2021"
set = { "run.duration" = "90 s", "run.transient" = "0 s" }
axes = [{ name = "sampling", path = "run.sampling", values = ["1 kHz", "4 MHz"] }]
reduce = [{ kind = "statistic", name = "rms", signal = "ax", at = "ring", statistic = "rms" }]
"""

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the limit on address space is Linux's")


def within(size: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size))


def limited(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, timeout=300, preexec_fn=within(MEMORY)
    )  # fmt: skip


@pytest.mark.slow
def test_run__with_too_little_memory_is_one_sentence(tmp_path: Path) -> None:
    done = limited(["-m", "gearplay", "run", "han2021", *LARGE, "--out", "run.nc"], tmp_path)
    assert done.returncode == 0, done.stderr
    done = limited(["-m", "gearplay", "export", "run.nc", "--out", "run.mat"], tmp_path)
    assert done.returncode == RESOURCE, done.stderr
    said = done.stderr.strip().splitlines()[-1]
    assert said.startswith("memory: this process may not have ")
    assert "iB more. Lower the sampling" in said
    assert "Traceback" not in done.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.slow
def test_python__raises_a_resource_error(tmp_path: Path) -> None:
    program = """
import gearplay as gp
result = gp.simulate("han2021", duration=15.0, transient=0.0, sampling=1e6)
try:
    result.save("run.csv")
except gp.ResourceError as error:
    print(error)
print(result.success, len(result.signal("ring.ax", window=(1.0, 1.001))))
"""
    done = limited(["-c", program], tmp_path)
    assert done.returncode == 0, done.stderr
    error, last = done.stdout.splitlines()
    assert error.startswith("memory: this process may not have ")
    assert last == "True 1000"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_sweep__keeps_cases_that_fit(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN)
    done = limited(["-m", "gearplay", "sweep", "plan.toml", "--out", "out", "--json"], tmp_path)
    assert done.returncode == PARTLY, done.stdout + done.stderr
    document = json.loads(done.stdout)
    assert document["failed"] == 1
    assert document["reasons"][0].startswith("memory: this process may not have ")


def test_sentence__names_the_size_where_it_is_known() -> None:
    assert "may not have more. " in str(too_little_memory(MemoryError()))
    assert "may not have 5.5 GiB more. " in str(
        too_little_memory(
            MemoryError("Unable to allocate 5.5 GiB for an array with shape (1,) and data type float64")
        )
    )
    assert is_too_little_memory(RuntimeError("can't start new thread"))
    assert not is_too_little_memory(RuntimeError("else"))
