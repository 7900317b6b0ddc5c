"""Steps of constant length, as in plain scripts, for comparison.

No contact is located, no error is estimated and no body uses the closed form. What begins or ends within a step is logged
and counted at its end. Contact conditions are frozen over the step, or updated at every stage, as by a right-hand side that
evaluates ``if delta > 0``. Both are of first order at every contact; between them they have the order of the formula.
"""

from gearplay.integrate import dispatch
from gearplay.integrate.restart import failure, restart
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import CALLS, DONE, FIXED, INSIDE, T_END, Run, T
from gearplay.integrate.runge_kutta import NODES, STAGES, stage_state
from gearplay.integrate.step_end import accept, go_on
from gearplay.integrate.switches import mark_separating, store_impact_speed, switch_values, update_modes
from gearplay.integrate.trial_step import attempt
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import OPEN, RATE, System


@compiled_inline
def is_by_stage(run: Run) -> bool:
    """Return whether contact states are updated at every stage: then every element acts."""
    return bool(run.active_set.forced[0] == 2)


@compiled_once
def update_acting(system: System, run: Run, t: float) -> int:
    """Fill the contact table of all that acts at (t, y_new); return 1 where a pair cannot mesh."""
    for c in range(1, run.active_set.acting[0] + 1):
        if (
            dispatch.contact_kinematics(system, run.active_set.acting[c], t, run.y_new, run.branch, run.loads)
            != 0
        ):
            return 1
    return 0


@compiled_once
def update_modes_of_stage(system: System, run: Run, h: float, stage: int) -> int:
    """Fill a stage of a step of h [s] with the forces of the modes that its own state has; 1 where a pair cannot mesh.

    A contact that was open where the step began stores its rate of penetration here.
    """
    t, branch, loads = run.clock[T] + NODES[stage] * h, run.branch, run.loads
    run.counts[CALLS] += 1
    stage_state(stage, run.active_set, h, run.y, run.stages, run.y_new)
    if update_acting(system, run, t) != 0:
        return 1
    update_modes(system, t, run.y_new, branch, loads)
    for k in range(system.contacts.size):
        if run.modes_0[k] == OPEN and branch.modes[k] != OPEN:
            store_impact_speed(system, k, loads.contacts[k, RATE], branch)
    failed = rates_of(system, run.active_set, t, run.y_new, branch, run.stages[stage], loads)
    if failed == 0 and mark_separating(system, branch, loads):
        failed = rates_of(system, run.active_set, t, run.y_new, branch, run.stages[stage], loads)
    return failed


@compiled_once
def update_stage_modes(system: System, run: Run, h: float, first: int, last: int) -> int:
    """Fill stages of a step of h [s], then the contact table at y_new on the step's own modes; 1 where a pair cannot mesh."""
    modes = run.branch.modes
    for m in range(modes.size):
        run.modes_0[m] = modes[m]
    run.clock[INSIDE] = 0.0
    failed = 0
    for stage in range(first, last + 1):
        if failed == 0:
            failed = update_modes_of_stage(system, run, h, stage)
    for m in range(modes.size):
        modes[m] = run.modes_0[m]
    return failed if failed != 0 else update_acting(system, run, run.clock[T] + NODES[last] * h)


@compiled_once
def take_fixed_step(system: System, run: Run, stop: float) -> int:
    """Take one step of the fixed length, or up to ``stop`` [s]; return a status."""
    clock, active_set = run.clock, run.active_set
    t, h = clock[T], clock[FIXED]
    to_stop = h >= (stop - t) * (1.0 - 1e-9)
    if to_stop:
        h = stop - t
    t_new = stop if to_stop else t + h
    for c in range(1, active_set.acting[0] + 1):
        dispatch.start_step(system, active_set.acting[c], t, run.y, run.branch)
    failed = (
        update_stage_modes(system, run, h, 1, STAGES - 1) if is_by_stage(run) else attempt(system, run, h)
    )
    if failed != 0:
        return failure(system, run)
    switch_values(system, active_set, t_new, run.y_new, run.branch, run.loads, run.g_1)
    first = -1
    for c in range(1, active_set.switches[0] + 1):
        if first < 0 and run.g_1[active_set.switches[c]] > 0.0:
            first = active_set.switches[c]
    status = accept(system, run, h, t_new, first)
    if status != DONE:
        return status
    if first < 0 and not (to_stop and stop < clock[T_END]):
        go_on(system, run)
        return DONE
    status = restart(system, run)
    if status == DONE and is_by_stage(run) and update_stage_modes(system, run, 0.0, 0, 0) != 0:
        return failure(system, run)
    return status
