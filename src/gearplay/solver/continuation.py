"""Continuation: the end of one run as the start of another with changed speeds, without a jump of the state."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import DRIVE_SPEED, System, omega_of
from gearplay.model.pack import Packed
from gearplay.solver.integration import Course

Floats = NDArray[np.float64]


class End(NamedTuple):
    """Final state of a run: the state with absolute angles [rad] and speeds [rad/s], shape [state]; the memory of each element,
    as how far a line of centres has followed an orbiting gear, shape [element, memory]; the stored impact speeds [m/s], shape
    [impact speed].
    """

    state: Floats
    memory: Floats
    impact_speeds: Floats


def end_of(system: System, t: float, y: Floats, memory: Floats, impact_speeds: Floats) -> End:
    """Return the end of a run at t [s] in state y: theta = Omega t + theta_relative, omega = Omega + omega_relative."""
    speeds = system.rotors["nominal_speed"]
    n, state = speeds.size, y.copy()
    state[2 : 3 * n : 3] += speeds * t
    state[3 * n + 2 : 6 * n : 3] += speeds
    return End(state, memory.copy(), impact_speeds.copy())


def start_from(end: End, packed: Packed) -> Floats:
    """Return the state at t = 0 of a run that continues from an end; prescribed shafts have their own speed from then on."""
    rotors: Any = packed.system.rotors
    n = rotors.size
    y = end.state.copy()
    y[3 * n + 2 : 6 * n : 3] -= rotors.nominal_speed
    for i in np.flatnonzero(rotors.drive == DRIVE_SPEED).tolist():
        y[omega_of(packed.system, i)] = 0.0
    ramp_speeds(y, packed)
    return y


def ramp_speeds(y: Floats, packed: Packed) -> None:
    """Set the speeds of prescribed shafts with a ramp in a state at t = 0, relative to the nominal ones, to its start."""
    rotors: Any = packed.system.rotors
    for i in np.flatnonzero((rotors.drive == DRIVE_SPEED) & (rotors.ramp_time > 0.0)).tolist():
        y[omega_of(packed.system, i)] = rotors[i].ramp_start - rotors[i].nominal_speed


def go_on_from(course: Course, end: End) -> None:
    """Transfer the elements' memory and the stored impact speeds of the previous run to a run that has not begun."""
    course.run.branch.memory[:] = end.memory
    course.set_impact_speeds(end.impact_speeds)
