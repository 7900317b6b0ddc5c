"""`modes`, `campbell` and `frequency_response`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.linear.campbell import Campbell, campbell_of
from gearplay.linear.modes import Modes, modes_of
from gearplay.linear.response import FrequencyResponse, response_of, responses_of
from gearplay.linear.system import linear_system
from gearplay.model.case import Case
from gearplay.model.families import Family, Varied
from gearplay.model.field_units import unit_at
from gearplay.model.reading import Source
from gearplay.results.simulate import case_of
from gearplay.schema.units import quantity_of
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError, ResourceError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

MOST = 100_000
"""Most speeds or frequencies of one call."""


def modes(case: Source, *, load: str = "operating", speed: float | str | None = None) -> Modes:
    """Return natural frequencies, damping ratios and shapes of a case about its static equilibrium.

    The equilibrium is that of constant torques with the mean stiffness of the meshes and elastic sleeves; contacts that the load
    closes are springs, open ones are absent. Errors, runouts, friction and what varies in time are left out; a servo is the
    spring and the damper that its gains are.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    load
        "operating", torques, drags and gravity as at the nominal speeds, or "none".
    speed
        Speed of the leading rotor [rad/s] or with a unit, for trains with carriers: modes are then seen from the turning carrier,
        with gyroscopic and centrifugal forces. None is at rest.

    Returns
    -------
    Modes
        ``.ds`` with ``frequency`` (mode) [Hz], ``damping_ratio`` (mode), ``shape`` (mode, coordinate), ``strain_energy_share``,
        ``kinetic_energy_share``, and the ``kind`` of each mode.

    Raises
    ------
    InputError
        For an invalid load or speed.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.modes("two-stage-reducer")
    >>> round(float(found.ds["frequency"][-1]), 1), str(found.ds["kind"].values[-1])
    (3439.3, 'coupled')

    """
    return modes_of(linear_system(case_of(case), load=load, speed=speed_of(speed)))


def campbell(case: Source, speeds: ArrayLike | Sequence[str], *, load: str = "operating") -> Campbell:
    """Return natural frequencies over speed, with the orders that excite them and where these meet.

    The load stays as it is at the case's own speed, whatever the speed.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    speeds
        Speeds of the leading rotor [rad/s], or texts with a unit, rising, shape [speed].
    load
        "operating" or "none", as of `modes`.

    Returns
    -------
    Campbell
        ``.ds`` with ``frequency`` (speed, mode) [Hz], ``order_frequency`` (speed, order) [Hz], and the crossings.

    Raises
    ------
    InputError
        For invalid speeds.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> diagram = gp.campbell("external-pair", ["500 rpm", "1000 rpm", "1500 rpm"])
    >>> diagram.ds["frequency"].sizes["speed"]
    3

    """
    _check_length("speeds", speeds)
    numbers = np.array(
        [speed_of(each, "speeds") for each in np.atleast_1d(np.asarray(speeds, dtype=object)).tolist()],
        dtype=float,
    )
    if not 2 <= numbers.size <= MOST or np.any(np.diff(numbers) <= 0.0) or not np.all(np.isfinite(numbers)):
        raise InputError.of(
            "speeds", numbers.size, f"must be 2 to {MOST} rising numbers", "Give them in order"
        )
    return campbell_of(case_of(case), numbers, load=load)


def frequency_response(
    case: Source | Family,
    path: str | None = None,
    values: Sequence[Any] | None = None,
    *,
    force: str,
    at: str | Sequence[str],
    frequencies: ArrayLike,
    load: str = "operating",
) -> FrequencyResponse:
    """Return the linear response of displacements, torques and forces to a harmonic force, error, unbalance or acceleration.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; with ``path`` also a function that returns a `Case` for a value of a
        parameter.
    path
        A field over which the response is computed, ``meshes.0.backlash``; of a function the name of its parameter. None for the
        case alone.
    values
        Values of the field, in SI or texts with a unit; of a function plain numbers.
    force
        What excites: ``rotor.fx``, ``rotor.fy`` [N], ``rotor.torque`` [N m], ``rotor.unbalance`` [kg m], a force m e omega^2 that
        turns with the frequency, ``driver-driven.transmission_error`` [m] of a mesh, ``base.ax``, ``base.ay`` [m/s^2] of the
        housing, to which displacements are then relative.
    at
        An output or several: ``rotor.x``, ``rotor.y`` [m], ``rotor.theta`` [rad]; ``first-second.torque`` [N m] of a coupling;
        ``driver-driven.force`` [N] of a mesh; ``rotor.force_x``, ``rotor.force_y`` [N] of a rotor's sleeve and support on it.
    frequencies
        [Hz], shape [frequency].
    load
        "operating" or "none", as of `modes`.

    Returns
    -------
    FrequencyResponse
        ``.ds`` with ``amplitude`` and ``phase`` (at, frequency), for an excitation of amplitude 1 in its unit, and ``unit`` (at);
        with ``path`` its last name is the first dimension, and there is ``natural_frequency`` (parameter, mode).

    Raises
    ------
    InputError
        For an unknown force or coordinate, and for invalid frequencies.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.frequency_response("two-stage-reducer", force="output.torque", at="output.theta", frequencies=[100.0, 600.0])
    >>> found.ds["amplitude"].shape
    (1, 2)
    >>> pair = lambda zeta: gp.torsional_pair(0.7, damping_ratio=zeta)
    >>> found = gp.frequency_response(
    ...     pair, "zeta", [0.02, 0.1], force="wheel.torque", at="wheel.theta", frequencies=range(100, 2000, 10)
    ... )
    >>> dict(found.ds["amplitude"].sizes)
    {'zeta': 2, 'at': 1, 'frequency': 190}

    """
    _check_length("frequencies", frequencies)
    numbers: NDArray[np.float64] = np.atleast_1d(np.asarray(frequencies, dtype=float))
    if (
        numbers.ndim != 1
        or not 1 <= numbers.size <= MOST
        or not np.all(np.isfinite(numbers))
        or np.any(numbers < 0.0)
    ):
        rule = f"must be 1 to {MOST} frequencies of 0 Hz or more"
        raise InputError.of("frequencies", str(numbers.shape), rule, "Give them in Hz")
    names = [at] if isinstance(at, str) else list(at)
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError.of("at", str(at), "must name outputs", "Write for example ring.x")
    if path is None and values is None:
        if callable(case) and not isinstance(case, Case):
            rule = "is required where the case is a function"
            raise InputError.of("path", NO_VALUE, rule, "Name its parameter, and give its values")
        return response_of(linear_system(case_of(case), load=load), force, names, numbers)
    if path is None or values is None or not len(values):
        rule = "must be given together"
        raise InputError.of("path, values", path, rule, "Give the field or parameter, and one value or more")
    _check_length("values", values)
    varied = Varied(case, path)
    given = np.array([varied.number(value, f"values.{k}") for k, value in enumerate(values)])
    family = varied.family(varied.case(float(given[0])))
    systems = [linear_system(family(float(value)), load=load) for value in given]
    units = "1" if varied.is_function else unit_at(systems[0].case, path)
    return responses_of(systems, force, names, numbers, path=path, values=given, units=units)


def _check_length(name: str, given: Any) -> None:
    """Raise `ResourceError` for more than `MOST` numbers, before any is read."""
    count = len(given) if hasattr(given, "__len__") and not isinstance(given, str) else 1
    if count > MOST:
        raise ResourceError(
            f"{name}: {count} numbers, {count / MOST:.3g} times the limit of {MOST}. Give fewer."
        )


def speed_of(value: Any, field: str = "speed") -> float | None:
    """Return a speed [rad/s] given as a number or with a unit, None for none; `InputError` of ``field`` for anything else."""
    return None if value is None else quantity_of(field, value, q.ANGULAR_SPEED)
