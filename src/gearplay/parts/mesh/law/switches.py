"""Switch functions of a mesh: ends of damping ramps, edges of a square stiffness; bounds of their interior maxima."""

from typing import Any

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    PULL,
    RATE,
    Branch,
    Loads,
    System,
    omega_of,
    vx_of,
    vy_of,
)
from gearplay.parts.mesh.flank import NOT_LOCATED, ON_RAMP, PAST_RAMP, RAMP_CONSTANT, RAMP_SMOOTH
from gearplay.parts.mesh.geometry import (
    is_printed,
    mesh_geometry,
    mesh_phase,
)
from gearplay.parts.mesh.law.friction import (
    change_pair,
    next_pair,
    pair_of,
    sense_of,
    sense_switch,
    switch_sense,
)
from gearplay.parts.mesh.law.record import (
    BACK,
    DRIVE,
    EDGE,
    KIND,
    PER_CONTACT,
)
from gearplay.parts.mesh.pairs.envelope import LAG, deepest_slot, press_envelope
from gearplay.parts.mesh.pairs.friction import SLIDING
from gearplay.parts.mesh.pairs.record import FLANKS, LEAD, PAIR, SEGMENT, SENSE
from gearplay.parts.mesh.tooth_stiffness import (
    STIFFNESS_SQUARE,
    square_edge,
    square_segment,
)


@compiled_inline
def next_pair_switch(mesh: Any) -> int:
    """Return the index of the switch to the next pair of teeth, with an envelope of the drive flank's to its next lead."""
    return EDGE + 1 if mesh.stiffness_kind == STIFFNESS_SQUARE else EDGE


@compiled_inline
def first_sense_switch(mesh: Any) -> int:
    """Return the index of the first of the switches of the contacts' sliding senses."""
    if mesh.pairs > 0 and mesh.envelope == 0:
        return int(PER_CONTACT * mesh.contacts)
    return next_pair_switch(mesh) + (FLANKS if mesh.envelope == 1 else 1)


@compiled_inline
def edges_of(mesh: Any, s: int, modes: Ints) -> tuple[int, float, float]:
    """Return the slot of the mode that switch s of the mesh phase guards, and the phases psi [rad] between which it holds."""
    if s < next_pair_switch(mesh):
        slot = mesh.mode + SEGMENT
        return slot, square_edge(mesh, modes[slot]), square_edge(mesh, modes[slot] + 1)
    slot = mesh.mode + PAIR
    return slot, next_pair(mesh, modes[slot]), next_pair(mesh, modes[slot] + 1)


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return a switch function of mesh n that is neither touch nor pull.

    The end of a flank's damping ramp [m], an edge of the square wave or the hand-over of friction's pair [rad], the overlap of a
    flank's next pair over that of its lead [m], or the edge of the sense of a contact's sliding [m/s].
    """
    modes = branch.modes
    mesh = system.records[KIND][n]
    first = first_sense_switch(mesh)
    if s >= first:
        return sense_switch(mesh, s - first, modes, loads.contacts)
    if mesh.pairs > 0 and mesh.envelope == 0:
        return -1.0
    if mesh.envelope == 1 and s >= next_pair_switch(mesh):
        k = mesh.contact + s - next_pair_switch(mesh)
        return -1.0 if modes[k] == OPEN else loads.contacts[k, LAG]
    if s >= EDGE:
        psi, _ = mesh_phase(mesh, system, t, y)
        _, low, high = edges_of(mesh, s, modes)
        return max(psi - high, low - psi)
    flank = s // PER_CONTACT
    past = modes[mesh.mode + flank]
    if (
        mesh.C_m == 0.0
        or mesh.ramp == RAMP_CONSTANT
        or past == NOT_LOCATED
        or modes[mesh.contact + flank] == OPEN
    ):
        return -1.0
    beyond = loads.contacts[mesh.contact + flank, PENETRATION] - mesh.depth
    return beyond if past == ON_RAMP else -beyond


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Change the mode that switch s of mesh n guards, its rows of the contact table filled."""
    modes = branch.modes
    mesh = system.records[KIND][n]
    first = first_sense_switch(mesh)
    if s >= first:
        switch_sense(mesh, s - first, modes, loads.contacts)
        return
    if mesh.envelope == 1 and s >= next_pair_switch(mesh):
        flank = s - next_pair_switch(mesh)
        find_lead(system, n, flank, modes[mesh.mode + LEAD + flank], t, y, branch, loads)
        return
    if s >= EDGE:
        psi, _ = mesh_phase(mesh, system, t, y)
        slot, low, high = edges_of(mesh, s, modes)
        step = 1 if psi > 0.5 * (low + high) else -1
        if s == next_pair_switch(mesh):
            change_pair(system, n, modes[slot] + step, y, modes, loads.contacts)
        else:
            modes[slot] += step
        return
    slot = mesh.mode + s // PER_CONTACT
    modes[slot] = 1 - modes[slot]


@compiled_once
def find_lead(
    system: System, n: int, flank: int, other: int, t: float, y: Floats, branch: Branch, loads: Loads
) -> None:
    """Let a flank's deepest pair but that in slot ``other`` be its lead, -1 for all; its rows of the contact table follow."""
    mesh = system.records[KIND][n]
    if mesh_geometry(system, n, t, y, branch.memory, loads.out) != 0:
        return
    branch.modes[mesh.mode + LEAD + flank] = deepest_slot(mesh, system, loads.out, flank, other)[0]
    press_envelope(system, n, branch, loads, True)
    if mesh.friction > 0.0:
        sliding = loads.contacts[mesh.contact + flank, SLIDING]
        branch.modes[mesh.mode + SENSE + flank] = sense_of(mesh, sliding)


@compiled_inline
def _settle_phase(system: System, n: int, t: float, y: Floats, modes: Ints, contacts: Rows) -> None:
    """Set the segment of mesh n's square wave, friction's pair and senses from the state; while it is open they are not kept."""
    mesh = system.records[KIND][n]
    if mesh.friction > 0.0 and mesh.envelope == 0:
        psi, _ = mesh_phase(mesh, system, t, y)
        change_pair(system, n, pair_of(mesh, psi), y, modes, contacts)
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        psi, _ = mesh_phase(mesh, system, t, y)
        modes[mesh.mode + SEGMENT] = square_segment(mesh, psi)


@compiled_once
def initialise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set mesh n's own modes from the state alone, its rows of the contact table filled."""
    mesh = system.records[KIND][n]
    if mesh.pairs > 0 and mesh.envelope == 0:
        if mesh.friction > 0.0:
            for c in range(mesh.contacts):
                sliding = loads.contacts[mesh.contact + c, SLIDING]
                branch.modes[mesh.mode + SENSE + c] = sense_of(mesh, sliding)
        return
    depth = mesh.depth
    for flank in range(2):
        if mesh.envelope == 1:
            find_lead(system, n, flank, -1, t, y, branch, loads)
        past = loads.contacts[mesh.contact + flank, PENETRATION] > depth
        branch.modes[mesh.mode + flank] = PAST_RAMP if past else ON_RAMP
    _settle_phase(system, n, t, y, branch.modes, loads.contacts)


@compiled_once
def locate_kinks(system: System, n: int, located: bool, branch: Branch, loads: Loads, g: Floats) -> None:
    """Set modes and switches of the smooth ramps of mesh n's flanks by the penetrations in ``loads``."""
    mesh, modes = system.records[KIND][n], branch.modes
    if mesh.C_m == 0.0 or mesh.ramp != RAMP_SMOOTH or (mesh.pairs > 0 and mesh.envelope == 0):
        return
    for flank in range(2):
        slot, at = mesh.mode + flank, mesh.switch + PER_CONTACT * flank + PER_CONTACT - 1
        modes[slot], g[at] = NOT_LOCATED, -1.0
        if located:
            beyond = loads.contacts[mesh.contact + flank, PENETRATION] - mesh.depth
            modes[slot] = PAST_RAMP if beyond > 0.0 else ON_RAMP
            g[at] = -1.0 if modes[mesh.contact + flank] == OPEN else -abs(beyond)


@compiled_once
def initialise_touch(
    system: System, n: int, k: int, t: float, y: Floats, branch: Branch, loads: Loads
) -> None:
    """Initialise contact k at its onset: ramp and sense, and the values that follow the phase if the mesh was open."""
    mesh = system.records[KIND][n]
    modes = branch.modes
    flank = k - mesh.contact
    if mesh.pairs > 0 and mesh.envelope == 0:
        if mesh.friction > 0.0:
            modes[mesh.mode + SENSE + flank] = sense_of(mesh, loads.contacts[k, SLIDING])
        return
    modes[mesh.mode + flank] = ON_RAMP
    if mesh.envelope == 1:
        find_lead(system, n, flank, -1, t, y, branch, loads)
    if modes[mesh.contact + 1 - flank] == OPEN:
        _settle_phase(system, n, t, y, modes, loads.contacts)
    elif mesh.friction > 0.0 and mesh.envelope == 0:
        modes[mesh.mode + SENSE + flank] = sense_of(mesh, loads.contacts[k, SLIDING])


@compiled_inline
def _ramp_weight(u: float) -> float:
    """Return u (3 - 2 u) of the damping ramp's factor, 0 below its start, 1 beyond its end; it is largest at u = 3/4."""
    return 1.0 if u >= 1.0 else max(u * (3.0 - 2.0 * u), 0.0)


@compiled_inline
def _may_change_pull(mesh: Any, k: int, mode: int, start: Floats, end: Floats) -> bool:
    """Return whether flank contact k, on one mode at both ends of a step, may have let go, or taken hold, in between.

    On the smooth ramp F / p = K - (C / d) u (3 - 2u) |dp/dt|, u = p / d, whose one minimum lies at u = 3/4.
    """
    c = mesh.C_m * mesh.inv_depth
    fastest, slowest = max(-start[k, RATE], -end[k, RATE]), min(-start[k, RATE], -end[k, RATE])
    if mode == LOADED and fastest <= 0.0:
        return False
    u_0, u_1 = start[k, PENETRATION] * mesh.inv_depth, end[k, PENETRATION] * mesh.inv_depth
    # Stiffnesses at both ends, with a half to spare for what changes between them.
    k_0 = start[k, MARGIN] - c * _ramp_weight(u_0) * start[k, RATE]
    k_1 = end[k, MARGIN] - c * _ramp_weight(u_1) * end[k, RATE]
    if mode != LOADED:
        return 1.5 * max(k_0, k_1) > c * slowest * min(_ramp_weight(u_0), _ramp_weight(u_1))
    deepest, slightest = min(max(u_0, u_1), 0.75), max(min(u_0, u_1), 0.0)
    if slightest > 0.75:
        deepest = slightest
    return 0.5 * min(k_0, k_1) < c * fastest * _ramp_weight(deepest)


@compiled_inline
def _phase_curvature(system: System, mesh: Any, stages: Rows) -> float:
    """Return the largest |psi''| [rad/s^2] at the stages of a step."""
    most = 0.0
    for stage in range(stages.shape[0]):
        alpha = stages[stage, omega_of(system, mesh.driver)]
        if mesh.frame >= 0:
            alpha -= stages[stage, omega_of(system, mesh.frame)]
        most = max(most, abs(alpha))
    return mesh.z_driver * most


@compiled_inline
def _may_change_constant(
    system: System,
    mesh: Any,
    s: int,
    k: int,
    h: float,
    start: Floats,
    end: Floats,
    g_0: Floats,
    g_1: Floats,
    stages: Rows,
) -> bool:
    """Return whether the force K p + C dp/dt of flank contact k may change its sign twice within a step of h [s].

    It changes by K dp/dt + C d2p/dt2, with the largest accelerations that the stages show.
    """
    a, b, curvature = mesh.a, mesh.b, 0.0
    for stage in range(stages.shape[0]):
        apart_x = stages[stage, vx_of(system, b)] - stages[stage, vx_of(system, a)]
        apart_y = stages[stage, vy_of(system, b)] - stages[stage, vy_of(system, a)]
        roll = (
            mesh.rho_a * stages[stage, omega_of(system, a)] + mesh.rho_b * stages[stage, omega_of(system, b)]
        )
        curvature = max(curvature, abs(roll) + abs(apart_x) + abs(apart_y))
    curvature += (
        abs(end[k, RATE] - start[k, RATE]) / h
    )  # what errors of the teeth and the turning line of action add
    fastest = max(abs(start[k, RATE]), abs(end[k, RATE])) + 0.5 * h * curvature
    at = mesh.switch + s
    return 0.5 * (g_0[at] + g_1[at] + h * (mesh.k_m * fastest + mesh.C_m * curvature)) > 0.0


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether switch s of mesh n, not positive at both ends of a step of h [s], may be so in between."""
    modes, start, end = branch.modes, loads_0.contacts, loads.contacts
    mesh = system.records[KIND][n]
    at = mesh.switch + s
    if s >= first_sense_switch(mesh) or (mesh.envelope == 1 and s >= next_pair_switch(mesh)):
        return False  # friction and the envelope are continuous there
    if mesh.pairs > 0 and mesh.envelope == 0:
        k = mesh.contact + s // PER_CONTACT
        if s % PER_CONTACT != PULL or s < EDGE or mesh.C_m == 0.0:
            return False
        if mesh.ramp == RAMP_CONSTANT:
            return _may_change_constant(system, mesh, s, k, h, start, end, g_0, g_1, stages)
        return g_0[at] < 0.0 and _may_change_pull(mesh, k, modes[k], start, end)
    if s >= EDGE:
        # A function with |g''| <= M rises by at most M h^2 / 8 above its ends; twice that, as M is of the stages.
        return max(g_0[at], g_1[at]) + 0.25 * h * h * _phase_curvature(system, mesh, stages) > 0.0
    flank, role = s // PER_CONTACT, s % PER_CONTACT
    k = mesh.contact + flank
    past = modes[mesh.mode + flank]
    if role == PULL and mesh.ramp == RAMP_CONSTANT:
        return _may_change_constant(system, mesh, s, k, h, start, end, g_0, g_1, stages)
    if role == PULL:
        smooth = mesh.ramp == RAMP_SMOOTH and past != PAST_RAMP
        return smooth and g_0[at] < 0.0 and _may_change_pull(mesh, k, modes[k], start, end)
    if past == NOT_LOCATED:
        return False
    sign = 1.0 if past == ON_RAMP else -1.0
    rising, falling = sign * start[k, RATE], -sign * end[k, RATE]
    return rising > 0.0 and falling > 0.0 and g_0[at] + rising * h > 0.0 and g_1[at] + falling * h > 0.0


@compiled_inline
def jump_of_pairs(mesh: Any, before: Ints, modes: Ints) -> int:
    """Return the touch switch of a pair of teeth whose force has just jumped, -1 for none.

    With constant damping it jumps at a touch, at a hard end of the path also where contact ends.
    """
    constant = mesh.ramp == RAMP_CONSTANT and mesh.C_m > 0.0
    hard = mesh.corners == 0 and mesh.fades == 0
    for place in range(FLANKS, FLANKS + 2 * mesh.pairs):
        k = mesh.contact + place
        touches = before[k] == OPEN and modes[k] != OPEN
        opens = before[k] != OPEN and modes[k] == OPEN
        if (touches and (constant or hard)) or (opens and hard):
            return int(PER_CONTACT * place)
    return -1


@compiled_once
def jump(system: System, n: int, before: Ints, modes: Ints) -> int:
    """Return the switch at which mesh n's force has just jumped, by its modes before and now; -1 for none."""
    mesh = system.records[KIND][n]
    if mesh.pairs > 0 and mesh.envelope == 0:
        return jump_of_pairs(mesh, before, modes)
    k, found = mesh.contact, -1
    constant = mesh.ramp == RAMP_CONSTANT and mesh.C_m > 0.0
    if is_printed(mesh) or constant:
        for flank in range(2):
            touches = before[k + flank] == OPEN and modes[k + flank] != OPEN
            opens = before[k + flank] != OPEN and modes[k + flank] == OPEN
            # Clipped at zero, a force of constant damping jumps at a touch alone.
            if found < 0 and (touches or (opens and is_printed(mesh))):
                found = PER_CONTACT * flank
    edge = EDGE
    closed = before[k + DRIVE] != OPEN or before[k + BACK] != OPEN
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        if closed and before[mesh.mode + SEGMENT] != modes[mesh.mode + SEGMENT]:
            found = edge
        edge += 1
    if mesh.envelope == 1:
        for flank in range(FLANKS):
            slot, touches = mesh.mode + LEAD + flank, before[k + flank] != OPEN and modes[k + flank] != OPEN
            if touches and before[slot] != modes[slot]:
                found = edge + flank
        return found
    if mesh.friction > 0.0 and closed and before[mesh.mode + PAIR] != modes[mesh.mode + PAIR]:
        found = edge
    return found
