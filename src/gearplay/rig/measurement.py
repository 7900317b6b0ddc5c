"""Simulation of a case and of its measurement chain."""

import math
import os
import threading
from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Record
from gearplay.model.case import Case
from gearplay.rig.chain import apply_chain, internal_factor
from gearplay.rig.collector import HALF_TAPS
from gearplay.rig.plan import Placement, Rig, load_rig, placements
from gearplay.solver.simulate import run_members
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, acceleration_signals
from gearplay.vocabulary.errors import Fault, InputError, SimulationError
from gearplay.vocabulary.progress import Tick

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


def measure(
    case: Case,
    rig: Rig | str | os.PathLike[str] | Mapping[str, object] | None = None,
    *,
    member: int = 0,
    duration: float | None = None,
    transient: float | None = None,
    oversampling: int | None = None,
    seed: int = 0,
    progress: Tick | None = None,
    stop: threading.Event | None = None,
) -> Record:
    """Simulate a case and return the record of the rig's sensors and data collector.

    Parameters
    ----------
    case
        What to simulate.
    rig
        As `load_rig` takes it; the rig of Han et al. 2021 if not given.
    member
        Of the case's ensemble.
    duration
        Length of the record [s]; the rig's ``collector.duration``, or else the case's.
    transient
        Simulated time before the record [s]; the case's. The sensors already run during its last part, three time constants
        of their AC coupling where it is that long, so that they are settled when the record starts.
    oversampling
        Samples of the simulation per sample of the collector; as many as 0.1 % in the sensors' bands takes.
    seed
        Of the noise, together with the member's number.
    progress, stop
        As `gearplay.solver.simulate.run_members` takes them.

    Returns
    -------
    Record
        Channels as of `apply_chain`; attributes name case, digests, rig, seed, member and each sensor's place.

    Raises
    ------
    InputError
        For a rig that does not fit the case.
    ResourceError
        For a record that is too long.
    SimulationError
        Where the simulation did not reach its end.
    KeyboardInterrupt
        Where it was interrupted.

    """
    built = load_rig(rig)
    places = placements(built, case)
    rate = built.collector.sampling
    factor = internal_factor(built) if oversampling is None else oversampling
    _check(member, seed, factor)
    wanted = duration if duration is not None else built.collector.duration
    size = _samples("duration", case.run.duration if wanted is None else wanted, rate, least=1)
    lead = _samples("transient", case.run.transient if transient is None else transient, rate, least=0)
    slowest = max(1.0 / (math.tau * s.coupling_corner) for s in built.accelerometers.values())
    settling = min(lead, math.ceil(SETTLING * slowest * rate))
    rotors = dict.fromkeys(place.rotor for place in places.values())
    run = run_members(
        case,
        [member],
        signals=acceleration_signals(rotors),
        # One velocity more than means, and what the symmetric filter of the ideal acceleration needs past the end.
        duration=((settling + size + HALF_TAPS) * factor + 1) / (rate * factor),
        transient=(lead - settling) / rate,
        sampling=rate * factor,
        progress=progress,
        stop=stop,
    )[0]
    if run.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    if not run.success:
        raise SimulationError(f"{case.title or 'case'}: {run.message}")
    return apply_chain(
        {name: mean_acceleration(run, place) for name, place in places.items()},
        rate * factor,
        built,
        settling=settling / rate,
        duration=size / rate,
        start=lead / rate,
        seed=(seed, member),
        source=case.title,
        attributes=_about(case, places, member),
    )


def _about(case: Case, places: Mapping[str, Placement], member: int) -> dict[str, str]:
    about = {"case_title": case.title, "case_sha256": case.sha256, "member": str(member)}
    for name, place in places.items():
        about[f"{name}_place"] = f"{place.rotor}, {math.degrees(place.direction):.6g} deg from +x"
    return about


def _check(member: int, seed: int, factor: int) -> None:
    faults = [
        Fault(name, value, f"must be a whole number, {least} or more", "Choose another")
        for name, value, least in (("member", member, 0), ("seed", seed, 0), ("oversampling", factor, 4))
        if isinstance(value, bool) or not isinstance(value, int) or value < least
    ]
    if faults:
        raise InputError(faults)


def _samples(name: str, value: float, rate: float, *, least: int) -> int:
    """Return a time [s] in samples of the collector."""
    count = value * rate if math.isfinite(value) else -1.0
    if round(count) < least:
        rule = f"must be a finite time of at least {least / rate:g} s"
        raise InputError(Fault(name, value, rule, "Give seconds"))
    return round(count)
