"""Measured values of each condition of a plan, given directly or read from records."""

from pathlib import Path

import numpy as np

from gearplay.calibration.objective import printed_measurements
from gearplay.calibration.observe import Ensemble, Observed, observe
from gearplay.calibration.plan import Condition, Plan, StatisticTarget
from gearplay.calibration.trials import Problem
from gearplay.files.measurements import read_measurement
from gearplay.files.record import Channel, Floats
from gearplay.model import rolling
from gearplay.vocabulary.errors import Fault, InputError

ACCELERATIONS = {
    "m/s^2": 1.0,
    "m/s²": 1.0,
    "m/s2": 1.0,
    "m/s/s": 1.0,
    "m s-2": 1.0,
    "mm/s^2": 1e-3,
    "gravity": 9.80665,
}


def measurements_of(plan: Plan, folder: Path) -> dict[str, dict[str, dict[str, Observed]]]:
    """Return the measured numbers by condition and target; records are searched in ``folder``.

    A record is averaged over the plan's sampling intervals and cut into pieces as long as a simulated record: the
    pieces are its ensemble, so that noise-like content, whose lines depend on the length, is compared like with like.

    Raises `InputError` for a record that does not fit the plan, `MeasurementError` for one that cannot be read.
    """
    found = printed_measurements(plan)
    problem = Problem(plan, plan.models[0])
    for at, (condition, case) in enumerate(zip(plan.conditions, problem.cases, strict=True)):
        if condition.record is None:
            continue
        targets = [
            t for t in plan.targets if not (isinstance(t, StatisticTarget) and t.contact is not None)
        ]  # an accelerometer does not see contacts
        if not targets:
            rule = "must be visible in a record, and those of contacts are not"
            raise InputError(Fault("targets", plan.targets, rule, "Add a line, a hump, a level or rms"))
        pieces = _pieces(plan, condition, at, folder)
        ensemble = Ensemble(
            pieces, plan.simulation.sampling, rolling.first_mesh_frequency(case), plan.simulation.window
        )
        found[condition.name] = observe(targets, ensemble)
    return found


def _pieces(plan: Plan, condition: Condition, at: int, folder: Path) -> Floats:
    """Return the record's accelerations [m/s^2] as the simulation's are sampled and cut, shape [piece, time]."""
    where = f"conditions.{at}.record"
    path = folder / str(condition.record)
    channel = read_measurement(path).channel(condition.channel)
    factor = ACCELERATIONS.get(channel.unit)
    if factor is None:
        cure = f"Units of acceleration: {', '.join(ACCELERATIONS)}"
        raise InputError(
            Fault(
                f"conditions.{at}.channel",
                f"{channel.name} [{channel.unit}]",
                "must be an acceleration",
                cure,
            )
        )
    averaged = _averaged(channel, plan.simulation.sampling, where)
    length = round(plan.simulation.duration * plan.simulation.sampling) - 1  # increments between the samples
    count = averaged.size // length
    if count == 0:
        rule = (
            f"must be at least {plan.simulation.duration:g} s long, as the simulated records are,"
            f" not {channel.duration:.3g} s"
        )
        raise InputError(
            Fault(where, condition.record, rule, "Shorten simulation.duration, or take a longer record")
        )
    return factor * averaged[: count * length].reshape(count, length)


def _averaged(channel: Channel, sampling: float, where: str) -> Floats:
    ratio = channel.sampling / sampling
    whole = round(ratio)
    if whole < 1 or abs(ratio - whole) > 1e-6 * whole:
        rule = f"must be sampled at a multiple of simulation.sampling = {sampling:g} Hz, not at {channel.sampling:g} Hz"
        raise InputError(Fault(where, channel.name, rule, "Change simulation.sampling"))
    count = channel.values.size // whole
    return np.asarray(channel.values[: count * whole].reshape(count, whole).mean(axis=1))
