"""Schema of the instruments: accelerometers, their mounting, and the collector."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, Field, ValidationError, model_validator

from gearplay.model.case import Case
from gearplay.model.file_kinds import check_kind
from gearplay.model.toml_files import parse_toml, plain_copy, toml_text
from gearplay.model.wording import translate
from gearplay.parts.mesh.train import geometry
from gearplay.rig.housing_paths import HousingPath, with_files
from gearplay.schema.fields import (
    Counted,
    FrozenTable,
    Listed,
    Measure,
    Name,
    Part,
    Problem,
    is_absent,
    refuse,
)
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, shorten
from gearplay.vocabulary.suggestions import did_you_mean

EDGE: Final = 0.05
"""Deviation of the response at both edges of a sensor's band, as data sheets state them."""

RESOLUTION_BAND: Final = (1.0, 1e4)
"""Band over which data sheets state the broadband resolution [Hz]."""

DEFAULT_SENSOR: Final = "356A02"

SENSORS: Final[Mapping[str, Mapping[str, float]]] = MappingProxyType({
    "356A02": {"sensitivity": 1.02e-3, "range": 4900.0, "lower_frequency": 1.0, "upper_frequency": 5e3,
               "resonance": 25e3, "resolution": 5e-3},
    "352C22": {"sensitivity": 1.02e-3, "range": 4900.0, "lower_frequency": 1.0, "upper_frequency": 1e4,
               "resonance": 50e3, "resolution": 0.02},
    "352C33": {"sensitivity": 10.2e-3, "range": 490.0, "lower_frequency": 0.5, "upper_frequency": 1e4,
               "resonance": 50e3, "resolution": 1.5e-3},
})  # fmt: skip
"""Nominal data of PCB Piezotronics [SI]: band within 5 %, least resonance, rms resolution from 1 Hz to 10 kHz.

Sensitivity and range of the 356A02 are those of Table 1 of Han et al. 2021; the others were not checked against a printed
data sheet. A calibration certificate goes before any of these.
"""


class Accelerometer(Part):
    """A piezoelectric accelerometer on a rotor's shaft or on the housing, with defaults from the table of sensors.

    It measures the acceleration of the rotor's centre along its axis, without gravity: the amplifier blocks
    constant voltages. With ``paths`` it sits on the housing and measures what forces of bearings make there.
    """

    kind: Annotated[
        Literal["356A02", "352C22", "352C33", "own"],
        Field(description="entry of the table of sensors, or own: all values given here"),
    ] = "356A02"
    rotor: (
        Annotated[
            str,
            Field(
                max_length=32,
                description="where it sits; the mesh's driven rotor, without meshes the only one that can move",
            ),
        ]
        | None
    ) = None
    mesh: Annotated[int, Field(ge=0, le=400, description="mesh whose centre line is angle 0")] = 0
    angle: Annotated[
        float, Measure(q.ANGLE, "direction of the axis, counter-clockwise from the centre line")
    ] = 0.0
    sensitivity: Annotated[float, Measure(q.SENSITIVITY, "voltage over acceleration", gt=0.0)]
    range: Annotated[float, Measure(q.ACCELERATION, "acceleration at which the output saturates", gt=0.0)]
    lower_frequency: Annotated[float, Measure(q.FREQUENCY, "lower edge of the band within 5 %", gt=0.0)]
    upper_frequency: Annotated[float, Measure(q.FREQUENCY, "upper edge of the band within 5 %", gt=0.0)]
    resonance: (
        Annotated[float, Measure(q.FREQUENCY, "natural frequency of the seismic element", gt=0.0)] | None
    ) = None
    damping_ratio: Annotated[
        float, Measure(None, "damping ratio of the seismic element", ge=1e-4, le=0.9)
    ] = 0.02
    resolution: Annotated[float, Measure(q.ACCELERATION, "rms noise from 1 Hz to 10 kHz", ge=0.0)] | None = (
        None
    )
    noise_density: (
        Annotated[float, Measure(q.ACCELERATION_DENSITY, "one-sided amplitude density of the noise", ge=0.0)]
        | None
    ) = None
    transverse_sensitivity: Annotated[
        float, Measure(q.RATIO, "response across the axis over that along it", ge=0.0, le=0.2)
    ] = 0.0
    paths: Annotated[
        tuple[HousingPath, ...],
        Listed(0, 32, "paths through the housing, from forces of bearings to the sensor"),
        Field(exclude_if=is_absent),
    ] = ()

    @model_validator(mode="before")
    @classmethod
    def _from_table(cls, raw: Any) -> Any:
        if not isinstance(raw, Mapping):
            return raw
        given = {key: value for key, value in raw.items() if value is not None}
        kind = given.get("kind", DEFAULT_SENSOR)
        if kind == "own":
            return given
        # An unknown kind is reported once, so its values are not also reported as missing.
        table = dict(SENSORS[kind if isinstance(kind, str) and kind in SENSORS else DEFAULT_SENSOR])
        if "noise_density" in given:
            del table["resolution"]
        return {**table, **given}

    @model_validator(mode="after")
    def _check(self) -> Accelerometer:
        problems = []
        if self.lower_frequency >= self.upper_frequency:
            rule = f"must be less than upper_frequency, {self.upper_frequency:g} Hz"
            problems.append(Problem(("lower_frequency",), rule, "Exchange the two or correct one"))
        if self.resolution is not None and self.noise_density is not None:
            rule = "must not be given together with resolution"
            problems.append(Problem(("noise_density",), rule, "Keep the one your data sheet states"))
        if self.resonance is not None and not self._band_is_flat():
            least = _resonance_for(self.upper_frequency, self.damping_ratio)
            rule = f"must keep the response within 5 % up to upper_frequency, {self.upper_frequency:g} Hz"
            cure = f"Give at least {least:.6g} Hz, or lower upper_frequency"
            problems.append(Problem(("resonance",), rule, cure))
        if self.paths and self.rotor is not None:
            rule = "must not be given together with paths, which put the sensor on the housing"
            problems.append(Problem(("rotor",), rule, "Remove one of the two"))
        if self.paths and self.transverse_sensitivity > 0.0:
            rule = "must be 0 with paths, which are along the sensor's axis"
            problems.append(Problem(("transverse_sensitivity",), rule, "Remove it"))
        refuse(problems)
        return self

    @property
    def natural_frequency(self) -> float:
        """Natural frequency of the seismic element [Hz]; where none is given, that of a +-5 % upper edge."""
        return self.resonance or _resonance_for(self.upper_frequency, self.damping_ratio)

    @property
    def coupling_corner(self) -> float:
        """Corner [Hz] of the first-order AC coupling that loses 5 % at the lower edge.

        >>> sensor = Accelerometer.model_validate({"kind": "356A02"})
        >>> round(sensor.coupling_corner, 4), round(1.0 / math.hypot(1.0, sensor.coupling_corner), 6)
        (0.3287, 0.95)
        """
        return self.lower_frequency * math.sqrt(1.0 / (1.0 - EDGE) ** 2 - 1.0)

    @property
    def density(self) -> float:
        """One-sided amplitude density of the noise [m/s^2/Hz^0.5]; 0 where neither form is given."""
        if self.noise_density is not None:
            return self.noise_density
        return (self.resolution or 0.0) / math.sqrt(RESOLUTION_BAND[1] - RESOLUTION_BAND[0])

    def _band_is_flat(self) -> bool:
        assert self.resonance is not None
        edge = self.upper_frequency / self.resonance
        peak = math.sqrt(max(0.0, 1.0 - 2.0 * self.damping_ratio**2))
        extremes = [edge, peak] if peak < edge else [edge]
        gains = [1.0 / math.hypot(1.0 - r * r, 2.0 * self.damping_ratio * r) for r in extremes]
        return all(abs(gain - 1.0) <= EDGE * (1.0 + 1e-9) for gain in gains)


def _resonance_for(upper: float, damping: float) -> float:
    """Return the natural frequency [Hz] whose response first leaves 1 -+ 5 % at ``upper`` [Hz].

    With x = (f / f_n)^2: (1 - x)^2 + 4 zeta^2 x = 1 / 1.05^2, or 1 / 0.95^2 where damping keeps the response below 1.05.

    Without damping x = 1 - 1 / 1.05 = 1 / 21:

    >>> round(_resonance_for(5000.0, 0.0) / 5000.0 / math.sqrt(21.0), 12)
    1.0
    """
    half = 1.0 - 2.0 * damping**2
    square = half**2 - 1.0 + 1.0 / (1.0 + EDGE) ** 2
    rises = half > 0.0 and square >= 0.0
    x = half - math.sqrt(square) if rises else half + math.sqrt(half**2 - 1.0 + 1.0 / (1.0 - EDGE) ** 2)
    return upper / math.sqrt(x)


class Collector(Part):
    """The recorder: anti-alias filter, sampling, conversion to counts.

    Of its defaults the sampling rate is that of Han et al. 2021; range, bits and filter are assumed.
    """

    sampling: Annotated[float, Measure(q.FREQUENCY, "samples per second", ge=10.0, le=1e6)] = 1e5
    range: Annotated[float, Measure(q.VOLTAGE, "largest voltage, either sign", gt=0.0)] = 5.0
    bits: Annotated[int, Field(ge=2, le=32, description="bits of the converter, sign included")] = 16
    filter: Annotated[
        Literal["butterworth", "none"], Field(description="anti-alias filter before the converter")
    ] = "butterworth"
    filter_order: Annotated[int, Field(ge=1, le=12, description="order of the filter")] = 8
    filter_corner: (
        Annotated[float, Measure(q.FREQUENCY, "where it loses 3 dB; 0.4 of the sampling rate", gt=0.0)] | None
    ) = None
    duration: Annotated[float, Measure(q.TIME, "length of a record; the case's", gt=0.0, le=1e6)] | None = (
        None
    )

    @model_validator(mode="after")
    def _check(self) -> Collector:
        if self.filter_corner is not None and self.filter_corner >= 0.5 * self.sampling:
            rule = f"must be less than half the sampling rate, {0.5 * self.sampling:g} Hz"
            refuse([Problem(("filter_corner",), rule, "Lower it, or leave it out for 0.4 of the rate")])
        return self

    @property
    def corner(self) -> float:
        """Corner of the anti-alias filter [Hz]."""
        return 0.4 * self.sampling if self.filter_corner is None else self.filter_corner

    @property
    def quantum(self) -> float:
        """Step of the converter [V]: 2 range / 2^bits.

        >>> Collector(range=5.0, bits=16).quantum
        0.000152587890625
        """
        return math.ldexp(self.range, 1 - self.bits)


class Rig(Part):
    """Accelerometers by name and the collector that records them. Without any field: the rig of Han et al. 2021."""

    title: Annotated[
        str, Field(max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$", description="title, for people")
    ] = ""
    accelerometers: Annotated[
        dict[Name, Accelerometer],
        Field(description="accelerometers by name, which their channels start with"),
        Counted(1, 64),
        AfterValidator(FrozenTable),
    ] = Field(default_factory=lambda: FrozenTable({"sensor": Accelerometer.model_validate({})}))
    collector: Collector = Collector()

    @model_validator(mode="after")
    def _check(self) -> Rig:
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        for name, sensor in self.accelerometers.items():
            band = sensor.lower_frequency, min(sensor.upper_frequency, 0.5 * self.collector.sampling)
            for k, path in enumerate(sensor.paths):
                low, high = path.reach
                if low > band[0] or high < band[1]:
                    rule = f"must cover the band of the sensor, {band[0]:g} to {band[1]:g} Hz; it is from {low:g} to {high:g} Hz"
                    cure = "Measure further, or narrow lower_frequency and upper_frequency"
                    yield Problem(("accelerometers", name, "paths", k, "table"), rule, cure)

    def resolved(self) -> dict[str, Any]:
        """Return every value, defaults included, as a JSON-able dictionary in SI that `load_rig` reads back."""
        return self.model_dump(mode="json")

    @cached_property
    def sha256(self) -> str:
        """Digest of the resolved rig."""
        text = json.dumps(self.resolved(), separators=(",", ":"), allow_nan=False, ensure_ascii=True)
        return hashlib.sha256(text.encode("ascii")).hexdigest()


def load_rig(source: Rig | str | os.PathLike[str] | Mapping[str, Any] | None = None) -> Rig:
    """Read a rig.

    Parameters
    ----------
    source
        Path of a TOML file, a dictionary laid out as such a file, a `Rig` (returned as it is), or None: the rig of
        Han et al. 2021.

    Raises
    ------
    InputError
        With every fault found.

    Examples
    --------
    >>> rig = load_rig({"accelerometers": {"ring": {"range": "500 m/s^2"}}, "collector": {"bits": 12}})
    >>> rig.accelerometers["ring"].sensitivity, rig.accelerometers["ring"].range
    (0.00102, 500.0)

    """
    if isinstance(source, Rig):
        return source
    try:
        document = _document({} if source is None else source)
        check_kind(document, "rig", "rig", NO_VALUE if isinstance(source, Mapping) else str(source))
        return Rig.model_validate(document)
    except ValidationError as error:
        faults = translate(error, document, Rig)
    except InputError as error:
        faults = error.faults
    # The reading of files is shared with cases, whose root it names.
    raise InputError([fault._replace(path="rig") if fault.path == "case" else fault for fault in faults])


def _document(source: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(source, Mapping):
        return with_files(plain_copy(source), Path())  # type: ignore[no-any-return]
    name = os.fspath(source) if isinstance(source, (str, os.PathLike)) else source
    if not isinstance(name, str):
        raise InputError.of("rig", name, "must be a path or a table", "Pass one of these")
    path = Path(name)
    return with_files(plain_copy(parse_toml(toml_text(path, what="rig"), shorten(path.name))), path.parent)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Placement:
    """Position of an accelerometer: its rotor, "" on the housing, and the direction of its axis from +x [rad]."""

    rotor: str
    direction: float


def _usual_rotor(case: Case, mesh: int) -> str | None:
    """Return the driven rotor of a mesh; of a case without meshes the only one whose centre can move, if there is one."""
    if case.meshes:
        return case.meshes[mesh].rotors[1]
    free = [name for name in case.rotors if not geometry.is_held(case, name)]
    return free[0] if len(free) == 1 else None


def placements(rig: Rig, case: Case) -> dict[str, Placement]:
    """Return where each accelerometer of a rig sits in a case.

    Angle 0 is the nominal vector of centres of the sensor's mesh (docs/conventions), or +x in a case without meshes.

    Raises `InputError` for a rotor or mesh that the case does not have.

    >>> from gearplay.model.reading import load_case
    >>> placements(load_rig(), load_case("han2021"))
    {'sensor': Placement(rotor='ring', direction=0.0)}
    """
    faults: list[Fault] = []
    found: dict[str, Placement] = {}
    centres = geometry.centres(case)
    for name, sensor in rig.accelerometers.items():
        at = f"accelerometers.{name}"
        if case.meshes and sensor.mesh >= len(case.meshes):
            rule = f"must be a mesh of the case, 0 to {len(case.meshes) - 1}"
            faults.append(Fault(f"{at}.mesh", sensor.mesh, rule, "Count the case's meshes from 0"))
            continue
        for k, path in enumerate(sensor.paths):
            table, _, part = path.at.partition(".")
            given = getattr(case, table)
            if part not in given:
                cure = did_you_mean(part, given, table.capitalize()) if given else f"The case has no {table}"
                faults.append(
                    Fault(f"{at}.paths.{k}.at", path.at, f"must be one of the {table} of the case", cure)
                )
            elif given[part].on is not None:
                rule = f"must be on the housing, not on {given[part].on}"
                faults.append(Fault(f"{at}.paths.{k}.at", path.at, rule, "Name another"))
        rotor = sensor.rotor or _usual_rotor(case, sensor.mesh)
        if sensor.paths:
            rotor = ""
        if rotor is None:
            faults.append(
                Fault(
                    f"{at}.rotor",
                    NO_VALUE,
                    "is required where the case has no mesh and several shafts that can move, or none",
                    "Add it",
                )
            )
        elif rotor and rotor not in case.rotors:
            cure = did_you_mean(rotor, case.rotors, "Rotors")
            faults.append(Fault(f"{at}.rotor", rotor, "must be a rotor of the case", cure))
        else:
            line = 0.0
            if case.meshes:
                foot, tip = geometry.signed_radii(case, sensor.mesh)[:2]
                (x_a, y_a), (x_b, y_b) = (centres[geometry.rotor_of(case, gear)] for gear in (foot, tip))
                line = math.atan2(y_b - y_a, x_b - x_a)
            found[name] = Placement(rotor, line + sensor.angle)
    if faults:
        raise InputError(faults)
    return found
