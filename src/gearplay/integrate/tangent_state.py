"""Arrays of the tangent of a run."""

from dataclasses import dataclass

import numpy as np

from gearplay.integrate.active_set import ActiveSet, add, copy_list, make_active_set, state_of
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.run import Run, T
from gearplay.integrate.runge_kutta import STAGES
from gearplay.integrate.slopes import Slopes, make_slopes
from gearplay.integrate.switches import make_branch
from gearplay.kernels.arrays import Cubes, Floats, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import Branch, Loads, System, vx_of, x_of


@dataclass(frozen=True, eq=False)
class Tangent(Group):
    """Changes of a run's initial state propagated to its present, with the workspace of a step; made by `make_tangent`."""

    changes: Rows  # [change, state, then stored impact speeds]
    rates: Cubes  # [change, stage, the same]
    stage: Floats  # [the same], scratch
    slopes: Slopes
    before: ActiveSet  # of the step's start
    branch: Branch
    y: Floats  # at its start
    y_stage: Floats
    stages: Rows  # [stage, state]
    jump: Rows  # [2, state], rates of the state before and after an event
    loads: Loads
    traces: Floats  # [stage], of the slopes
    totals: Floats  # [2]: integral of the divergence since the start; 1 where it is requested


def make_tangent(system: System, run: Run, changes: Floats, *, divergence: bool = False) -> Tangent:
    """Allocate the tangent of a run for ``changes`` of its start, shape [change, state + impact speed]."""
    n, n_z = run.y.size, run.y.size + run.branch.impact_speeds.size
    rows = np.ascontiguousarray(changes, dtype=np.float64)
    return Tangent(
        changes=rows,
        rates=np.zeros((len(rows), STAGES, n_z)),
        stage=np.zeros(n_z),
        slopes=make_slopes(system),
        before=make_active_set(system, n),
        branch=make_branch(system),
        y=np.zeros(n),
        y_stage=np.zeros(n),
        stages=np.zeros((STAGES, n)),
        jump=np.zeros((2, n)),
        loads=make_loads(system),
        traces=np.zeros(STAGES),
        totals=np.array([0.0, 1.0 if divergence else 0.0]),
    )


@compiled_once
def read_state(system: System, run: Run, y: Floats) -> None:
    """Fill ``y`` with the present state, free bodies included."""
    for s in range(y.size):
        y[s] = run.y[s]
    for i in range(system.rotors.size):
        state_of(system, run.active_set, i, run.clock[T], run.y, y)


@compiled_inline
def list_states(system: System, active_set: ActiveSet) -> None:
    """List the states of active rotors, centres at rest included, whose changes move on, and of acting elements."""
    active_set.states[0] = 0
    for c in range(1, active_set.active[0] + 1):
        for axis in range(3):
            add(active_set.states, x_of(active_set.active[c]) + axis)
        for axis in range(3):
            add(active_set.states, vx_of(system, active_set.active[c]) + axis)
    for c in range(1, active_set.acting[0] + 1):
        element = system.elements[active_set.acting[c]]
        for slot in range(element.state, element.state + element.states):
            add(active_set.states, slot)


@compiled_once
def remember(system: System, run: Run, tangent: Tangent) -> None:
    """Store the state at the start of a step."""
    now, before, branch = run.active_set, tangent.before, tangent.branch
    read_state(system, run, tangent.y)
    for i in range(system.rotors.size):
        before.body_states[i] = now.body_states[i]
    copy_list(now.active, before.active)
    copy_list(now.acting, before.acting)
    list_states(system, before)
    for m in range(branch.modes.size):
        branch.modes[m] = run.branch.modes[m]
    for k in range(branch.impact_speeds.size):
        branch.impact_speeds[k] = run.branch.impact_speeds[k]
    for e in range(branch.memory.shape[0]):
        for c in range(branch.memory.shape[1]):
            branch.memory[e, c] = run.branch.memory[e, c]
