"""Statistics of the contacts of a run, and the log of onsets and releases.

Peaks are those of the motion itself: where one may lie inside a step and above the largest value so far, the step's interpolant
is searched for it.
"""

import math

from gearplay.integrate import dispatch
from gearplay.integrate.run import (
    DEPTH_MAX,
    FORCE_MAX,
    INSIDE,
    LAST_FORCE,
    LAST_STEP,
    LOGGED,
    ONSETS,
    SPEED_MAX,
    SPEED_SQUARES,
    SPEED_SUM,
    TIME,
    WEDGED,
    Run,
    T,
)
from gearplay.integrate.switches import is_overruled
from gearplay.integrate.trial_step import interpolate_element
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import FORCE, LOADED, OPEN, PENETRATION, System

PARTS = 4  # of a step, at whose ends it is evaluated first
ENDS = 4  # evaluations near an end that is the highest, each five times as close to it
PEAK_LOOKS = 20  # evaluations at most to narrow a peak down
NARROW = 1e-5  # of a step: the value at a smooth peak is then exact to about the square of that


@compiled_inline
def tally_step(system: System, run: Run, h: float) -> None:
    """Add one accepted step of h [s] to the contact statistics."""
    for c in range(1, run.active_set.acting[0] + 1):
        e = run.active_set.acting[c]
        element = system.elements[e]
        for k in range(element.contact, element.contact + element.contacts):
            tally_contact(system, run, e, k, h)


@compiled_inline
def tally_contact(system: System, run: Run, e: int, k: int, h: float) -> None:
    """Add a step of h [s] to contact k of element e: its time, largest force and depth where it is closed, else whether it is
    overruled.
    """
    tally, start, end = run.tallies[k], run.loads_0.contacts[k], run.loads.contacts[k]
    if run.branch.modes[k] == OPEN:
        if end[PENETRATION] > 0.0 and is_overruled(system, k, run.branch):
            tally[WEDGED] += h
        tally[LAST_STEP] = 0.0
        return
    tally[TIME] += h
    tally[FORCE_MAX] = max(tally[FORCE_MAX], start[FORCE], end[FORCE])
    tally[DEPTH_MAX] = max(tally[DEPTH_MAX], start[PENETRATION], end[PENETRATION])
    x = vertex(run, k, PENETRATION, h, tally[DEPTH_MAX], 0.0, 0.0)
    if x > 0.0 and may_peak(system, run, e, k, PENETRATION, h, x, tally[DEPTH_MAX]):
        tally[DEPTH_MAX] = max(tally[DEPTH_MAX], find_peak(system, run, e, k, PENETRATION, h))
    x = vertex(run, k, FORCE, h, tally[FORCE_MAX], tally[LAST_STEP], tally[LAST_FORCE])
    if x > 0.0 and may_peak(system, run, e, k, FORCE, h, x, tally[FORCE_MAX]):
        tally[FORCE_MAX] = max(tally[FORCE_MAX], find_peak(system, run, e, k, FORCE, h))
    tally[LAST_STEP], tally[LAST_FORCE] = h, start[FORCE]


@compiled_inline
def vertex(run: Run, k: int, column: int, h: float, largest: float, last: float, last_value: float) -> float:
    """Return about where in a step of h [s] a column of contact k may exceed ``largest``, 0 where it does not.

    Its second derivative is taken with a factor of four: from both ends and the stage inside, or with the value at the start of
    the step before, ``last`` [s] long, the larger of the two.
    """
    place = run.clock[INSIDE]
    if place == 0.0:
        return 0.5
    start, inside = run.loads_0.contacts[k, column], run.loads_inside.contacts[k, column]
    end = run.loads.contacts[k, column]
    slope = (end - start) / h
    curvature = 2.0 * ((end - inside) / (1.0 - place) - (inside - start) / place) / (h * h)
    if last > 0.0:
        other = 2.0 * (slope - (start - last_value) / last) / (h + last)
        if abs(other) > abs(curvature):
            curvature = other
    reach = abs(curvature) * h
    if max(start, inside, end) + 0.5 * reach * h <= largest or abs(slope) > 2.0 * reach:
        return 0.0  # it stays below, or it rises, or falls, all the way
    return min(max(0.5 - slope / curvature / h, 0.1), 0.9) if curvature < 0.0 else 0.5


@compiled_inline
def may_peak(
    system: System, run: Run, e: int, k: int, column: int, h: float, x: float, largest: float
) -> bool:
    """Return whether a column of contact k of element e may exceed ``largest`` inside a step of h [s], by its value at t + x h.

    The top of the parabola through it and both ends stands above them by at most what the value stands above the chord, over
    4 x (1 - x); three times that counts.
    """
    g_0, g_1 = run.loads_0.contacts[k, column], run.loads.contacts[k, column]
    value = value_inside(system, run, e, k, column, h, x)
    above = abs(value - (g_0 + x * (g_1 - g_0)))
    return bool(max(g_0, g_1, value) + 0.75 * above / (x * (1.0 - x)) > largest)


@compiled_inline
def value_inside(system: System, run: Run, e: int, k: int, column: int, h: float, x: float) -> float:
    """Return a column of contact k's row at t + x h on the step's interpolant; -inf where its geometry fails."""
    t = run.clock[T] + x * h
    interpolate_element(system, run, e, h, x)
    if dispatch.contact_kinematics(system, e, t, run.y_try, run.branch, run.loads_try) != 0:
        return -math.inf
    return float(run.loads_try.contacts[k, column])


@compiled_once
def find_peak(system: System, run: Run, e: int, k: int, column: int, h: float) -> float:
    """Return the largest value of a column of contact k of element e in a step of h [s], on its interpolant.

    The step is evaluated in equal parts; parabolas narrow the bracket about the best of their ends.
    """
    x, best = 0.0, run.loads_0.contacts[k, column]
    low, g_low, g_high, last = 0.0, best, -math.inf, best
    for part in range(1, PARTS + 1):
        at = part / PARTS
        value = run.loads.contacts[k, column]
        if part < PARTS:
            value = value_inside(system, run, e, k, column, h, at)
        if value > best:
            low, g_low, x, best = at - 1.0 / PARTS, last, at, value
        elif at - x < 1.5 / PARTS:
            g_high = value
        last = value
    high = min(x + 1.0 / PARTS, 1.0)
    if x == 0.0 or x == 1.0:  # a point inside that is higher than the end
        way = 1.0 / PARTS if x == 0.0 else -1.0 / PARTS
        edge, g_edge = x, best
        for _ in range(ENDS):
            way *= 0.2
            value = value_inside(system, run, e, k, column, h, edge + way)
            if value > g_edge:
                x, best = edge + way, value
                break
            if way > 0.0:
                high, g_high = edge + way, value
            else:
                low, g_low = edge + way, value
        if x == edge:
            return best
        if way > 0.0:
            low, g_low = edge, g_edge
        else:
            high, g_high = edge, g_edge
    for _ in range(PEAK_LOOKS):
        if high - low < NARROW:
            break
        # The vertex of the parabola through the bracket, or a point in its larger part.
        left, right = (best - g_low) * (high - x), (best - g_high) * (x - low)
        at = x
        if left + right > 0.0:
            at = x + 0.5 * (right * (low - x) + left * (high - x)) / (left + right)
        least = 0.01 * (high - low)
        if not low + least < at < high - least or abs(at - x) < 0.5 * NARROW:
            at = x + 0.4 * (high - x) if high - x > x - low else x - 0.4 * (x - low)
        value = value_inside(system, run, e, k, column, h, at)
        if value > best:
            if at > x:
                low, g_low = x, best
            else:
                high, g_high = x, best
            x, best = at, value
        elif at > x:
            high, g_high = at, value
        else:
            low, g_low = at, value
    return best


@compiled_inline
def tally_change(run: Run, t: float, k: int, mode_before: int, rate: float) -> None:
    """Log an onset or release of contact k at time t [s], at a rate of penetration [m/s]; count it where there are statistics."""
    now = run.branch.modes[k]
    if (mode_before == OPEN) == (now == OPEN):
        return
    if now == LOADED and run.tallies.shape[0] > 0:
        tally = run.tallies[k]
        tally[ONSETS] += 1.0
        tally[SPEED_SUM] += rate
        tally[SPEED_SQUARES] += rate * rate
        tally[SPEED_MAX] = max(tally[SPEED_MAX], rate)
    row = run.log[run.counts[LOGGED]]
    row[0], row[1], row[2], row[3] = t, float(k), 1.0 if now == LOADED else 0.0, rate
    run.counts[LOGGED] += 1
