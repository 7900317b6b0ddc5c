"""Products of sweeps with made-up numbers: plans of the article's rig and what their cases could have given."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.evaluate import REFUSED, Sweep
from gearplay.sweeps.running.product import to_product

Value = Callable[[Any, Mapping[str, Any], int], Any]

SHORT = {"run.duration": 0.02, "run.transient": 0.0, "run.sampling": 10_000.0}
RMS = {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}
HITS = {"kind": "contact", "name": "hits", "contact": "ring", "statistic": "impacts_per_second"}
SPECTRUM = {"kind": "spectrum", "name": "s", "signal": "ax", "at": "ring", "band": [0.5, 400.5], "count": 400}
HISTORY = {"kind": "history", "name": "raw", "signal": "x", "at": "ring"}
MODEL = {"name": "model", "path": "backlash_model", "values": ["coupled", "uncoupled"]}
SPEED = {"name": "speed", "path": "rotors.pinion.drive.speed", "low": "60 rpm", "high": "300 rpm", "count": 5}
PLAY = {"name": "play", "path": "sleeves.ring.radial_clearance", "low": "10 um", "high": "300 um", "count": 4}
BACKLASH = {
    "name": "b",
    "path": "meshes.0.backlash",
    "low": "20 um",
    "high": "400 um",
    "count": 3,
    "scale": "log",
}
BOUNCE = {"name": "bounce", "path": "sleeves.ring.restitution", "values": [0.5, 0.7, 0.9]}
DRAG = {"name": "drag", "path": "rotors.ring.load.drag", "low": 0.1, "high": 10.0, "mode": "scale"}
DESIGN = {
    "count": 40,
    "parameters": [
        {k: v for k, v in axis.items() if k not in ("count", "scale")} for axis in (SPEED, PLAY, BACKLASH)
    ]
    + [{**DRAG, "distribution": "log-uniform"}],
}


def plan_of(*axes: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    plan = {
        "title": "A",
        "case": "han2021",
        "set": SHORT,
        "axes": [dict(axis) for axis in axes],
        "reduce": [RMS, HITS],
    } | more
    if SPECTRUM in plan["reduce"]:  # its parts are no finer than the lines of a record
        plan["set"] = {**plan["set"], "run.duration": 1.0}
    return plan


def smooth(kept: Any, values: Mapping[str, Any], member: int) -> Any:
    """Return a made-up number that differs between cases, variables and members."""
    at = sum(v if isinstance(v, float) else len(str(v)) for v in values.values())
    return np.full(kept.size, 1.0 + math.sin(0.37 * at + len(kept.name)) ** 2 + 0.1 * member)


def made(plan: Mapping[str, Any], value: Value = smooth) -> tuple[Sweep, xr.Dataset]:
    """Return a sweep and its product with made-up rows; a reason in words in place of a number is a failed case."""
    sweep = Sweep(load_sweep(plan))
    rows: dict[bytes, tuple[int, str, bytes]] = {}
    for index in range(len(sweep.template.points)):
        values, member = sweep.template.points.at(index)
        parts = [value(kept, values, member) for kept in sweep.reducer.layout]
        wrong = next((part for part in parts if isinstance(part, str)), "")
        numbers = [np.full(kept.size, np.nan) for kept in sweep.reducer.layout] if wrong else parts
        row = np.concatenate([np.atleast_1d(part).astype(np.float64) for part in numbers])
        rows[sweep.template.address_of(index)] = (REFUSED if wrong else 0, wrong, row.tobytes())
    return sweep, to_product(sweep, rows)
