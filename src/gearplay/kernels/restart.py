"""Starting afresh: at the start of a run and after every change of mode."""

import math

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.events import watch
from gearplay.kernels.layout import DRIVE_SPEED, KNOWN, OPEN, RATE, System, contact_count
from gearplay.kernels.mesh import know_angles
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.recording import tally_change
from gearplay.kernels.roster import muster, state_of
from gearplay.kernels.run_state import (
    BEGUN,
    BLOW_UP,
    BURST,
    BURST_START,
    CALLS,
    CANNOT_MESH,
    CHATTER,
    DONE,
    EVENTS,
    H_RESTART,
    NOT_FINITE,
    H,
    Motion,
    T,
)
from gearplay.kernels.switches import settle_margins, settle_modes, switch_mode, switch_values

BURST_EVENTS = 10_000  # between two looks at their density
PERIOD_EVENTS = 100  # per contact and period of the fastest contact: more is chatter
FURTHEST = 1e9  # in units of the error scale's natural size: beyond it a run has blown up


@compiled_inline
def check_state(motion: Motion, i: int) -> int:
    """Return a status for the present value of state i: finite and within all reason."""
    if not math.isfinite(motion.y[i]):
        return NOT_FINITE
    return BLOW_UP if abs(motion.y[i]) > FURTHEST * motion.natural[i] else DONE


@compiled_inline
def failure(motion: Motion) -> int:
    """Return why the step tried into y_new failed: a state that is not finite, else gears that cannot mesh."""
    for s in range(1, motion.roster.states[0] + 1):
        if not math.isfinite(motion.y_new[motion.roster.states[s]]):
            return NOT_FINITE
    return CANNOT_MESH


@compiled
def check_states(motion: Motion) -> int:
    """Return the first status of all states that is not DONE."""
    for i in range(motion.y.size):
        status = check_state(motion, i)
        if status != DONE:
            return status
    return DONE


@compiled_inline
def evaluate(system: System, motion: Motion, t: float) -> int:
    """Evaluate f, contacts and switches at (t, y) into row 0 of the stages and the ``_0`` tables."""
    motion.counts[CALLS] += 1
    failed = right_hand_side(
        system,
        motion.roster,
        t,
        motion.y,
        motion.modes,
        motion.latch,
        motion.stages[0],
        motion.contacts_0,
        motion.force,
        motion.out,
    )
    if failed == 0:
        failed = watch(system, motion, t, motion.y, motion.contacts_0)
    if failed == 0:
        switch_values(system, motion.roster, t, motion.y, motion.modes, motion.contacts_0, motion.g_0)
    return failed


@compiled_inline
def settle_coincidence(system: System, motion: Motion, t: float) -> bool:
    """Change one contact that, at the same instant as another, is past its touch or release; False if there is none."""
    for c in range(1, motion.roster.switches[0] + 1):
        k = motion.roster.switches[c]
        if k >= contact_count(system):
            continue
        before, rate = motion.modes[k], motion.contacts_0[k, RATE]
        if motion.g_0[k] >= 0.0 and (rate > 0.0 if before == OPEN else rate < 0.0 < motion.g_0[k]):
            motion.counts[EVENTS] += 1
            switch_mode(system, k, t, motion.y, motion.modes, motion.contacts_0, motion.latch)
            tally_change(motion, t, k, before, rate)
            return True
    return False


@compiled
def restart(system: System, motion: Motion) -> int:
    """Muster for the new branch, evaluate it, shorten the step and watch for endless chatter; return a status."""
    clock, counts = motion.clock, motion.counts
    n_r, t = system.rotors.size, clock[T]
    base = motion.modes.size - n_r
    for i in range(n_r):
        if motion.modes[base + i] == 1 and t >= system.rotors[i].ramp_time:
            motion.modes[base + i] = 0
            if system.rotors[i].drive == DRIVE_SPEED:
                motion.y[3 * (n_r + i) + 2] = 0.0  # exactly at its prescribed speed from here on
    while True:
        muster(system, motion.roster, t, motion.y, motion.modes)
        for i in range(n_r):
            if motion.roster.roles[i] == KNOWN:
                state_of(system, motion.roster, i, t, motion.y, motion.y_new)
                state_of(system, motion.roster, i, t, motion.y, motion.y_try)
        if evaluate(system, motion, t) != 0:
            return CANNOT_MESH
        if not settle_coincidence(system, motion, t):
            break
    clock[H] = clock[H_RESTART]
    counts[BURST] += 1
    if counts[BURST] >= BURST_EVENTS:
        # The restart step is 0.1 / omega of the fastest contact; each contact has a few events in a period.
        periods = (t - clock[BURST_START]) / (20.0 * math.pi * clock[H_RESTART])
        if periods * PERIOD_EVENTS * contact_count(system) < BURST_EVENTS:
            return CHATTER
        counts[BURST], clock[BURST_START] = 0, t
    return DONE


@compiled
def begin(system: System, motion: Motion) -> int:
    """Find the modes of the initial state; return a status. `advance` does it for a run that has not begun."""
    t = motion.clock[T]
    motion.counts[BEGUN] = 1
    status = check_states(motion)
    if status != DONE:
        return status
    for k in range(system.sleeves.size):  # what another run has latched stays
        motion.latch[k] = max(motion.latch[k], system.sleeves[k].minimum_speed)
    for j in range(system.meshes.size):
        know_angles(system, j, t, motion.y)
    # A new roster has every rotor active and every element touching.
    if evaluate(system, motion, t) != 0:
        return CANNOT_MESH
    settle_modes(system, t, motion.y, motion.modes, motion.contacts_0, motion.latch)
    evaluate(system, motion, t)
    settle_margins(system, motion.modes, motion.contacts_0)
    motion.clock[BURST_START] = t
    return restart(system, motion)
