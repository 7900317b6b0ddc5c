"""The table of quantities: name, symbol, SI unit, display unit, long name.

Case files, result files, plots and reports all take names and units from here. Unit strings are written as
netCDF and pint both read them: ``N s/m``, ``kg m^2``; ``1`` is dimensionless.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

_DEGREES: Final = 180.0 / math.pi
_RPM: Final = 30.0 / math.pi


class Quantity(NamedTuple):
    """A physical quantity or a variable of a result.

    Parameters
    ----------
    name
        Identifier, as in a result file.
    symbol
        Short symbol, ASCII.
    unit
        SI unit; every number inside the package is in it.
    display_unit
        Unit for people.
    display_factor
        Number of display units in one SI unit: ``shown = value * display_factor + display_offset``.
    long_name
        Words for an axis or a table.
    display_offset
        What 0 in SI is in the display unit: of a temperature -273.15 degC.

    Examples
    --------
    >>> LENGTH.unit, LENGTH.display_unit, 1e-4 * LENGTH.display_factor
    ('m', 'um', 100.0)

    """

    name: str
    symbol: str
    unit: str
    display_unit: str
    display_factor: float
    long_name: str
    display_offset: float = 0.0

    @property
    def label(self) -> str:
        """Axis label in display units: ``penetration of the sleeve [um]``."""
        return f"{self.long_name} [{self.display_unit}]"


def hertz_stiffness(exponent: float) -> Quantity:
    """Return the stiffness of a contact ``F = K delta^exponent`` [N/m^exponent].

    Examples
    --------
    >>> hertz_stiffness(1.5).unit, hertz_stiffness(1.0).unit
    ('N/m^1.5', 'N/m')

    """
    unit = "N/m" if exponent == 1.0 else f"N/m^{exponent:g}"
    return Quantity("hertz_stiffness", "K", unit, unit, 1.0, "contact stiffness")


# Dimensions of what a case file gives.
LENGTH: Final = Quantity("length", "l", "m", "um", 1e6, "length")
MASS: Final = Quantity("mass", "m", "kg", "kg", 1.0, "mass")
INERTIA: Final = Quantity("inertia", "J", "kg m^2", "kg m^2", 1.0, "polar moment of inertia")
ANGLE: Final = Quantity("angle", "phi", "rad", "deg", _DEGREES, "angle")
ANGULAR_SPEED: Final = Quantity("angular_speed", "omega", "rad/s", "rpm", _RPM, "angular speed")
TIME: Final = Quantity("time", "t", "s", "s", 1.0, "time")
FREQUENCY: Final = Quantity("frequency", "f", "Hz", "Hz", 1.0, "frequency")
SPEED: Final = Quantity("speed", "v", "m/s", "mm/s", 1e3, "speed")
ACCELERATION: Final = Quantity("acceleration", "a", "m/s^2", "m/s^2", 1.0, "acceleration")
FORCE: Final = Quantity("force", "F", "N", "N", 1.0, "force")
TORQUE: Final = Quantity("torque", "T", "N m", "N m", 1.0, "torque")
STIFFNESS: Final = Quantity("stiffness", "k", "N/m", "N/um", 1e-6, "stiffness")
DAMPING: Final = Quantity("damping", "C", "N s/m", "N s/m", 1.0, "damping")
ROTATIONAL_DRAG: Final = Quantity("rotational_drag", "d", "N m s/rad", "N m s/rad", 1.0, "rotational drag")
ROTATIONAL_STIFFNESS: Final = Quantity(
    "rotational_stiffness", "k_i", "N m/rad", "N m/rad", 1.0, "rotational stiffness"
)
PRESSURE: Final = Quantity("pressure", "E", "Pa", "GPa", 1e-9, "pressure, elastic modulus")
RATIO: Final = Quantity("ratio", "r", "1", "1", 1.0, "ratio")
VOLTAGE: Final = Quantity("voltage", "U", "V", "V", 1.0, "voltage")
RESISTANCE: Final = Quantity("resistance", "R", "ohm", "ohm", 1.0, "electrical resistance")
INDUCTANCE: Final = Quantity("inductance", "L", "H", "mH", 1e3, "inductance")
TORQUE_CONSTANT: Final = Quantity("torque_constant", "k_t", "N m/A", "N m/A", 1.0, "torque constant")
SENSITIVITY: Final = Quantity(
    "sensitivity", "S", "V/(m/s^2)", "mV/(m/s^2)", 1e3, "sensitivity of an accelerometer"
)
ACCELERATION_DENSITY: Final = Quantity(
    "acceleration_density", "n", "m/s^2/Hz^0.5", "m/s^2/Hz^0.5", 1.0, "amplitude density of acceleration"
)
INTEGRAL_GAIN: Final = Quantity(
    "integral_gain", "k_i", "N m/(rad s)", "N m/(rad s)", 1.0, "gain on the integral of an angle"
)
TEMPERATURE: Final = Quantity("temperature", "T", "K", "degC", 1.0, "temperature", -273.15)
EXPANSION: Final = Quantity("expansion", "alpha", "1/K", "1/K", 1.0, "coefficient of linear expansion")
MASS_DENSITY: Final = Quantity("mass_density", "rho", "kg/m^3", "kg/m^3", 1.0, "mass density")
UNBALANCE: Final = Quantity("unbalance", "U", "kg m", "g mm", 1e6, "unbalance")
SPECTRAL_DENSITY: Final = Quantity(
    "spectral_density", "S", "(m/s^2)^2/Hz", "(m/s^2)^2/Hz", 1.0, "spectral density of acceleration"
)
WEAR_COEFFICIENT: Final = Quantity("wear_coefficient", "k", "m^2/N", "mm^3/(N m)", 1e9, "wear coefficient")
HERTZ_STIFFNESS: Final = hertz_stiffness(1.5)

DIMENSIONS: Final[Mapping[str, Quantity]] = MappingProxyType({
    quantity.name: quantity
    for quantity in (
        LENGTH, MASS, INERTIA, ANGLE, ANGULAR_SPEED, TIME, FREQUENCY, SPEED, ACCELERATION, FORCE, TORQUE,
        STIFFNESS, DAMPING, ROTATIONAL_DRAG, ROTATIONAL_STIFFNESS, PRESSURE, RATIO, HERTZ_STIFFNESS,
        VOLTAGE, SENSITIVITY, ACCELERATION_DENSITY, UNBALANCE, SPECTRAL_DENSITY,
        INTEGRAL_GAIN, TEMPERATURE, EXPANSION, MASS_DENSITY, WEAR_COEFFICIENT, RESISTANCE, INDUCTANCE, TORQUE_CONSTANT,
    )
})  # fmt: skip
"""Dimensions of inputs, by name."""


def _table(*rows: Quantity) -> Mapping[str, Quantity]:
    return MappingProxyType({row.name: row for row in rows})


ROTOR_VARIABLES: Final = _table(
    Quantity("x", "x", "m", "um", 1e6, "displacement of the rotor's centre along x"),
    Quantity("y", "y", "m", "um", 1e6, "displacement of the rotor's centre along y"),
    Quantity("theta", "theta", "rad", "rad", 1.0, "rotation of the rotor"),
    Quantity("vx", "vx", "m/s", "mm/s", 1e3, "velocity of the rotor's centre along x"),
    Quantity("vy", "vy", "m/s", "mm/s", 1e3, "velocity of the rotor's centre along y"),
    Quantity("omega", "omega", "rad/s", "rpm", _RPM, "angular speed of the rotor"),
    Quantity("ax", "ax", "m/s^2", "m/s^2", 1.0, "acceleration of the rotor's centre along x"),
    Quantity("ay", "ay", "m/s^2", "m/s^2", 1.0, "acceleration of the rotor's centre along y"),
    Quantity("drive_torque", "T_d", "N m", "N m", 1.0, "torque of the drive on the rotor"),
    Quantity("load_torque", "T_l", "N m", "N m", 1.0, "torque of the load on the rotor"),
    Quantity("rotor_power_loss", "P", "W", "W", 1.0, "power lost to drag, dry friction and damping"),
)
"""Result variables with one value per rotor; those of elements are in the file of each kind (`kernels.elements`)."""

CONTACT_STATISTICS: Final = _table(
    Quantity("share_of_time", "s", "1", "%", 100.0, "share of time in contact"),
    Quantity("impacts_per_second", "n", "1/s", "1/s", 1.0, "impacts per second"),
    Quantity("mean_impact_speed", "v_mean", "m/s", "mm/s", 1e3, "mean impact speed"),
    Quantity("rms_impact_speed", "v_rms", "m/s", "mm/s", 1e3, "rms impact speed"),
    Quantity("max_impact_speed", "v_max", "m/s", "mm/s", 1e3, "largest impact speed"),
    Quantity("peak_force", "F_max", "N", "N", 1.0, "largest force"),
    Quantity("max_penetration", "delta_max", "m", "um", 1e6, "largest penetration"),
)
"""Statistics of every contact of a run; those of couplings are in rad/s, N m and rad."""

ANGULAR_UNITS: Final = MappingProxyType({"m/s": "rad/s", "N": "N m", "m": "rad"})
"""Units of the statistics of contacts between rotations, as of couplings, by the unit of the others."""


def contact_unit(statistic: str, *, angular: bool) -> str:
    """Return the SI unit of a statistic of a contact, between rotations if ``angular``.

    Examples
    --------
    >>> contact_unit("peak_force", angular=True), contact_unit("share_of_time", angular=True)
    ('N m', '1')

    """
    unit = CONTACT_STATISTICS[statistic].unit
    return ANGULAR_UNITS.get(unit, unit) if angular else unit


OUTPUT_STATISTICS: Final = _table(
    Quantity("mean_speed", "omega_mean", "rad/s", "rpm", _RPM, "mean speed"),
    Quantity("speed_ripple", "omega_pp", "rad/s", "rpm", _RPM, "speed ripple, peak to peak"),
    Quantity("mean_torque", "T_mean", "N m", "N m", 1.0, "mean torque"),
    Quantity("torque_ripple", "T_pp", "N m", "N m", 1.0, "torque ripple, peak to peak"),
    Quantity(
        "transmission_error", "e_pp", "rad", "arcmin", 60.0 * _DEGREES, "transmission error, peak to peak"
    ),
    Quantity("wind_up", "e_mean", "rad", "arcmin", 60.0 * _DEGREES, "wind-up, mean lag"),
    Quantity("output_power", "P_out", "W", "W", 1.0, "mean power into the load"),
    Quantity("efficiency", "eta", "1", "%", 100.0, "efficiency"),
    Quantity("impacts_per_second", "n", "1/s", "1/s", 1.0, "impacts of all contacts"),
    Quantity("impact_power", "P_i", "W", "W", 1.0, "kinetic energy of the impacts"),
)
"""Statistics of the output shaft of a run (`gearplay.results.output_shaft`)."""
