"""The end of a step that is accepted: what switches there, and what is carried over to the next."""

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import OPEN, RATE, System, contact_count
from gearplay.kernels.mesh import follow_orbit
from gearplay.kernels.recording import record_samples, sample_is_due, tally_change, tally_step
from gearplay.kernels.restart import check_state
from gearplay.kernels.run_state import DONE, EVENTS, STEPS, Motion, T
from gearplay.kernels.runge_kutta import STAGES
from gearplay.kernels.switches import contact_of_switch, switch_mode


@compiled
def change_modes(system: System, motion: Motion, t: float, first: int) -> None:
    """Apply switch ``first`` and every other one that is positive at the same state."""
    n_s, roster = system.sleeves.size, motion.roster
    for c in range(1, roster.switches[0] + 1):
        k = roster.switches[c]
        if k != first and not (motion.g_1[k] > 0.0 and motion.g_0[k] <= 0.0):
            continue
        motion.counts[EVENTS] += 1
        # A switch changes its own contact, and with printed flanks perhaps its neighbour.
        contact = contact_of_switch(system, k)
        other = n_s + ((contact - n_s) ^ 1) if contact >= n_s else -1
        before = motion.modes[contact] if contact >= 0 else OPEN
        other_before = motion.modes[other] if other >= 0 else OPEN
        switch_mode(system, k, t, motion.y_new, motion.modes, motion.contacts, motion.latch)
        if contact >= 0:
            tally_change(motion, t, contact, before, motion.contacts[contact, RATE])
        if other >= 0:
            tally_change(motion, t, other, other_before, motion.contacts[other, RATE])


@compiled
def accept(system: System, motion: Motion, h: float, t: float, first: int) -> int:
    """Make the state at the end t [s] of a step of h [s] the present one, with what switches there; return a status.

    ``first`` is the switch that ended the step, -1 for none.
    """
    roster, status = motion.roster, DONE
    if sample_is_due(motion, t):
        record_samples(system, motion, h, t)
    tally_step(motion, h)
    motion.counts[STEPS] += 1
    motion.clock[T] = t
    if first >= 0:
        change_modes(system, motion, t, first)
    for s in range(1, roster.states[0] + 1):
        motion.y[roster.states[s]] = motion.y_new[roster.states[s]]
        status = max(status, check_state(motion, roster.states[s]))
    for c in range(1, roster.meshes[0] + 1):
        follow_orbit(system, roster.meshes[c], motion.y)
    for c in range(1, roster.watched_meshes[0] + 1):
        follow_orbit(system, roster.watched_meshes[c], motion.y_new)
    return status


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
