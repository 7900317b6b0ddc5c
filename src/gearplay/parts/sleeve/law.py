"""A sleeve: a journal in a bush with radial clearance, on the ground or on another rotor (docs/theory, section 3).

One contact. Where the bush is carried, ``damping`` acts between journal and bush, touching or not.
"""

import math
from typing import Any

from gearplay.kernels.advancement import (
    PASSES,
    RESOLUTION,
    STAYS_OPEN,
    TOUCHES,
    open_span,
    rotor_bounds,
)
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.carrier_motion import add_pair, seat_motion, seat_motion_change
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    FORCE_X,
    FORCE_Y,
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    RATE,
    Branch,
    Loads,
    System,
    impact_speed_at,
    omega_of,
    spin_of,
    theta_of,
)
from gearplay.kernels.sample_block import place_rotor
from gearplay.kernels.smooth_sign import smooth_sign, smooth_sign_slope
from gearplay.parts.mount import Mount, seats
from gearplay.parts.sleeve.force import KIND, RECORD, SIGNALS, sleeve_force, sleeve_force_slopes
from gearplay.parts.sleeve.line import DEEPEST, LINE_JOHNSON

__all__ = ["KIND", "RECORD", "SIGNALS"]
MEMORY: tuple[float, ...] = ()
MODES = 0
PER_CONTACT = 2  # switches: touch, pull

# Slots of the scratch: penetration [m], its rate [m/s], direction u, sliding speed [m/s], the bush's arm on its carrier [m],
# velocity [m/s] of the journal's centre against the bush, its part across u.
DELTA, DELTA_RATE, U_X, U_Y, SLIDING, ARM_X, ARM_Y, V_X, V_Y, ACROSS = range(10)


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] with which off-centre bushes turn in the frames of their journals."""
    return [
        abs(speeds[each.bush] - frames[each.journal])
        for each in system.records[KIND]
        if each.bush >= 0 and math.hypot(each.offset_x, each.offset_y) > 0.0
    ]


def mounts(records: Any) -> list[Mount]:
    """Return the mounting of the journals."""
    return seats(records, "journal", "bush")


@compiled_inline
def contact_arm(sleeve: Any, length: float) -> float:
    """Return the lever arm along u [m] of the contact, on the journal's surface, about the rotor's centre.

    The arm about the centre of the other side is longer by ``length`` = |e|: R and R + |e| of a journal in a bush, -(R + |e|)
    and -R of a bush around a journal. Friction acts at one point, so that angular momentum is kept.
    """
    return -(sleeve.shaft_radius + length) if sleeve.is_bush == 1 else sleeve.shaft_radius


@compiled_inline
def sleeve_geometry(system: System, n: int, t: float, y: Floats, out: Floats) -> None:
    """Fill ``out`` with the kinematics of sleeve n at state y.

    Equations (1), (2): e is the journal's displacement in the bush, delta = |e| - c. A bush on a carrier turns with it.
    """
    sleeve = system.records[KIND][n]
    j = sleeve.journal
    e_x, e_y, v_x, v_y, arm_x, arm_y, _, bush_spin = seat_motion(system, sleeve, j, sleeve.bush, t, y, out)
    length = math.sqrt(e_x * e_x + e_y * e_y)
    u_x, u_y = (e_x / length, e_y / length) if length > 0.0 else (1.0, 0.0)
    out[DELTA] = length - sleeve.clearance
    out[DELTA_RATE] = v_x * u_x + v_y * u_y
    out[U_X], out[U_Y] = u_x, u_y
    out[ARM_X], out[ARM_Y] = arm_x, arm_y
    out[V_X], out[V_Y] = v_x, v_y
    out[ACROSS] = -v_x * u_y + v_y * u_x
    arm = contact_arm(sleeve, length)
    out[SLIDING] = out[ACROSS] + spin_of(system, j, y) * arm - bush_spin * (arm + length)


@compiled_inline
def _press(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Fill sleeve n's row of the contact table as `contact_kinematics`; return the tangential force [N] on the journal."""
    contacts, out = loads.contacts, loads.out
    sleeve = system.records[KIND][n]
    k = sleeve.contact
    sleeve_geometry(system, n, t, y, out)
    delta, rate = out[DELTA], out[DELTA_RATE]
    normal, margin = sleeve_force(sleeve, delta, rate, branch.impact_speeds[sleeve.impact_slot])
    contacts[k, PENETRATION], contacts[k, RATE], contacts[k, MARGIN] = delta, rate, margin
    f_x, f_y, tangential = 0.0, 0.0, 0.0
    if branch.modes[k] == LOADED:
        if sleeve.friction > 0.0:
            tangential = -sleeve.friction * normal * smooth_sign(out[SLIDING] / sleeve.friction_speed)
        f_x = -normal * out[U_X] - tangential * out[U_Y]
        f_y = -normal * out[U_Y] + tangential * out[U_X]
    else:
        normal = 0.0
    if sleeve.damping > 0.0:
        f_x -= sleeve.damping * out[V_X]
        f_y -= sleeve.damping * out[V_Y]
    contacts[k, FORCE], contacts[k, FORCE_X], contacts[k, FORCE_Y] = normal, f_x, f_y
    return tangential


@compiled_inline
def beyond_law(system: System, n: int, loads: Loads) -> int:
    """Return 1 where the journal of sleeve n is pressed deeper than Johnson's law is one-valued, 0 else."""
    sleeve = system.records[KIND][n]
    if sleeve.line != LINE_JOHNSON:
        return 0
    return 1 if loads.contacts[sleeve.contact, PENETRATION] > 4.0 * DEEPEST * sleeve.clearance else 0


@compiled_inline
def contact_kinematics(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill sleeve n's row of the contact table at (t, y); return 1 where Johnson's law has ended, 0 else."""
    _press(system, n, t, y, branch, loads)
    return beyond_law(system, n, loads)


@compiled_inline
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add sleeve n's forces to the sums on its rotors, its row of the contact table filled; return as `contact_kinematics`."""
    tangential = _press(system, n, t, y, branch, loads)
    out, force = loads.out, loads.rotors
    sleeve = system.records[KIND][n]
    k = sleeve.contact
    if branch.modes[k] != LOADED and sleeve.damping == 0.0:
        return beyond_law(system, n, loads)
    f_x, f_y = loads.contacts[k, FORCE_X], loads.contacts[k, FORCE_Y]
    b, length = sleeve.bush, out[DELTA] + sleeve.clearance
    arm = contact_arm(sleeve, length)
    reaction = -(out[ARM_X] * f_y - out[ARM_Y] * f_x) - (arm + length) * tangential
    add_pair(force, sleeve.journal, b, f_x, f_y, arm * tangential, reaction)
    return beyond_law(system, n, loads)


@compiled_once
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of sleeve n's gap at (t, y), and a time [s], at most ``longest``, for which it provably stays open.

    Works on q = |e|^2 - c^2 with q'' <= 2 (v^2 + c a): smooth through the centre, and without forces exact.
    """
    sleeve = system.records[KIND][n]
    sleeve_geometry(system, n, t, y, out)
    delta, rate = out[DELTA], out[DELTA_RATE]
    c = sleeve.clearance
    if delta >= 0.0 and rate > 0.0:
        return TOUCHES, 0.0
    a, _, _ = rotor_bounds(system, sleeve.journal, t, y, branch)
    arm, b_a, b_alpha, b_spin = 0.0, 0.0, 0.0, 0.0
    if sleeve.bush >= 0:
        b_a, b_alpha, b_spin = rotor_bounds(system, sleeve.bush, t, y, branch)
        arm = math.sqrt(sleeve.offset_x * sleeve.offset_x + sleeve.offset_y * sleeve.offset_y)
    speed = math.sqrt(rate * rate + out[ACROSS] * out[ACROSS])
    q, q_rate = min(delta, 0.0) * (delta + 2.0 * c), 2.0 * (delta + c) * rate
    slack = RESOLUTION * system.contacts[sleeve.contact].natural
    over, best = longest, 0.0
    for _ in range(PASSES):
        spin = b_spin + b_alpha * over
        pull = a + b_a + arm * (spin * spin + b_alpha)
        fastest = speed + pull * over
        curvature = 2.0 * (fastest * fastest + c * pull)
        span = open_span(q - 2.0 * slack * c, q_rate, curvature)
        if span >= over:
            return STAYS_OPEN, over
        best = max(best, span)
        over = max(math.sqrt(over * span), span)
    return STAYS_OPEN, best


# Columns of a sleeve's row of slopes: geometry, contact arms about both centres, spins of the rotor and its carrier; force and
# its derivatives by penetration, rate and stored speed; friction.
S_U_X, S_U_Y, INV_L, V_U, V_N, S_ARM_X, S_ARM_Y, LEVER, OTHER_LEVER, OWN_SPIN, SPIN = range(11)
N, N_D, N_R, N_V, DRAG, DRAG_N, DRAG_S, F_X, F_Y = range(11, 20)
SLOPES = 20


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill sleeve n's row of slopes at (t, y), the exact derivative of `apply_forces` on a fixed mode; return 0."""
    _press(system, n, t, y, branch, loads)
    out = loads.out
    sleeve = system.records[KIND][n]
    k = sleeve.contact
    delta, rate, u_x, u_y = out[DELTA], out[DELTA_RATE], out[U_X], out[U_Y]
    length = delta + sleeve.clearance
    row[S_U_X], row[S_U_Y], row[V_U], row[V_N] = u_x, u_y, rate, out[ACROSS]
    row[INV_L] = 1.0 / length if length > 0.0 else 0.0
    row[S_ARM_X], row[S_ARM_Y], row[SPIN] = out[ARM_X], out[ARM_Y], 0.0
    row[LEVER] = contact_arm(sleeve, length)
    row[OTHER_LEVER], row[OWN_SPIN] = row[LEVER] + length, spin_of(system, sleeve.journal, y)
    if sleeve.bush >= 0:
        row[SPIN] = spin_of(system, sleeve.bush, y)
    for c in range(N, SLOPES):
        row[c] = 0.0
    if branch.modes[k] == LOADED:
        v_in = branch.impact_speeds[sleeve.impact_slot]
        row[N] = loads.contacts[k, FORCE]
        row[N_D], row[N_R], row[N_V] = sleeve_force_slopes(sleeve, delta, rate, v_in)
        if sleeve.friction > 0.0:
            u = out[SLIDING] / sleeve.friction_speed
            row[DRAG_N] = -sleeve.friction * smooth_sign(u)
            row[DRAG] = row[DRAG_N] * row[N]
            row[DRAG_S] = -sleeve.friction * row[N] * smooth_sign_slope(u) / sleeve.friction_speed
    row[F_X], row[F_Y] = loads.contacts[k, FORCE_X], loads.contacts[k, FORCE_Y]
    return 0


@compiled_once
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return the derivatives along z of sleeve n's penetration [m] and of its rate [m/s], and the rate."""
    sleeve = system.records[KIND][n]
    arm_x, arm_y = row[S_ARM_X], row[S_ARM_Y]
    e_x, e_y, v_x, v_y = seat_motion_change(system, sleeve.journal, sleeve.bush, z, arm_x, arm_y, row[SPIN])
    u_x, u_y = row[S_U_X], row[S_U_Y]
    turn = (-e_x * u_y + e_y * u_x) * row[INV_L]  # of the direction u [rad]
    return e_x * u_x + e_y * u_y, v_x * u_x + v_y * u_y + row[V_N] * turn, row[V_U]


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of sleeve n's forces by a change z of state and stored speeds to ``force`` [rotor, (N, N, N m)]."""
    sleeve = system.records[KIND][n]
    k = sleeve.contact
    loaded = branch.modes[k] == LOADED
    if not loaded and sleeve.damping == 0.0:
        return
    j, b = sleeve.journal, sleeve.bush
    arm_x, arm_y = row[S_ARM_X], row[S_ARM_Y]
    e_x, e_y, v_x, v_y = seat_motion_change(system, j, b, z, arm_x, arm_y, row[SPIN])
    f_x, f_y, torque, other = 0.0, 0.0, 0.0, 0.0
    if loaded:
        u_x, u_y = row[S_U_X], row[S_U_Y]
        turn = (-e_x * u_y + e_y * u_x) * row[INV_L]
        delta = e_x * u_x + e_y * u_y
        rate = v_x * u_x + v_y * u_y + row[V_N] * turn
        stored = z[impact_speed_at(z, branch.impact_speeds, sleeve.impact_slot)]
        normal = row[N_D] * delta + row[N_R] * rate + row[N_V] * stored
        pull = 0.0
        if sleeve.friction > 0.0:
            # The arms by the length of e.
            longer, other_longer = (-delta, 0.0) if sleeve.is_bush == 1 else (0.0, delta)
            sliding = -v_x * u_y + v_y * u_x - row[V_U] * turn
            sliding += row[LEVER] * z[omega_of(system, j)] + longer * row[OWN_SPIN]
            if b >= 0:
                sliding -= row[OTHER_LEVER] * z[omega_of(system, b)] + other_longer * row[SPIN]
            pull = row[DRAG_N] * normal + row[DRAG_S] * sliding
            torque = row[LEVER] * pull + longer * row[DRAG]
            other = row[OTHER_LEVER] * pull + other_longer * row[DRAG]
        # f = -N u + T n with n across u; dn = -u dswing
        f_x = -normal * u_x - pull * u_y + (row[N] * u_y - row[DRAG] * u_x) * turn
        f_y = -normal * u_y + pull * u_x - (row[N] * u_x + row[DRAG] * u_y) * turn
    if sleeve.damping > 0.0:
        f_x -= sleeve.damping * v_x
        f_y -= sleeve.damping * v_y
    reaction = 0.0
    if b >= 0:
        reaction = -(arm_x * f_y - arm_y * f_x - z[theta_of(b)] * (arm_y * row[F_Y] + arm_x * row[F_X]))
    add_pair(force, j, b, f_x, f_y, torque, reaction - other)


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether switch s of sleeve n, not positive at both ends of a step of h [s], may be so in between.

    The margin 1 + a ddelta/v_in follows the rate, whose bow between the ends shows in how far the journal went: a parabola
    with the ends' rates and their mean stands 3/2 (mean - half their sum) above its chord. Twice that, as no rate is quite a
    parabola; as printed the margin is a force and is evaluated at the ends alone.
    """
    sleeve = system.records[KIND][n]
    k = sleeve.contact
    start, end = loads_0.contacts, loads.contacts
    mean = (end[k, PENETRATION] - start[k, PENETRATION]) / h
    bow = 1.5 * abs(mean - 0.5 * (start[k, RATE] + end[k, RATE]))
    at = sleeve.switch + s
    return (
        max(g_0[at], g_1[at]) + 2.0 * bow * sleeve.dissipation / branch.impact_speeds[sleeve.impact_slot]
        > 0.0
    )


@compiled_inline
def _power_loss(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return the power [W] dissipated in sleeve n: that of its forces less the rate of its stored energy."""
    sleeve = system.records[KIND][n]
    tangential, out, k = _press(system, n, t, y, branch, loads), loads.out, sleeve.contact
    lost = sleeve.damping * (out[V_X] * out[V_X] + out[V_Y] * out[V_Y])
    if branch.modes[k] != OPEN:
        elastic, _ = sleeve_force(sleeve, out[DELTA], 0.0, 1.0)
        lost += (loads.contacts[k, FORCE] - elastic) * out[DELTA_RATE] - tangential * out[SLIDING]
    return lost


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill sleeve n's signals of a full ``row``; where it acts its row of the contact table is of (t, y)."""
    sleeve = system.records[KIND][n]
    at, k = sleeve.signal, sleeve.contact
    if acting:
        row[at] = loads.contacts[k, PENETRATION]
        row[at + 1], row[at + 2] = loads.contacts[k, FORCE_X], loads.contacts[k, FORCE_Y]
        row[at + 3] = _power_loss(system, n, t, y, branch, loads)
        return
    sleeve_geometry(system, n, t, y, loads.out)
    row[at], row[at + 1], row[at + 2], row[at + 3] = loads.out[DELTA], 0.0, 0.0, 0.0


@compiled_once
def show_free(
    system: System, n: int, times: Floats, count: int, free_states: Rows, y: Floats, branch: Branch, scratch_memory: Rows,
    out: Floats, shown: Rows,
) -> bool:  # fmt: skip
    """Fill sleeve n's signals in a block of free motion; return True."""
    sleeve = system.records[KIND][n]
    for s in range(count):
        place_rotor(system, sleeve.journal, free_states, s, y)
        if sleeve.bush >= 0:
            place_rotor(system, sleeve.bush, free_states, s, y)
        sleeve_geometry(system, n, times[s], y, out)
        shown[0, s], shown[1, s], shown[2, s], shown[3, s] = out[DELTA], 0.0, 0.0, 0.0
    return True
