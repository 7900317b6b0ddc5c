"""Ctrl-C at any time of any verb: exit code 130 within seconds, one sentence, never a traceback, nothing half-written."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gearplay as gp
from depth import sized
from gearplay.cli.main import app

pytestmark = pytest.mark.hostile

TIMES = sized(20, 2)
"""Of each verb, at times uniform over its first seconds."""
LONGEST = 6.0
PATIENCE = 3.0
"""From the signal to the end [s], on a machine that does nothing else; four times that here."""
LONG = ["--set", "run.duration=100000s"]
VERBS: dict[str, list[str]] = {
    "run": ["run", "han2021", *LONG, "--set", "run.sampling=10Hz", "--out", "out.nc"],
    "run, loaded": ["run", "external-pair", *LONG, "--set", "run.sampling=10Hz", "--out", "out.nc"],
    "study": ["study", "han2021", "--members", "64", "--duration", "400", "--out", "out"],
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
SHORT = {"check", "copy", "schema", "plot", "modes", "portrait", "analyze", "serve"}
"""Verbs that are done within seconds, or, as `serve`, have an end of their own: tests/page."""


def test_every_verb_is_tried_or_short() -> None:
    names = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert names - {"resume"} == {name.split(",")[0] for name in VERBS} | SHORT


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("result") / "run.nc"
    gp.simulate("han2021", duration=0.3).save(path)
    return path


@pytest.mark.parametrize("turn", range(TIMES))
@pytest.mark.parametrize("verb", VERBS)
def test_ctrl_c_ends_a_verb_with_one_sentence(verb: str, turn: int, tmp_path: Path, result: Path) -> None:
    rng = random.Random(f"{verb} {turn}")
    (tmp_path / "run.nc").symlink_to(result)
    process = subprocess.Popen(
        [sys.executable, "-c", BEGIN, *VERBS[verb]],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stderr is not None
        assert process.stderr.readline() == "on\n"
        time.sleep(rng.uniform(0.0, LONGEST) ** 2 / LONGEST)  # more of them early, while libraries load
        os.killpg(process.pid, signal.SIGINT)
        said, words = process.communicate(timeout=4.0 * PATIENCE)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert process.returncode == 130, (words, said)
    for trace in ("Traceback", "Exception ignored", "Error"):
        assert trace not in words, words
    assert words.count("nterrupted") == 1 or '"INTERRUPTED"' in said or "nterrupted" in said, (words, said)
    assert not list(tmp_path.rglob("*.tmp*"))
