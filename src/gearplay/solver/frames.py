"""Frames of rotating carriers, in which a planetary set is periodic with the mesh period.

Rotors that meshes, bushes, supports and bending couplings join belong together. Where they are one coaxial set about one turning
carrier their motion is seen from it: centres and velocities are turned back by the carrier's nominal rotation, so that a motion
that is periodic relative to the carrier is periodic. All other rotors are in fixed axes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import housing_motion
from gearplay.kernels.layout import System
from gearplay.parts.registry import MESH, joined_centres, mounts

Floats = NDArray[np.float64]

COAXIAL = 1e-9
"""Distance [m] of two axes that are one."""


class CarrierFrames:
    """Frames of the rotors of a system.

    ``speeds`` are those of their frames [rad/s], 0 for fixed ones, shape [rotor]; ``arms`` their nominal centres from the axis
    of the frame [m], shape [rotor, 2]; ``breaks`` whether something that turns with no frame acts on a rotor's set:
    gravity, the housing's motion, a support or a bush on the ground that is not alike in all directions, shape [rotor].

    ``hubs`` is the rotor that carries each, -1 for none, ``leads`` the carrier of its coaxial set, or a turning one that
    carries it, shape [rotor]; ``places`` its nominal centre from that of its carrier [m], ``seats`` the centre of its bush or
    support from its nominal centre [m], in axes that turn with the carrier, shape [rotor, 2].
    """

    def __init__(self, system: System) -> None:
        rotors: Any = system.rotors
        n = rotors.size
        self.speeds, self.arms = np.zeros(n), np.zeros((n, 2))
        self.breaks = np.zeros(n, dtype=bool)
        carriers = _carriers(system)
        self.hubs, self.places, self.seats = np.full(n, -1), np.zeros((n, 2)), _seats(system)
        for i, (carrier, place) in carriers.items():
            self.hubs[i], self.places[i] = carrier, place
        turning = np.array(
            [self.hubs[i] >= 0 and rotors[self.hubs[i]].nominal_speed != 0.0 for i in range(n)]
        )
        self.leads = np.where(turning, self.hubs, -1)
        for group in _groups(system, carriers):
            hubs = {carriers[i][0] for i in group if i in carriers}
            if len(hubs) != 1:
                continue
            (carrier,) = hubs
            speed = float(rotors[carrier].nominal_speed)
            arms = {i: np.array(carriers[i][1]) for i in group if i in carriers}
            if carrier in carriers or not _is_coaxial(system, group, arms, carrier):
                continue
            self.leads[list(group)] = carrier
            if speed == 0.0:
                continue
            broken = _is_broken(system, group)
            for i in group:
                self.speeds[i], self.breaks[i] = speed, broken
                self.arms[i] = arms.get(i, np.zeros(2))

    @property
    def turning(self) -> bool:
        """Whether the frame of any rotor is a turning carrier."""
        return bool(np.any(self.speeds))

    def beside_seat(self, i: int, centre: Floats, hub: Floats, angle: Floats) -> Floats:
        """Return the centre of rotor i on a carrier relative to its seat [m], in axes that turn with the carrier, shape [2, ...].

        R(-angle) (P_i + d_i - P_hub - d_hub) - (P_i - P_hub) - seat, with displacements d ``centre`` and ``hub`` [m],
        shape [2, ...], and the carrier's actual rotation ``angle`` [rad].
        """
        lasts = (slice(None), *[None] * np.ndim(angle))
        found: Floats = turned(centre + self.places[i][lasts] - hub, -angle)
        beside: Floats = found - (self.places[i] + self.seats[i])[lasts]
        return beside

    def rate_beside_seat(
        self, i: int, beside: Floats, velocity: Floats, hub: Floats, angle: Floats, speed: Floats
    ) -> Floats:
        """Return the rate [m/s] of ``beside``, the relative centre returned by `beside_seat`.

        From velocities ``velocity`` and ``hub`` [m/s] and the carrier's ``speed`` [rad/s].
        """
        lasts = (slice(None), *[None] * np.ndim(angle))
        x, y = beside + (self.places[i] + self.seats[i])[lasts]
        found: Floats = turned(velocity - hub, -angle) - speed * np.stack([-y, x])
        return found

    def seen(self, t: float, state: Floats) -> Floats:
        """Return a state at t [s] in the frames of the carriers, shape [state]; the state itself where none turns."""
        if not self.turning:
            return state
        found = state.copy()
        self._turn(t, found[None], places=True)
        return found

    def turned_back(self, t: float, changes: Floats) -> Floats:
        """Return small changes of a state at t [s] in the frames of the carriers, shape [change, state + impact speed]."""
        if not self.turning:
            return changes
        found = changes.copy()
        self._turn(t, found, places=False)
        return found

    def _turn(self, t: float, rows: Floats, *, places: bool) -> None:
        n = self.speeds.size
        for i in np.flatnonzero(self.speeds):
            angle = self.speeds[i] * t
            c, s = np.cos(angle), np.sin(angle)
            arm_x, arm_y = self.arms[i] if places else (0.0, 0.0)
            for at, a_x, a_y in ((3 * i, arm_x, arm_y), (3 * (n + i), 0.0, 0.0)):
                x, y = rows[:, at] + a_x, rows[:, at + 1] + a_y
                rows[:, at], rows[:, at + 1] = c * x + s * y - a_x, -s * x + c * y - a_y


def turned(vectors: Floats, angle: Floats) -> Floats:
    """Return vectors, shape [2, ...], turned by angles [rad].

    >>> turned(np.array([1.0, 0.0]), np.array(0.5 * np.pi)).round(12).tolist()
    [0.0, 1.0]
    """
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[0] - s * vectors[1], s * vectors[0] + c * vectors[1]])


def _seats(system: System) -> Floats:
    """Return the seats of rotors from their nominal centres [m], the first of several parts', shape [rotor, 2]."""
    found = np.zeros((system.rotors.size, 2))
    for mount in reversed(list(mounts(system.records))):
        found[mount.rotor] = mount.seat
    return found


def _carriers(system: System) -> dict[int, tuple[int, tuple[float, float]]]:
    """Return the carrier of every carried rotor and the rotor's position on it."""
    return {each.rotor: (each.carrier, each.place) for each in mounts(system.records) if each.carrier >= 0}


def _groups(system: System, carriers: dict[int, tuple[int, tuple[float, float]]]) -> list[set[int]]:
    """Return the rotors that forces on their centres join."""
    n = system.rotors.size
    pairs = [(i, carrier) for i, (carrier, _) in carriers.items()]
    pairs += joined_centres(system.records)
    root = list(range(n))

    def top(i: int) -> int:
        while root[i] != i:
            i = root[i]
        return i

    for i, j in pairs:
        root[top(i)] = top(j)
    groups: dict[int, set[int]] = {}
    for i in range(n):
        groups.setdefault(top(i), set()).add(i)
    return list(groups.values())


def _is_coaxial(system: System, group: set[int], arms: dict[int, Floats], carrier: int) -> bool:
    """Return whether all rotors of a group that are not carried lie on the carrier's axis, according to its meshes."""
    for mesh in system.records[MESH]:
        a, b = int(mesh["a"]), int(mesh["b"])
        if a not in group:
            continue
        if mesh["frame"] != carrier:
            return False
        apart = mesh["A0"] * np.array([mesh["u0_x"], mesh["u0_y"]])
        placed = arms.get(b, np.zeros(2)) - arms.get(a, np.zeros(2))
        if float(np.max(np.abs(apart - placed))) > COAXIAL:
            return False
    return True


def _is_broken(system: System, group: set[int]) -> bool:
    """Return whether something that does not turn with the carrier acts on the centres of a group."""
    rotors: Any = system.rotors
    free = any(rotors[i].inv_mass > 0.0 for i in group)
    if free and (np.any(system.gravity) or system.base[housing_motion.KIND] != housing_motion.NONE):
        return True
    return any(
        each.carrier < 0 and (not each.isotropic or each.seat != (0.0, 0.0))
        for each in mounts(system.records)
        if each.rotor in group
    )
