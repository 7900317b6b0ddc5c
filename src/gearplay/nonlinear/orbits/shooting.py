"""Periodic orbits by shooting: Newton's method with exact derivatives; Floquet multipliers."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.orbits.period_map import PeriodMap
from gearplay.solver.integration import OutOfTimeError
from gearplay.vocabulary.errors import GearplayError, SimulationError

Floats = NDArray[np.float64]
CLOSE = 1e-9
"""Residual in natural sizes from which on an orbit counts as found."""
SAME = 1e-6
"""Distance in natural sizes up to which two sections of an orbit count as one."""
MOST_STEPS = 30


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit: its states at the section, shape [order, state], and the derivative of the map over its period.

    ``multipliers`` are the Floquet multipliers, the largest first, complex, shape [state less constants]: the impact speed of a
    sleeve that stays closed is a constant of the orbit and no direction that could grow. ``residual`` is in natural sizes;
    ``contacts`` the contact changes over the period, shape [change, 2].

    Of an autonomous system the last entry of a state is the ``period`` [s], else NaN; the multiplier 1 of a shift in time is not
    among the multipliers.
    """

    parameter: float
    states: Floats
    matrix: Floats
    multipliers: NDArray[np.complex128]
    residual: float
    contacts: NDArray[np.int64]
    period: float

    @property
    def order(self) -> int:
        """Periods of the excitation after which the orbit repeats."""
        return len(self.states)

    @property
    def stable(self) -> bool:
        """Whether small changes decay."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))


@dataclass(frozen=True)
class Return:
    """A map over ``order`` periods: the states at the section on the way, shape [order, state], image, derivative, contacts."""

    states: Floats
    image: Floats
    matrix: Floats
    contacts: NDArray[np.int64]
    period: float = math.nan


def after(period_map: PeriodMap, state: Floats, parameter: float, order: int) -> Return:
    """Return the map over ``order`` periods with the product of its derivatives."""
    matrix, states, contacts = np.eye(state.size), [], []
    for _ in range(order):
        states.append(state)
        found = period_map(state, parameter)
        matrix = found.matrix @ matrix
        state = found.state
        contacts.append(found.contacts)
    return Return(np.array(states), state, matrix, np.concatenate(contacts), found.period)


def constants(matrix: Floats) -> NDArray[np.bool_]:
    """Return the states that a map keeps unchanged: rows of its derivative that are those of the identity.

    >>> constants(np.array([[0.5, 0.1], [0.0, 1.0]])).tolist()
    [False, True]
    """
    return np.asarray(np.all(matrix == np.eye(len(matrix)), axis=1))


def defect_slopes(found: Return, scale: Floats) -> Floats:
    """Return the derivative of a map's defect, M - 1 in natural sizes; rows of constants are those of the identity."""
    slopes = found.matrix * scale[None, :] / scale[:, None] - np.eye(scale.size)
    kept = constants(found.matrix)
    slopes[kept] = np.eye(scale.size)[kept]
    return np.asarray(slopes)


def find_orbit(period_map: PeriodMap, guess: Floats, parameter: float, *, order: int = 1) -> Orbit:
    """Return the periodic orbit of an order near a guess of its state at the section, shape [state].

    Newton's method, each step halved until the residual falls; stable and unstable orbits alike.

    Raises `SimulationError` where it does not converge, or leads to an orbit of a lower order.
    """
    scale = period_map.scale
    state = np.array(guess, dtype=np.float64)
    found = after(period_map, state, parameter, order)
    residual = _size(found.image - state, scale)
    for _ in range(MOST_STEPS):
        if residual <= CLOSE:
            if (lower := order_of(found.states, scale)) < order:
                raise SimulationError(
                    f"orbit: the motion near the guess repeats after {lower} of {order} periods already. "
                    f"Ask for order {lower}."
                )
            return _polished(period_map, found, parameter, residual)
        step = _newton_step(found, scale)
        share = 1.0
        while share > 1e-3:
            try:
                tried = after(period_map, state + share * step, parameter, order)
            except OutOfTimeError:
                raise
            except GearplayError:  # the motion cannot be followed from there
                share *= 0.5
                continue
            size = _size(tried.image - tried.states[0], scale)
            if size < residual:
                break
            share *= 0.5
        else:
            break
        state, found, residual = tried.states[0], tried, size
    raise SimulationError(
        f"orbit: Newton's method found no orbit of order {order} near the guess (scaled residual {residual:.2g}). "
        "Start nearer, or from a settled motion."
    )


def order_of(states: Floats, scale: Floats) -> int:
    """Return the period of sections, shape [order, state]: their number, or a divisor of it.

    >>> order_of(np.array([[1.0], [2.0], [1.0], [2.0]]), np.ones(1)), order_of(np.array([[1.0], [2.0]]), np.ones(1))
    (2, 2)
    """
    order = len(states)
    lower = (n for n in range(1, order) if order % n == 0 and _size(states[n] - states[0], scale) <= SAME)
    return next(lower, order)


def _polished(period_map: PeriodMap, found: Return, parameter: float, residual: float) -> Orbit:
    """Return the orbit after one more step, if that brings it nearer: Newton's method squares the error."""
    scale = period_map.scale
    try:
        better = after(period_map, found.states[0] + _newton_step(found, scale), parameter, len(found.states))
        size = _size(better.image - better.states[0], scale)
    except GearplayError:
        size = residual
    return orbit_of(*((better, parameter, size) if size < residual else (found, parameter, residual)), scale)


def _newton_step(found: Return, scale: Floats) -> Floats:
    """Solve (M - 1) dx = x - P(x) in natural sizes; entries that neither change nor matter stay."""
    defect = (found.states[0] - found.image) / scale
    return np.asarray(np.linalg.lstsq(defect_slopes(found, scale), defect, rcond=1e-12)[0] * scale)


def _size(difference: Floats, scale: Floats) -> float:
    return float(np.max(np.abs(difference / scale))) if difference.size else 0.0


def orbit_of(found: Return, parameter: float, residual: float, scale: Floats) -> Orbit:
    """Return the orbit of a closed return map."""
    autonomous = math.isfinite(found.period)
    size = scale.size - int(autonomous)
    free = np.flatnonzero(~constants(found.matrix)[:size])
    matrix = found.matrix * scale[None, :] / scale[:, None]
    multipliers = np.linalg.eigvals(matrix[np.ix_(free, free)]).astype(np.complex128)
    if autonomous:
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
    order = np.argsort(-np.abs(multipliers), kind="stable")
    return Orbit(
        parameter, found.states, found.matrix, multipliers[order], residual, found.contacts, found.period
    )
