"""Shafts in a rolling bearing, their static equilibrium by the packed law, and published trajectories."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from building import Document, Floats, case_of
from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.slopes import make_slopes
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import FORCE, LOADED, OPEN, PENETRATION
from gearplay.linear.balance import balance
from gearplay.model.pack import pack

BALLS: Document = {
    "rolling_elements": 8,
    "element_diameter": 7.9375e-3,
    "pitch_diameter": 33.5026e-3,
    "stiffness": 1.334e10,
}
"""The bearing of the specification's tables."""


def shaft(bearing: Document, *, weight: float = 0.0, mass: float = 2.0, **rotor: Any) -> Document:
    """Return a shaft at rest in a bearing, its weight [N] along -y."""
    held = {"drive": {"kind": "speed", "speed": 0.0}} | rotor
    return {
        "gravity": [0.0, -weight / mass],
        "rotors": {"shaft": {"mass": mass, "inertia": 1e-3, **held}},
        "bearings": {"shaft": bearing},
        "run": {"duration": 0.01, "sampling": 1e5},
    }


class Law:
    """The packed law of one bearing."""

    def __init__(self, bearing: Document, faults: Sequence[Document] = ()) -> None:
        self.packed = pack(case_of(shaft(bearing) | {"faults": list(faults)}))
        self.system = self.packed.system
        self.branch, self.loads = make_branch(self.system), make_loads(self.system)
        self.y = np.zeros(self.packed.state_size)

    def force(self, x: float, y: float) -> Floats:
        """Return the force on the shaft [N] at a displacement [m]."""
        self.y[:2] = x, y
        dispatch.contact_kinematics(self.system, 0, 0.0, self.y, self.branch, self.loads)
        count = self.system.contacts.size
        self.branch.modes[:count] = np.where(self.loads.contacts[:, PENETRATION] > 0.0, LOADED, OPEN)
        dispatch.initialise(self.system, 0, 0.0, self.y, self.branch, self.loads)
        self.loads.rotors[:] = 0.0
        acting = np.array([1, 0], dtype=np.int64)
        dispatch.apply_forces(
            self.system, acting, 0.0, self.y, self.branch, self.loads, np.zeros(self.y.size)
        )
        found: Floats = self.loads.rotors[0, :2].copy()
        return found

    def displacement(self, weight: float, start: float) -> Floats:
        """Return the displacement [m] under a weight [N] along -y."""
        scale, at = 1e-6, np.zeros(2)

        def force(z: Floats) -> Floats:
            at[:] = scale * z
            return scale * (self.force(*at) - [0.0, weight])

        found = balance(
            force,
            lambda: scale * scale * self.stiffness(*at),
            np.array([0.0, -start / scale]),
            scale * weight,
        )
        assert found is not None
        assert found.balances
        place: Floats = scale * found.at
        for _ in range(3):
            left = self.force(*place) - [0.0, weight]
            place = place + np.linalg.lstsq(self.stiffness(*place), left, rcond=1e-9)[0]
        return place

    def stiffness(self, x: float, y: float) -> Floats:
        """Return minus the derivative of the force by the displacement [N/m], shape [2, 2]."""
        self.force(x, y)
        slopes, force = make_slopes(self.system), np.zeros((1, 3))
        dispatch.linearise(self.system, 0, 0.0, self.y, self.branch, self.loads, slopes.elements[0])
        found = np.zeros((2, 2))
        for axis in range(2):
            z, force[:] = np.zeros(self.y.size), 0.0
            z[axis] = 1.0
            dispatch.add_change(self.system, 0, slopes.elements[0], z, self.branch, force, np.zeros(z.size))
            found[:, axis] = -force[0, :2]
        return found

    def loads_of_elements(self) -> Floats:
        """Return the loads of the elements [N], largest first, as last evaluated."""
        found: Floats = np.sort(self.loads.contacts[:, FORCE])[::-1]
        return found


def under(bearing: Document, angle: float) -> Document:
    """Return a bearing whose element 0 is an angle [rad] from the load line, which points along -y."""
    return bearing | {"cage_phase": -0.5 * math.pi + angle}
