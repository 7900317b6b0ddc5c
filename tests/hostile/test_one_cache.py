"""One cache of compiled code for three cold starts of two versions at one place, as where a package is updated while it runs."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import gearplay
from depth import TORTURE
from gearplay.kernels.compiled import INTERPRETED

pytestmark = pytest.mark.hostile

PACKAGE = Path(gearplay.__file__).parent
PROGRAM = """
import sys, time
from pathlib import Path
import gearplay as gp
case = gp.replace(gp.load_case("han2021"), {"rotors.ring.initial.vx": 0.05})
import gearplay.kernels.run
here, go = Path(sys.argv[1]), Path(sys.argv[2])
here.touch()
while not go.exists():
    time.sleep(0.01)
run = gp.simulate(case, duration=0.01, transient=0.0)
print("value", repr(float(run.ds["peak_force"].max())))
"""
CHANGE = ("return x * math.sqrt(abs(x))", "return 2.0 * x * math.sqrt(abs(x))")
"""Of the law of contact, in the second version: it is twice as stiff."""
WAIT = 900.0  # s


@pytest.mark.skipif(INTERPRETED or not TORTURE, reason="compiles all kernels of two versions: make torture")
def test_three_cold_starts_of_two_versions(tmp_path: Path, tried: Callable[[int], None]) -> None:
    """Each start gives the numbers of its own version, as plain Python gives them; a second start loads the same."""
    for version in ("one", "two"):
        shutil.copytree(PACKAGE, tmp_path / version, ignore=shutil.ignore_patterns("__pycache__"))
    law = tmp_path / "two" / "kernels" / "elements" / "sleeve_law.py"
    law.write_text(law.read_text().replace(*CHANGE))
    assert law.read_text() != (tmp_path / "one" / "kernels" / "elements" / "sleeve_law.py").read_text()
    place, go = tmp_path / "site" / "gearplay", tmp_path / "go"
    place.parent.mkdir()
    file = tmp_path / "program.py"
    file.write_text(PROGRAM)
    started = 0

    def start(version: str, **more: str) -> "subprocess.Popen[str]":
        nonlocal started
        started += 1
        place.unlink(missing_ok=True)
        place.symlink_to(tmp_path / version, target_is_directory=True)
        here = tmp_path / f"here-{started}"
        running = subprocess.Popen(
            [sys.executable, str(file), str(here), str(go)],
            env={**os.environ, "PYTHONPATH": str(place.parent), "NUMBA_CACHE_DIR": str(tmp_path / "cache"), **more},
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        until = time.monotonic() + WAIT
        while not here.exists() and running.poll() is None and time.monotonic() < until:
            time.sleep(0.01)
        return running

    def value(running: "subprocess.Popen[str]") -> float:
        out, err = running.communicate(timeout=WAIT)
        assert running.returncode == 0, err
        assert "Traceback" not in err
        return float(out.split("value")[1])

    cold = [start("one"), start("two"), start("two")]
    go.touch()
    values = [value(each) for each in cold]
    plain = {version: value(start(version, NUMBA_DISABLE_JIT="1")) for version in ("one", "two")}
    assert abs(plain["one"] / plain["two"] - 1.0) > 1e-3
    assert values == pytest.approx([plain["one"], plain["two"], plain["two"]], rel=1e-6)
    assert value(start("one")) == values[0]
    assert value(start("two")) == values[1] == values[2]
    tried(started)
