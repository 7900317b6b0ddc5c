"""Steps of one length, contacts noticed at their ends: as plain scripts do it, to see what that changes.

No contact is located, no error is estimated and nothing flies in closed form. What begins or ends within a step is noticed
at its end, which makes the method one of first order at every contact; between them it has the order of its formula.
"""

from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
from gearplay.kernels.events import attempt
from gearplay.kernels.layout import System
from gearplay.kernels.restart import failure, restart
from gearplay.kernels.run import DONE, FIXED, T_END, Run, T
from gearplay.kernels.step_end import accept, go_on
from gearplay.kernels.switches import switch_values


@compiled_once
def take_fixed_step(system: System, run: Run, stop: float) -> int:
    """Take one step of the fixed length, or up to ``stop`` [s]; return a status."""
    clock, roster = run.clock, run.roster
    t, h = clock[T], clock[FIXED]
    to_stop = h >= (stop - t) * (1.0 - 1e-9)
    if to_stop:
        h = stop - t
    t_new = stop if to_stop else t + h
    for c in range(1, roster.acting[0] + 1):
        table.start_step(system, roster.acting[c], t, run.y, run.branch)
    if attempt(system, run, h) != 0:
        return failure(run)
    switch_values(system, roster, t_new, run.y_new, run.branch, run.loads, run.g_1)
    first = -1
    for c in range(1, roster.switches[0] + 1):
        if first < 0 and run.g_1[roster.switches[c]] > 0.0:
            first = roster.switches[c]
    status = accept(system, run, h, t_new, first)
    if status != DONE:
        return status
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, run)
    go_on(system, run)
    return DONE
