"""Static equilibrium by a line-search Newton method with the exact contact laws."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Force = Callable[[Floats], Floats | None]
"""Scaled forces [J] at scaled displacements, shape [coordinate]; None where a pair cannot mesh."""
Stiffness = Callable[[], Floats]
"""Scaled stiffness [J] where the forces were evaluated last, shape [coordinate, coordinate]."""

STEPS = 400
"""Most Newton steps."""
FARTHEST = 20.0
"""Longest step, in natural sizes."""
SOFTEST = 1e-13
"""Least stiffness of a direction, per the largest, that a step divides by."""
FLATTER = 0.3
"""Part of the slope along a step that may be left at its end."""
EARLY, LATE = 1e2, 1e12
"""First and longest time step along the flow, over the largest stiffness."""
RISE = 4.0
"""Factor by which forces may rise in a step along the flow that is longer than the first."""
STRIDE = 0.3
"""Longest step along the flow, in natural sizes."""
TRIALS = 40
"""Most evaluations along one step."""
BALANCED, NEARLY, ACCEPTED = 1e-12, 1e-9, 1e-7
"""Forces left over, per those that act: at which the search ends, at which it ends where they do not halve any more, at most."""
ROUNDING = 1e-11
"""Forces left over that are rounding of displacements, per the largest stiffness."""
PUSHES = 3
"""Most pushes off an equilibrium that is not stable."""
FALLING = -1e-9
"""Stiffness of a direction, per the largest, from which on down it gives way."""


class Balance(NamedTuple):
    """End of the search: scaled displacements, scaled residual forces, shape [coordinate], whether they balance."""

    at: Floats
    left: Floats
    balances: bool


def balance(force: Force, stiffness: Stiffness, start: Floats, acting: float) -> Balance | None:
    """Return displacements in which forces balance, reached downhill from ``start``; None where forces fail there.

    Contacts that do not pull have a potential without maxima but of curvature, once differentiable, its second derivative
    jumping where they open. Newton's steps with the stiffness of the present contacts, along which the work of the forces
    decides how far to go, reach its minimum across any gaps: a step across a gap ends where what it closes balances. A direction
    without a restoring force is left on the side of the work done, or by a push where none is done.

    Parameters
    ----------
    force, stiffness
        Scaled by natural sizes of the coordinates; evaluated in turn.
    start
        Scaled displacements, shape [coordinate].
    acting
        Size of the scaled forces that act [J].

    """
    at, left = start, force(start)
    if left is None:
        return None
    pushes, before, rounding = 0, np.inf, 0.0
    for _ in range(STEPS):
        sizes, ways = _principal(stiffness())
        size, stiffest = _largest(left), _largest(sizes)
        rounding = ROUNDING * stiffest
        if size <= BALANCED * acting or (size <= max(NEARLY * acting, rounding) and size > 0.5 * before):
            if pushes == PUSHES or not sizes.size or sizes[0] >= FALLING * stiffest:
                break
            pushes += 1
            step = (0.1 if pushes % 2 else -0.1) * ways[:, 0]
            now = force(at + step)
            if now is None:
                break
            at, left, before = at + step, now, np.inf
            continue
        before = size
        stiff = np.maximum(np.abs(sizes), SOFTEST * max(stiffest, acting))
        step = ways @ ((ways.T @ left) / stiff)
        longest = _largest(step)
        if longest > FARTHEST:
            step *= FARTHEST / longest
        found = _along(force, at, left, step)
        if found is None:
            break
        at, left = found
    if _largest(left) > max(ACCEPTED * acting, rounding):
        at, left = _downstream(force, stiffness, at, left, max(NEARLY * acting, rounding))
    return Balance(at, left, _largest(left) <= max(ACCEPTED * acting, rounding))


def _downstream(
    force: Force, stiffness: Stiffness, at: Floats, left: Floats, enough: float
) -> tuple[Floats, Floats]:
    """Return where the flow dx/dt = forces leads from ``at``, and the forces left over there.

    Forces of teeth that deviate have no potential: a stable equilibrium need not be the minimum of a work. Implicit Euler steps
    that lengthen as the forces fall (C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508) end as Newton's.
    """
    force(at)
    matrix, size = stiffness(), float(np.linalg.norm(left))
    span = EARLY / max(_largest(matrix), enough)
    for _ in range(STEPS):
        step: Floats = np.asarray(np.linalg.solve(np.eye(at.size) / span + matrix, left), dtype=np.float64)
        step *= min(1.0, STRIDE / max(_largest(step), STRIDE))
        now = force(at + step)
        rises = now is not None and float(np.linalg.norm(now)) > RISE * max(size, 10.0 * enough)
        if now is None or (rises and span * _largest(matrix) > EARLY):
            span *= 0.1
            continue
        at, left, before, size = at + step, now, size, float(np.linalg.norm(now))
        if _largest(left) <= enough or size == 0.0:
            break
        matrix = stiffness()
        stiffest = max(_largest(matrix), enough)
        span = min(max(span * min(max(1.5 * before / size, 0.1), 10.0), 0.01 / stiffest), LATE / stiffest)
    return at, left


def _largest(values: Floats) -> float:
    return float(np.abs(values).max(initial=0.0))


def _principal(stiffness: Floats) -> tuple[Floats, Floats]:
    """Return stiffnesses [J], rising, and their directions, shape [coordinate, direction]."""
    sizes, ways = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    return sizes, ways


def _along(force: Force, at: Floats, left: Floats, step: Floats) -> tuple[Floats, Floats] | None:
    """Return where the work along a step has its maximum, nearly, and the forces there; None where no progress is left."""
    slope = float(left @ step)
    low, high = 0.0, np.inf
    slope_low, slope_high = slope, 0.0
    part, best = 1.0, None
    for _ in range(TRIALS):
        now = force(at + part * step)
        if now is None:
            high, slope_high = part, np.nan
            part = 0.5 * (low + part)
            continue
        here = float(now @ step)
        if abs(here) <= FLATTER * slope:
            return at + part * step, now
        if here > 0.0:
            low, slope_low, best = part, here, (at + part * step, now)
            if not np.isfinite(high):
                if part >= 4.0**6:
                    return best
                part *= 4.0
                continue
        else:
            high, slope_high = part, here
        if high - low <= 1e-12 * high:
            break
        part = 0.5 * (low + high)
        if np.isfinite(slope_high):  # the zero of the chord, not nearer to an end than a tenth
            chord = low + (high - low) * slope_low / (slope_low - slope_high)
            part = min(max(chord, low + 0.1 * (high - low)), high - 0.1 * (high - low))
    return best
