"""Events of a dented rolling bearing: an element enters or leaves a dent.

Bit d of the bearing's mode is whether an element is in dent d; its switch is the angle beyond the end of the present branch.
"""

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import OPEN, Branch, Loads, System, omega_of, spin_of, theta_of, turn_of
from gearplay.parts.bearing.law.record import KIND, PER_CONTACT
from gearplay.parts.bearing.law.surface import ROWS, beyond_end, passed_dents


@compiled_inline
def relative_turn(system: System, n: int, t: float, y: Floats) -> tuple[float, float]:
    """Return Delta [rad], the rotation of bearing n's rotor relative to its carrier or the ground, and its rate [rad/s]."""
    bearing = system.records[KIND][n]
    turn, spin = turn_of(system, bearing.rotor, t, y), spin_of(system, bearing.rotor, y)
    if bearing.carrier >= 0:
        turn -= turn_of(system, bearing.carrier, t, y)
        spin -= spin_of(system, bearing.carrier, y)
    return turn, spin


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return how far [rad] the nearest element is beyond the end of the dent of switch s that its branch ends at."""
    bearing = system.records[KIND][n]
    d = s - PER_CONTACT * bearing.contacts
    turn, _ = relative_turn(system, n, t, y)
    beyond = beyond_end(bearing, system.terms, d, turn)
    return beyond if (branch.modes[bearing.mode] >> d) & 1 == 1 else -beyond


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Let an element enter the dent of switch s, or leave it."""
    bearing = system.records[KIND][n]
    branch.modes[bearing.mode] ^= 1 << (s - PER_CONTACT * bearing.contacts)


@compiled_once
def initialise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set the mode of bearing n from the state alone."""
    bearing = system.records[KIND][n]
    turn, _ = relative_turn(system, n, t, y)
    branch.modes[bearing.mode] = passed_dents(bearing, system.terms, turn)


@compiled_once
def initialise_touch(
    system: System, n: int, k: int, t: float, y: Floats, branch: Branch, loads: Loads
) -> None:
    """Set the mode with which a touch of contact k begins, where no other element was in contact."""
    bearing = system.records[KIND][n]
    for other in range(bearing.contact, bearing.contact + bearing.contacts):
        if other != k and branch.modes[other] != OPEN:
            return
    initialise(system, n, t, y, branch, loads)


@compiled_inline
def may_pass_dent(
    system: System, n: int, s: int, h: float, branch: Branch, g_0: float, g_1: float, stages: Rows
) -> bool:
    """Return whether the switch s of a dent, not positive at both ends of a step of h [s], may be so in between.

    A dent may be passed as a whole: then the travel covers its arc and the ways to it. Or an element turns round at its end: a
    function with |g''| <= M rises by at most M h^2 / 8 above its ends; twice that, as M is of the stages.
    """
    bearing = system.records[KIND][n]
    d, a, b = s - PER_CONTACT * bearing.contacts, bearing.rotor, bearing.carrier
    row, most, mean = bearing.dents + ROWS * d, 0.0, 0.0
    rate = abs(system.terms[row, 0])
    for stage in range(stages.shape[0]):
        alpha = stages[stage, omega_of(system, a)]
        if b >= 0:
            alpha -= stages[stage, omega_of(system, b)]
        most = max(most, abs(alpha))
    mean = system.rotors[a].nominal_speed + stages[0, theta_of(a)]
    if b >= 0:
        mean -= system.rotors[b].nominal_speed + stages[0, theta_of(b)]
    if max(g_0, g_1) + 0.25 * h * h * rate * most > 0.0:
        return True
    outside = (branch.modes[bearing.mode] >> d) & 1 == 0
    travel = h * rate * (abs(mean) + h * most)
    return bool(outside and g_0 + g_1 + travel > 0.9 * system.terms[row, 2])


@compiled_once
def jump(system: System, n: int, before: Ints, modes: Ints) -> int:
    """Return the switch of the dent at whose end bearing n's force has just jumped; -1 for none."""
    bearing = system.records[KIND][n]
    changed = before[bearing.mode] ^ modes[bearing.mode]
    if bearing.dent_count == 0 or changed == 0:
        return -1
    for k in range(bearing.contact, bearing.contact + bearing.contacts):
        if before[k] != OPEN:
            for d in range(bearing.dent_count):
                if (changed >> d) & 1 == 1:
                    return PER_CONTACT * bearing.contacts + d
    return -1
