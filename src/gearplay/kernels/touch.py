"""The next touch of rotors in flight: when it comes, and what it changes."""

import math

from gearplay.kernels.advancement import FAILS, TOUCHES, mesh_span, sleeve_span
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import OPEN, PENETRATION, RATE, System
from gearplay.kernels.mesh import follow_orbit
from gearplay.kernels.motion import press_mesh, press_sleeve
from gearplay.kernels.recording import tally_change
from gearplay.kernels.roster import members, state_of
from gearplay.kernels.run_state import CALLS, CANNOT_MESH, CHATTER, DONE, EVENTS, NOT_FINITE, T_END, Motion
from gearplay.kernels.switches import switch_mode

BURST_LOOKS = 200_000  # at gaps within one flight: beyond it a contact hovers without touching


@compiled_inline
def something_is_due(motion: Motion, limit: float) -> bool:
    """Return whether a dormant element or a flight must be looked at before ``limit`` [s]."""
    first = limit
    for e in range(motion.roster.due.size):
        first = min(first, motion.roster.due[e])
    return bool(first < limit)


@compiled
def next_touch(system: System, motion: Motion, limit: float) -> tuple[int, float, int]:
    """Return the first dormant element that touches before ``limit`` [s], or a flight whose closed form ends there.

    Returns (its place in ``due``; time; status); the length of ``due`` and ``limit`` without one.
    """
    roster = motion.roster
    n_s, nothing = system.sleeves.size, roster.due.size
    elements = n_s + system.meshes.size
    for _ in range(BURST_LOOKS):
        first, t = nothing, limit
        for e in range(roster.due.size):
            if roster.due[e] < t:
                first, t = e, roster.due[e]
        if first >= elements:
            return first, t, DONE
        motion.counts[CALLS] += 1
        a, b, c = members(system, first)
        state_of(system, roster, a, t, motion.y, motion.y_try)
        if b >= 0:
            state_of(system, roster, b, t, motion.y, motion.y_try)
        if c >= 0:
            state_of(system, roster, c, t, motion.y, motion.y_try)
        # Far enough ahead to be of use whatever comes next, near enough to end with the run.
        longest = motion.clock[T_END] - t + 1e-9
        if first < n_s:
            doing, span = sleeve_span(system, first, t, motion.y_try, longest, motion.out)
        else:
            follow_orbit(system, first - n_s, motion.y_try)
            doing, span = mesh_span(system, first - n_s, t, motion.y_try, longest, motion.out)
        if doing == FAILS:
            return first, t, CANNOT_MESH
        if doing == TOUCHES:
            return first, t, DONE
        if not math.isfinite(span):
            return first, t, NOT_FINITE
        roster.due[first] = t + max(span, 4e-16 * abs(t) + 1e-18)
    return nothing, limit, CHATTER


@compiled
def touch_down(system: System, motion: Motion, e: int, t: float) -> int:
    """Change the modes of dormant element e that touches at t [s]; return 1 where it cannot mesh."""
    n_s = system.sleeves.size
    y, contacts, modes, out = motion.y_try, motion.contacts, motion.modes, motion.out
    for i in members(system, e):
        if i >= 0:
            state_of(system, motion.roster, i, t, motion.y, y)
    first, count = (e, 1) if e < n_s else (n_s + 2 * (e - n_s), 2)
    if e < n_s:
        press_sleeve(system, e, y, t, modes, motion.latch, contacts, out)
    elif press_mesh(system, e - n_s, y, t, modes, contacts, out) != 0:
        return 1
    before, other_before = modes[first], modes[first + count - 1]
    for k in range(first, first + count):
        if modes[k] == OPEN and contacts[k, PENETRATION] >= 0.0 and contacts[k, RATE] > 0.0:
            motion.counts[EVENTS] += 1
            switch_mode(system, k, t, y, modes, contacts, motion.latch)
    tally_change(motion, t, first, before, contacts[first, RATE])
    if count == 2:
        tally_change(motion, t, first + 1, other_before, contacts[first + 1, RATE])
    return 0
