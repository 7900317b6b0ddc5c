"""What the page shows of a run: thinned curves, spectrum with its lines, contacts, frames of the mechanism."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.geometry import (
    ADDENDUM,
    DEDENDUM,
    centres,
    jam_ratio,
    mesh_frequency,
    nominal_speeds,
)
from gearplay.solver.trajectory import Trajectory
from gearplay.study.signals.extremes import extremes
from gearplay.study.signals.spectra import amplitude_spectrum

Floats = NDArray[np.float64]
STRETCHES = 700  # of a curve, each with its lowest and highest value
ORBIT_POINTS, FRAMES, LINES = 2000, 900, 1200
MOST_CONTACTS = 1500  # intervals of one contact's strip
HISTORIES = {
    "mesh": ("backlash", "center_distance", "drive_force", "back_force"),
    "sleeve": ("sleeve_force",),
}


def views_of(case: Case, run: Trajectory) -> dict[str, Any]:
    """Return one run as the page draws it; arrays are SI."""
    time = run.time
    return {
        "status": run.message,
        "finished": bool(run.success),
        "reached": run.reached,
        "steps": run.counters.steps,
        "events": run.counters.events,
        "wall_time": run.wall_time,
        "orbits": _orbits(case, run),
        "histories": _histories(run, time),
        "strip": _strip(run),
        "spectra": _spectra(case, run),
        "statistics": _statistics(run),
        "frames": _frames(case, run, time),
    }


def mechanism_of(case: Case) -> dict[str, Any]:
    """Return what the drawing of the mechanism needs: gears with their teeth, sleeves, meshes, lines of the spectrum."""
    places, speeds = centres(case), nominal_speeds(case)
    module: dict[str, float] = {}
    angle: dict[str, float] = {}
    for mesh in case.meshes:
        for name in (mesh.driver, mesh.driven):
            module.setdefault(name, mesh.module)
            angle.setdefault(name, mesh.pressure_angle)
    gears = [
        {
            "name": name,
            "x": float(places[name][0]),
            "y": float(places[name][1]),
            "speed": float(speeds[i]),
            "teeth": rotor.teeth,
            "internal": rotor.internal,
            "module": module.get(name),
            "pressure_angle": angle.get(name),
            "addendum": ADDENDUM,
            "dedendum": DEDENDUM,
        }
        for i, (name, rotor) in enumerate(case.rotors.items())
    ]
    return {
        "gears": gears,
        "sleeves": [
            {"name": name, "clearance": sleeve.radial_clearance, "on": sleeve.on}
            for name, sleeve in case.sleeves.items()
        ],
        "meshes": [
            {
                "name": mesh.label,
                "driver": mesh.driver,
                "driven": mesh.driven,
                "backlash": mesh.backlash,
                "pressure_angle": mesh.pressure_angle,
                "frequency": mesh_frequency(case, j),
                "jam_ratio": jam_ratio(case, j),
            }
            for j, mesh in enumerate(case.meshes)
        ],
    }


def _orbits(case: Case, run: Trajectory) -> list[dict[str, Any]]:
    step = max(1, -(-len(run.values) // ORBIT_POINTS))
    return [
        {
            "name": name,
            "clearance": sleeve.radial_clearance,
            "x": run.signal("x", name)[::step],
            "y": run.signal("y", name)[::step],
        }
        for name, sleeve in case.sleeves.items()
        if sleeve.on is None
    ]


def _histories(run: Trajectory, time: Floats) -> list[dict[str, Any]]:
    found = []
    for mesh in dict.fromkeys(c.label for c in run.columns if c.dimension == "mesh"):
        for signal in HISTORIES["mesh"]:
            t, v = extremes(time, run.signal(signal, mesh), STRETCHES)
            found.append({"signal": signal, "label": mesh, "t": t, "v": v})
    for sleeve in dict.fromkeys(c.label for c in run.columns if c.dimension == "sleeve"):
        force = np.hypot(run.signal("sleeve_force_x", sleeve), run.signal("sleeve_force_y", sleeve))
        t, v = extremes(time, force, STRETCHES)
        found.append({"signal": "sleeve_force", "label": sleeve, "t": t, "v": v})
    return found


def _strip(run: Trajectory) -> list[dict[str, Any]]:
    """Return when each contact was closed: pairs of times [s], shape [interval, 2]."""
    found = []
    end = run.reached
    for at, label in enumerate(run.statistics.labels):
        rows = run.log[run.log[:, 1] == at] if len(run.log) else np.zeros((0, 4))
        spans: list[tuple[float, float]] = []
        begun: float | None = None if len(rows) == 0 or rows[0, 2] == 1.0 else run.first_sample
        if len(rows) == 0 and run.statistics.share_of_time[at] > 0.5:
            begun = run.first_sample
        for t, _, closes, _ in rows:
            if closes == 1.0:
                begun = t
            elif begun is not None:
                spans.append((begun, t))
                begun = None
        if begun is not None:
            spans.append((begun, end))
        found.append({"label": label, "spans": np.array(spans[:MOST_CONTACTS]).reshape(-1, 2)})
    return found


def _spectra(case: Case, run: Trajectory) -> list[dict[str, Any]]:
    """Return the acceleration spectra of the rotors in sleeves, or of all that are free, highest of each stretch."""
    names = [name for name in case.rotors if name in case.sleeves] or list(case.rotors)[:2]
    found = []
    for name in names[:6]:
        for signal in ("ax", "ay"):
            values = run.signal(signal, name)
            if values.size < 256 or not np.all(np.isfinite(values)):
                continue
            spectrum = amplitude_spectrum(values, run.sampling)
            f, a = spectrum.frequency[1:], spectrum.amplitude[1:]
            at = highest(a)
            found.append({"label": name, "signal": signal, "f": f[at], "a": a[at]})
    return found


def highest(amplitude: Floats, whole: int = 400, stretches: int = LINES - 400) -> NDArray[np.int64]:
    """Return which lines of a spectrum are shown: the first ``whole`` ones, then the highest of each stretch.

    >>> highest(np.array([1.0, 2.0, 5.0, 4.0, 0.0, 9.0]), 2, 2).tolist()
    [0, 1, 2, 5]
    """
    rest = amplitude.size - whole
    if rest <= stretches:
        return np.arange(amplitude.size, dtype=np.int64)
    size = -(-rest // stretches)
    count = rest // size
    table = amplitude[whole : whole + count * size].reshape(count, size)
    return np.concatenate([np.arange(whole), whole + table.argmax(axis=1) + size * np.arange(count)])


def _statistics(run: Trajectory) -> list[dict[str, Any]]:
    s = run.statistics
    return [
        {
            "contact": label,
            "share_of_time": float(s.share_of_time[at]),
            "impacts_per_second": float(s.impacts_per_second[at]),
            "rms_impact_speed": float(s.rms_impact_speed[at]),
            "peak_force": float(s.peak_force[at]),
        }
        for at, label in enumerate(s.labels)
    ]


def _frames(case: Case, run: Trajectory, time: Floats) -> dict[str, Any]:
    """Return the motion for the drawing: positions and rotations of all rotors, forces of all contacts, at some instants.

    Rotations are those beside the nominal ones: 32 bits would not resolve a backlash after some turns.
    """
    at = np.unique(np.linspace(0, len(time) - 1, min(FRAMES, len(time))).astype(np.int64))
    if at.size == 0 or len(time) == 0:
        at = np.zeros(0, dtype=np.int64)
    speeds = nominal_speeds(case)

    def of(signal: str, name: str) -> Floats:
        return run.signal(signal, name)[at]

    rotors = [
        [of("x", name), of("y", name), of("theta", name) - speeds[i] * time[at]]
        for i, name in enumerate(case.rotors)
    ]
    return {
        "t": time[at],
        "rotors": np.array(rotors).reshape(len(case.rotors), 3, at.size),
        "sleeves": np.array(
            [[of("sleeve_force_x", name), of("sleeve_force_y", name)] for name in case.sleeves]
        ).reshape(len(case.sleeves), 2, at.size),
        "meshes": np.array(
            [[_peaks(run, "drive_force", m.label, at), _peaks(run, "back_force", m.label, at)] for m in case.meshes]
        ).reshape(len(case.meshes), 2, at.size),
    }  # fmt: skip


def _peaks(run: Trajectory, signal: str, label: str, at: NDArray[np.int64]) -> Floats:
    """Return the largest force between two frames, so that a short impact is seen."""
    values = run.signal(signal, label)
    if at.size == 0:
        return values[:0]
    return np.maximum.reduceat(values, at)


def spectrum_lines(case: Case) -> dict[str, float]:
    """Return the lines that are marked: ``f_m`` and ``2 f_m`` of the first mesh, shaft speeds [Hz]."""
    found: dict[str, float] = {}
    if case.meshes:
        f_m = mesh_frequency(case, 0)
        found |= {"f_m": f_m, "2 f_m": 2.0 * f_m}
    for name, speed in zip(case.rotors, nominal_speeds(case), strict=True):
        if speed != 0.0:
            found[f"shaft of {name}"] = abs(float(speed)) / (2.0 * math.pi)
    return found
