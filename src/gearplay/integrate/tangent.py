"""The tangent of a run: propagated small changes of its start, exact through contacts and their events.

The run itself is the stepper's, bit for bit. Each of its steps is differentiated: the stages of the method, or the closed form
in free motion. At an event the change is multiplied by its saltation (`saltation`; docs/theory, "Tangent of the motion").
"""

from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import BEGUN, CANNOT_MESH, DONE, ERROR_SHARE, PAUSED, Run, T
from gearplay.integrate.runge_kutta import ERROR, NODES, ORDER, STAGES, WEIGHTS, error_norm, stage_state
from gearplay.integrate.saltation import carry_over, carry_samples
from gearplay.integrate.slopes import linearise, propagate_change, rate_of_change
from gearplay.integrate.stepper import advance, log_is_full, synchronise
from gearplay.integrate.tangent_state import Tangent, remember
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.joined import move_change
from gearplay.kernels.layout import FREE, System, vx_of


@compiled_once
def retrace(system: System, run: Run, tangent: Tangent, t: float, h: float) -> int:
    """Move the changes on by the step of h [s] that was taken at t [s]; return 1 where a pair cannot mesh.

    The step is cut where the changes need it: the slope of a Hertz contact starts like a square root.
    """
    active_set, passed, part = tangent.before, 0.0, h
    for c in range(1, active_set.acting[0] + 1):
        dispatch.start_step(system, active_set.acting[c], t, tangent.y, tangent.branch)
    while active_set.active[0] > 0 and passed < h:
        part = min(part, h - passed)
        if try_part(system, tangent, t + passed, part) != 0:
            return 1
        own = error_norm(active_set, part, tangent.stages, run.scale) / run.clock[ERROR_SHARE]
        error = max(change_error(run, tangent, part), own)
        if error > 1.0 and part > 1e-9 * h:
            part *= max(0.1, 0.9 * error ** (-1.0 / ORDER))
            continue
        take_part(system, tangent, part)
        passed = h if part >= (h - passed) * (1.0 - 1e-12) else passed + part
        part *= 5.0 if error < 1e-4 else min(5.0, 0.9 * error ** (-1.0 / ORDER))
    for i in range(system.rotors.size):
        if active_set.body_states[i] == FREE:
            for c in range(tangent.changes.shape[0]):
                propagate_change(system, i, h, tangent.changes[c])
            r = system.rotors[i]
            tangent.totals[0] -= h * (2.0 * r.radial_damping * r.inv_mass + r.drag * r.inv_inertia)
    for c in range(system.joined.chains.size):
        chain = system.joined.chains[c]
        if active_set.body_states[system.joined.coordinates[chain.first] // 3] == FREE:
            for n in range(tangent.changes.shape[0]):
                move_change(system, c, h, tangent.changes[n], active_set.modal_rates)
            tangent.totals[0] -= h * chain.damping
    return 0


@compiled_once
def try_part(system: System, tangent: Tangent, t: float, h: float) -> int:
    """Evaluate the stages of a part of h [s] of a step, and their slopes; return 1 where a pair cannot mesh."""
    active_set, y, y_stage, stages = tangent.before, tangent.y, tangent.y_stage, tangent.stages
    branch, rates = tangent.branch, tangent.rates
    for s in range(y.size):
        y_stage[s] = y[s]
    for stage in range(STAGES):
        at = t + NODES[stage] * h
        stage_state(stage, active_set, h, y, stages, y_stage)
        failed = rates_of(system, active_set, at, y_stage, branch, stages[stage], tangent.loads)
        if (
            failed != 0
            or linearise(system, active_set, at, y_stage, branch, tangent.slopes, tangent.loads) != 0
        ):
            return 1
        for c in range(tangent.changes.shape[0]):
            advance_stage(tangent, c, stage, h)
            rate_of_change(system, active_set, branch, tangent.slopes, tangent.stage, rates[c, stage])
        if tangent.totals[1] == 1.0:
            tangent.traces[stage] = divergence(system, tangent)
    return 0


@compiled_inline
def change_error(run: Run, tangent: Tangent, h: float) -> float:
    """Return the largest local error of the changes over its allowance: the run's tolerance times the size of the change."""
    states, worst = tangent.before.states, 0.0
    for c in range(tangent.changes.shape[0]):
        size, error = 0.0, 0.0
        for i in range(run.natural.size):
            size = max(size, abs(tangent.changes[c, i]) / run.natural[i])
        for s in range(1, states[0] + 1):
            i = states[s]
            e = 0.0
            for j in range(STAGES):
                e += ERROR[j] * tangent.rates[c, j, i]
            error = max(error, abs(h * e) / run.natural[i])
        allowed = size * run.scale[0] / run.natural[0]
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


@compiled_once
def divergence(system: System, tangent: Tangent) -> float:
    """Return the divergence [1/s] of the active states' derivative: the trace of its slopes, at a linearised state."""
    total, z, dz = 0.0, tangent.stage, tangent.jump[0]
    for s in range(z.size):
        z[s] = 0.0
    for s in range(1, tangent.before.states[0] + 1):
        i = tangent.before.states[s]
        if i < vx_of(system, 0):
            continue  # a position's rate is a velocity
        z[i] = 1.0
        rate_of_change(system, tangent.before, tangent.branch, tangent.slopes, z, dz)
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


@compiled_once
def advance_tangent(system: System, run: Run, tangent: Tangent, steps: int) -> int:
    """Advance as `stepper.advance`, step by step, and propagate the tangent; return a status."""
    begun = run.counts[BEGUN]
    if begun == 0:
        remember(system, run, tangent)
    status = advance(system, run, 0)  # begins
    if begun == 0:
        carry_samples(system, run, tangent)
    for _ in range(steps):
        if status != PAUSED or log_is_full(run):
            break
        t = run.clock[T]
        remember(system, run, tangent)
        status = advance(system, run, 1)
        if status <= PAUSED and (
            retrace(system, run, tangent, t, run.clock[T] - t) != 0 or carry_over(system, run, tangent) != 0
        ):
            worse = synchronise(system, run)
            return CANNOT_MESH if worse == DONE else worse
    return status
