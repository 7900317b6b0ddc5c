"""Kernels translated for a device do what the kernels do, bit for bit where the mathematics is the same."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

CASES = {
    "han2021": ["run.duration=50ms"],
    "han2021 loaded": ["run.duration=10ms", "gravity.1=-9.81", "rotors.ring.load.torque=1"],
    "external-pair": ["run.duration=10ms"],
    "external-pair at 1e-9": ["run.duration=10ms", "run.tolerance=1e-9"],
    "pinion-idler-ring": ["run.duration=10ms"],
}
PROGRAM = Path(__file__).parents[2] / "translated_device.py"


@pytest.mark.deep
@pytest.mark.compiled
def test_the_translation_is_exact() -> None:
    pytest.importorskip("numba_cuda")
    done = subprocess.run(
        [sys.executable, PROGRAM, json.dumps(CASES)],
        env={
            **os.environ,
            "LLVMLITE_ENABLE_IR_LAYER_TYPED_POINTERS": "0",
            "PYTHONPATH": str(PROGRAM.parents[1]),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert list(found) == list(CASES)
    for name, case in found.items():
        assert case["state"] == 0.0, name
        assert case["logs"], name
        assert all(ours == theirs for ours, theirs in case["counts"]), name
        assert case["counts"][0][0] > 100, name
