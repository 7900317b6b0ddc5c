"""Ctrl-C at any time of any command: exit code 130 within seconds, one sentence, no partial file."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from depth import FULL, sized
from gearplay.cli.main import COMMANDS

pytestmark = pytest.mark.hostile

TIMES = sized(2, 1, torture=100)
"""Of each verb, at times uniform over its first seconds."""
LONGEST = 6.0 if FULL else 2.0
PATIENCE = 6.0
"""From the signal to the end [s]: 3 on a machine that does nothing else."""
LONG = ["--set", "run.duration=100000s"]
VERBS: dict[str, list[str]] = {
    "run": ["run", "han2021", *LONG, "--set", "run.sampling=10Hz", "--out", "out.nc"],
    "run, loaded": ["run", "external-pair", *LONG, "--set", "run.sampling=10Hz", "--out", "out.nc"],
    "run, saved": ["run", "han2021", "--duration", "8s", "--out", "out.nc"],
    "study": ["study", "han2021", "--members", "64", "--duration", "400", "--out", "out"],
    "dataset": ["dataset", "bearing-dents", "--out", "dents"],
    "sweep": ["sweep", "han2021-map", "--out", "out"],
    "sweep, processes": ["sweep", "han2021-map", "--engine", "processes", "--out", "out"],
    "calibrate": ["calibrate", "tutorial", "--out", "out"],
    "motion": ["motion", "han2021", "--periods", "30000"],
    "bifurcation": [
        *("bifurcation", "han2021", "rotors.pinion.drive.speed", "--low", "60rpm", "--high", "300rpm"),
        *("--count", "400", "--settle", "5000", "--signal", "ring.x", "--out", "out"),
    ],
    "measure": ["measure", "han2021-calibrated", "--set", "run.duration=300s", "--out", "out.h5"],
    "animate": ["animate", "run.nc", "--frames", "2000", "--out", "out.gif"],
    "plot": ["plot", "run.nc", "--out", "out.png"],
    "modes": ["modes", "two-stage-reducer", "--out", "out.nc"],
    "portrait": ["portrait", "han2021", "--keep", "20000", "--out", "out.png"],
    "analyze": ["analyze", "run.nc", "--channel", "ring.ax"],
    "diagnose": ["diagnose", "bench.h5", "--case", "han2021", "--members", "64"],
    "export": ["export", "run.nc", "--out", "out.nc"],
    "validate": ["validate"],
    "wear": [
        "wear",
        "han2021",
        "--turns",
        "1e6",
        "--blocks",
        "1000",
        "--set",
        'sleeves.ring.wear={coefficient=1e-16, length="10 mm"}',
        "--out",
        "w",
    ],
}
BEGIN = """
import sys
from gearplay.cli.interrupts import leave_at_once
leave_at_once()
print("on", file=sys.stderr, flush=True)
from gearplay.__main__ import main
main()
"""
"""Of Python's own start nothing is asked: the entrance's first line is said, from there on Ctrl-C is heard."""
QUICK = {"plot", "modes", "portrait", "analyze", "export", "run, saved", "validate"}
"""They may be done before the signal comes."""
SHORT = {
    *(
        "check",
        "copy",
        "export_dxf",
        "export_fmu",
        "import_",
        "load_sharing",
        "lost_motion",
        "schema",
        "serve",
        "teeth",
    )
}
"""Verbs that are done within seconds, or, as `serve`, have an end of their own: tests/web."""


def test_every_verb_is_tried_or_short() -> None:
    assert set(COMMANDS) - {"resume"} == {name.split(",")[0] for name in VERBS} | SHORT


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("result") / "run.nc"
    gp.simulate("han2021", duration=0.3).save(path)
    noise = gp.Channel("acc", np.random.default_rng(0).standard_normal(12_000), 2000.0, "m/s^2")
    gp.write_record(gp.Record((noise,)), path.parent / "bench.h5")
    return path


def begun(words: list[str], folder: Path) -> "subprocess.Popen[str]":
    """Start a command and wait until it is on."""
    process = subprocess.Popen(
        [sys.executable, "-c", BEGIN, *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stderr is not None
    assert process.stderr.readline() == "on\n"
    return process


@pytest.mark.slow
@pytest.mark.parametrize("turn", range(TIMES))
@pytest.mark.parametrize("verb", VERBS)
def test_ctrl_c_ends_a_verb_with_one_sentence(verb: str, turn: int, tmp_path: Path, result: Path) -> None:
    rng = random.Random(f"{verb} {turn}")
    for name in ("run.nc", "bench.h5"):
        (tmp_path / name).symlink_to(result.parent / name)
    with begun(VERBS[verb], tmp_path) as process:
        try:
            time.sleep(rng.uniform(0.0, LONGEST))
            if verb in QUICK and process.poll() is not None:
                return
            os.killpg(process.pid, signal.SIGINT)
            process.wait(PATIENCE)
            said, words = process.communicate(timeout=60.0)  # workers that were about to start hold its ends
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    if verb in QUICK and process.returncode == 0:  # its answer was out
        return
    assert process.returncode == 130, (words, said)
    for trace in ("Traceback", "Exception ignored", "Error"):
        assert trace not in words, words
    assert words.count("nterrupted") == 1 or '"INTERRUPTED"' in said or "nterrupted" in said, (words, said)
    assert not list(tmp_path.rglob("*.tmp*"))


POINTS = """
import signal
import time
import numpy.lib._npyio_impl as reading
from gearplay.cli.interrupts import interruptible
from scipy.stats import qmc
read = reading.NpzFile.__getitem__
def interrupted(archive, name):
    signal.raise_signal(signal.SIGINT)
    time.sleep(0.02)
    return read(archive, name)
reading.NpzFile.__getitem__ = interrupted
end = "finished"
try:
    with interruptible():
        qmc.Sobol(3, scramble=False)
        signal.sigtimedwait([], 5.0)
except KeyboardInterrupt:
    end = "interrupted"
time.sleep(0.2)
print(end, qmc.Sobol(3, scramble=False).random(4).tolist())
"""


@pytest.mark.slow
def test_ctrl_c_while_sobol_points_begin_spoils_none(tmp_path: Path) -> None:
    """SciPy reads their table in Cython, where an exception is lost with a traceback and the table stays half empty.

    The two arrays of the table are two files, each interrupted: only one interrupt comes again, at any moment after the
    table is read, and none after the end.
    """
    done = subprocess.run([sys.executable, "-c", POINTS], cwd=tmp_path, capture_output=True, text=True)
    points = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.75, 0.25, 0.25], [0.25, 0.75, 0.75]]
    assert (done.returncode, done.stdout, done.stderr) == (0, f"interrupted {points}\n", "")


TWICE = """
import signal
import threading
from gearplay.cli.interrupts import interruptible
notify_all, twice = threading.Condition.notify_all, []
def interrupted(condition):
    if not twice:
        twice.append(True)
        signal.raise_signal(signal.SIGINT)
    notify_all(condition)
threading.Condition.notify_all = interrupted
try:
    with interruptible():
        signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c__a_second_one_during_the_first_does_not_hang() -> None:
    """Wrappers send one to their group and one to their child, microseconds apart; an event that is being set is locked."""
    done = subprocess.run([sys.executable, "-c", TWICE], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted\n", "")


@pytest.mark.slow
def test_second_ctrl_c__keeps_old_results_and_replaces_none_by_a_part(tmp_path: Path) -> None:
    """A whole result is there; the run that is to replace it is stopped, twice at once: it stays, the part lies beside it."""
    gp.simulate("han2021", duration=0.1).save(tmp_path / "out.nc")
    before = (tmp_path / "out.nc").read_bytes()
    part = tmp_path / "out.partial.nc"
    for delay in (4.0, 12.0, 40.0):  # a loaded machine may still be starting when the signal comes
        with begun([*VERBS["run"], "--overwrite"], tmp_path) as process:
            time.sleep(delay)
            for _ in range(2):
                os.killpg(process.pid, signal.SIGINT)
                time.sleep(0.2)
            process.wait(2.0 * PATIENCE)
            said, words = process.communicate(timeout=60.0)
        assert process.returncode == 130, (said, words)
        assert words.count("nterrupted") == 1
        assert (tmp_path / "out.nc").read_bytes() == before
        if part.exists():
            break
    assert gp.read_result(part).ds.attrs["status"] == "INTERRUPTED"
    assert str(part.name) in said
