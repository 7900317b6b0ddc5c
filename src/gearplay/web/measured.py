"""Measurements shown with a run: spectra of an uploaded file, and measured lines of the bundled calibration plans."""

import math
import threading
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.reading import PACKAGE, load_plan
from gearplay.files.measurements import read_measurement
from gearplay.files.record import Channel, Record
from gearplay.model.bundled import bundled
from gearplay.model.case import Case
from gearplay.model.plan_values import number_in_si, value_at
from gearplay.model.reading import load_case
from gearplay.results.spectra import amplitude_spectrum
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary.errors import Fault, GearplayError, InputError
from gearplay.vocabulary.progress import Tick
from gearplay.vocabulary.quantities import ACCELERATION, FREQUENCY, Quantity
from gearplay.web.frames import pack_frame
from gearplay.web.jobs import Job
from gearplay.web.views import shown_lines

Floats = NDArray[np.float64]
LEAST = 64
"""Samples of a spectrum, at least."""
MOST = 24
"""Channels."""
CLOSE = 1e-6
"""Relative difference up to which a field of the case has the value of a condition."""


def measured(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Return the amplitude spectra [m/s^2] over frequency [Hz] of the accelerations in a file, as a frame.

    The job has the ``path`` of the file, its ``name`` on the user's side, and the ``unit`` of channels without one, "" for
    none. A text table whose first column is a frequency holds spectra.

    Raises `InputError` for a file without an acceleration, `MeasurementError` as `read_measurement` does.
    """
    path, name, unit = Path(str(job["path"])), str(job["name"]), str(job["unit"])
    frequency, channels = _read(path)
    found: list[dict[str, Any]] = []
    for channel in channels[:MOST]:
        factor = _factor(channel.unit or unit, ACCELERATION)
        if factor is None or (frequency is None and channel.values.size < LEAST):
            continue
        if frequency is None:
            spectrum = amplitude_spectrum(factor * channel.values, channel.sampling)
            f, a = spectrum.frequency[1:], spectrum.amplitude[1:]
        else:
            f, a = frequency, factor * channel.values
        at = shown_lines(a)
        words = f"{name}: {channel.name}" if len(channels) > 1 else name
        found.append({"name": words, "f": f[at], "a": a[at]})
    if not found:
        raise InputError(_nothing(channels, name))
    return pack_frame({"kind": "measured", "channels": found})


def _read(path: Path) -> tuple[Floats | None, list[Channel]]:
    """Return frequencies [Hz] of a table of spectra, None for a record over time, and the channels."""
    try:
        return None, list(read_measurement(path).channels)
    except GearplayError:
        try:
            table = read_measurement(path, sampling=1.0)  # a table without a column of time
        except GearplayError:
            table = Record(())
        first = next(iter(table.channels), None)
        factor = None if first is None else _factor(first.unit, FREQUENCY)
        if first is None or factor is None or len(table.channels) < 2 or np.any(np.diff(first.values) <= 0.0):
            raise
        return factor * first.values, list(table.channels[1:])


def _factor(unit: str, quantity: Quantity) -> float | None:
    """Return the factor from ``unit`` to the SI unit of a quantity; None for no unit, or one of another quantity."""
    try:
        return parse_quantity(f"1 {unit}", quantity) if unit else None
    except UnitError:
        return None


def _nothing(channels: list[Channel], name: str) -> Fault:
    """Return the error for a file without a spectrum to show."""
    bare = [each.name for each in channels if not each.unit]
    if bare:
        rule = f"its channel {bare[0]!r} says no unit"
        return Fault("measurement", name, rule, "Choose m/s² or g under unit, or write it into the file")
    short = [each for each in channels if _factor(each.unit, ACCELERATION) is not None]
    if short:
        rule = f"must hold {LEAST} samples or more, {short[0].values.size} found"
        return Fault("measurement", name, rule, "Give a longer record")
    units = ", ".join(f"{each.name} [{each.unit}]" for each in channels[:6])
    return Fault(
        "measurement", name, f"must hold an acceleration; found {units}", "Choose a channel in m/s^2 or g"
    )


@cache
def _conditions() -> tuple[tuple[dict[str, int | None], dict[str, float], list[dict[str, Any]]], ...]:
    """Return the conditions of bundled plans with measured values: teeth of the rotors, values by path in SI, measured lines."""
    found = []
    for plan in (load_plan(name) for name in bundled(PACKAGE, "plans")):
        case = load_case(plan.case)
        for condition in plan.conditions:
            if condition.measured:
                values = {path: number_in_si(case, (path,), raw, path) for path, raw in condition.set.items()}
                lines = [
                    {"line": name, "frequency": measured.frequency}
                    for name, measured in condition.measured.items()
                    if measured.frequency is not None
                ]
                found.append((_teeth(case), values, lines))
    return tuple(found)


def _teeth(case: Case) -> dict[str, int | None]:
    return {name: rotor.teeth for name, rotor in case.rotors.items()}


def _is_at(case: Case, values: Mapping[str, float]) -> bool:
    """Return whether a case has these values by path."""
    try:
        return all(math.isclose(value_at(case, path), value, rel_tol=CLOSE) for path, value in values.items())
    except (InputError, TypeError):  # a field that the case lacks or that is no number
        return False


def measured_lines(case: Case) -> list[dict[str, Any]]:
    """Return the lines that a bundled plan has as measured for the condition of a case: name and frequency [Hz].

    Empty for a case of other rotors, or at no condition of a plan.
    """
    own = _teeth(case)
    return next(
        (lines for teeth, values, lines in _conditions() if teeth == own and _is_at(case, values)), []
    )
