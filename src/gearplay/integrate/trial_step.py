"""A step taken on trial, and the evaluation of contacts and switch functions on its interpolant."""

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import propagate_body, propagate_listed
from gearplay.integrate.implicit import COLLOCATED
from gearplay.integrate.implicit_stages import collocate, weigh_inside
from gearplay.integrate.run import CALLS, INSIDE, Run, T
from gearplay.integrate.runge_kutta import KEPT, NODES, STAGES, interpolate_state, step
from gearplay.integrate.switches import switch_value
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import first_axis
from gearplay.kernels.layout import ACTIVE, FREE, Loads, System, members, vx_of, x_of


@compiled_once
def attempt(system: System, run: Run, h: float) -> int:
    """Try a step h [s] of the active rotors into y_new; evaluate the watched contacts at its end; return 0, or 1
    where a pair cannot mesh.
    """
    run.counts[CALLS] += STAGES - 1
    t = run.clock[T]
    run.clock[INSIDE] = NODES[KEPT]
    run.implicit.numbers[COLLOCATED] = 0
    failed = step(
        system, run.active_set, t, h, run.y, run.stages, run.branch, run.y_new, run.loads_inside, run.loads
    )
    return failed if failed != 0 else watch(system, run, t + h, run.y_new, run.loads)


@compiled_once
def watch(system: System, run: Run, t: float, y: Floats, loads: Loads) -> int:
    """Fill the contact table of watched elements and of acting ones with deferred contacts at t [s]; 1 where a pair cannot mesh.

    Those of other acting elements are filled with the forces.
    """
    active_set = run.active_set
    propagate_listed(system, active_set, active_set.near, t, y)
    for c in range(1, active_set.watched[0] + 1):
        if dispatch.contact_kinematics(system, active_set.watched[c], t, y, run.branch, loads) != 0:
            return 1
    for c in range(1, active_set.acting[0] + 1):
        e = active_set.acting[c]
        if (
            system.elements[e].deferred == 1
            and dispatch.contact_kinematics(system, e, t, y, run.branch, loads) != 0
        ):
            return 1
    return 0


@compiled_inline
def state_inside(run: Run, i: int, h: float, x: float) -> float:
    """Return state i at t + x h on the interpolant of the step last tried."""
    if run.implicit.numbers[COLLOCATED] > 0:
        return collocate(run, i, h)
    return interpolate_state(i, x, h, run.y, run.y_new, run.stages)


@compiled_inline
def interpolate_rotor(system: System, run: Run, i: int, h: float, x: float) -> None:
    """Fill rotor i's entries of y_try with its state at t + x h: on the step's interpolant or in closed form."""
    if run.active_set.body_states[i] == FREE:
        propagate_body(system, run.active_set, i, run.clock[T] + x * h, run.y_try)
    elif run.active_set.body_states[i] == ACTIVE:
        for axis in range(first_axis(system, i, run.y), 3):
            place, speed = x_of(i) + axis, vx_of(system, i) + axis
            run.y_try[place] = state_inside(run, place, h, x)
            run.y_try[speed] = state_inside(run, speed, h, x)


@compiled
def interpolate_element(system: System, run: Run, e: int, h: float, x: float) -> None:
    """Fill y_try with the states that element e depends on, at t + x h."""
    if run.implicit.numbers[COLLOCATED] > 0:
        weigh_inside(run.implicit, x)
    a, b, c = members(system, e)
    interpolate_rotor(system, run, a, h, x)
    if b >= 0:
        interpolate_rotor(system, run, b, h, x)
    if c >= 0:
        interpolate_rotor(system, run, c, h, x)
    element = system.elements[e]
    for slot in range(element.state, element.state + element.states):
        run.y_try[slot] = state_inside(run, slot, h, x)


@compiled
def interpolate(run: Run, h: float, x: float) -> None:
    """Fill the active states of y_try with those at t + x h on the interpolant of the step last tried."""
    if x == 0.0:
        for c in range(1, run.active_set.states[0] + 1):
            run.y_try[run.active_set.states[c]] = run.y[run.active_set.states[c]]
        return
    if run.implicit.numbers[COLLOCATED] > 0:
        weigh_inside(run.implicit, x)
    for c in range(1, run.active_set.states[0] + 1):
        s = run.active_set.states[c]
        run.y_try[s] = state_inside(run, s, h, x)


@compiled_once
def evaluate(system: System, run: Run, h: float, x: float, s: int) -> bool:
    """Evaluate switch s and its contact on the step's interpolant at t + x h; False where a pair cannot mesh."""
    t, y, switch = run.clock[T] + x * h, run.y_try, system.switches[s]
    interpolate_element(system, run, switch.element, h, x)
    run.counts[CALLS] += 1
    if (
        switch.contact >= 0
        and dispatch.contact_kinematics(system, switch.element, t, y, run.branch, run.loads_try) != 0
    ):
        return False
    run.g_try[s] = switch_value(system, s, t, y, run.branch, run.loads_try)
    return True
