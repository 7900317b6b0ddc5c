"""Finding the first switch inside a step, on its interpolant, and taking the step again so that it ends there."""

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import (
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    RAMP_SMOOTH,
    RATE,
    System,
    contact_count,
)
from gearplay.kernels.motion import press_mesh, press_sleeve
from gearplay.kernels.roster import fly_listed
from gearplay.kernels.run_state import CALLS, Motion, T
from gearplay.kernels.runge_kutta import STAGES, interpolate, step
from gearplay.kernels.switches import contact_of_switch, switch_value, switch_values

Floats = NDArray[np.float64]


@compiled_inline
def attempt(system: System, motion: Motion, h: float) -> int:
    """Try a step h [s] of the active rotors into y_new; look at the watched contacts at its end; return 0, or 1
    where a pair cannot mesh.
    """
    motion.counts[CALLS] += STAGES - 1
    t = motion.clock[T]
    failed = step(
        system,
        motion.roster,
        t,
        h,
        motion.y,
        motion.stages,
        motion.modes,
        motion.latch,
        motion.y_new,
        motion.contacts,
        motion.force,
        motion.out,
    )
    return failed if failed != 0 else watch(system, motion, t + h, motion.y_new, motion.contacts)


@compiled_inline
def watch(system: System, motion: Motion, t: float, y: Floats, contacts: Floats) -> int:
    """Fill the rows of ``contacts`` of watched elements at t [s]; return 1 where a pair cannot mesh."""
    roster = motion.roster
    fly_listed(system, roster, roster.near, t, y)
    for c in range(1, roster.watched_sleeves[0] + 1):
        k = roster.watched_sleeves[c]
        press_sleeve(system, k, y, t, motion.modes, motion.latch, contacts, motion.out)
    for c in range(1, roster.watched_meshes[0] + 1):
        if press_mesh(system, roster.watched_meshes[c], y, t, motion.modes, contacts, motion.out) != 0:
            return 1
    return 0


@compiled_inline
def look(system: System, motion: Motion, h: float, x: float, k: int) -> bool:
    """Evaluate switch k and its contact on the step's interpolant at t + x h; False where a pair cannot mesh."""
    t = motion.clock[T] + x * h
    y, contacts = motion.y_try, motion.contacts_try
    interpolate(motion.roster, x, h, motion.y, motion.y_new, motion.stages, y)
    fly_listed(system, motion.roster, motion.roster.near, t, y)
    motion.counts[CALLS] += 1
    n_s, contact = system.sleeves.size, contact_of_switch(system, k)
    if 0 <= contact < n_s:
        press_sleeve(system, contact, y, t, motion.modes, motion.latch, contacts, motion.out)
    elif contact >= 0:
        mesh = (contact - n_s) // 2
        if press_mesh(system, mesh, y, t, motion.modes, contacts, motion.out) != 0:
            return False
    motion.g_try[k] = switch_value(system, k, t, y, motion.modes, contacts)
    return True


@compiled_inline
def allowance(motion: Motion, k: int, n_c: int) -> float:
    """Return how far [m] beyond zero a step may end behind penetration switch k: a tenth of its allowed error."""
    return 0.1 * motion.scale[0] if k < n_c else 0.0


@compiled
def locate_root(system: System, motion: Motion, h: float, k: int, high: float, g_high: float) -> float:
    """Return the end x of the smallest bracket in (0, high] on which switch k turns positive (Illinois)."""
    low, g_low = 0.0, min(motion.g_0[k], 0.0)
    side = 0
    width = max(1e-14, 4e-16 * abs(motion.clock[T]) / h)
    close = 0.1 * allowance(motion, k, contact_count(system))
    for _ in range(80):
        if high - low <= width or 0.0 <= g_high <= close:
            break
        x = (low * g_high - high * g_low) / (g_high - g_low) if g_high > g_low else 0.5 * (low + high)
        if not (low + 0.25 * width < x < high - 0.25 * width):
            # The secant sits on an end: step off it by just more than the wanted width.
            x = low + 0.75 * width if x - low < high - x else high - 0.75 * width
        if not look(system, motion, h, x, k):
            return x
        g = motion.g_try[k]
        if g > 0.0:
            high, g_high = x, g
            if side == 1:
                g_low *= 0.5
            side = 1
        else:
            low, g_low = x, g
            if side == -1:
                g_high *= 0.5
            side = -1
    return high


@compiled
def locate_peak(system: System, motion: Motion, h: float, k: int) -> float:
    """Return the x in (0, 1) where penetration switch k peaks, by bisection on its rate, or 1 if it stays negative.

    Called only when the rate changes sign inside the step while both ends are negative: the grazing touch that
    looking at step ends alone would skip. Stops as soon as a positive value is seen.
    """
    sign = 1.0 if motion.modes[k] == OPEN else -1.0
    low, high = 0.0, 1.0
    reach = abs(motion.contacts_0[k, RATE]) + abs(motion.contacts[k, RATE])
    for _ in range(60):
        x = 0.5 * (low + high)
        if not look(system, motion, h, x, k):
            return 1.0
        if motion.g_try[k] > 0.0:
            return x
        if motion.g_try[k] + reach * (high - low) * h < 0.0:
            return 1.0
        if sign * motion.contacts_try[k, RATE] > 0.0:
            low = x
        else:
            high = x
        if high - low < 1e-10:
            break
    return 1.0


@compiled
def may_dip(system: System, motion: Motion, k: int) -> bool:
    """Return whether flank contact k, pressing at both ends of the step, may have let go in between.

    On the smooth ramp F / p = K - (C / d) u (3 - 2u) |dp/dt|, u = p / d, whose one minimum lies at u = 3/4.
    """
    n_s, n_m = system.sleeves.size, system.meshes.size
    mesh = system.meshes[(k - n_s) // 2]
    start, end = motion.contacts_0, motion.contacts
    fastest = max(-start[k, RATE], -end[k, RATE])
    damping = mesh.C_m * mesh.inv_depth * fastest
    if damping <= 0.0 or mesh.ramp != RAMP_SMOOTH or motion.modes[2 * n_m + k] == 1:
        return False
    u_0, u_1 = start[k, PENETRATION] * mesh.inv_depth, end[k, PENETRATION] * mesh.inv_depth
    deepest, slightest = min(max(u_0, u_1), 0.75), max(min(u_0, u_1), 0.0)
    if slightest > 0.75:
        deepest = slightest
    # The least of both ends' stiffnesses, with a half to spare for what changes between them.
    least = min(
        start[k, MARGIN] - mesh.C_m * mesh.inv_depth * max(u_0 * (3.0 - 2.0 * u_0), 0.0) * start[k, RATE],
        end[k, MARGIN] - mesh.C_m * mesh.inv_depth * max(u_1 * (3.0 - 2.0 * u_1), 0.0) * end[k, RATE],
    )
    return bool(0.5 * least < damping * deepest * (3.0 - 2.0 * deepest))


@compiled
def locate_dip(system: System, motion: Motion, h: float, s: int, place: float) -> float:
    """Return an x in (0, place) where margin switch s is positive, or 1 without one (golden section; one hump)."""
    low, high = 0.0, place
    left, right = low + 0.381966 * place, low + 0.618034 * place
    if not look(system, motion, h, left, s):
        return 1.0
    g_left = motion.g_try[s]
    if g_left > 0.0:
        return left
    if not look(system, motion, h, right, s):
        return 1.0
    g_right = motion.g_try[s]
    for _ in range(24):
        if g_right > 0.0:
            return right
        if g_left > 0.0:
            return left
        if g_left > g_right:
            high, right, g_right = right, left, g_left
            left = low + high - right
            if not look(system, motion, h, left, s):
                return 1.0
            g_left = motion.g_try[s]
        else:
            low, left, g_left = left, right, g_right
            right = low + high - left
            if not look(system, motion, h, right, s):
                return 1.0
            g_right = motion.g_try[s]
    return 1.0


@compiled_inline
def first_switch(system: System, motion: Motion, h: float) -> tuple[int, float]:
    """Return the first switch of the step just taken and its place x in (0, 1]; (-1, 1) without one."""
    n_c, n_s = contact_count(system), system.sleeves.size
    first, place = -1, 1.0
    roster = motion.roster
    for c in range(1, roster.switches[0] + 1):
        k = roster.switches[c]
        high, g_high = place, motion.g_1[k]
        if first >= 0 and motion.g_1[k] > 0.0:
            if not look(system, motion, h, place, k):
                continue
            g_high = motion.g_try[k]
        if g_high > 0.0:
            # A switch that was never on its own side changes over at the end.
            x = high if motion.g_0[k] > 0.0 else locate_root(system, motion, h, k, high, g_high)
            if first < 0 or x < place:
                first, place = k, x
        elif k < n_c and motion.g_0[k] < 0.0:
            sign = 1.0 if motion.modes[k] == OPEN else -1.0
            if sign * motion.contacts_0[k, RATE] > 0.0 and sign * motion.contacts[k, RATE] < 0.0:
                peak = locate_peak(system, motion, h, k)
                if peak < place:
                    look(system, motion, h, peak, k)
                    first, place = k, locate_root(system, motion, h, k, peak, motion.g_try[k])
    for c in range(1, roster.meshes[0] + 1):
        for k in range(n_s + 2 * roster.meshes[c], n_s + 2 * roster.meshes[c] + 2):
            s = n_c + k
            if (
                motion.modes[k] == LOADED
                and s != first
                and motion.g_0[s] < 0.0
                and may_dip(system, motion, k)
            ):
                dip = locate_dip(system, motion, h, s, place)
                if dip < place:
                    look(system, motion, h, dip, s)
                    first, place = s, locate_root(system, motion, h, s, dip, motion.g_try[s])
    return first, place


@compiled
def retake(system: System, motion: Motion, h: float, k: int, x: float) -> float:
    """Take the step again so that it ends just past switch k; return its length [s], or -1 on failure."""
    n_c = contact_count(system)
    ahead = allowance(motion, k, n_c)
    slope = 0.0  # of g, for the first try and its corrections
    if k < n_c and motion.g_try[k] != motion.g_0[k]:
        slope = abs(motion.contacts_try[k, RATE])
    elif x < 1.0:
        slope = (motion.g_1[k] - motion.g_try[k]) / ((1.0 - x) * h)
    short = x * h
    if slope > 0.0:
        short += min(ahead / slope, 0.01 * h)
    nudge = max(1e-15 * h, 4e-16 * abs(motion.clock[T]))
    for _ in range(8):
        if attempt(system, motion, short) != 0:
            return -1.0
        switch_values(
            system,
            motion.roster,
            motion.clock[T] + short,
            motion.y_new,
            motion.modes,
            motion.contacts,
            motion.g_1,
        )
        if motion.g_1[k] >= 0.0 or motion.g_0[k] > 0.0:
            break
        # The interpolant was a little early: go on by what the slope asks for, and a little more each time.
        if slope > 0.0:
            short += min((ahead + 1.5 * abs(motion.g_1[k])) / slope, 0.01 * h)
        short += nudge
        nudge *= 8.0
    return short
