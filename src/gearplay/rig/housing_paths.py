"""Housing paths: acceleration of the housing at a sensor by forces of bearings, by modes or a measured transfer function.

Of modes a / F = sum shape / m s^2 / (s^2 + 2 zeta w s + w^2), the accelerance of a linear structure by its modes (D. J. Ewins,
Modal Testing, 2nd ed. 2000, ch. 2); a table is interpolated linearly in its real and imaginary part.
"""

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gearplay.model.toml_files import lines_of
from gearplay.rig.modes import Modes, sharpen
from gearplay.schema.fields import MEMBER, NAME, Listed, Measure, Part, Problem, is_absent, refuse
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

FORCES: Final[Mapping[str, str]] = {
    "sleeves": "sleeve_force",
    "supports": "support_force",
    "bearings": "bearing_force",
}
"""Signals of the forces on a rotor along x and y, without their ending, by table of the case."""
MOST_ROWS: Final = 20_000
COLUMNS: Final = (("frequency", "real", "imaginary"), ("frequency", "magnitude", "phase"))
"""Headings of a file: frequency [Hz], accelerance [m/s^2/N]; phase [deg]."""


class HousingMode(Part):
    """A mode of the housing between a bearing and a sensor."""

    frequency: Annotated[float, Measure(q.FREQUENCY, "natural frequency, undamped", gt=0.0)]
    damping_ratio: Annotated[float, Measure(None, "damping ratio", ge=1e-5, le=0.9)]
    mass: Annotated[float, Measure(q.MASS, "modal mass", gt=0.0)]
    shape: Annotated[
        float,
        Measure(None, "mode shape at the bearing times that at the sensor, scaled as the modal mass is"),
    ] = 1.0

    @property
    def velocity(self) -> Modes:
        """Velocity over force [m/s/N]: shape / m s / (s^2 + 2 zeta w s + w^2), as the modes of a filter."""
        pole = (
            math.tau * self.frequency * complex(-self.damping_ratio, math.sqrt(1.0 - self.damping_ratio**2))
        )
        return Modes((pole,), (self.shape / self.mass * pole / (2j * pole.imag),))


class HousingPath(Part):
    """Path from the force of a bearing on the housing to a sensor there: ``modes``, or a measured ``table`` or ``file``."""

    at: Annotated[
        str,
        Field(
            pattern=rf"^({'|'.join(FORCES)})\.{NAME}(\.{MEMBER})?$",
            description="what presses on the housing: sleeves.ROTOR, bearings.ROTOR or supports.ROTOR",
        ),
    ]
    angle: Annotated[
        float, Measure(q.ANGLE, "direction of the force, counter-clockwise from the sensor's axis")
    ] = 0.0
    modes: Annotated[
        tuple[HousingMode, ...], Listed(0, 256, "modes of the housing"), Field(exclude_if=is_absent)
    ] = ()
    table: Annotated[
        tuple[Annotated[tuple[float, float, float], Listed(3, 3, "frequency, real and imaginary part")], ...],
        Listed(0, MOST_ROWS, "measured accelerance: frequency [Hz], real and imaginary part [m/s^2/N]"),
        Field(exclude_if=is_absent),
    ] = ()

    @model_validator(mode="after")
    def _check(self) -> "HousingPath":
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if bool(self.modes) == bool(self.table):
            rule = "must not be given together with modes" if self.table else "is required, or file or table"
            yield Problem(("table",) if self.table else ("modes",), rule, "Give one of the two")
        if len(self.table) == 1:
            yield Problem(("table",), "must have two rows or more", "Add one")
        for k, ((f, *_), (f_1, *_)) in enumerate(pairwise(self.table), start=1):
            if f_1 <= f:
                yield Problem(
                    ("table", k), "must have a frequency above that of the row before", "Order the rows"
                )
                return
        if self.table and self.table[0][0] < 0.0:
            yield Problem(("table", 0), "must have a frequency of 0 Hz or more", "Correct it")

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz] at which the path is known."""
        return (self.table[0][0], self.table[-1][0]) if self.table else (0.0, math.inf)

    def response(self, frequency: Floats) -> Complex:
        """Return the accelerance a / F [m/s^2/N] at each frequency [Hz], shape [frequency].

        Raises `InputError` for a frequency outside a table.

        >>> mode = {"frequency": 1000.0, "damping_ratio": 0.05, "mass": 2.0}
        >>> path = HousingPath.model_validate({"at": "sleeves.ring", "modes": [mode]})
        >>> np.abs(path.response(np.array([1000.0]))).round(6).item()  # 1 / (2 zeta m)
        5.0
        """
        frequency = np.asarray(frequency, dtype=np.float64)
        if self.modes:
            s = 2j * math.pi * frequency
            return np.asarray(sum(s * mode.velocity.response(frequency) for mode in self.modes))
        low, high = self.reach
        outside = (frequency < low) | (frequency > high)
        if np.any(outside):
            rule = f"must be within the table, {low:g} to {high:g} Hz"
            raise InputError.of(
                "frequency", f"{frequency[outside][0]:g} Hz", rule, "Measure further, or ask within it"
            )
        return self._interpolated(frequency)

    def _interpolated(self, frequency: Floats) -> Complex:
        """Return the table at frequencies [Hz], 0 outside it."""
        f, real, imaginary = np.array(self.table).T
        parts = (np.interp(frequency, f, part, left=0.0, right=0.0) for part in (real, imaginary))
        first, second = parts
        return np.asarray(first + 1j * second)

    def mean_acceleration(self, force: Floats, sampling: float) -> Floats:
        """Return the mean acceleration of the housing in each sampling interval [m/s^2], shape [time - 1].

        ``force`` [N], shape [time], at this rate [Hz], presses along the path's direction. The housing is at rest under the first
        force. Of a table frequencies outside it are left out.
        """
        change = np.asarray(force, dtype=np.float64) - force[0]
        if self.modes:
            sharp = sharpen(change)
            speed = sum(mode.velocity.join(sharp, 1.0 / sampling) for mode in self.modes)
            return np.asarray(np.diff(speed) * sampling)
        size = 2 * len(change)  # the response of the second half does not come round to the first
        frequency: Floats = np.fft.rfftfreq(size, 1.0 / sampling).astype(np.float64)
        ahead: Complex = np.asarray(2j * math.pi / sampling * frequency, dtype=np.complex128)
        ahead[0] = 1.0  # a constant force makes no acceleration
        averaged: Complex = np.expm1(ahead) / ahead
        averaged[0] = 0.0
        change = np.concatenate([change, np.linspace(change[-1], 0.0, len(change))])  # no jump at the end
        spectrum: Complex = (
            np.fft.rfft(change, size).astype(np.complex128) * self._interpolated(frequency) * averaged
        )
        return np.asarray(np.fft.irfft(spectrum, size)[: len(force) - 1])


def with_files(document: Any, folder: Path) -> Any:
    """Return a raw rig whose paths hold the tables of their files, which are paths from ``folder``."""
    sensors = document.get("accelerometers") if isinstance(document, dict) else None
    for name, sensor in sensors.items() if isinstance(sensors, dict) else ():
        paths = sensor.get("paths") if isinstance(sensor, dict) else None
        for k, path in enumerate(paths if isinstance(paths, list) else ()):
            if not isinstance(path, dict) or "file" not in path:
                continue
            at = f"accelerometers.{name}.paths.{k}.file"
            file = path.pop("file")
            if not isinstance(file, str):
                raise InputError.of(at, file, "must be the name of a file", "Write it in quotes")
            if "table" in path:
                raise InputError.of(
                    at, file, "must not be given together with table", "Remove one of the two"
                )
            path["table"] = _table_of(at, folder / file)
    return document


def _table_of(at: str, file: Path) -> list[list[float]]:
    """Return the rows (frequency, real, imaginary) of a file with a heading of `COLUMNS`."""
    rows: list[list[float]] = []
    heading: tuple[str, ...] | None = None
    for number, words in lines_of(at, file):
        if heading is None:
            heading = tuple(word.lower() for word in words if not word.startswith("["))
            if heading not in COLUMNS:
                every = " or ".join(",".join(columns) for columns in COLUMNS)
                raise InputError.of(
                    at, f"line {number}", f"must be the heading {every}", "Correct the heading"
                )
            continue
        try:
            f, one, other = map(float, words)
        except ValueError:
            rule = "must have three numbers: " + ", ".join(heading)
            raise InputError.of(at, f"line {number}", rule, "Correct that line") from None
        if not all(map(math.isfinite, (f, one, other))):
            raise InputError.of(at, f"line {number}", "must have finite numbers", "Remove that line")
        if heading[1] == "magnitude":
            one, other = one * math.cos(math.radians(other)), one * math.sin(math.radians(other))
        rows.append([f, one, other])
    if heading is None:
        raise InputError.of(at, NO_VALUE, "must have a heading and rows", "Write the measured values into it")
    return rows
