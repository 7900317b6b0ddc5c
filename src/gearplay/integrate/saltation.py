"""Saltation of small changes of the state at an event, and of stored impact speeds.

A change of the instant of an event, dt = -dh / h' of the function h that crosses zero, lets the other derivative hold for that
long (docs/theory, T24).
"""

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import ActiveSet
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import Run, T
from gearplay.integrate.tangent_state import Tangent, read_state
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import shaken_rates
from gearplay.kernels.joined import acceleration
from gearplay.kernels.layout import (
    ACTIVE,
    FREE,
    OPEN,
    TOUCH,
    Branch,
    System,
    impact_speed_at,
    is_acting,
    members,
    omega_of,
    theta_of,
    vx_of,
    vy_of,
    x_of,
)


@compiled_once
def carry_over(system: System, run: Run, tangent: Tangent) -> int:
    """Carry the changes over the event at which the step ended, if there was one; return 1 where a pair cannot mesh."""
    t, before, modes = run.clock[T], tangent.branch.modes, run.branch.modes
    read_state(system, run, tangent.y)
    for s in range(system.switches.size):
        k = system.switches[s].contact
        stores = system.switches[s].role == TOUCH and system.contacts[k].impact_slot >= 0
        if stores and before[k] == OPEN and modes[k] != OPEN:
            change_impact_speed(system, run, tangent, s, t)
    carry_samples(system, run, tangent)
    for e in range(system.elements.size):
        s = dispatch.jump(system, e, before, modes)
        if s >= 0 and carry_over_jump(system, run, tangent, e, s, t) != 0:
            return 1
    return 0


@compiled_once
def carry_samples(system: System, run: Run, tangent: Tangent) -> None:
    """Carry the changes over samples that controls have just taken: these come at fixed times."""
    for e in range(system.elements.size):
        for c in range(tangent.changes.shape[0]):
            dispatch.carry_sample(system, e, tangent.branch.memory, run.branch, tangent.changes[c])


@compiled_once
def carry_over_jump(system: System, run: Run, tangent: Tangent, e: int, s: int, t: float) -> int:
    """Carry the changes over a jump of element e's force at its switch s, at t [s]; return 1 where the pair cannot mesh."""
    before, after, row = tangent.jump[0], tangent.jump[1], tangent.slopes.elements[e]
    acts = is_acting(system, e, run.branch.modes)
    active_set = run.active_set if acts else tangent.before  # one that holds this element's rotors
    if (
        rates_at_event(system, tangent, active_set, tangent.branch, t, before) != 0
        or rates_at_event(system, tangent, active_set, run.branch, t, after) != 0
        or dispatch.linearise(system, e, t, tangent.y, run.branch, tangent.loads, row) != 0
    ):
        return 1
    for c in range(tangent.changes.shape[0]):
        change = tangent.changes[c]
        crossing, _, rate = dispatch.crossing(system, e, s, row, change)
        sooner = -crossing / rate
        for place in range(1, active_set.states[0] + 1):
            i = active_set.states[place]
            change[i] += (before[i] - after[i]) * sooner
    return 0


@compiled_once
def rates_at_event(
    system: System, tangent: Tangent, active_set: ActiveSet, branch: Branch, t: float, rates: Floats
) -> int:
    """Fill ``rates`` with the derivative of the active states at an event, on a given branch; 1 where a pair cannot mesh."""
    for s in range(rates.size):
        rates[s] = 0.0
    return rates_of(system, active_set, t, tangent.y, branch, rates, tangent.loads)


@compiled_once
def change_impact_speed(system: System, run: Run, tangent: Tangent, s: int, t: float) -> None:
    """Set the first-order change of the impact speed just stored at t [s] by the contact of touch switch s.

    With the touch at zero penetration the instant changes by dt = -dp / p', the rate by its own change plus p'' dt.
    """
    e, local = system.switches[s].element, system.switches[s].local
    contact, row = system.contacts[system.switches[s].contact], tangent.slopes.elements[e]
    slot = impact_speed_at(tangent.stage, run.branch.impact_speeds, contact.impact_slot)
    dispatch.linearise(system, e, t, tangent.y, run.branch, tangent.loads, row)
    along = tangent.stage  # the motion itself as a change, at its absolute speeds
    rates_at_event(system, tangent, tangent.before, tangent.branch, t, tangent.jump[0])
    for c in range(along.size):
        along[c] = 0.0
    for i in members(system, e):
        if i >= 0:
            move_along(system, tangent, i, t, along)
    _, curvature, rate = dispatch.crossing(system, e, local, row, along)
    for c in range(tangent.changes.shape[0]):
        deeper, faster, _ = dispatch.crossing(system, e, local, row, tangent.changes[c])
        # a stored floor does not change
        tangent.changes[c, slot] = faster - curvature * deeper / rate if rate > contact.floor else 0.0


@compiled_inline
def move_along(system: System, tangent: Tangent, i: int, t: float, along: Floats) -> None:
    """Fill rotor i's entries of ``along`` with its velocities and accelerations at the event, at t [s]."""
    y, x, vx = tangent.y, x_of(i), vx_of(system, i)
    for axis in range(3):
        along[x + axis] = y[vx + axis]
    along[theta_of(i)] += system.rotors[i].nominal_speed
    if tangent.before.body_states[i] == ACTIVE:
        for axis in range(3):
            along[vx + axis] = tangent.jump[0, vx + axis]
    elif tangent.before.body_states[i] == FREE:
        a_x, a_y, alpha = shaken_rates(system, i, t, y[vx], y[vy_of(system, i)], y[omega_of(system, i)])
        along[vx], along[vy_of(system, i)], along[omega_of(system, i)] = a_x, a_y, alpha
        for axis in range(3):
            c, k = system.joined.places[2 * (x + axis)], system.joined.places[2 * (x + axis) + 1]
            if c >= 0:
                along[vx + axis] = acceleration(system, c, k, y, 1.0)
