"""A coupling: a torsional spring and damper between two rotors, rigid in its play (docs/theory, section 4).

With play two contacts, one for each sense of the twist; without play none, and it always acts. So does its lateral part, a
spring and damper between the displacements of the two centres. A spring in stages has a mode, the stage that the twist is in,
and a switch at the ends of the stage.
"""

import math
from typing import Any

import numpy as np

from gearplay.kernels.advancement import RESOLUTION, STAYS_OPEN, TOUCHES, open_span, rotor_bounds
from gearplay.kernels.arrays import Floats, Ints, Rows
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
    PLACES,
    RATE,
    Branch,
    Loads,
    Signal,
    System,
    omega_of,
    spin_of,
    theta_of,
    turn_of,
    vx_of,
    vy_of,
    x_of,
    y_of,
)

KIND = 3
RECORD = np.dtype(
    [
        *PLACES,
        ("stiffness", "f8"),  # N m/rad
        ("damping", "f8"),  # N m s/rad
        ("half_play", "f8"),  # rad
        ("rest", "f8"),  # rad, twist without torque of a spring in stages
        (
            "first_stage",
            "i8",
        ),  # row of the terms: twist [rad], torque [N m], stiffness [N m/rad] from there on
        ("stages", "i8"),  # number of these rows, 0 for a linear spring
        ("ratio", "f8"),  # of phi = theta_a - ratio theta_b
        ("lateral_stiffness", "f8"),  # N/m
        ("lateral_damping", "f8"),  # N s/m
        ("a", "i8"),
        ("b", "i8"),
    ],
    align=True,
)
SIGNALS = (
    Signal("coupling_twist", "phi", "rad", "deg", 180.0 / math.pi, "twist of the coupling", True),
    Signal("coupling_torque", "T", "N m", "N m", 1.0, "torque of the coupling"),
    Signal("coupling_power_loss", "P", "W", "W", 1.0, "power lost in the coupling"),
    Signal(
        "coupling_force_x", "Fx", "N", "N", 1.0, "lateral force on the coupling's first rotor along x", True
    ),
    Signal(
        "coupling_force_y", "Fy", "N", "N", 1.0, "lateral force on the coupling's first rotor along y", True
    ),
)
MEMORY: tuple[float, ...] = ()
MODES = 1  # stage of the spring
PER_CONTACT = 2  # switches: touch, pull
ROUNDING = 2e-15
"""Depth at which a touch is found, over the angles that its twist is a difference of: damping makes a torque jump there."""

STEADY = 0.1
"""Least of the rates of change at the stages of a step, over the largest, that shows that a torque rises or falls all the way."""


def joined_centres(records: Any) -> list[tuple[int, int]]:
    """Return the pairs of rotors between whose centres a force acts."""
    lateral = (records["lateral_stiffness"] > 0.0) | (records["lateral_damping"] > 0.0)
    return [(int(each["a"]), int(each["b"])) for each in records[lateral]]


@compiled_inline
def twist(system: System, n: int, t: float, y: Floats) -> tuple[float, float]:
    """Return phi = theta_a - ratio theta_b [rad], in full angles, and its rate [rad/s]."""
    coupling = system.records[KIND][n]
    a, b = coupling.a, coupling.b
    phi = turn_of(system, a, t, y) - coupling.ratio * turn_of(system, b, t, y)
    return phi, spin_of(system, a, y) - coupling.ratio * spin_of(system, b, y)


@compiled_inline
def _stage(system: System, n: int, phi: float, stage: int) -> tuple[float, float, float]:
    """Return torque [N m] and stiffness [N m/rad] of a stage at twist phi [rad], and the distance [rad] of phi beyond its ends.

    The first and the last stage have one end each.
    """
    coupling, terms = system.records[KIND][n], system.terms
    row, x = coupling.first_stage + stage, phi - coupling.rest
    below = terms[row, 0] - x if stage > 0 else -math.inf
    above = x - terms[row + 1, 0] if stage + 1 < coupling.stages else -math.inf
    return terms[row, 1] + terms[row, 2] * (x - terms[row, 0]), terms[row, 2], max(below, above)


@compiled_inline
def _elastic(system: System, n: int, phi: float, branch: Branch) -> tuple[float, float]:
    """Return torque [N m] and stiffness [N m/rad] of the spring of coupling n without play at twist phi [rad]."""
    coupling = system.records[KIND][n]
    if coupling.stages == 0:
        return coupling.stiffness * phi, coupling.stiffness
    torque, stiffness, _ = _stage(system, n, phi, branch.modes[coupling.mode])
    return torque, stiffness


@compiled_inline
def _torque(system: System, n: int, phi: float, rate: float, branch: Branch, loads: Loads) -> float:
    """Return the torque [N m] that turns phi back."""
    coupling = system.records[KIND][n]
    if coupling.contacts == 0:
        torque, _ = _elastic(system, n, phi, branch)
        return torque + coupling.damping * rate
    return loads.contacts[coupling.contact, FORCE] - loads.contacts[coupling.contact + 1, FORCE]


@compiled_once
def own_switch(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return the distance [rad] of coupling n's twist beyond the ends of its stage; negative within."""
    phi, _ = twist(system, n, t, y)
    _, _, beyond = _stage(system, n, phi, branch.modes[system.records[KIND][n].mode])
    return beyond


@compiled_once
def switch_own(system: System, n: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Change to the adjacent stage at the nearer end of the present one."""
    coupling = system.records[KIND][n]
    phi, _ = twist(system, n, t, y)
    stage = branch.modes[coupling.mode]
    row, x = coupling.first_stage + stage, phi - coupling.rest
    last = stage + 1 == coupling.stages
    upwards = stage == 0 or (not last and x > 0.5 * (system.terms[row, 0] + system.terms[row + 1, 0]))
    branch.modes[coupling.mode] = stage + 1 if upwards else stage - 1


@compiled_once
def initialise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set the stage of coupling n from its twist."""
    coupling = system.records[KIND][n]
    phi, _ = twist(system, n, t, y)
    stage = 0
    while (
        stage + 1 < coupling.stages
        and phi - coupling.rest > system.terms[coupling.first_stage + stage + 1, 0]
    ):
        stage += 1
    branch.modes[coupling.mode] = stage


@compiled_inline
def lateral_force(system: System, n: int, y: Floats) -> tuple[float, float]:
    """Return the lateral force [N] on coupling n's first rotor along x and y, of a state or of a change of it."""
    coupling = system.records[KIND][n]
    a, b, k, c = coupling.a, coupling.b, coupling.lateral_stiffness, coupling.lateral_damping
    return (
        k * (y[x_of(b)] - y[x_of(a)]) + c * (y[vx_of(system, b)] - y[vx_of(system, a)]),
        k * (y[y_of(b)] - y[y_of(a)]) + c * (y[vy_of(system, b)] - y[vy_of(system, a)]),
    )


@compiled_once
def contact_kinematics(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill coupling n's rows of the contact table at (t, y), T = k p + c dp/dt beyond the play; return 0."""
    contacts = loads.contacts
    coupling = system.records[KIND][n]
    phi, rate = twist(system, n, t, y)
    sign = 1.0
    for k in range(coupling.contact, coupling.contact + coupling.contacts):
        p = sign * phi - coupling.half_play
        torque = coupling.stiffness * p + coupling.damping * sign * rate
        contacts[k, PENETRATION], contacts[k, RATE], contacts[k, MARGIN] = p, sign * rate, torque
        contacts[k, FORCE] = torque if branch.modes[k] == LOADED else 0.0
        contacts[k, FORCE_X] = contacts[k, FORCE_Y] = 0.0
        sign = -1.0
    return 0


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add coupling n's torque to the sums on its rotors, its rows of the contact table filled; return 0."""
    coupling, phi, rate = system.records[KIND][n], 0.0, 0.0
    if coupling.contacts > 0:
        contact_kinematics(system, n, t, y, branch, loads)
    else:
        phi, rate = twist(system, n, t, y)
    torque = _torque(system, n, phi, rate, branch, loads)
    loads.rotors[coupling.a, 2] -= torque
    loads.rotors[coupling.b, 2] += coupling.ratio * torque
    if coupling.lateral_stiffness > 0.0 or coupling.lateral_damping > 0.0:
        f_x, f_y = lateral_force(system, n, y)
        loads.rotors[coupling.a, 0] += f_x
        loads.rotors[coupling.a, 1] += f_y
        loads.rotors[coupling.b, 0] -= f_x
        loads.rotors[coupling.b, 1] -= f_y
    return 0


@compiled_inline
def _curvature(system: System, n: int, t: float, y: Floats, branch: Branch) -> float:
    """Return the largest |phi''| [rad/s^2] in free motion."""
    coupling = system.records[KIND][n]
    _, alpha_a, _ = rotor_bounds(system, coupling.a, t, y, branch)
    _, alpha_b, _ = rotor_bounds(system, coupling.b, t, y, branch)
    return alpha_a + abs(coupling.ratio) * alpha_b


@compiled_once
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of coupling n at (t, y) within its play, and a time [s] for which it provably stays there."""
    coupling = system.records[KIND][n]
    half = coupling.half_play
    phi, rate = twist(system, n, t, y)
    if (phi >= half and rate > 0.0) or (-phi >= half and rate < 0.0):
        return TOUCHES, 0.0
    curvature = _curvature(system, n, t, y, branch)
    turns = abs(turn_of(system, coupling.a, t, y)) + abs(coupling.ratio * turn_of(system, coupling.b, t, y))
    slack = min(RESOLUTION * system.contacts[coupling.contact].natural, ROUNDING * (turns + half))
    ahead = open_span(min(phi - half, 0.0) - slack, rate, curvature)
    behind = open_span(min(-phi - half, 0.0) - slack, -rate, curvature)
    return STAYS_OPEN, min(longest, ahead, behind)


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether a pull or the stage's switch of coupling n, not positive at both ends of a step of h [s], may be in between.

    A pull's torque changes by k dp/dt + c d2p/dt2, the twist by its rate; the derivatives in ``stages`` bound these. What rises,
    or falls, at all of them does not return.
    """
    coupling = system.records[KIND][n]
    k, a, b, ratio = coupling.contact + s // PER_CONTACT, coupling.a, coupling.b, coupling.ratio
    at, curvature = coupling.switch + s, 0.0
    nominal = system.rotors[a].nominal_speed - ratio * system.rotors[b].nominal_speed
    lowest, highest = math.inf, -math.inf
    for stage in range(stages.shape[0]):
        rate = nominal + stages[stage, theta_of(a)] - ratio * stages[stage, theta_of(b)]
        alpha = stages[stage, omega_of(system, a)] - ratio * stages[stage, omega_of(system, b)]
        slope = coupling.stiffness * rate + coupling.damping * alpha
        curvature, lowest, highest = max(curvature, abs(alpha)), min(lowest, slope), max(highest, slope)
    if coupling.stages > 0:  # the rate at most, by its mean over the step
        fastest = abs(nominal + stages[0, theta_of(a)] - ratio * stages[0, theta_of(b)])
        return 0.5 * (g_0[at] + g_1[at] + h * (fastest + h * curvature)) > 0.0
    if min(abs(lowest), abs(highest)) > STEADY * max(abs(lowest), abs(highest)) and lowest * highest > 0.0:
        return False
    fastest = max(abs(loads_0.contacts[k, RATE]), abs(loads.contacts[k, RATE])) + 0.5 * h * curvature
    return 0.5 * (g_0[at] + g_1[at] + h * (coupling.stiffness * fastest + coupling.damping * curvature)) > 0.0


@compiled_once
def jump(system: System, n: int, before: Ints, modes: Ints) -> int:
    """Return the touch switch at which coupling n's torque has just jumped to c dp/dt; -1 for none."""
    coupling = system.records[KIND][n]
    if coupling.damping > 0.0:
        for at in range(coupling.contacts):
            if before[coupling.contact + at] == OPEN and modes[coupling.contact + at] != OPEN:
                return PER_CONTACT * at
    return -1


# Columns of a coupling's row of slopes: of its torque by twist and rate, and the rate.
BY_TWIST, BY_RATE, TWIST_RATE = range(3)
SLOPES = 3


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill coupling n's row of slopes at (t, y); return 0."""
    contact_kinematics(system, n, t, y, branch, loads)
    coupling = system.records[KIND][n]
    acts = coupling.contacts == 0
    for k in range(coupling.contact, coupling.contact + coupling.contacts):
        acts = acts or branch.modes[k] == LOADED
    phi, row[TWIST_RATE] = twist(system, n, t, y)
    _, stiffness = _elastic(system, n, phi, branch)
    row[BY_TWIST] = stiffness if acts else 0.0
    row[BY_RATE] = coupling.damping if acts else 0.0
    return 0


@compiled_inline
def _changes(system: System, n: int, z: Floats) -> tuple[float, float]:
    """Return the change of the twist [rad] and of its rate [rad/s] by a change z of the state."""
    coupling = system.records[KIND][n]
    a, b, ratio = coupling.a, coupling.b, coupling.ratio
    spin = z[omega_of(system, a)] - ratio * z[omega_of(system, b)]
    return z[theta_of(a)] - ratio * z[theta_of(b)], spin


@compiled_once
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return the derivatives of the penetration of switch s and of its rate along z, and the rate [rad/s]."""
    phi, rate = _changes(system, n, z)
    sign = 1.0 if s < PER_CONTACT else -1.0
    return sign * phi, sign * rate, sign * row[TWIST_RATE]


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of coupling n's torque by a change z of the state to ``force`` [rotor, (N, N, N m)]."""
    coupling = system.records[KIND][n]
    phi, rate = _changes(system, n, z)
    torque = row[BY_TWIST] * phi + row[BY_RATE] * rate
    force[coupling.a, 2] -= torque
    force[coupling.b, 2] += coupling.ratio * torque
    f_x, f_y = lateral_force(system, n, z)
    force[coupling.a, 0] += f_x
    force[coupling.a, 1] += f_y
    force[coupling.b, 0] -= f_x
    force[coupling.b, 1] -= f_y


@compiled_inline
def _power_loss(
    system: System, n: int, phi: float, rate: float, torque: float, y: Floats, branch: Branch
) -> float:
    """Return the power [W] that coupling n dissipates: that of its torque and force less the rate of its stored energy."""
    coupling = system.records[KIND][n]
    a, b = coupling.a, coupling.b
    elastic = 0.0
    if coupling.contacts == 0:
        elastic, _ = _elastic(system, n, phi, branch)
    for end in range(coupling.contacts):
        if branch.modes[coupling.contact + end] != OPEN:
            elastic += coupling.stiffness * (phi - (1.0 - 2.0 * end) * coupling.half_play)
    v_x = y[vx_of(system, b)] - y[vx_of(system, a)]
    v_y = y[vy_of(system, b)] - y[vy_of(system, a)]
    return (torque - elastic) * rate + coupling.lateral_damping * (v_x * v_x + v_y * v_y)


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill coupling n's signals of a full ``row``; where it acts its rows of the contact table are of (t, y)."""
    at = system.records[KIND][n].signal
    phi, rate = twist(system, n, t, y)
    row[at] = phi
    # One without play transmits torque in free motion, too.
    torque = (
        _torque(system, n, phi, rate, branch, loads)
        if acting or system.records[KIND][n].contacts == 0
        else 0.0
    )
    row[at + 1], row[at + 2] = torque, _power_loss(system, n, phi, rate, torque, y, branch)
    row[at + 3], row[at + 4] = lateral_force(system, n, y)
