"""Branches of periodic orbits over a parameter: pseudo-arclength continuation through folds.

Unknowns are the state at the section and the parameter, in natural sizes. A step goes along the tangent of the branch and
Newton's method brings it back, at right angles to the tangent (H. B. Keller, in: Applications of Bifurcation Theory, Academic
Press 1977, 359). Test functions that change sign between two orbits are brought to zero by shortening the step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.orbits.period_map import PeriodMap
from gearplay.nonlinear.orbits.shooting import (
    Orbit,
    Return,
    after,
    defect_slopes,
    find_orbit,
    orbit_of,
    order_of,
)
from gearplay.solver.integration import OutOfTimeError
from gearplay.vocabulary.errors import GearplayError, InputError, SimulationError
from gearplay.vocabulary.progress import Tick

Floats = NDArray[np.float64]
CLOSE = 1e-9  # residual in natural sizes
NUDGE = 1e-6  # step of the derivative by the parameter, in its natural size
MOST_CORRECTIONS = 8
AMPLITUDES = (0.01, 0.03, 0.1, 0.3, 1.0)  # tried for an orbit of twice the order, in natural sizes
CLOSED = "it closes on itself"
LEFT = "the parameter has left its bounds"
OUT_OF_TIME = "run.max_wall_time, the limit of the whole request, was reached"
FEWEST_OF_LOOP = 8
FOLD, DOUBLING, TORUS, GRAZING = "fold", "period doubling", "Neimark-Sacker", "grazing"


@dataclass(frozen=True)
class Special:
    """A special point of a branch: its kind, its position on the branch, and the orbit."""

    kind: str
    place: int  # the orbit of the branch after which it lies
    orbit: Orbit


@dataclass(frozen=True)
class Branch:
    """Periodic orbits in the order of the branch, its special points, and the reason for its end."""

    orbits: tuple[Orbit, ...]
    special: tuple[Special, ...] = ()
    ended: str = ""
    order: int = 1

    @property
    def parameters(self) -> Floats:
        """The parameter of each orbit, shape [orbit]."""
        return np.array([orbit.parameter for orbit in self.orbits])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each orbit is stable, shape [orbit]."""
        return np.array([orbit.stable for orbit in self.orbits])


@dataclass(frozen=True)
class Settings:
    """Settings of continuation. Steps are in natural sizes of state and parameter together.

    ``low`` and ``high`` bound the parameter, ``size`` is its natural size.
    """

    low: float
    high: float
    size: float
    step: float = 0.05
    least: float = 1e-6
    most: float = 0.2
    orbits: int = 500


class _Follower:
    def __init__(self, period_map: PeriodMap, order: int, settings: Settings) -> None:
        self.map, self.order, self.settings = period_map, order, settings
        self.scale = np.append(period_map.scale, settings.size)

    def evaluate(self, unknowns: Floats) -> tuple[Return, Floats, Floats]:
        """Return the map at scaled unknowns, its defect and its derivative, both in natural sizes, shape [state, state + 1]."""
        state, parameter = unknowns[:-1] * self.scale[:-1], float(unknowns[-1] * self.scale[-1])
        found = after(self.map, state, parameter, self.order)
        nudge = NUDGE * self.settings.size
        ends = [after(self.map, state, parameter + side * nudge, self.order).image for side in (1.0, -1.0)]
        by_parameter = (ends[0] - ends[1]) / (2.0 * nudge)
        sizes = self.scale[:-1]
        slopes = np.empty((sizes.size, sizes.size + 1))
        slopes[:, :-1] = defect_slopes(found, sizes)
        slopes[:, -1] = by_parameter * self.scale[-1] / sizes
        return found, (found.image - state) / sizes, slopes

    def tangent(self, slopes: Floats, before: Floats) -> Floats:
        """Return the unit tangent of the branch, in the sense of ``before``."""
        direction = np.linalg.svd(slopes)[2][-1]
        return np.asarray(direction if direction @ before >= 0.0 else -direction)

    def correct(self, guess: Floats, tangent: Floats) -> tuple[Floats, Return, Floats, int]:
        """Bring a guess back to the branch at right angles to the tangent; return unknowns, map, slopes and Newton steps.

        Raises `SimulationError` where that does not converge.
        """
        unknowns = guess.copy()
        last = math.inf
        for count in range(MOST_CORRECTIONS):
            found, defect, slopes = self.evaluate(unknowns)
            size = float(np.max(np.abs(defect)))
            if size <= CLOSE:
                return unknowns, found, slopes, count
            if size > 2.0 * last:
                break
            last = size
            whole = np.vstack([slopes, tangent])
            unknowns = unknowns - np.linalg.lstsq(whole, np.append(defect, 0.0), rcond=1e-13)[0]
        raise SimulationError("branch: the correction does not converge. Shorten the step.")

    def orbit(self, unknowns: Floats, found: Return) -> Orbit:
        """Return the orbit at unknowns on the branch."""
        defect = (found.image - found.states[0]) / self.scale[:-1]
        parameter = float(unknowns[-1] * self.scale[-1])
        return orbit_of(found, parameter, float(np.max(np.abs(defect))), self.scale[:-1])


@dataclass(frozen=True)
class _Place:
    """A point of the branch: scaled unknowns, unit tangent, orbit."""

    unknowns: Floats
    tangent: Floats
    orbit: Orbit


def follow_branch(
    period_map: PeriodMap,
    start: Orbit,
    settings: Settings,
    *,
    upwards: bool = True,
    progress: Tick | None = None,
) -> Branch:
    """Return the branch of periodic orbits through ``start``, stable and unstable ones, until the parameter leaves its bounds.

    Steps grow where Newton's method converges at once and shrink where it does not. Special points are located on the way.

    Raises `InputError` where the start lies outside the bounds.
    """
    if not settings.low <= start.parameter <= settings.high:
        rule = f"must lie between low and high, {settings.low:g} and {settings.high:g}"
        raise InputError.of("start.parameter", start.parameter, rule, "Widen the bounds")
    follower = _Follower(period_map, start.order, settings)
    unknowns = np.append(start.states[0], start.parameter) / follower.scale
    try:
        found, _, slopes = follower.evaluate(unknowns)
    except OutOfTimeError:
        return Branch((start,), (), OUT_OF_TIME, start.order)
    ahead = np.zeros(unknowns.size)
    ahead[-1] = 1.0 if upwards else -1.0
    here = _Place(unknowns, follower.tangent(slopes, ahead), follower.orbit(unknowns, found))
    orbits, special, step, ended = [here.orbit], list[Special](), settings.step, ""
    while len(orbits) < settings.orbits:
        try:
            there, count = _advance(follower, here, step)
        except OutOfTimeError:
            ended = OUT_OF_TIME
            break
        except GearplayError as error:
            step *= 0.5
            if step < settings.least:
                ended = f"the branch could not be followed further ({str(error).splitlines()[0]})"
                break
            continue
        bend = float(here.tangent @ there.tangent)
        if bend < 0.8 and step > 16.0 * settings.least:  # a sharp turn: shorten the step
            step *= 0.5
            continue
        if order_of(there.orbit.states, follower.scale[:-1]) < there.orbit.order:
            ended = "it has met a branch of lower order"
            break
        try:
            between = _between(follower, here, there, step)
        except OutOfTimeError:
            ended = OUT_OF_TIME
            break
        special += [Special(kind, len(orbits) - 1, located) for kind, located in between]
        here = there
        orbits.append(here.orbit)
        if progress is not None:
            progress(float(len(orbits)), float(settings.orbits))
        if len(orbits) > FEWEST_OF_LOOP and _passes(orbits[-2], here.orbit, start, follower.scale):
            ended = CLOSED
            break
        if not settings.low <= here.orbit.parameter <= settings.high:
            ended = LEFT
            break
        step = min(settings.most, step * (1.6 if count <= 2 and bend > 0.95 else 0.7 if count > 4 else 1.0))
    return Branch(tuple(orbits), tuple(special), ended or "the number of orbits is reached", start.order)


def _passes(one: Orbit, other: Orbit, start: Orbit, scale: Floats) -> bool:
    """Return whether the line between two neighbours of a branch passes an orbit, at any of its sections."""
    a, b = (np.append(orbit.states[0], orbit.parameter) / scale for orbit in (one, other))
    for state in start.states:
        goal = np.append(state, start.parameter) / scale
        share = float(np.clip((goal - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0))
        if np.max(np.abs(goal - a - share * (b - a))) < 0.1 * np.max(np.abs(b - a)):
            return True
    return False


def _advance(follower: _Follower, here: _Place, step: float) -> tuple[_Place, int]:
    unknowns, found, slopes, count = follower.correct(here.unknowns + step * here.tangent, here.tangent)
    tangent = follower.tangent(slopes, here.tangent)
    return _Place(unknowns, tangent, follower.orbit(unknowns, found)), count


def _tests(place: _Place) -> dict[str, float]:
    """Return the test functions at a point: each crosses zero at a special point of its kind."""
    multipliers = place.orbit.multipliers
    doubling = float(np.real(np.prod(multipliers + 1.0)))
    pairs = [multipliers[i] * multipliers[j] - 1.0 for i in range(multipliers.size) for j in range(i)]
    torus = float(np.real(np.prod(pairs))) if pairs else 1.0
    return {FOLD: float(place.tangent[-1]), DOUBLING: doubling, TORUS: torus}


def _between(follower: _Follower, here: _Place, there: _Place, step: float) -> list[tuple[str, Orbit]]:
    """Locate the special points between two points of the branch a step apart."""
    found = []
    before, after_ = _tests(here), _tests(there)
    for kind in (FOLD, DOUBLING, TORUS):
        if before[kind] * after_[kind] < 0.0:
            place = _locate(follower, here, there, step, kind)
            if kind != TORUS or _is_torus(place.orbit):
                found.append((kind, place.orbit))
    if not _same_contacts(here.orbit, there.orbit):
        place = _bisect(follower, here, step, lambda p: _same_contacts(p.orbit, here.orbit))
        found.append((GRAZING, place.orbit))
    return found


def _is_torus(orbit: Orbit) -> bool:
    """Return whether a product of two multipliers is 1 because a complex pair crosses the unit circle."""
    complex_ones = orbit.multipliers[np.abs(orbit.multipliers.imag) > 1e-9]
    return bool(np.any(np.abs(np.abs(complex_ones) - 1.0) < 1e-3))


def _same_contacts(one: Orbit, other: Orbit) -> bool:
    """Return whether two orbits have the same contact changes, from any section on."""
    a, b = ([tuple(row) for row in orbit.contacts.tolist()] for orbit in (one, other))
    return len(a) == len(b) and sorted(a) == sorted(b)


def _locate(follower: _Follower, here: _Place, there: _Place, step: float, kind: str) -> _Place:
    """Return the place where the test function of a kind is 0, by regula falsi (Illinois) on the length of the step."""
    low, high, g_low, g_high = 0.0, step, _tests(here)[kind], _tests(there)[kind]
    best, side = there, 0
    for _ in range(40):
        if high - low < 1e-12 * max(step, 1e-3) or min(abs(g_low), abs(g_high)) < 1e-12:
            break
        middle = (low * g_high - high * g_low) / (g_high - g_low)
        try:
            best, _ = _advance(follower, here, middle)
        except OutOfTimeError:
            raise
        except GearplayError:
            break
        g = _tests(best)[kind]
        if g * g_high > 0.0:
            high, g_high = middle, g
            g_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, g_low = middle, g
            g_high *= 0.5 if side == -1 else 1.0
            side = -1
        if abs(g) < 1e-10:
            break
    return best


def _bisect(follower: _Follower, here: _Place, step: float, keeps: Callable[[_Place], bool]) -> _Place:
    """Return the last point along a step for which ``keeps`` holds, by bisection from ``here``."""
    low, high, best = 0.0, step, here
    while high - low > 1e-9 * max(1.0, step):
        middle = 0.5 * (low + high)
        try:
            place, _ = _advance(follower, here, middle)
        except OutOfTimeError:
            raise
        except GearplayError:
            high = middle
            continue
        if keeps(place):
            low, best = middle, place
        else:
            high = middle
    return best


def doubled(period_map: PeriodMap, orbit: Orbit) -> Orbit:
    """Return an orbit of twice the order near a period doubling: along the multiplier's direction that passes -1.

    Raises `SimulationError` where none is found at this side of the doubling.
    """
    scale = period_map.scale
    values, vectors = np.linalg.eig(orbit.matrix * scale[None, :] / scale[:, None])
    direction = np.real(vectors[:, int(np.argmin(np.abs(values + 1.0)))])
    for amplitude in AMPLITUDES:
        guess = orbit.states[0] + amplitude * scale * direction / np.linalg.norm(direction)
        try:
            return find_orbit(period_map, guess, orbit.parameter, order=2 * orbit.order)
        except OutOfTimeError:
            raise
        except SimulationError:
            continue
    raise SimulationError(
        "branch: only the orbit of half the order exists here. Begin on the other side of the period doubling."
    )
