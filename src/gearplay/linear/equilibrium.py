"""Static equilibrium under constant loads, and the linearised equations of motion there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from gearplay.integrate.active_set import make_active_set
from gearplay.integrate.linear import matrix_at, rates_at
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.slopes import make_slopes, rate_of_change
from gearplay.integrate.switches import make_branch
from gearplay.kernels.compiled_once import bound
from gearplay.kernels.layout import OPEN
from gearplay.linear.balance import balance
from gearplay.linear.time_invariant import Smooth
from gearplay.model.initial import initial_state
from gearplay.parts.mesh.bilateral import bilateral_meshes, join_flanks
from gearplay.parts.mesh.train import rolling
from gearplay.parts.mesh.train.massless import UNITS
from gearplay.parts.registry import KINDS
from gearplay.parts.sleeve.bilateral import centred_as_springs, linear_bushes
from gearplay.vocabulary.errors import InputError, SimulationError

Floats = NDArray[np.float64]


ROLLING = 1e-9
"""Part of a motion on coordinates with mass that is rounding."""
ROUNDING = 1e-13
"""Stiffness of a direction, per the largest of its element, that is rounding."""


class Linear:
    """Forces and their derivatives of a smooth case at its ``state``, shape [state].

    ``free`` are the places of free positions in the state, shape [coordinate]; ``mass`` their masses [kg, kg m^2], which may be
    0; ``units`` those that turn accelerations of the kernels into forces, 1 where the mass is 0; ``bilateral`` the meshes that
    touch on both flanks without a load, which act on both sides of zero (`bilateral`).
    """

    def __init__(self, smooth: Smooth) -> None:
        self.smooth, self.system = smooth, smooth.packed.system
        rotors: Any = self.system.rotors
        self.rotors, self.size = rotors.size, smooth.packed.state_size
        moves, turns = rotors.inv_mass > 0.0, rotors.inv_inertia > 0.0
        self.free = np.flatnonzero(np.stack([moves, moves, turns], axis=1).ravel())
        with np.errstate(divide="ignore"):
            units = np.stack([1.0 / rotors.inv_mass, 1.0 / rotors.inv_mass, 1.0 / rotors.inv_inertia], axis=1)
        self.units = units.ravel()[self.free]
        given = np.stack([rotors.mass, rotors.mass, rotors.inertia], axis=1).ravel()[self.free]
        self.mass = np.where(given == 0.0, 0.0, self.units)
        self.active_set = make_active_set(self.system, self.size)
        self.branch, self.loads = make_branch(self.system), make_loads(self.system)
        self.slopes = make_slopes(self.system)
        wide = self.size + self.branch.impact_speeds.size
        self.columns, self.scratch = np.zeros((wide, wide)), np.zeros(wide)
        self.rates, self.state = np.zeros(self.size), np.zeros(self.size)
        self._rates_at = bound(
            rates_at, self.system, self.active_set, self.state, self.branch, self.loads, self.rates
        )
        self._matrix_at = bound(
            matrix_at, self.system, self.active_set, self.state, self.branch, self.slopes, self.loads, self.scratch,
            self.columns,
        )  # fmt: skip
        self.riding = np.flatnonzero(smooth.frames.speeds).tolist()
        self.linear_bushes = linear_bushes(self.system)
        self.bilateral: tuple[int, ...] = ()

    def start(self) -> None:
        """Set the nominal positions, with flanks touching."""
        self.state[:] = initial_state(self.smooth.case, self.smooth.packed)
        self.state[3 * self.rotors + 2 : 6 * self.rotors : 3] = 0.0

    def ride(self) -> Floats:
        """Set the centres' velocities to those of steadily rotating carriers; return their accelerations, shape [coordinate]."""
        frames, n, state = self.smooth.frames, self.rotors, self.state
        whole = np.zeros(3 * n)
        for i in self.riding:
            x, y = frames.arms[i] + state[3 * i : 3 * i + 2]
            state[3 * (n + i) : 3 * (n + i) + 2] = frames.speeds[i] * np.array([-y, x])
            whole[3 * i : 3 * i + 2] = -(frames.speeds[i] ** 2) * np.array([x, y])
        return whole[self.free]

    def acting(self, riding: Floats) -> float:
        """Return the scale of the loads [J]: the largest sum of load and inertia force times its coordinate's natural size."""
        rotors: Any = self.system.rotors
        weights = np.abs(self.system.gravity)
        loads = np.stack([rotors.mass * weights[0], rotors.mass * weights[1], np.abs(rotors.torque)], axis=1)
        whole = loads.ravel()[self.free] + self.mass * np.abs(riding)
        return float(np.max(self.smooth.packed.natural[self.free] * whole, initial=0.0))

    def forces(self) -> Floats | None:
        """Return the forces on the free coordinates [N, N m], shape [coordinate]; None where a pair cannot mesh."""
        if self._rates_at() != 0:
            return None
        found: Floats = self.units * self.rates[3 * self.rotors + self.free]
        return found

    def matrix(self) -> Floats:
        """Return the derivative of all rates by all states, shape [state, state]; call `forces` first."""
        self.columns[:] = 0.0
        self._matrix_at()
        rows = self.slopes.elements
        join_flanks(self.system, rows, self.bilateral)
        if centred_as_springs(self.system, rows, self.state, self.linear_bushes) or self.bilateral:
            for column in range(self.size):
                self.scratch[column] = 1.0
                rate_of_change(
                    self.system, self.active_set, self.branch, self.slopes, self.scratch, self.columns[column]
                )
                self.scratch[column] = 0.0
        return self.columns[: self.size, : self.size].T.copy()

    def stiffness(self, matrix: Floats) -> Floats:
        """Return the stiffness matrix of the free coordinates [N/m, N/rad, N m/rad], shape [coordinate, coordinate]."""
        found: Floats = -self.units[:, None] * matrix[np.ix_(3 * self.rotors + self.free, self.free)]
        return found

    def springs(self) -> tuple[Floats, Floats] | None:
        """Return P and N of the stiffness matrix P'P - N'N, shapes [spring, coordinate]; None where it is not symmetric.

        Element by element, so that soft springs keep their digits in the presence of stiff ones; call `matrix` first.
        """
        natural = self.smooth.packed.natural
        pull, push = [np.zeros((0, self.free.size))], [np.zeros((0, self.free.size))]
        at = {int(place): k for k, place in enumerate(self.free)}
        for e, element in enumerate(self.system.elements):
            rotors = sorted({int(element[name]) for name in "abc"} - {-1})
            places = [place for i in rotors for place in range(3 * i, 3 * i + 3) if place in at]
            own = natural[places, None] * self._element_stiffness(e, places) * natural[places]
            if np.abs(own - own.T).max(initial=0.0) > ROUNDING * np.abs(own).max(initial=0.0):
                return None
            columns = np.array([at[place] for place in places], dtype=int)
            count, labels = connected_components(own != 0.0, directed=False)
            for part in range(count):  # springs along and about an axis are uncoupled
                mine = np.flatnonzero(labels == part)
                sizes, ways = np.linalg.eigh(0.5 * (own + own.T)[np.ix_(mine, mine)])
                real = np.abs(sizes) > ROUNDING * np.abs(sizes).max(initial=0.0)
                rows = np.zeros((int(real.sum()), self.free.size))
                rows[:, columns[mine]] = (ways[:, real] * np.sqrt(np.abs(sizes[real]))).T
                rows[:, columns[mine]] /= natural[places][mine]
                pull.append(rows[sizes[real] > 0.0])
                push.append(rows[sizes[real] < 0.0])
        return np.concatenate(pull), np.concatenate(push)

    def _element_stiffness(self, e: int, places: list[int]) -> Floats:
        """Return the stiffness matrix of element e alone, for some entries of the state, shape [entry, entry]."""
        columns = [-self._force_change(e, place).ravel()[places] for place in places]
        return np.reshape(columns, (len(places), len(places))).T

    def _force_change(self, e: int, place: int) -> Floats:
        """Return the forces of element e per unit of an entry of the state, shape [rotor, 3], overwritten by the next call."""
        element, force, z = self.system.elements[e], self.slopes.force, self.scratch
        add_change = KINDS[int(element["kind"])].file.add_change
        force[:] = 0.0
        z[place] = 1.0
        add_change(
            self.system, int(element["index"]), self.slopes.elements[e], z, self.branch, force, self.rates
        )
        z[place] = 0.0
        return force

    def force_rows(self, e: int, rotor: int, axis: int) -> tuple[Floats, Floats]:
        """Return the derivatives of element e's force on an axis of a rotor by free displacements and velocities.

        Shapes [coordinate]; N or N m per m, rad, m/s, rad/s. `matrix` has been there.
        """
        by_place, by_rate = (
            np.array([self._force_change(e, first + int(place))[rotor, axis] for place in self.free])
            for first in (0, 3 * self.rotors)
        )
        return by_place, by_rate

    def damping(self, matrix: Floats) -> Floats:
        """Return the damping matrix of the free coordinates, shape [coordinate, coordinate]."""
        at = 3 * self.rotors + self.free
        found: Floats = -self.units[:, None] * matrix[np.ix_(at, at)]
        return found

    def unheld(self, place: int) -> InputError:
        """Return the error for a massless coordinate without elastic support, by its index in the state."""
        name, field = self.smooth.packed.rotor_names[place // 3], "inertia" if place % 3 == 2 else "mass"
        what = "rotation" if field == "inertia" else "centre"
        rule = (
            f"must be greater than 0 {UNITS[field]} where no coupling, support or closed contact ties the {what} to something "
            "that has mass or is held"
        )
        cure = "Give it one, or a stiffness (a contact is closed by a load, or without a gap)"
        return InputError.of(self.smooth.case.field_path(name, field), 0.0, rule, cure)

    def rolling_motions(self) -> Floats:
        """Return the motions in which every mesh and coupling rolls and no spring is strained, shape [coordinate, motion].

        Centres ride on their carriers.
        """
        turns = rolling.free_turns(self.smooth.case)
        whole = np.zeros((3 * self.rotors, turns.shape[1]))
        whole[2::3] = turns
        for i, on, (x, y) in self.smooth.arms():
            whole[3 * i], whole[3 * i + 1] = -y * turns[on], x * turns[on]
        return whole[self.free]


@dataclass(frozen=True)
class Equilibrium:
    """Static equilibrium under the loads.

    ``state`` is the kernels' state, ``matrix`` the derivative of its rates, shape [state, state]; ``closed`` names
    contacts; ``unbalanced`` is whether drives and loads would accelerate the train.
    """

    linear: Linear
    state: Floats
    matrix: Floats
    closed: tuple[str, ...]
    unbalanced: bool


def find_equilibrium(linear: Linear) -> Equilibrium:
    """Return the equilibrium under the loads, reached from the nominal positions across clearances and backlash (`balance`).

    Where drives and loads do not balance, the train accelerates as one and d'Alembert's forces hold it (inertia relief).

    Raises `SimulationError` where none is found, `InputError` where nothing elastic holds a massless rotor.
    """
    free, mass = linear.free, linear.mass
    state = linear.state
    linear.start()
    riding = linear.ride()
    rolls = linear.rolling_motions()
    weigh = rolls * mass[:, None]
    _, sizes, ways = np.linalg.svd(rolls[mass > 0.0])
    if int(np.sum(sizes > ROLLING)) < rolls.shape[1]:  # something without mass turns, and nothing with it
        raise linear.unheld(int(free[int(np.argmax(np.abs(rolls @ ways[-1])))]))
    project = rolls @ np.linalg.pinv(weigh.T @ rolls) @ weigh.T if rolls.shape[1] else None
    natural = linear.smooth.packed.natural[free]
    across = None
    if project is not None:  # forces and ways but for those of the train as one
        across = np.eye(free.size) - project
    origin = state[free].copy()

    def force(at: Floats) -> Floats | None:
        state[free] = origin + natural * at
        riding = linear.ride()
        found = linear.forces()
        if found is None or not np.isfinite(found).all():
            return None
        left = found - mass * riding
        return natural * (left if across is None else across.T @ left)

    def stiffness() -> Floats:
        matrix = linear.stiffness(linear.matrix())
        if across is not None:
            matrix = across.T @ matrix @ across
        return natural[:, None] * matrix * natural

    first = force(np.zeros(free.size))
    if first is None:
        raise SimulationError("no static equilibrium: a pair cannot mesh where the case places it")
    whole = natural * (linear.units * linear.rates[3 * linear.rotors + free] - mass * riding)
    unbalanced = bool(np.max(np.abs(whole - first), initial=0.0) > 1e-6 * np.max(np.abs(whole), initial=0.0))
    acting = linear.acting(riding) or float(np.max(np.abs(whole), initial=0.0))
    found = balance(force, stiffness, np.zeros(free.size), max(acting, 1e-30))
    assert found is not None, "evaluated before"
    if not found.balances:
        raise SimulationError(
            f"no static equilibrium found: forces on {_worst(linear, np.abs(found.left))} are left over"
        )
    force(found.at)
    linear.bilateral = bilateral_meshes(linear.system, state, linear.branch.memory)
    modes, labels = linear.branch.modes, linear.smooth.packed.contact_labels
    closed = tuple(name for k, name in enumerate(labels) if modes[k] != OPEN)
    return Equilibrium(linear, state.copy(), linear.matrix(), closed, unbalanced)


def _worst(linear: Linear, shares: Floats) -> str:
    return linear.smooth.packed.rotor_names[int(linear.free[int(np.argmax(shares))]) // 3]
