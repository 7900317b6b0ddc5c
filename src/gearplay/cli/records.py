"""Records on the command line: the file, units and calibration of its channels, the speed of the shaft."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

_FACTOR: Final = re.compile(
    r"(?P<factor>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?) +(?P<unit>\S.*)"
)

Calibration = dict[str, tuple[float, str]]
"""Factor and unit of channels by name."""


def record_in(
    path: Path, sampling: float | None, units: dict[str, str], calibration: Calibration
) -> tuple[Any, str | None]:
    """Return the record in a file, or the run in a file as one, and the most informative channel of a run."""
    from gearplay.files.measurements import read_measurement

    changed = sampling is not None or units or calibration
    if path.suffix.lower() in (".nc", ".nc4") and path.is_file() and not changed:
        from gearplay.files.netcdf import check_file, opened
        from gearplay.public_functions import read_result
        from gearplay.results.provenance import KIND
        from gearplay.results.recorded import record_of, usual_channel
        from gearplay.results.result import Result

        with opened(check_file(path)) as file:
            kind = file.attributes().get(KIND)
        if kind == Result.result_kind:
            result = read_result(path)
            return record_of(result), usual_channel(result)
    return read_measurement(path, sampling=sampling, units=units, calibration=calibration), None


def full_scale_of(held: Any) -> str:
    """Return the encoding of a record whose samples are integers of a WAV file, scaled to +-1; else empty."""
    encoding = str(held.attributes.get("encoding", ""))
    return f"WAV, {encoding}" if held.format == "wav" and encoding.startswith("integer") else ""


def units_of(given: Sequence[str]) -> dict[str, str]:
    """Return the units that are given as NAME=UNIT."""
    from gearplay.vocabulary.errors import InputError

    found = {}
    for text in given:
        name, sign, unit = text.rpartition("=")
        if not sign or not name or not unit.strip():
            raise InputError.of("--unit", text, "must be a channel and its unit", "Write --unit acc=g")
        found[name] = unit.strip()
    return found


def calibration_of(given: Sequence[str], units: dict[str, str]) -> Calibration:
    """Return the factors and units that are given as NAME=FACTOR UNIT, of channels without one in ``units``.

    >>> calibration_of(["channel 1=9.81 m/s^2"], {})
    {'channel 1': (9.81, 'm/s^2')}
    """
    from gearplay.schema.units import comma_cure
    from gearplay.vocabulary.errors import InputError

    found: Calibration = {}
    for text in given:
        name, _, value = text.rpartition("=")
        match = _FACTOR.fullmatch(value.strip())
        if not name or match is None:
            cure = comma_cure(value) or 'Write --calibration "channel 1=9.81 m/s^2"'
            rule = "must be a channel, the factor of its samples and their unit"
            raise InputError.of("--calibration", text, rule, cure)
        if name in units or name in found:
            rule = "must give the unit of a channel once"
            raise InputError.of("--calibration", text, rule, f"Leave out the other unit of {name}")
        found[name] = float(match["factor"]), match["unit"].strip()
    return found


def speed_of(held: Any, speed: str | None, pulses: int | None) -> Any:
    """Return a speed [rad/s]: a quantity, a scalar of the file, or a channel of speeds, angles or pulses, of it or of another."""
    from gearplay.schema.units import UnitError, parse_quantity
    from gearplay.vocabulary.errors import InputError
    from gearplay.vocabulary.quantities import ANGULAR_SPEED
    from gearplay.vocabulary.suggestions import listed

    if speed is not None and speed not in held.names and Path(speed).is_file():
        from gearplay.files.measurements import read_measurement
        from gearplay.signals.angle import angle_from_tacho

        channel = read_measurement(Path(speed)).channel()
        return channel if pulses is None else angle_from_tacho(channel, pulses)
    if pulses is not None and speed not in held.names:
        cure = f"Channels: {listed(held.names)}"
        raise InputError.of("--speed", speed, "must name the channel of the pulses", cure)
    if speed is None:
        return None
    if speed in held.names:
        from gearplay.signals.angle import angle_from_tacho

        channel = held.channel(speed)
        return channel if pulses is None else angle_from_tacho(channel, pulses)
    text = _scalar(held, speed) or speed
    try:
        return parse_quantity(text, ANGULAR_SPEED)
    except UnitError as error:
        named = [*held.names, *(key for key, value in held.attributes.items() if _is_number(value))]
        cure = f"{error.cure}, or name a channel or a scalar: {listed(named)}"
        raise InputError.of("--speed", speed, error.rule, cure) from None


def _scalar(held: Any, speed: str) -> str | None:
    """Return a scalar of the file as text with a unit: the one given after its name, else the one that the name ends with.

    ``Hz`` of a scalar is revolutions a second.
    """
    for name, value in held.attributes.items():
        given = speed.removeprefix(name).strip()
        if not speed.startswith(name) or not _is_number(value) or (given and speed[len(name)] != " "):
            continue
        unit = given or next((u for u in ("rpm", "hz", "rps", "rad/s") if name.lower().endswith(u)), "")
        return f"{value} {'rps' if unit.lower() == 'hz' else unit}".strip()
    return None


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
