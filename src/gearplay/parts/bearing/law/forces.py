"""Forces of a rolling bearing, the time without touch of its elements, its signals (docs/theory, section 3).

F = K delta^n (1 + chi ddelta/dt) between the rings along the element's direction u. The cage's motion is imposed: with
the torques -F ddelta/dtheta on the rings energy closes; without them (`cage_torque` 0) the cage puts in their power.
"""

import math
from typing import Any

from gearplay.kernels.advancement import PASSES, RESOLUTION, STAYS_OPEN, TOUCHES, open_span, rotor_bounds
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.carrier_motion import add_pair
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
    omega_of,
)
from gearplay.parts.bearing.law.passing import may_pass_dent, relative_turn
from gearplay.parts.bearing.law.record import (
    ACROSS,
    ARM_X,
    ARM_Y,
    BY_A,
    BY_B,
    CAGE,
    CAGE_SPIN,
    DELTA,
    DELTA_RATE,
    DENT,
    DENT_SLOPE,
    DENTED,
    E_X,
    E_Y,
    F_X,
    F_Y,
    KIND,
    LOST,
    PER_CONTACT,
    PUT_IN,
    SPIN_A,
    SPIN_B,
    TORQUE_A,
    TORQUE_B,
    V_X,
    V_Y,
    C,
    S,
    next_element,
    place_element,
    place_seat,
)
from gearplay.parts.bearing.law.surface import BY_PLACE, RING_A, RING_B, ROWS, dent_rate, is_uneven
from gearplay.parts.mount import Mount, seats
from gearplay.parts.sleeve.force import signed_power


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] with which elements pass, and waves of the rings, in the frames of the rotors."""
    rates = []
    for each in system.records[KIND]:
        frame, carrier = frames[each.rotor], speeds[each.carrier] if each.carrier >= 0 else 0.0
        cage = each.share_a * speeds[each.rotor] + each.share_b * carrier
        rates.append(abs(cage - frame) * (1 if is_uneven(each) else int(each.contacts)))
        orders = [(each.waves_a, each.count_a, speeds[each.rotor]), (each.waves_b, each.count_b, carrier)]
        for first, count, speed in orders:
            rates += [order * abs(speed - frame) for order in system.terms[first : first + count, 0]]
        for row in range(each.dents, each.dents + ROWS * each.dent_count, ROWS):
            place = int(system.terms[row + 1, 1])
            carries = {RING_A: speeds[each.rotor], RING_B: carrier}.get(place, cage)
            rates.append(abs(carries - frame))
            if place >= 0:
                rates.append(2.0 * abs(system.terms[row, 0] * (speeds[each.rotor] - carrier)))
    return rates


def mounts(records: Any) -> list[Mount]:
    """Return the mounting of the rotors; the elements, which have no direction of their own, are listed by `recurrence_rates`."""
    return seats(records, "rotor", "carrier")


@compiled_inline
def is_loaded(bearing: Any, branch: Branch) -> bool:
    """Return whether an element of a bearing is in contact."""
    loaded = False
    for k in range(bearing.contact, bearing.contact + bearing.contacts):
        loaded = loaded or branch.modes[k] != OPEN
    return bool(loaded)


@compiled_inline
def dents_inside(bearing: Any, branch: Branch) -> int:
    """Return the dents passed on the present branch: by place where all elements are open, since no event is located then."""
    if bearing.dent_count == 0 or not is_loaded(bearing, branch):
        return BY_PLACE
    return int(branch.modes[bearing.mode])


@compiled_inline
def press(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Fill bearing n's rows of the contact table at (t, y), and the sums over its elements in the scratch."""
    contacts, out = loads.contacts, loads.out
    bearing = system.records[KIND][n]
    place_seat(system, n, t, y, out)
    f_x, f_y, torque_a, torque_b, lost, put_in = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    inside = dents_inside(bearing, branch)
    for at in range(bearing.contacts):
        next_element(bearing, system.terms, at, out)
        place_element(system, n, at, inside, out)
        k = bearing.contact + at
        delta, rate = out[DELTA], out[DELTA_RATE]
        margin = 1.0 + bearing.dissipation * rate
        contacts[k, PENETRATION], contacts[k, RATE], contacts[k, MARGIN] = delta, rate, margin
        contacts[k, FORCE] = contacts[k, FORCE_X] = contacts[k, FORCE_Y] = 0.0
        if branch.modes[k] != LOADED:
            continue
        elastic = bearing.stiffness * signed_power(delta, bearing.exponent)
        force = elastic * margin
        contacts[k, FORCE] = force
        contacts[k, FORCE_X], contacts[k, FORCE_Y] = -force * out[C], -force * out[S]
        f_x -= force * out[C]
        f_y -= force * out[S]
        lost += elastic * bearing.dissipation * rate * rate
        if bearing.cage_torque == 1:
            torque_a -= force * out[BY_A]
            torque_b -= force * out[BY_B]
        else:  # the carrier takes the force at the rotor's centre
            torque_b -= force * out[ACROSS]
            put_in += force * (out[BY_A] * out[SPIN_A] + (out[BY_B] - out[ACROSS]) * out[SPIN_B])
    if bearing.damping > 0.0:
        f_x -= bearing.damping * out[V_X]
        f_y -= bearing.damping * out[V_Y]
        lost += bearing.damping * (out[V_X] * out[V_X] + out[V_Y] * out[V_Y])
    out[F_X], out[F_Y], out[TORQUE_A], out[TORQUE_B] = f_x, f_y, torque_a, torque_b
    out[LOST], out[PUT_IN] = lost, put_in


@compiled_once
def contact_kinematics(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill bearing n's rows of the contact table at (t, y); return 0."""
    press(system, n, t, y, branch, loads)
    return 0


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add bearing n's forces to the sums on its rotors, its rows of the contact table filled; return 0."""
    press(system, n, t, y, branch, loads)
    out, bearing = loads.out, system.records[KIND][n]
    reaction = out[TORQUE_B] - out[ARM_X] * out[F_Y] + out[ARM_Y] * out[F_X]
    add_pair(loads.rotors, bearing.rotor, bearing.carrier, out[F_X], out[F_Y], out[TORQUE_A], reaction)
    return 0


@compiled_once
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of bearing n's gaps at (t, y), and a time [s], at most ``longest``, for which all provably stay open.

    With delta = e.u(phi) - c + w,  delta'' = e''.u + 2 e'.u_phi phi' + e.u_phi phi'' - e.u phi'^2 + w'': each factor is bounded
    over the time considered by its value now and the bounds of the accelerations. A dent lowers delta: it stays below that of
    the whole surface; and, from within the dent, below that of the dent without ends, until its next arc could begin.
    """
    bearing = system.records[KIND][n]
    place_seat(system, n, t, y, out)
    a, alpha_a, _ = rotor_bounds(system, bearing.rotor, t, y, branch)
    arm, b_a, alpha_b, spin_b = 0.0, 0.0, 0.0, 0.0
    if bearing.carrier >= 0:
        b_a, alpha_b, spin_b = rotor_bounds(system, bearing.carrier, t, y, branch)
        arm = math.sqrt(bearing.offset_x * bearing.offset_x + bearing.offset_y * bearing.offset_y)
    reach, speed = math.hypot(out[E_X], out[E_Y]), math.hypot(out[V_X], out[V_Y])
    alpha = bearing.share_a * alpha_a + bearing.share_b * alpha_b
    beside_a, beside_b = abs(out[CAGE_SPIN] - out[SPIN_A]), abs(out[CAGE_SPIN] - out[SPIN_B])
    rolling = out[SPIN_A] - out[SPIN_B]
    slack = RESOLUTION * system.contacts[bearing.contact].natural
    over, best = longest, 0.0
    for turn in range(PASSES):
        spin = spin_b + alpha_b * over
        pull = a + b_a + arm * (spin * spin + alpha_b)
        fastest = speed + pull * over
        farthest = reach + fastest * over
        cage = abs(out[CAGE_SPIN]) + alpha * over
        past_a, past_b = beside_a + (alpha + alpha_a) * over, beside_b + (alpha + alpha_b) * over
        curvature = pull + 2.0 * fastest * cage + farthest * (cage * cage + alpha)
        curvature += bearing.bend_a * past_a * past_a + bearing.slope_a * (alpha + alpha_a)
        curvature += bearing.bend_b * past_b * past_b + bearing.slope_b * (alpha + alpha_b)
        past = abs(rolling) + (alpha_a + alpha_b) * over
        within = curvature + bearing.dent_bend * past * past + bearing.dent_slope * (alpha_a + alpha_b)
        span = over
        out[C], out[S] = math.cos(out[CAGE]), math.sin(out[CAGE])
        for at in range(bearing.contacts):
            next_element(bearing, system.terms, at, out)
            place_element(system, n, at, BY_PLACE, out)
            if turn == 0 and out[DELTA] >= 0.0 and out[DELTA_RATE] > 0.0:
                return TOUCHES, 0.0
            if out[DENTED] == 0.0:
                span = min(span, open_span(min(out[DELTA], 0.0) - slack, out[DELTA_RATE], curvature))
                continue
            whole, rate = out[DELTA] - out[DENT], out[DELTA_RATE] - out[DENT_SLOPE] * rolling
            of_whole = open_span(whole, rate, curvature) if whole < 0.0 else 0.0
            of_dent = open_span(min(out[DELTA], 0.0) - slack, out[DELTA_RATE], within)
            if past > 0.0:
                of_dent = min(of_dent, bearing.dent_travel / past)
            span = min(span, max(of_whole, of_dent))
        if span >= over:
            return STAYS_OPEN, over
        best = max(best, span)
        over = max(math.sqrt(over * span), span)
    return STAYS_OPEN, best


@compiled_inline
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] with which elements and waves of bearing n force it."""
    bearing = system.records[KIND][n]
    i, b = bearing.rotor, bearing.carrier
    spin_a = abs(system.rotors[i].nominal_speed + y[omega_of(system, i)])
    spin_b = abs(system.rotors[b].nominal_speed + y[omega_of(system, b)]) if b >= 0 else 0.0
    relative = spin_a + spin_b
    fastest = max(2.0, bearing.highest_a, bearing.highest_b) * relative
    if bearing.dent_count > 0:
        turn, spin = relative_turn(system, n, t, y)
        fastest = max(fastest, dent_rate(bearing, system.terms, turn, spin))
    return fastest


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether the pull s of bearing n, not positive at both ends of a step of h [s], may be so in between.

    The margin 1 + chi ddelta/dt follows the rate, whose bow shows in the way of the penetration: as for sleeves.
    """
    bearing = system.records[KIND][n]
    at = bearing.switch + s
    if s >= PER_CONTACT * bearing.contacts:
        return may_pass_dent(system, n, s, h, branch, g_0[at], g_1[at], stages)
    k = bearing.contact + s // PER_CONTACT
    start, end = loads_0.contacts, loads.contacts
    mean = (end[k, PENETRATION] - start[k, PENETRATION]) / h
    bow = 1.5 * abs(mean - 0.5 * (start[k, RATE] + end[k, RATE]))
    return max(g_0[at], g_1[at]) + 2.0 * bow * bearing.dissipation > 0.0


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill bearing n's signals of a full ``row`` at (t, y)."""
    bearing, out = system.records[KIND][n], loads.out
    at = bearing.signal
    if not acting:
        for c in range(6):
            row[at + c] = 0.0
        return
    press(system, n, t, y, branch, loads)
    largest = 0.0
    for k in range(bearing.contact, bearing.contact + bearing.contacts):
        largest = max(largest, loads.contacts[k, FORCE])
    row[at], row[at + 1], row[at + 2], row[at + 3] = out[F_X], out[F_Y], out[TORQUE_A], largest
    row[at + 4], row[at + 5] = out[LOST], out[PUT_IN]
