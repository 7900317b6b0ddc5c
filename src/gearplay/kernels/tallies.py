"""What contacts of a run leave behind: tallies, and the log of onsets and releases."""

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import FORCE, LOADED, OPEN, PENETRATION, System
from gearplay.kernels.run import (
    DEPTH_MAX,
    FORCE_MAX,
    LAST_DEPTH,
    LAST_FORCE,
    LAST_STEP,
    LOGGED,
    NOW_DEPTH,
    NOW_FORCE,
    ONSETS,
    SPEED_MAX,
    SPEED_SQUARES,
    SPEED_SUM,
    TIME,
    WEDGED,
    Run,
)
from gearplay.kernels.switches import is_overruled


@compiled_inline
def tally_step(system: System, run: Run, h: float) -> None:
    """Add one accepted step to the contact statistics."""
    for c in range(1, run.roster.acting[0] + 1):
        element = system.elements[run.roster.acting[c]]
        for k in range(element.contact, element.contact + element.contacts):
            tally_contact(system, run, k, h)


@compiled_inline
def peak_between(before: float, now: float, after: float, last: float, h: float) -> float:
    """Return the top of the parabola through three values, ``last`` and ``h`` apart, where the middle one is the highest.

    >>> peak_between(0.0, 3.0, 3.0, 1.0, 1.0), peak_between(3.0, 2.0, 1.0, 1.0, 1.0)
    (3.375, 2.0)
    """
    if now < before or now < after or before + after == 2.0 * now:
        return now
    rise, fall = (now - before) / last, (now - after) / h
    slope = (rise * h - fall * last) / (last + h)
    return now + 0.25 * slope * slope * (last + h) / (rise + fall)


@compiled_inline
def tally_contact(system: System, run: Run, k: int, h: float) -> None:
    """Add h [s] to contact k's time if it touches, and note its largest force and depth; or to that in which it should."""
    tally = run.tallies[k]
    if run.branch.modes[k] == OPEN:
        if run.loads.contacts[k, PENETRATION] > 0.0 and is_overruled(system, k, run.branch):
            tally[WEDGED] += h
        tally[LAST_STEP] = 0.0
        return
    tally[TIME] += h
    force, depth = run.loads.contacts[k, FORCE], run.loads.contacts[k, PENETRATION]
    highest, deepest, last = force, depth, tally[LAST_STEP]
    if last > 0.0:
        highest = max(highest, peak_between(tally[LAST_FORCE], tally[NOW_FORCE], force, last, h))
        deepest = max(deepest, peak_between(tally[LAST_DEPTH], tally[NOW_DEPTH], depth, last, h))
        tally[LAST_FORCE], tally[LAST_DEPTH] = tally[NOW_FORCE], tally[NOW_DEPTH]
    else:
        tally[LAST_FORCE] = run.loads_0.contacts[k, FORCE]
        tally[LAST_DEPTH] = run.loads_0.contacts[k, PENETRATION]
    tally[FORCE_MAX] = max(tally[FORCE_MAX], highest)
    tally[DEPTH_MAX] = max(tally[DEPTH_MAX], deepest)
    tally[LAST_STEP], tally[NOW_FORCE], tally[NOW_DEPTH] = h, force, depth


@compiled_inline
def tally_change(run: Run, t: float, k: int, mode_before: int, rate: float) -> None:
    """Log an onset or release of contact k at time t [s], at a rate of penetration [m/s], and count it."""
    now = run.branch.modes[k]
    if (mode_before == OPEN) == (now == OPEN):
        return
    if now == LOADED:
        tally = run.tallies[k]
        tally[ONSETS] += 1.0
        tally[SPEED_SUM] += rate
        tally[SPEED_SQUARES] += rate * rate
        tally[SPEED_MAX] = max(tally[SPEED_MAX], rate)
    row = run.log[run.counts[LOGGED]]
    row[0], row[1], row[2], row[3] = t, float(k), 1.0 if now == LOADED else 0.0, rate
    run.counts[LOGGED] += 1
