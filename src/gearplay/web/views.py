"""Views of a run for the page: thinned curves, spectrum with lines, contacts, frames of the mechanism."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.parts.mesh.train.geometry import (
    carrier_of,
    is_held,
)
from gearplay.parts.protocol import without_slots
from gearplay.pictures.extremes import extremes, thinned_path
from gearplay.results.contacts import contacts_of
from gearplay.results.mechanism import frames_of, orbit_of
from gearplay.results.output_shaft import shaft_of_runs
from gearplay.results.spectra import ensemble_spectrum, student_widening
from gearplay.solver.frames import CarrierFrames
from gearplay.solver.trajectory import Trajectory, work_of

Floats = NDArray[np.float64]
INTERVALS = 700  # of a curve, each with its lowest and highest value
ORBIT_POINTS, LINES = 2000, 1200
MOST_CONTACTS = 1500  # intervals of one contact's strip
MEANS = ("share_of_time", "impacts_per_second", "rms_impact_speed")
MESH_HISTORIES = ("backlash", "center_distance", "drive_force", "back_force")


def views_of(case: Case, packed: Packed, runs: Sequence[Trajectory]) -> dict[str, Any]:
    """Return the runs of a case, which is also given ``packed``, as the page draws them; arrays are SI.

    Spectra and statistics are of all members, the rest is of the first. Times count from ``start``, so that 32 bits resolve them.
    """
    run = runs[0]
    shaft, frames = shaft_of_runs(case, packed, None, runs), CarrierFrames(packed.system)
    since = run.time - run.first_sample
    return {
        "status": run.message,
        "finished": all(each.success for each in runs),
        "reached": run.reached,
        "start": run.first_sample,
        **asdict(work_of(runs)),
        "orbits": _orbits(case, frames, run),
        "histories": _histories(run, since),
        "strip": _strip(run),
        "spectra": spectra_of(case, runs),
        "statistics": statistics_of(runs),
        "output": {"title": shaft.title, "rows": shaft.rows(), "note": shaft.note},
        "frames": frames_of(case, frames, since, run.signal, start=run.first_sample),
    }


def _orbits(case: Case, frames: CarrierFrames, run: Trajectory) -> list[dict[str, Any]]:
    """Return the paths of free centres, with their clearance in sleeves and bearings; ``on`` is the carrier of a rotor.

    The paths of carried rotors are relative to their pins, in axes that turn with the carrier.
    """
    found = []
    for name in case.rotors:
        on = carrier_of(case, name)
        if is_held(case, name) and on is None:
            continue
        x, y = thinned_path(*orbit_of(case, frames, name, run.signal), ORBIT_POINTS)
        clearance = max((part.clearance() or 0.0 for part in case.operating.holders(name)), default=0.0)
        found.append({"name": name, "on": on, "clearance": clearance, "x": x, "y": y})
    return found


def _histories(run: Trajectory, time: Floats) -> list[dict[str, Any]]:
    found = []
    for mesh in dict.fromkeys(c.label for c in run.columns if c.dimension == "mesh"):
        for signal in MESH_HISTORIES:
            t, v = extremes(time, run.signal(signal, mesh), INTERVALS)
            found.append({"signal": signal, "label": mesh, "t": t, "v": v})
    held = (c for c in run.columns if c.dimension in ("sleeve", "bearing"))
    for kind, rotor in dict.fromkeys((c.dimension, c.label) for c in held):
        force = np.hypot(*(run.signal(f"{kind}_force_{axis}", rotor) for axis in "xy"))
        t, v = extremes(time, force, INTERVALS)
        found.append({"signal": f"{kind}_force", "label": rotor, "t": t, "v": v})
    return found


def _strip(run: Trajectory) -> list[dict[str, Any]]:
    """Return when each contact was closed, without slots: pairs of times [s], shape [interval, 2]."""
    found = []
    log = run.log.reshape(-1, 4)
    for label in without_slots(run.statistics.labels):
        at = run.statistics.labels.index(label)
        rows = log[log[:, 1] == at]
        begins, ends = (rows[rows[:, 2] == closes, 0] for closes in (1.0, 0.0))
        begun = rows[0, 2] == 0.0 if len(rows) else run.statistics.share_of_time[at] > 0.5
        if begun:
            begins = np.r_[run.first_sample, begins]
        if len(begins) > len(ends):
            ends = np.r_[ends, run.reached]
        found.append({"label": label, "spans": merged(np.column_stack([begins, ends])) - run.first_sample})
    return found


def merged(spans: Floats, most: int = MOST_CONTACTS) -> Floats:
    """Return intervals, shape [interval, 2], in order; where they are more than ``most``, the shortest gaps are closed.

    >>> merged(np.array([[0.0, 1.0], [1.1, 2.0], [5.0, 6.0]]), 2).tolist()
    [[0.0, 2.0], [5.0, 6.0]]
    """
    if len(spans) <= most:
        return spans
    gaps = spans[1:, 0] - spans[:-1, 1]
    kept = np.sort(np.argsort(gaps)[len(spans) - most :])
    return np.column_stack([spans[np.r_[0, kept + 1], 0], spans[np.r_[kept, len(spans) - 1], 1]])


def spectra_of(case: Case, runs: Sequence[Trajectory]) -> list[dict[str, Any]]:
    """Return the acceleration spectra of rotors whose centres are free: rms averages over the members.

    ``s`` is the spread over the members in decades, None for one.
    """
    names = [name for name in case.rotors if not is_held(case, name)] or list(case.rotors)[:2]
    found = []
    for name in names[:6]:
        for signal in ("ax", "ay"):
            records = [run.signal(signal, name) for run in runs if len(run.time) == len(runs[0].time)]
            if records[0].size < 256 or not all(np.all(np.isfinite(values)) for values in records):
                continue
            spectrum = ensemble_spectrum(records, runs[0].sampling)
            f, a = spectrum.frequency[1:], spectrum.amplitude[1:]
            at = shown_lines(a)
            spread = None if spectrum.spread is None else spectrum.spread[1:][at]
            found.append({"label": name, "signal": signal, "f": f[at], "a": a[at], "s": spread})
    return found


def shown_lines(
    amplitude: Floats, whole: int = 400, intervals: int = (LINES - 400) // 2
) -> NDArray[np.int64]:
    """Return which lines of a spectrum are shown: the first ``whole`` ones, then the lowest and the highest of each interval.

    >>> shown_lines(np.array([1.0, 2.0, 5.0, 4.0, 3.0, 0.0, 9.0, 8.0]), 2, 2).tolist()
    [0, 1, 2, 4, 5, 6]
    """
    rest = amplitude.size - whole
    if rest <= 2 * intervals:
        return np.arange(amplitude.size, dtype=np.int64)
    size = -(-rest // intervals)
    count = rest // size
    table = amplitude[whole : whole + count * size].reshape(count, size)
    ends = np.sort([table.argmin(axis=1), table.argmax(axis=1)], axis=0) + size * np.arange(count)
    return np.concatenate([np.arange(whole), whole + np.unique(ends)])


def statistics_of(runs: Sequence[Trajectory]) -> list[dict[str, Any]]:
    """Return the contacts' statistics over all members.

    ``half`` is half the 95 % interval of their means, by Student's t; None for one member.
    """
    table = contacts_of(runs)
    widening = student_widening(len(runs)) if len(runs) > 1 else None
    return [
        {
            "contact": label,
            "impacts": round(float(table.impacts[at])),
            "angular": bool(table.angular[at]),
            **{name: float(table.values[name][at]) for name in (*MEANS, "peak_force")},
            "half": None if widening is None else {n: widening * float(table.spread[n][at]) for n in MEANS},
        }
        for at, label in enumerate(table.labels)
    ]
