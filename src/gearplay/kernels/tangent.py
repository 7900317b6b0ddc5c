"""The tangent of a run: how small changes of its start have moved on, exact through contacts and their events.

The run itself is the stepper's, bit for bit. Each of its steps is taken again to first order: the derivative of the method's
own stages, or of the closed form in flight. At an event the change is carried over by its saltation matrix: a change of
the instant of the event times the jump of the derivatives there, and the latched impact speed (docs/theory, "Tangent of the
motion").
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.flight import flight_rates
from gearplay.kernels.layout import (
    ACTIVE,
    CONTACT_COLUMNS,
    FLYING,
    OPEN,
    OUT_SIZE,
    STIFFNESS_SQUARE,
    System,
    contact_count,
)
from gearplay.kernels.linear_mesh import flank_change, linearise_mesh, mesh_changes
from gearplay.kernels.linear_motion import Slopes, fly_change, linearise, make_slopes, rate_of_change
from gearplay.kernels.linear_sleeve import V_U, linearise_sleeve, sleeve_changes
from gearplay.kernels.mesh import know_angles
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.roster import Roster, make_roster, state_of
from gearplay.kernels.run_state import CANNOT_MESH, DONE, PAUSED, Motion, T
from gearplay.kernels.runge_kutta import ERROR, NODES, ORDER, STAGES, WEIGHTS, stage_state
from gearplay.kernels.stepper import advance, log_is_full, synchronise
from gearplay.kernels.switches import is_printed

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Tangent(NamedTuple):
    """Changes of a run's start moved on to its present, and what a step needs; made by `make_tangent`."""

    changes: Floats  # [change, state, then latched speed of each sleeve]
    rates: Floats  # [change, stage, the same]
    stage: Floats  # [the same], scratch
    slopes: Slopes
    before: Roster  # of the step's start
    modes: Ints
    latch: Floats
    y: Floats  # at its start
    y_stage: Floats
    stages: Floats  # [stage, state]
    jump: Floats  # [2, state], rates of the state before and after an event
    contacts: Floats
    force: Floats
    out: Floats
    traces: Floats  # [stage], of the slopes
    totals: Floats  # [2]: integral of the divergence since the start; 1 where that is wanted


def make_tangent(system: System, motion: Motion, changes: Floats, *, divergence: bool = False) -> Tangent:
    """Allocate the tangent of a run for ``changes`` of its start, shape [change, state + sleeve]."""
    n, n_z = motion.y.size, motion.y.size + system.sleeves.size
    rows = np.ascontiguousarray(changes, dtype=np.float64)
    return Tangent(
        changes=rows,
        rates=np.zeros((len(rows), STAGES, n_z)),
        stage=np.zeros(n_z),
        slopes=make_slopes(system),
        before=make_roster(system, n),
        modes=motion.modes.copy(),
        latch=motion.latch.copy(),
        y=np.zeros(n),
        y_stage=np.zeros(n),
        stages=np.zeros((STAGES, n)),
        jump=np.zeros((2, n)),
        contacts=np.zeros((contact_count(system), CONTACT_COLUMNS)),
        force=np.zeros((system.rotors.size, 3)),
        out=np.zeros(OUT_SIZE),
        traces=np.zeros(STAGES),
        totals=np.array([0.0, 1.0 if divergence else 0.0]),
    )


@compiled_inline
def copy_list(source: Ints, target: Ints) -> None:
    """Copy a list that starts with its length."""
    for c in range(source[0] + 1):
        target[c] = source[c]


@compiled
def read_state(system: System, motion: Motion, y: Floats) -> None:
    """Fill ``y`` with the state now, of those that fly too."""
    for i in range(system.rotors.size):
        state_of(system, motion.roster, i, motion.clock[T], motion.y, y)
    for s in range(6 * system.rotors.size, y.size):  # integrals of servos
        y[s] = motion.y[s]


@compiled
def remember(system: System, motion: Motion, tangent: Tangent) -> None:
    """Note what a step starts from."""
    now, before = motion.roster, tangent.before
    read_state(system, motion, tangent.y)
    for i in range(system.rotors.size):
        before.roles[i] = now.roles[i]
    copy_list(now.active, before.active)
    copy_list(now.states, before.states)
    copy_list(now.sleeves, before.sleeves)
    copy_list(now.meshes, before.meshes)
    for m in range(motion.modes.size):
        tangent.modes[m] = motion.modes[m]
    for k in range(motion.latch.size):
        tangent.latch[k] = motion.latch[k]


@compiled
def retrace(system: System, motion: Motion, tangent: Tangent, t: float, h: float) -> int:
    """Move the changes on by the step of h [s] that was taken at t [s]; return 1 where a pair cannot mesh.

    The step is cut where the changes need it: the slope of a Hertz contact starts like a square root.
    """
    roster, passed, part = tangent.before, 0.0, h
    for c in range(1, roster.meshes[0] + 1):
        know_angles(system, roster.meshes[c], t, tangent.y)
    while roster.active[0] > 0 and passed < h:
        part = min(part, h - passed)
        if try_part(system, tangent, t + passed, part) != 0:
            return 1
        error = change_error(motion, tangent, part)
        if error > 1.0 and part > 1e-9 * h:
            part *= max(0.1, 0.9 * error ** (-1.0 / ORDER))
            continue
        take_part(system, tangent, part)
        passed = h if part >= (h - passed) * (1.0 - 1e-12) else passed + part
        part *= 5.0 if error < 1e-4 else min(5.0, 0.9 * error ** (-1.0 / ORDER))
    for i in range(system.rotors.size):
        if roster.roles[i] == FLYING:
            for c in range(tangent.changes.shape[0]):
                fly_change(system, i, h, tangent.changes[c])
            r = system.rotors[i]
            tangent.totals[0] -= h * (2.0 * r.radial_damping * r.inv_mass + r.drag * r.inv_inertia)
    return 0


@compiled
def try_part(system: System, tangent: Tangent, t: float, h: float) -> int:
    """Evaluate the stages of a part of h [s] of a step, and their slopes; return 1 where a pair cannot mesh."""
    roster, y, y_stage, stages = tangent.before, tangent.y, tangent.y_stage, tangent.stages
    modes, latch, rates = tangent.modes, tangent.latch, tangent.rates
    for s in range(y.size):
        y_stage[s] = y[s]
    for stage in range(STAGES):
        at = t + NODES[stage] * h
        stage_state(roster, stage, h, y, stages, y_stage)
        failed = right_hand_side(
            system,
            roster,
            at,
            y_stage,
            modes,
            latch,
            stages[stage],
            tangent.contacts,
            tangent.force,
            tangent.out,
        )
        if failed != 0 or linearise(system, roster, at, y_stage, modes, latch, tangent.slopes) != 0:
            return 1
        for c in range(tangent.changes.shape[0]):
            advance_stage(tangent, c, stage, h)
            rate_of_change(system, roster, modes, tangent.slopes, tangent.stage, rates[c, stage])
        if tangent.totals[1] == 1.0:
            tangent.traces[stage] = divergence(system, tangent)
    return 0


@compiled_inline
def change_error(motion: Motion, tangent: Tangent, h: float) -> float:
    """Return the largest local error of the changes over its allowance: the run's tolerance times the size of the change."""
    states, worst = tangent.before.states, 0.0
    for c in range(tangent.changes.shape[0]):
        size, error = 0.0, 0.0
        for i in range(motion.natural.size):
            size = max(size, abs(tangent.changes[c, i]) / motion.natural[i])
        for s in range(1, states[0] + 1):
            i = states[s]
            e = 0.0
            for j in range(STAGES):
                e += ERROR[j] * tangent.rates[c, j, i]
            error = max(error, abs(h * e) / motion.natural[i])
        allowed = size * motion.scale[0] / motion.natural[0]
        if error > worst * allowed:
            worst = error / allowed if allowed > 0.0 else 0.0
    return worst


@compiled_inline
def take_part(system: System, tangent: Tangent, h: float) -> None:
    """Make the end of a part of a step the start of the next."""
    states = tangent.before.states
    for s in range(1, states[0] + 1):
        i = states[s]
        tangent.y[i] = tangent.y_stage[i]
        for c in range(tangent.changes.shape[0]):
            total = 0.0
            for j in range(STAGES - 1):
                total += WEIGHTS[STAGES - 1, j] * tangent.rates[c, j, i]
            tangent.changes[c, i] += h * total
    for j in range(STAGES - 1):
        tangent.totals[0] += h * WEIGHTS[STAGES - 1, j] * tangent.traces[j]


@compiled
def divergence(system: System, tangent: Tangent) -> float:
    """Return the divergence [1/s] of the active states' derivative: the trace of its slopes, at a linearised state."""
    total, z, dz, n = 0.0, tangent.stage, tangent.jump[0], system.rotors.size
    for s in range(z.size):
        z[s] = 0.0
    for s in range(1, tangent.before.states[0] + 1):
        i = tangent.before.states[s]
        if i < 3 * n:
            continue  # a position's rate is a velocity
        z[i] = 1.0
        rate_of_change(system, tangent.before, tangent.modes, tangent.slopes, z, dz)
        z[i] = 0.0
        total += dz[i]
    return total


@compiled_inline
def advance_stage(tangent: Tangent, c: int, stage: int, h: float) -> None:
    """Fill ``stage`` with change c at a stage of the step."""
    change, at, states = tangent.changes[c], tangent.stage, tangent.before.states
    for s in range(at.size):
        at[s] = change[s]
    for s in range(1, states[0] + 1):
        i = states[s]
        for j in range(stage):
            at[i] += h * WEIGHTS[stage, j] * tangent.rates[c, j, i]


@compiled
def carry_over(system: System, motion: Motion, tangent: Tangent) -> int:
    """Carry the changes over the event at which the step ended, if there was one; return 1 where a pair cannot mesh."""
    n_s, n_m = system.sleeves.size, system.meshes.size
    t, modes_0, modes = motion.clock[T], tangent.modes, motion.modes
    read_state(system, motion, tangent.y)
    for k in range(n_s):
        if modes_0[k] == OPEN and modes[k] != OPEN:
            latch_change(system, motion, tangent, k, t)
    for j in range(n_m):
        drive, slot = n_s + 2 * j, n_s + 4 * n_m + j
        closed = modes_0[drive] != OPEN or modes_0[drive + 1] != OPEN
        edge = -1  # the flank whose touch or release makes the force jump, 2 for the edge of a square wave
        if is_printed(system, j):
            for flank in range(2):
                if (modes_0[drive + flank] == OPEN) != (modes[drive + flank] == OPEN) and edge < 0:
                    edge = flank
        if system.meshes[j].stiffness_kind == STIFFNESS_SQUARE and closed and modes_0[slot] != modes[slot]:
            edge = 2
        if edge >= 0 and carry_over_jump(system, motion, tangent, j, edge, t) != 0:
            return 1
    return 0


@compiled
def carry_over_jump(system: System, motion: Motion, tangent: Tangent, j: int, edge: int, t: float) -> int:
    """Carry the changes over a jump of mesh j's force at t [s]; return 1 where the pair cannot mesh.

    The instant changes by dt = -dh / h' of the function h that crosses zero: for that long the other derivative holds.
    """
    before, after, row, n_s = tangent.jump[0], tangent.jump[1], tangent.slopes.meshes[j], system.sleeves.size
    drive = n_s + 2 * j
    touching = motion.modes[drive] != OPEN or motion.modes[drive + 1] != OPEN
    roster = motion.roster if touching else tangent.before  # one that holds this mesh's gears
    if (
        rates_at_event(system, tangent, roster, tangent.modes, tangent.latch, t, before) != 0
        or rates_at_event(system, tangent, roster, motion.modes, motion.latch, t, after) != 0
        or linearise_mesh(system, j, t, tangent.y, motion.modes, tangent.contacts, row, tangent.out) != 0
    ):
        return 1
    rate = tangent.out[13] if edge == 2 else tangent.out[2 + edge]
    for c in range(tangent.changes.shape[0]):
        change = tangent.changes[c]
        if edge == 2:
            _, _, _, _, crossing, _ = mesh_changes(system, j, row, change)
        else:
            crossing, _, _, _ = flank_change(system, j, edge, row, change)
        sooner = -crossing / rate
        for s in range(1, roster.states[0] + 1):
            i = roster.states[s]
            change[i] += (before[i] - after[i]) * sooner
    return 0


@compiled
def rates_at_event(
    system: System, tangent: Tangent, roster: Roster, modes: Ints, latch: Floats, t: float, rates: Floats
) -> int:
    """Fill ``rates`` with the derivative of the active states at an event, on given modes; 1 where a pair cannot mesh."""
    for s in range(rates.size):
        rates[s] = 0.0
    return right_hand_side(
        system, roster, t, tangent.y, modes, latch, rates, tangent.contacts, tangent.force, tangent.out
    )


@compiled
def latch_change(system: System, motion: Motion, tangent: Tangent, k: int, t: float) -> None:
    """Set what the changes do to the impact speed that sleeve k has just latched at t [s].

    With the touch at delta = 0 the instant changes by dt = -ddelta / rate, the rate by its own change plus rate' dt.
    """
    n_s = system.sleeves.size
    sleeve, slopes = system.sleeves[k], tangent.slopes
    first = tangent.changes.shape[1] - n_s
    row = slopes.sleeves[k]
    linearise_sleeve(system, k, t, tangent.y, motion.modes, motion.latch, row, tangent.out)
    rate = row[V_U]
    if rate <= sleeve.minimum_speed:  # the floor was latched
        for c in range(tangent.changes.shape[0]):
            tangent.changes[c, first + k] = 0.0
        return
    along = tangent.stage  # the motion itself as a change, at its absolute speeds
    rates_at_event(system, tangent, tangent.before, tangent.modes, tangent.latch, t, tangent.jump[0])
    for s in range(along.size):
        along[s] = 0.0
    j, b = sleeve.journal, sleeve.bush
    move_along(system, tangent, j, along)
    if b >= 0:
        move_along(system, tangent, b, along)
    _, _, _, bend, _ = sleeve_changes(system, k, row, along)
    for c in range(tangent.changes.shape[0]):
        _, _, delta, faster, _ = sleeve_changes(system, k, row, tangent.changes[c])
        tangent.changes[c, first + k] = faster - bend * delta / rate


@compiled_inline
def move_along(system: System, tangent: Tangent, i: int, along: Floats) -> None:
    """Fill rotor i's entries of ``along`` with its velocities and accelerations at the event."""
    n = system.rotors.size
    for c in range(3):
        along[3 * i + c] = tangent.y[3 * (n + i) + c]
    along[3 * i + 2] += system.rotors[i].nominal_speed
    if tangent.before.roles[i] == ACTIVE:
        for c in range(3):
            along[3 * (n + i) + c] = tangent.jump[0, 3 * (n + i) + c]
    elif tangent.before.roles[i] == FLYING:
        a_x, a_y, alpha = flight_rates(
            system, i, tangent.y[3 * (n + i)], tangent.y[3 * (n + i) + 1], tangent.y[3 * (n + i) + 2]
        )
        along[3 * (n + i)], along[3 * (n + i) + 1], along[3 * (n + i) + 2] = a_x, a_y, alpha


@compiled
def advance_tangent(system: System, motion: Motion, tangent: Tangent, steps: int) -> int:
    """Do what `stepper.advance` does, step by step, and move the tangent on with it; return a status."""
    status = advance(system, motion, 0)  # begins
    for _ in range(steps):
        if status != PAUSED or log_is_full(motion):
            break
        t = motion.clock[T]
        remember(system, motion, tangent)
        status = advance(system, motion, 1)
        if status <= PAUSED and (
            retrace(system, motion, tangent, t, motion.clock[T] - t) != 0
            or carry_over(system, motion, tangent) != 0
        ):
            worse = synchronise(system, motion)
            return CANNOT_MESH if worse == DONE else worse
    return status
