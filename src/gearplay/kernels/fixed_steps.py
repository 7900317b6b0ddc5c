"""Steps of one length, contacts noticed at their ends: as plain scripts do it, to see what that changes.

No contact is located, no error is estimated and nothing flies in closed form. What begins or ends within a step is noticed
at its end, which makes the method one of first order at every contact; between them it has the order of its formula.
"""

from gearplay.kernels.compiled import compiled
from gearplay.kernels.events import attempt
from gearplay.kernels.layout import System
from gearplay.kernels.mesh import know_angles
from gearplay.kernels.restart import failure, restart
from gearplay.kernels.run_state import DONE, FIXED, T_END, Motion, T
from gearplay.kernels.step_end import accept, go_on
from gearplay.kernels.switches import switch_values


@compiled
def take_fixed_step(system: System, motion: Motion, stop: float) -> int:
    """Take one step of the fixed length, or up to ``stop`` [s]; return a status."""
    clock, roster = motion.clock, motion.roster
    t, h = clock[T], clock[FIXED]
    to_stop = h >= (stop - t) * (1.0 - 1e-9)
    if to_stop:
        h = stop - t
    t_new = stop if to_stop else t + h
    for c in range(1, roster.meshes[0] + 1):
        know_angles(system, roster.meshes[c], t, motion.y)
    if attempt(system, motion, h) != 0:
        return failure(motion)
    switch_values(system, roster, t_new, motion.y_new, motion.modes, motion.contacts, motion.g_1)
    first = -1
    for c in range(1, roster.switches[0] + 1):
        if first < 0 and motion.g_1[roster.switches[c]] > 0.0:
            first = roster.switches[c]
    status = accept(system, motion, h, t_new, first)
    if status != DONE:
        return status
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, motion)
    go_on(system, motion)
    return DONE
