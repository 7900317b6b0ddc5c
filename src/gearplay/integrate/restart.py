"""Initialisation of the integration: at the start of a run and after every change of mode."""

import math

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import copy_rotor, rebuild, states_of
from gearplay.integrate.implicit import IN_USE, QUIET
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import (
    BEGUN,
    BLOW_UP,
    BURST,
    BURST_START,
    CALLS,
    CANNOT_MESH,
    CHATTER,
    DONE,
    EVENTS,
    H_BEGIN,
    H_RESTART,
    NOT_FINITE,
    STEP_TOO_SMALL,
    H,
    Run,
    T,
)
from gearplay.integrate.switches import initialise_modes, mark_separating, switch_mode, switch_values
from gearplay.integrate.tallies import tally_change
from gearplay.integrate.trial_step import watch
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import first_axis
from gearplay.kernels.layout import (
    DRIVE_SPEED,
    KNOWN,
    OPEN,
    RATE,
    TOUCH,
    Loads,
    System,
    members,
    omega_of,
    ramp_of,
    theta_of,
    vx_of,
    x_of,
)

BURST_EVENTS = 10_000  # between two checks of their density
PERIOD_EVENTS = 100  # per contact and period of the fastest contact: more is chatter
FURTHEST = 1e9  # in units of the error scale's natural size: beyond it a run has blown up


@compiled_inline
def check_state(run: Run, i: int) -> int:
    """Return a status for the present value of state i: finite and within all reason."""
    if not math.isfinite(run.y[i]):
        return NOT_FINITE
    return BLOW_UP if abs(run.y[i]) > FURTHEST * run.natural[i] else DONE


@compiled_inline
def leaves_mesh(system: System, run: Run, e: int) -> bool:
    """Return whether element e fails where its rotors, from the accepted state, would be after a restart step."""
    y = run.y_try
    states_of(system, run.active_set, e, run.clock[T], run.y, y)
    for i in members(system, e):
        if i >= 0:
            for axis in range(3):
                y[x_of(i) + axis] += run.clock[H_RESTART] * y[vx_of(system, i) + axis]
    return bool(dispatch.contact_kinematics(system, e, run.clock[T], y, run.branch, run.loads_try) != 0)


@compiled_once
def failure(system: System, run: Run) -> int:
    """Return the status of the step into y_new that failed: not finite, gears leave mesh, or step too small.

    A stage of a step that is far too long may fail anywhere: gears leave mesh only where the accepted motion takes them there.
    """
    active_set = run.active_set
    for s in range(1, active_set.states[0] + 1):
        if not math.isfinite(run.y_new[active_set.states[s]]):
            return NOT_FINITE
    for c in range(1, active_set.acting[0] + 1):
        if leaves_mesh(system, run, active_set.acting[c]):
            return CANNOT_MESH
    for c in range(1, active_set.watched[0] + 1):
        if leaves_mesh(system, run, active_set.watched[c]):
            return CANNOT_MESH
    return STEP_TOO_SMALL


@compiled
def check_states(run: Run) -> int:
    """Return the first status of all states that is not DONE."""
    for i in range(run.y.size):
        status = check_state(run, i)
        if status != DONE:
            return status
    return DONE


@compiled_once
def evaluate(system: System, run: Run, t: float) -> int:
    """Evaluate f, contacts and switches at (t, y) into row 0 of the stages and the ``_0`` tables."""
    run.counts[CALLS] += 1
    failed = rates_of(system, run.active_set, t, run.y, run.branch, run.stages[0], run.loads_0)
    if failed == 0:
        failed = watch(system, run, t, run.y, run.loads_0)
    if failed == 0:
        switch_values(system, run.active_set, t, run.y, run.branch, run.loads_0, run.g_0)
    return failed


@compiled_inline
def change_mode(system: System, run: Run, s: int, t: float, y: Floats, loads: Loads) -> None:
    """Apply switch s at t [s]; log the change of its contact, and the release of the contact that excludes it."""
    contact, modes = system.switches[s].contact, run.branch.modes
    partner = system.contacts[contact].partner if contact >= 0 else -1
    before = modes[contact] if contact >= 0 else OPEN
    partner_before = modes[partner] if partner >= 0 else OPEN
    run.counts[EVENTS] += 1
    switch_mode(system, s, t, y, run.branch, loads)
    if contact >= 0:
        tally_change(run, t, contact, before, loads.contacts[contact, RATE])
    if partner >= 0:
        tally_change(run, t, partner, partner_before, loads.contacts[partner, RATE])


@compiled_inline
def resolve_coincidence(system: System, run: Run, t: float) -> bool:
    """Change one further contact that is past its touch or release at the same instant; False if there is none."""
    for c in range(1, run.active_set.switches[0] + 1):
        s = run.active_set.switches[c]
        if system.switches[s].role != TOUCH:
            continue
        k = system.switches[s].contact
        before, rate = run.branch.modes[k], run.loads_0.contacts[k, RATE]
        if run.g_0[s] >= 0.0 and (rate > 0.0 if before == OPEN else rate < 0.0 < run.g_0[s]):
            change_mode(system, run, s, t, run.y, run.loads_0)
            return True
    return False


@compiled_once
def locate_kinks(system: System, run: Run, located: bool) -> None:
    """Locate kinks of forces as events from the present state on, or integrate across them."""
    acting = run.active_set.acting
    for c in range(1, acting[0] + 1):
        dispatch.locate_kinks(system, acting[c], located, run.branch, run.loads_0, run.g_0)


@compiled_once
def restart(system: System, run: Run) -> int:
    """Rebuild the active set for the new contact states, evaluate it, shorten the step and count events; return a status."""
    clock, counts, modes = run.clock, run.counts, run.branch.modes
    t = clock[T]
    for i in range(system.rotors.size):
        ramp = ramp_of(system, modes, i)
        if modes[ramp] == 1 and t >= system.rotors[i].ramp_time:
            modes[ramp] = 0
            if system.rotors[i].drive == DRIVE_SPEED:
                run.y[omega_of(system, i)] = 0.0  # exactly at its prescribed speed from here on
                for row in range(run.stages.shape[0]):
                    run.stages[row, theta_of(i)] = run.stages[row, omega_of(system, i)] = 0.0
    if run.implicit.numbers[IN_USE] == 1:
        if evaluate(system, run, t) != 0:
            return CANNOT_MESH
        locate_kinks(system, run, True)
    while True:
        rebuild(system, run.active_set, t, run.y, run.branch)
        for i in range(system.rotors.size):
            if run.active_set.body_states[i] == KNOWN or first_axis(system, i, run.y) > 0:
                copy_rotor(system, i, run.y, run.y_new)
                copy_rotor(system, i, run.y, run.y_try)
        if evaluate(system, run, t) != 0:
            return CANNOT_MESH
        if not resolve_coincidence(system, run, t):
            break
    clock[H] = clock[H_BEGIN]
    run.implicit.numbers[QUIET] = run.implicit.numbers[IN_USE] = 0
    counts[BURST] += 1
    if counts[BURST] >= BURST_EVENTS:
        # The restart step is 0.1 / omega of the fastest contact; each contact has a few events in a period.
        periods = (t - clock[BURST_START]) / (20.0 * math.pi * clock[H_RESTART])
        if periods * PERIOD_EVENTS * max(system.contacts.size, 1) < BURST_EVENTS:
            return CHATTER
        counts[BURST], clock[BURST_START] = 0, t
    return DONE


@compiled_once
def begin(system: System, run: Run) -> int:
    """Find the modes of the initial state; return a status. `advance` does it for a run that has not begun."""
    t = run.clock[T]
    run.counts[BEGUN] = 1
    status = check_states(run)
    if status != DONE:
        return status
    for k in range(system.contacts.size):  # impact speeds of a continued run stay
        slot = system.contacts[k].impact_slot
        if slot >= 0:
            run.branch.impact_speeds[slot] = max(run.branch.impact_speeds[slot], system.contacts[k].floor)
    for e in range(system.elements.size):
        dispatch.start_step(system, e, t, run.y, run.branch)
    # A new active set has every rotor active and every element acting.
    if evaluate(system, run, t) != 0:
        return CANNOT_MESH
    initialise_modes(system, t, run.y, run.branch, run.loads_0)
    if evaluate(system, run, t) != 0:
        return CANNOT_MESH
    mark_separating(system, run.branch, run.loads_0)
    run.clock[BURST_START] = t
    return restart(system, run)
