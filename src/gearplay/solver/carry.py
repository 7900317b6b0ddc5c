"""From the end of one run to the start of another: the same mechanism with changed speeds, without a jump of its state."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import DRIVE_SPEED, System
from gearplay.model.pack import Packed

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class End:
    """Where a run ended: the state with absolute angles [rad] and speeds [rad/s], shape [state]; how far the reference of each
    mesh's line of centres has followed an orbiting gear [rad], shape [mesh]; the impact speed that each sleeve has latched
    [m/s], shape [sleeve].
    """

    state: Floats
    turned: Floats
    latch: Floats


def end_of(system: System, y: Floats, latch: Floats, t: float) -> End:
    """Return the end of a run at t [s]: theta = Omega t + theta_relative, omega = Omega + omega_relative."""
    rotors: Any = system.rotors
    meshes: Any = system.meshes
    n, state = rotors.size, y.copy()
    state[2 : 3 * n : 3] += rotors.nominal_speed * t
    state[3 * n + 2 : 6 * n : 3] += rotors.nominal_speed
    return End(state, meshes.turned.copy(), latch[: system.sleeves.size].copy())


def start_from(end: End, packed: Packed) -> Floats:
    """Return the state at t = 0 of a run that goes on from an end; prescribed shafts have their own speed from then on."""
    rotors: Any = packed.system.rotors
    n = rotors.size
    y = end.state.copy()
    y[3 * n + 2 : 6 * n : 3] -= rotors.nominal_speed
    for i in range(n):
        if rotors[i].drive == DRIVE_SPEED:
            own = rotors[i].ramp_start if rotors[i].ramp_time > 0.0 else rotors[i].nominal_speed
            y[3 * (n + i) + 2] = own - rotors[i].nominal_speed
    return y


def follow(system: System, latch: Floats, end: End) -> None:
    """Set the references of a run's own meshes, and the latched speeds, to where they were."""
    latch[: system.sleeves.size] = np.nextafter(
        end.latch, np.inf
    )  # above the floor that means: not latched yet
    meshes: Any = system.meshes
    meshes.turned = end.turned
    meshes.turned_cos, meshes.turned_sin = np.cos(end.turned), np.sin(end.turned)
