"""`measure`: simulation of a case and of its measurement chain."""

import math
import os
import threading
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Record
from gearplay.model.case import Case
from gearplay.model.reading import Source
from gearplay.results.simulate import case_of
from gearplay.rig.chain import apply_chain, internal_factor
from gearplay.rig.housing_paths import FORCES, HousingPath
from gearplay.rig.instruments import HALF_TAPS
from gearplay.rig.plan import Accelerometer, Placement, Rig, load_rig, placements
from gearplay.solver.simulate import run_members
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, acceleration_signals
from gearplay.vocabulary.errors import Fault, InputError, SimulationError
from gearplay.vocabulary.progress import Progress, ticking

Floats = NDArray[np.float64]

SETTLING: Final = 3.0
"""Time constants of the slowest sensor that it runs before the record, where the case's transient is that long."""


def mean_acceleration(run: Trajectory, place: Placement) -> Floats:
    """Return the mean acceleration of each sampling interval [m/s^2], along and across an axis, shape [time - 1, 2].

    As `Trajectory.mean_acceleration` has it, turned.
    """
    c, s = math.cos(place.direction), math.sin(place.direction)
    rise_x, rise_y = run.mean_acceleration(place.rotor)
    return np.column_stack((c * rise_x + s * rise_y, c * rise_y - s * rise_x))


def housing_acceleration(run: Trajectory, sensor: Accelerometer, place: Placement) -> Floats:
    """Return the mean acceleration of the housing in each sampling interval [m/s^2], along a sensor's axis, shape [time - 1].

    The sum over its paths, driven by the reactions to the parts' forces on the rotors, and the motion of the base.
    """
    total = np.zeros(len(run.time) - 1)
    for path in sensor.paths:
        direction = place.direction + path.angle
        f_x, f_y = (
            run.signal(signal.rpartition(".")[2], path.at.partition(".")[2]) for signal in force_signals(path)
        )
        force = -(math.cos(direction) * f_x + math.sin(direction) * f_y)
        total += path.mean_acceleration(force, run.sampling)
    if run.housing is not None:
        moving_x, moving_y = run.housing.means(run.time)
        total += math.cos(place.direction) * moving_x + math.sin(place.direction) * moving_y
    return total


def force_signals(path: HousingPath) -> list[str]:
    """Return the names of the signals of the force at the start of a path, along x and y."""
    table, _, part = path.at.partition(".")
    return [f"{part}.{FORCES[table]}_{axis}" for axis in "xy"]


def measure(
    case: Source,
    rig: Rig | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    duration: float | None = None,
    transient: float | None = None,
    tolerance: float | None = None,
    member: int = 0,
    seed: int = 0,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Record:
    """Simulate a case and return the record of the rig's sensors and data collector; see docs/rig.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    rig
        A `Rig`, a path or a mapping; that of Han et al. 2021 if not given.
    duration
        Length of the record [s]; the rig's ``collector.duration``, or else the case's.
    transient
        Simulated time before the record [s]; the case's. The sensors run during its last part, three time constants of their
        AC coupling where it is that long, so that they are settled when the record starts.
    tolerance
        Error tolerance on scaled states [1]; the case's if not given.
    member
        Member of the ensemble, 0 for the unperturbed start.
    seed
        Of the sensors' noise, together with the member's number.
    progress
        Called with what is running, simulated seconds done, and of how many.
    stop
        An event that ends the simulation early.

    Returns
    -------
    Record
        A channel for each stage of the chain, as of `apply_chain`: acceleration [m/s^2], voltage [V], counts, what is
        recorded. Attributes name case, digests, rig, seed, member and each sensor's place.

    Raises
    ------
    InputError
        For bad input, or a rig that does not fit the case.
    ResourceError
        For a record that is too long.
    SimulationError
        Where the simulation does not reach its end.
    KeyboardInterrupt
        Where it was interrupted.

    Examples
    --------
    >>> record = measure("han2021", duration=0.01, transient=0.0)
    >>> record.names
    ('sensor.acceleration', 'sensor.voltage', 'sensor.counts', 'sensor.recorded')

    """
    chosen, built = case_of(case, tolerance=tolerance), load_rig(rig)
    places = placements(built, chosen)
    rate, factor = built.collector.sampling, internal_factor(built)
    _check(member, seed)
    if duration is None:
        duration = built.collector.duration
    size = _samples("duration", chosen.run.duration if duration is None else duration, rate, least=1)
    lead = _samples("transient", chosen.run.transient if transient is None else transient, rate, least=0)
    slowest = max(1.0 / (math.tau * s.coupling_corner) for s in built.accelerometers.values())
    settling = min(lead, math.ceil(SETTLING * slowest * rate))
    run = run_members(
        chosen,
        [member],
        signals=_signals(built, places),
        # One velocity more than means, and what the symmetric filter of the ideal acceleration needs past the end.
        duration=((settling + size + HALF_TAPS) * factor + 1) / (rate * factor),
        transient=(lead - settling) / rate,
        sampling=rate * factor,
        progress=ticking(progress, chosen.title or "record"),
        stop=stop,
    )[0]
    if run.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    if not run.success:
        raise SimulationError(f"{chosen.title or 'case'}: {run.message}")
    return apply_chain(
        {
            name: housing_acceleration(run, built.accelerometers[name], place)
            if built.accelerometers[name].paths
            else mean_acceleration(run, place)
            for name, place in places.items()
        },
        rate * factor,
        built,
        settling=settling / rate,
        duration=size / rate,
        start=lead / rate,
        seed=(seed, member),
        source=chosen.title,
        attributes=_about(chosen, built, places, member),
    )


def _signals(rig: Rig, places: Mapping[str, Placement]) -> list[str]:
    """Return the signals that a rig needs of a motion: velocities of rotors with a sensor, forces at the start of paths."""
    on_rotors = dict.fromkeys(
        place.rotor for name, place in places.items() if not rig.accelerometers[name].paths
    )
    forces = [
        signal
        for sensor in rig.accelerometers.values()
        for path in sensor.paths
        for signal in force_signals(path)
    ]
    return [*acceleration_signals(on_rotors), *dict.fromkeys(forces)]


def _about(case: Case, rig: Rig, places: Mapping[str, Placement], member: int) -> dict[str, str]:
    about = {"case_title": case.title, "case_sha256": case.sha256, "member": str(member)}
    for name, place in places.items():
        seat = "housing" if rig.accelerometers[name].paths else place.rotor
        about[f"{name}_place"] = f"{seat}, {math.degrees(place.direction):.6g} deg from +x"
    return about


def _check(member: int, seed: int) -> None:
    faults = [
        Fault(name, value, "must be a whole number, 0 or more", "Choose another")
        for name, value in (("member", member), ("seed", seed))
        if isinstance(value, bool) or not isinstance(value, int) or value < 0
    ]
    if faults:
        raise InputError(faults)


def _samples(name: str, value: float, rate: float, *, least: int) -> int:
    """Return a time [s] in samples of the collector."""
    count = value * rate if math.isfinite(value) else -1.0
    if round(count) < least:
        rule = f"must be a finite time of at least {least / rate:g} s"
        raise InputError.of(name, value, rule, "Give seconds")
    return round(count)
