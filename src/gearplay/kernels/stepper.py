"""The hybrid integrator: closed-form flight between contacts, embedded Runge-Kutta steps of what is touched.

An error estimate does not see a kink, so each step is searched for switches (docs/theory, "Events"). A step that
contains one is taken again so that it ends there, the mode changes, and the method starts afresh. Rotors that nothing touches
are not integrated; their next touch is found by conservative advancement (`advancement`). All state lives in the arrays of
`Motion`: `advance` can return at any step and be called again without a trace in the result.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.advancement import FAILS, TOUCHES, mesh_span, sleeve_span
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.events import attempt, first_switch, retake, watch
from gearplay.kernels.layout import (
    ACTIVE,
    DRIVE_SPEED,
    KNOWN,
    OPEN,
    PENETRATION,
    RATE,
    System,
    contact_count,
)
from gearplay.kernels.mesh import follow_orbit, know_angles, mesh_phase
from gearplay.kernels.motion import press_mesh, press_sleeve, right_hand_side
from gearplay.kernels.recording import record_samples, tally_change, tally_step
from gearplay.kernels.roster import members, muster, state_of
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
    LOGGED,
    NOT_FINITE,
    PAUSED,
    REJECTED,
    STEP_TOO_SMALL,
    STEPS,
    T_END,
    H,
    Motion,
    T,
)
from gearplay.kernels.runge_kutta import ORDER, STAGES, error_norm
from gearplay.kernels.switches import settle_margins, settle_modes, switch_mode, switch_values

Floats = NDArray[np.float64]

BURST_EVENTS = 10_000  # between two looks at their density
PERIOD_EVENTS = 100  # per contact and period of the fastest contact: more is chatter
BURST_LOOKS = 200_000  # at gaps within one flight: beyond it a contact hovers without touching
FURTHEST = 1e9  # in units of the error scale's natural size: beyond it a run has blown up


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


@compiled
def begin(system: System, motion: Motion) -> int:
    """Find the modes of the initial state; return a status. `advance` does it for a run that has not begun."""
    t = motion.clock[T]
    motion.counts[BEGUN] = 1
    status = check_states(motion)
    if status != DONE:
        return status
    for k in range(system.sleeves.size):
        motion.latch[k] = system.sleeves[k].minimum_speed
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


@compiled_inline
def longest_step(system: System, motion: Motion) -> float:
    """Return the longest step [s] that still resolves every forcing term of what is integrated."""
    n, roster = system.rotors.size, motion.roster
    fastest = 1e-9
    for watched in range(2):
        meshes = roster.watched_meshes if watched == 1 else roster.meshes
        for c in range(1, meshes[0] + 1):
            m = system.meshes[meshes[c]]
            _, rate = mesh_phase(m, system, motion.clock[T], motion.y)
            fastest = max(fastest, abs(rate) * m.highest_order)
    for c in range(1, roster.active[0] + 1):
        i = roster.active[c]
        omega = system.rotors[i].nominal_speed + motion.y[3 * (n + i) + 2]
        fastest = max(fastest, abs(omega))
    return 0.5 / fastest


@compiled_inline
def next_stop(motion: Motion) -> float:
    """Return the next time [s] that a step must not pass."""
    for i in range(motion.stops.size):
        if motion.stops[i] > motion.clock[T]:
            return min(motion.stops[i], motion.clock[T_END])
    return motion.clock[T_END]


@compiled_inline
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
        bearing = e < n_s and system.sleeves[e].clearance == 0.0
        if modes[k] == OPEN and contacts[k, PENETRATION] >= 0.0 and (contacts[k, RATE] > 0.0 or bearing):
            motion.counts[EVENTS] += 1
            switch_mode(system, k, t, y, modes, contacts, motion.latch)
    tally_change(motion, t, first, before, contacts[first, RATE])
    if count == 2:
        tally_change(motion, t, first + 1, other_before, contacts[first + 1, RATE])
    return 0


@compiled
def change_modes(system: System, motion: Motion, t: float, first: int) -> None:
    """Apply switch ``first`` and every other one that is positive at the same state."""
    n_c, n_s = contact_count(system), system.sleeves.size
    roster = motion.roster
    for c in range(1, roster.switches[0] + 1):
        k = roster.switches[c]
        if k != first and not (motion.g_1[k] > 0.0 and motion.g_0[k] <= 0.0):
            continue
        motion.counts[EVENTS] += 1
        # A switch changes its own contact, and with printed flanks perhaps its neighbour.
        contact = k if k < n_c else k - n_c if k < 2 * n_c else -1
        other = n_s + ((contact - n_s) ^ 1) if contact >= n_s else -1
        before = motion.modes[contact] if contact >= 0 else OPEN
        other_before = motion.modes[other] if other >= 0 else OPEN
        switch_mode(system, k, t, motion.y_new, motion.modes, motion.contacts, motion.latch)
        if contact >= 0:
            tally_change(motion, t, contact, before, motion.contacts[contact, RATE])
        if other >= 0:
            tally_change(motion, t, other, other_before, motion.contacts[other, RATE])


@compiled_inline
def check_state(motion: Motion, i: int) -> int:
    """Return a status for the present value of state i: finite and within all reason."""
    if not math.isfinite(motion.y[i]):
        return NOT_FINITE
    return BLOW_UP if abs(motion.y[i]) > FURTHEST * motion.natural[i] else DONE


@compiled
def check_states(motion: Motion) -> int:
    """Return the first status of all states that is not DONE."""
    for i in range(motion.y.size):
        status = check_state(motion, i)
        if status != DONE:
            return status
    return DONE


@compiled
def take_flight(system: System, motion: Motion) -> int:
    """Fly, all rotors untouched, to the next touch or stop; return a status."""
    clock = motion.clock
    stop = next_stop(motion)
    e, t, status = next_touch(system, motion, stop)
    record_samples(system, motion, 1.0, t)
    motion.counts[STEPS] += 1
    clock[T] = t
    if status != DONE:
        return status
    if e < motion.roster.doings.size and touch_down(system, motion, e, t) != 0:
        return CANNOT_MESH
    if e == motion.roster.due.size and stop >= clock[T_END]:
        return DONE
    return restart(system, motion)


@compiled_inline
def go_on(system: System, motion: Motion) -> None:
    """Make the end of a step the start of the next, for what takes part in it."""
    roster = motion.roster
    for s in range(1, roster.states[0] + 1):
        i = roster.states[s]
        motion.stages[0, i] = motion.stages[STAGES - 1, i]
    n_c = contact_count(system)
    for s in range(1, roster.switches[0] + 1):
        k = roster.switches[s]
        motion.g_0[k] = motion.g_1[k]
        if k < n_c:
            motion.contacts_0[k, RATE] = motion.contacts[k, RATE]


@compiled
def take_step(system: System, motion: Motion) -> int:
    """Take one accepted step of the active rotors, with at most one switch at its end; return a status."""
    clock, counts, roster = motion.clock, motion.counts, motion.roster
    t, stop = clock[T], next_stop(motion)
    h = min(clock[H], longest_step(system, motion))
    touching, t_touch, status = next_touch(system, motion, min(t + h, stop))
    if status != DONE:
        return status
    if touching < roster.due.size:
        stop = t_touch
    if stop - t <= 2e-15 * max(abs(t), 1e-6):  # nothing that a step could resolve
        clock[T] = stop
        if touching < roster.due.size:
            return land(system, motion, touching, stop)
        return DONE if stop >= clock[T_END] else restart(system, motion)
    for c in range(1, roster.meshes[0] + 1):
        know_angles(system, roster.meshes[c], t, motion.y)
    reason, rejected = STEP_TOO_SMALL, counts[REJECTED]
    while True:
        to_stop = h >= (stop - t) * (1.0 - 1e-12)
        if to_stop:
            h = stop - t
        if h <= 1e-15 * max(abs(t), 1e-6):
            return reason
        if attempt(system, motion, h) != 0:
            reason = CANNOT_MESH
            for s in range(1, roster.states[0] + 1):
                if not math.isfinite(motion.y_new[roster.states[s]]):
                    reason = NOT_FINITE
            counts[REJECTED] += 1
            h *= 0.25
            continue
        error = error_norm(roster, h, motion.stages, motion.scale)
        if error <= 1.0:
            break
        reason = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        counts[REJECTED] += 1
        h *= max(0.1, 0.9 * error ** (-1.0 / ORDER)) if math.isfinite(error) else 0.1
    most = 5.0 if counts[REJECTED] == rejected else 1.0
    growth = min(most, 0.9 * error ** (-1.0 / ORDER)) if error > 1e-12 else most

    t_new = stop if to_stop else t + h
    switch_values(system, roster, t_new, motion.y_new, motion.modes, motion.contacts, motion.g_1)
    first, place = first_switch(system, motion, h)
    taken = h
    if first >= 0 and place < 1.0:
        taken = retake(system, motion, h, first, place)
        if taken < 0.0:
            return CANNOT_MESH
        t_new = t + taken
        to_stop = False
    record_samples(system, motion, taken, t_new)
    tally_step(motion, taken)
    counts[STEPS] += 1
    clock[T] = t_new
    if first >= 0:
        change_modes(system, motion, t_new, first)
    status = DONE
    for s in range(1, roster.states[0] + 1):
        motion.y[roster.states[s]] = motion.y_new[roster.states[s]]
        status = max(status, check_state(motion, roster.states[s]))
    for c in range(1, roster.meshes[0] + 1):
        follow_orbit(system, roster.meshes[c], motion.y)
    for c in range(1, roster.watched_meshes[0] + 1):
        follow_orbit(system, roster.watched_meshes[c], motion.y_new)
    if status != DONE:
        return status
    if to_stop and touching < roster.due.size:
        return land(system, motion, touching, t_new)
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, motion)
    go_on(system, motion)
    clock[H] = h * growth
    return DONE


@compiled
def land(system: System, motion: Motion, e: int, t: float) -> int:
    """Let dormant element e touch at t [s], or a flight's closed form end, and start afresh; return a status."""
    if e < motion.roster.doings.size and touch_down(system, motion, e, t) != 0:
        return CANNOT_MESH
    return restart(system, motion)


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
def synchronise(system: System, motion: Motion) -> int:
    """Bring y up to the present time for every rotor; return a status. Flights go on from where they began."""
    for i in range(system.rotors.size):
        if motion.roster.roles[i] != ACTIVE:
            state_of(system, motion.roster, i, motion.clock[T], motion.y, motion.y)
    return check_states(motion)


@compiled
def advance(system: System, motion: Motion, steps: int) -> int:
    """Advance until T_END, for at most ``steps`` steps, or until the log is full; return a status."""
    clock, counts = motion.clock, motion.counts
    spare = 2 * motion.g_0.size + 2
    if counts[BEGUN] == 0:
        status = begin(system, motion)
        if status != DONE:
            return status
    for _ in range(steps):
        if clock[T] >= clock[T_END]:
            return synchronise(system, motion)
        if counts[LOGGED] + spare > motion.log.shape[0]:
            return PAUSED
        status = take_step(system, motion) if motion.roster.active[0] > 0 else take_flight(system, motion)
        if status != DONE:
            worse = synchronise(system, motion)
            return status if worse == DONE else worse
    return synchronise(system, motion) if clock[T] >= clock[T_END] else PAUSED
