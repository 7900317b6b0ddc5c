"""Branches of periodic orbits: maps with known bifurcations, an impacting oscillator, the primary resonance of the pair."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

import gearplay as gp
from gearplay.model.torsional_pair import BASE_RADIUS, HALF_BACKLASH
from gearplay.nonlinear.orbits.branches import (
    CLOSED,
    DOUBLING,
    FOLD,
    GRAZING,
    TORUS,
    Branch,
    Settings,
    doubled,
    follow_branch,
)
from gearplay.nonlinear.orbits.period_map import Image, StrobeMap
from gearplay.nonlinear.orbits.shooting import find_orbit
from gearplay.nonlinear.torsional import torsional_pair
from gearplay.vocabulary.errors import InputError, SimulationError

Floats = NDArray[np.float64]
NOTHING = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Plain:
    """A map given by its formula and the formula of its derivative."""

    step: Callable[[Floats, float], Floats]
    slope: Callable[[Floats, float], Floats]
    size: int = 1

    @property
    def scale(self) -> Floats:
        return np.ones(self.size)

    def __call__(self, state: Floats, parameter: float) -> Image:
        return Image(self.step(state, parameter), self.slope(state, parameter), NOTHING)


LOGISTIC = Plain(lambda x, r: r * x * (1.0 - x), lambda x, r: np.array([[r * (1.0 - 2.0 * x[0])]]))
DELAYED = Plain(
    lambda x, a: np.array([x[1], a * x[1] * (1.0 - x[0])]),
    lambda x, a: np.array([[0.0, 1.0], [-a * x[1], a * (1.0 - x[0])]]),
    2,
)


def kinds(branch: Branch) -> list[str]:
    return [special.kind for special in branch.special]


def test_doublings_and_the_fold_of_the_logistic_map(measured: Any) -> None:
    """Its fixed point doubles at 3, the orbit of order 2 at 1 + sqrt 6; orbits of order 3 come in a fold at 1 + sqrt 8."""
    settings = Settings(low=2.5, high=3.9, size=1.0, step=0.02, most=0.05)
    once = follow_branch(LOGISTIC, find_orbit(LOGISTIC, np.array([0.6]), 2.6), settings)
    assert kinds(once) == [DOUBLING]
    twice = follow_branch(LOGISTIC, doubled(LOGISTIC, find_orbit(LOGISTIC, np.array([0.67]), 3.1)), settings)
    assert kinds(twice) == [DOUBLING]
    settings = Settings(low=3.8, high=3.9, size=1.0, step=0.01, most=0.02)
    thrice = follow_branch(
        LOGISTIC, find_orbit(LOGISTIC, np.array([0.5146]), 3.84, order=3), settings, upwards=False
    )
    assert FOLD in kinds(thrice)
    errors = [
        once.special[0].orbit.parameter - 3.0,
        twice.special[0].orbit.parameter - (1.0 + math.sqrt(6.0)),
        next(s for s in thrice.special if s.kind == FOLD).orbit.parameter - (1.0 + math.sqrt(8.0)),
    ]
    measured("period doublings and fold of the logistic map", float(np.max(np.abs(errors))), "1e-8")
    assert np.max(np.abs(errors)) < 1e-8


def test_the_torus_of_the_delayed_logistic_map(measured: Any) -> None:
    """Its fixed point 1 - 1/a loses its stability at a = 2 by multipliers exp(+-i pi/3) (Neimark-Sacker)."""
    settings = Settings(low=1.5, high=2.3, size=1.0, step=0.05)
    branch = follow_branch(DELAYED, find_orbit(DELAYED, np.array([0.4, 0.4]), 1.6), settings)
    assert kinds(branch) == [TORUS]
    error = abs(branch.special[0].orbit.parameter - 2.0)
    measured("Neimark-Sacker point of the delayed logistic map", error, "1e-8")
    assert error < 1e-8
    assert np.allclose(np.abs(np.angle(branch.special[0].orbit.multipliers)), math.pi / 3.0, atol=1e-6)


def test_bounds_and_ends() -> None:
    start = find_orbit(LOGISTIC, np.array([0.6]), 2.6)
    with pytest.raises(InputError, match=r"start\.parameter = 2\.6: must lie between low and high, 3 and 4"):
        follow_branch(LOGISTIC, start, Settings(low=3.0, high=4.0, size=1.0))
    few = follow_branch(LOGISTIC, start, Settings(low=2.5, high=4.0, size=1.0, orbits=5))
    assert (len(few.orbits), few.ended) == (5, "the number of orbits is reached")
    with pytest.raises(SimulationError, match="only the orbit of half the order exists here"):
        doubled(LOGISTIC, find_orbit(LOGISTIC, np.array([0.6]), 2.9))


# The driven impact oscillator x'' + 2 zeta x' + x = cos(omega t) with a stop at x = d and restitution r.


@dataclass(frozen=True)
class ImpactMap:
    """Its map over a period in closed form between impacts, with its saltation at them; the parameter is d."""

    omega: float = 2.8
    zeta: float = 0.05
    restitution: float = 0.7

    @property
    def scale(self) -> Floats:
        return np.ones(2)

    @property
    def response(self) -> complex:
        return 1.0 / (1.0 - self.omega**2 + 2j * self.zeta * self.omega)

    def forced(self, t: float) -> Floats:
        turned = self.response * np.exp(1j * self.omega * t)
        return np.array([turned.real, (1j * self.omega * turned).real])

    def free(self, time: float) -> Floats:
        z, w = self.zeta, math.sqrt(1.0 - self.zeta**2)
        c, s = math.cos(w * time), math.sin(w * time)
        return math.exp(-z * time) * np.array([[c + z / w * s, s / w], [-s / w, c - z / w * s]])

    def __call__(self, state: Floats, parameter: float) -> Image:
        period, t, matrix, events = 2.0 * math.pi / self.omega, 0.0, np.eye(2), []
        while True:

            def x_at(time: float, t: float = t, state: Floats = state) -> Floats:
                return np.asarray(self.forced(time) + self.free(time - t) @ (state - self.forced(t)))

            grid = np.linspace(t, period, 400)[1:]
            above = [time for time in grid if x_at(time)[0] > parameter]
            if not above:  # perhaps between two times of the grid
                top, width = grid[int(np.argmax([x_at(time)[0] for time in grid]))], grid[1] - grid[0]
                ends = (max(top - width, t), min(top + width, period))
                peak = minimize_scalar(
                    lambda time: -x_at(time)[0], bounds=ends, method="bounded", options={"xatol": 1e-12}
                ).x
                above = [peak] if x_at(peak)[0] > parameter else []
            if not above:
                return Image(
                    x_at(period),
                    self.free(period - t) @ matrix,
                    np.array(events, dtype=np.int64).reshape(-1, 2),
                )
            high = above[0]
            low = max(high - (grid[1] - grid[0]), t + 1e-9)
            for _ in range(80):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if x_at(middle)[0] > parameter else (middle, high)
            before = x_at(high)
            after = np.array([parameter, -self.restitution * before[1]])

            def rates(s: Floats, time: float = high) -> Floats:
                return np.array([s[1], math.cos(self.omega * time) - s[0] - 2.0 * self.zeta * s[1]])

            reset = np.diag([1.0, -self.restitution])
            jump = (rates(after) - reset @ rates(before))[:, None] @ np.array([[1.0, 0.0]]) / before[1]
            matrix = (reset + jump) @ self.free(high - t) @ matrix
            events.append((0, 1))
            state, t = after, high


def impact_orbit(oscillator: ImpactMap, d: float) -> Floats:
    """Return the state at t = 0 of the orbit with one impact per period, in closed form (Shaw and Holmes 1983).

    With the impact at phase tau, x = forced + free (s - forced(tau)) must come back to x = d with velocity -v/r before impact:
    two linear equations in cos and sin of omega tau, and v from their squares.
    """
    r, period = oscillator.restitution, 2.0 * math.pi / oscillator.omega
    whole = oscillator.free(period)

    def pulled(v: float) -> Floats:
        """Return the forced state at the impact that velocity v after it needs: (1 - E) f = before - E after."""
        return np.asarray(
            np.linalg.solve(np.eye(2) - whole, np.array([d, -v / r]) - whole @ np.array([d, v]))
        )

    # forced = (a, omega b), a^2 + b^2 = |response|^2: quadratic in v
    p, q = pulled(0.0), pulled(1.0) - pulled(0.0)
    w = oscillator.omega
    a, b, c = (
        q[0] ** 2 + (q[1] / w) ** 2,
        2.0 * (p[0] * q[0] + p[1] * q[1] / w**2),
        p[0] ** 2 + (p[1] / w) ** 2,
    )
    c -= abs(oscillator.response) ** 2
    roots = np.roots([a, b, c])
    v = min(float(root.real) for root in roots if abs(root.imag) < 1e-12)  # leaves the stop downwards
    f = pulled(v)
    angle = (-math.atan2(f[1] / w, f[0]) - np.angle(oscillator.response)) % (2.0 * math.pi)  # omega tau
    tau = angle / w
    return np.asarray(
        oscillator.forced(period)
        + oscillator.free(period - tau) @ (np.array([d, v]) - oscillator.forced(tau))
    )


def test_the_orbit_of_the_impact_oscillator(measured: Any) -> None:
    oscillator, d = ImpactMap(), 0.05
    exact = impact_orbit(oscillator, d)
    assert np.allclose(oscillator(exact, d).state, exact, atol=1e-12)
    found = find_orbit(oscillator, exact + np.array([1e-3, -1e-3]), d)
    error = float(np.max(np.abs(found.states[0] - exact)))
    measured("period-1 orbit of the impact oscillator", error, "1e-8")
    assert error < 1e-8
    assert len(found.contacts) == 1


@pytest.mark.deep
def test_the_impact_oscillator_grazes_at_its_free_amplitude(measured: Any) -> None:
    """Without impacts the orbit is the free response; it grazes where d is its amplitude."""
    oscillator = ImpactMap()
    amplitude = abs(oscillator.response)
    low, high = 0.9 * amplitude, 1.1 * amplitude
    assert len(find_orbit(oscillator, oscillator.forced(0.0), high).contacts) == 0
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        try:
            free = len(find_orbit(oscillator, oscillator.forced(0.0), middle).contacts) == 0
        except SimulationError:  # orbits that impact slowly repel: none is near
            free = False
        low, high = (low, middle) if free else (middle, high)
    error = abs(high - amplitude)
    measured("grazing of the impact oscillator", error, "1e-8")
    assert error < 1e-8


# The primary resonance of the torsional pair, which softens as contact is lost.

ZETA, MEAN, FORCE = 0.05, 0.1, 0.05


@pytest.fixture(scope="module")
def family() -> StrobeMap:
    return StrobeMap(
        lambda f: torsional_pair(f, mean_force=MEAN, force=FORCE, damping_ratio=ZETA, tolerance=1e-11), 1.3
    )


@pytest.fixture(scope="module")
def resonance(family: StrobeMap) -> Branch:
    start = find_orbit(family, family.settle(family.start(1.3), 1.3, 200), 1.3)
    return follow_branch(family, start, Settings(low=0.4, high=1.35, size=0.1), upwards=False)


@pytest.mark.slow
def test_the_branch_passes_both_folds_and_both_grazings(resonance: Branch, measured: Any) -> None:
    """Contact is lost and regained where the linear response equals the static deflection: |1 - W^2 + 2 i zeta W| = F_a / F_m."""
    folds = [s.orbit for s in resonance.special if s.kind == FOLD]
    grazings = sorted(s.orbit.parameter for s in resonance.special if s.kind == GRAZING)
    assert len(folds) == len(grazings) == 2
    assert resonance.ended == "the parameter has left its bounds"
    for orbit in folds:
        assert np.min(np.abs(orbit.multipliers - 1.0)) < 1e-4
    # W^4 - (2 - 4 zeta^2) W^2 + 1 - (F_a / F_m)^2 = 0
    half = 1.0 - 2.0 * ZETA**2
    root = math.sqrt(half**2 - 1.0 + (FORCE / MEAN) ** 2)
    error = max(abs(grazings[0] - math.sqrt(half - root)), abs(grazings[1] - math.sqrt(half + root)))
    measured("grazing frequencies of the pair", error, "1e-6")
    assert error < 1e-6
    between = (resonance.parameters > folds[0].parameter) & ~resonance.stable
    assert between.sum() > 10


@pytest.mark.deep
def test_stable_branch__equals_the_sweeps(family: StrobeMap, resonance: Branch, measured: Any) -> None:
    """Carried up and down in frequency the motion jumps at the folds; elsewhere it settles on the branch."""
    folds = sorted(s.orbit.parameter for s in resonance.special if s.kind == FOLD)
    frequencies = np.linspace(0.42, 1.28, 44)
    worst, hysteresis = 0.0, {}
    for way in (frequencies, frequencies[::-1]):
        state = family.settle(family.start(float(way[0])), float(way[0]), 300)
        for frequency in map(float, way):
            if min(abs(frequency - fold) for fold in folds) < 0.01:
                continue  # next to a fold it settles for ever
            state = family.settle(state, frequency, 400)
            near = [o for o in resonance.orbits if o.stable]
            near.sort(
                key=lambda o, f=frequency, x=state: abs(o.parameter - f) + 1e3 * abs(o.states[0][0] - x[0])
            )
            orbit = find_orbit(family, near[0].states[0], frequency)
            if np.max(np.abs(orbit.states[0] - state) / family.scale) > 1e-3:
                orbit = find_orbit(family, state, frequency)
            worst = max(worst, float(np.max(np.abs(orbit.states[0] - state) / family.scale)))
            hysteresis.setdefault(frequency, []).append(state[0])
    jumps = [f for f, seen in hysteresis.items() if len(seen) == 2 and abs(seen[0] - seen[1]) > 1e-5]
    assert jumps
    assert folds[0] - 0.02 < min(jumps) < max(jumps) < folds[1] + 0.02
    measured("stable branches against sweeps up and down [scaled]", worst, "1e-6")
    assert worst < 1e-6


def harmonic_balance(frequency: float, guess: Floats, harmonics: int = 40) -> Floats:
    """Return x over a period, shape [sample], of the dimensionless pair by harmonic balance with samples in time (AFT)."""
    count = guess.size
    rates = 1j * frequency * np.arange(harmonics + 1)
    linear = rates**2 + 2.0 * ZETA * rates
    load = np.zeros(harmonics + 1, dtype=complex)
    load[0], load[1] = MEAN, 0.5 * FORCE

    def samples(c: NDArray[np.complex128]) -> Floats:
        return np.fft.irfft(np.append(c, np.zeros(count // 2 - harmonics)) * count, count)

    def restoring(x: Floats) -> Floats:
        return np.where(x > 1.0, x - 1.0, np.where(x < -1.0, x + 1.0, 0.0))

    c = np.fft.rfft(guess)[: harmonics + 1] / count
    for _ in range(60):
        x = samples(c)
        defect = linear * c + np.fft.rfft(restoring(x))[: harmonics + 1] / count - load
        if np.max(np.abs(defect)) < 1e-12:
            return x
        touching = np.fft.fft((np.abs(x) > 1.0).astype(float)) / count  # slope of the restoring force
        n = np.arange(-harmonics, harmonics + 1)
        slopes = touching[(n[:, None] - n[None, :]) % count]
        slopes += np.diag(np.concatenate([np.conj(linear[:0:-1]), linear]))
        step = np.linalg.solve(slopes, np.concatenate([np.conj(defect[:0:-1]), defect]))
        c = c - step[harmonics:]
    raise AssertionError("harmonic balance does not converge")


@pytest.mark.slow
def test_the_branch_is_that_of_harmonic_balance(family: StrobeMap, resonance: Branch, measured: Any) -> None:
    """Peak of x on stable and unstable parts against 40 harmonics of the dimensionless equation; 1 %."""
    worst = 0.0
    for orbit in resonance.orbits[::6]:
        flow, period = family.member(orbit.parameter).flow, family.member(orbit.parameter).period
        full = np.zeros(flow.size)
        full[family.free] = orbit.states[0]
        count = 1024
        course, thetas = flow.begin(full), []
        for at in range(count):
            if at:
                course.advance(period * at / count)
            thetas.append(course.state[family.free[0]])
        error = flow.case.meshes[0].transmission_error[0]
        psi = 2.0 * math.pi * np.arange(count) / count
        p = BASE_RADIUS * np.array(thetas) + error.amplitude * np.sin(psi + error.phase)
        x = p / HALF_BACKLASH + 1.0
        balanced = harmonic_balance(orbit.parameter, x)
        worst = max(worst, abs(np.ptp(balanced) / np.ptp(x) - 1.0))
    measured("stroke on the branch against harmonic balance", worst, "1e-2")
    assert worst < 1e-2


def test_a_closed_branch_is_followed_once() -> None:
    """Fixed points on the circle x^2 + p^2 = 1: two folds at p = -1 and 1, and the branch is back where it began."""
    circle = Plain(lambda x, p: x + 0.3 * (x * x + p * p - 1.0), lambda x, p: np.array([[1.0 + 0.6 * x[0]]]))
    start = find_orbit(circle, np.array([-1.0]), 0.1)
    branch = follow_branch(circle, start, Settings(low=-2.0, high=2.0, size=1.0))
    assert branch.ended == CLOSED
    folds = sorted(each.orbit.parameter for each in branch.special if each.kind == FOLD)
    assert folds == pytest.approx([-1.0, 1.0], abs=1e-8)
    radius = [orbit.states[0][0] ** 2 + orbit.parameter**2 for orbit in branch.orbits]
    assert radius == pytest.approx(np.ones(len(radius)), abs=1e-8)


def test_branch_of_order_2__is_not_continued_as_order_1() -> None:
    """Downwards the 2-cycle of the logistic map ends at r = 3; what repeats each time is no orbit of order 2."""
    start = find_orbit(LOGISTIC, np.array([0.8]), 3.2, order=2)
    branch = follow_branch(LOGISTIC, start, Settings(low=2.5, high=3.3, size=0.1), upwards=False)
    assert all(abs(orbit.states[0] - orbit.states[1]) > 1e-6 for orbit in branch.orbits)
    assert min(branch.parameters) == pytest.approx(3.0, abs=0.02)
    assert min(branch.parameters) > 3.0 - 1e-9


def test_map_invariant__is_constant_along_its_branch() -> None:
    """A second state that is only carried along, and shifts the first: its value picks the branch, nothing moves it."""
    carried = Plain(
        lambda x, r: np.array([r * x[0] * (1.0 - x[0]) + 0.01 * x[1], x[1]]),
        lambda x, r: np.array([[r * (1.0 - 2.0 * x[0]), 0.01], [0.0, 1.0]]),
        2,
    )
    start = find_orbit(carried, np.array([0.6, 0.3]), 2.6)
    assert len(start.multipliers) == 1
    branch = follow_branch(carried, start, Settings(low=2.5, high=3.4, size=1.0, step=0.02, most=0.05))
    assert [orbit.states[0][1] for orbit in branch.orbits] == pytest.approx(
        0.3 * np.ones(len(branch.orbits)), abs=1e-12
    )
    assert kinds(branch) == [DOUBLING]
    assert branch.parameters[-1] > 3.4


def test_message__has_the_range_of_the_field_and_an_early_end() -> None:
    pair = torsional_pair(0.7, force=0.05)
    path = "meshes.0.transmission_error.0.amplitude"
    found = gp.branch(pair, path, "2 um", "9 um", settle=300, orbits=3)
    low, high = found.parameters.min(), found.parameters.max()
    assert f"3 orbits from {low:.6g} to {high:.6g} m, 3 of them stable" in found.message
    assert found.message.endswith("; ends early: the number of orbits is reached")
    whole = gp.branch(pair, path, f"{0.99 * low} m", f"{1.01 * low} m", settle=300)
    assert "ends early" not in whole.message
