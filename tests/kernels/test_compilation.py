"""Every kernel is compiled once for each kind of numbers: one signature each; plain Python agrees."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import gearplay.kernels
from programs import run_program

SHORT = """
import json, sys
import gearplay as gp
case = gp.replace(gp.load_case("han2021"), {"run.duration": 0.002, "run.transient": 0.0, "run.sampling": 5e3,
                                            "rotors.ring.initial.vx": 0.3})
run = gp.simulate(case).runs[0]
json.dump({"values": run.values.tolist(), "events": run.counters.events, "steps": run.counters.steps}, sys.stdout)
"""


def output_of(program: str, **environment: str) -> Any:
    return json.loads(run_program(program, **environment).stdout)


@pytest.mark.deep
def test_no_kernel_reads_outside_its_arrays(tmp_path: Path) -> None:
    # With bounds checked numba raises IndexError, which fails the subprocess.
    checked = output_of(SHORT, NUMBA_BOUNDSCHECK="1", NUMBA_CACHE_DIR=str(tmp_path))
    assert checked["events"] > 0


ALLOCATES = """
import json, sys
import numpy as np
from gearplay.kernels.compiled_once import compiled_once

@compiled_once
def allocates(n: int) -> float:
    return np.zeros(n).sum()

try:
    allocates(3)
    reason = "compiled"
except Exception as error:
    reason = str(error)
json.dump(reason, sys.stdout)
"""


@pytest.mark.slow
def test_no_kernel_can_allocate(tmp_path: Path) -> None:
    # so that kernels suit a device, and threads share no reference counts
    done = run_program(ALLOCATES, file=tmp_path / "program.py")
    assert json.loads(done.stdout) != "compiled"


BACKLASH = """
import sys
from pathlib import Path
from typing import Any

import gearplay.kernels
import numpy as np
import gearplay as gp
from gearplay.kernels.layout import OUT_SIZE
from gearplay.parts.mesh.geometry import B_T, gaps_at
from gearplay.integrate.switches import make_branch
from gearplay.model.pack import pack
packed = pack(gp.load_case("han2021"))
y, out = np.zeros(packed.state_size), np.zeros(OUT_SIZE)
y[3] = 50e-6
gaps_at(packed.system, 0, 0.0, y, make_branch(packed.system).memory, out)
sys.stdout.write(repr(float(out[B_T])))
"""


@pytest.mark.deep
def test_an_edit_of_one_kernel_file_is_seen_by_kernels_of_another(tmp_path: Path) -> None:
    source = Path(gearplay.kernels.__file__).parents[1]
    copy = tmp_path / "src" / "gearplay"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    environment = {"PYTHONPATH": str(tmp_path / "src"), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    before = output_of(BACKLASH, **environment)
    edited = copy / "kernels" / "involute.py"
    text = edited.read_text(encoding="utf-8")
    series = "return (even + odd * u) * u\n"
    assert series in text
    edited.write_text(text.replace(series, series.replace(" * u\n", " * u * 2.0\n")), encoding="utf-8")
    # mesh_geometry.py, whose kernel contains the edited one, has not changed
    after = output_of(BACKLASH, **environment)
    assert abs(after - 100e-6) > 1.5 * abs(before - 100e-6) > 0.0
