"""Linear system of a case about its equilibrium: coordinates, matrices, elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.linear import strain_energies
from gearplay.kernels.layout import OPEN, OUT_SIZE
from gearplay.linear.condense import Condensed, condense
from gearplay.linear.eigen import FREE_TURNING, Eigen, solve_at_rest, solve_turning
from gearplay.linear.equilibrium import Equilibrium, Linear, find_equilibrium
from gearplay.linear.time_invariant import smooth
from gearplay.model.case import Case
from gearplay.parts.mesh.geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    BY_FRAME,
    N_D_X,
    N_D_Y,
    mesh_geometry,
)
from gearplay.parts.mesh.law.record import BACK, DRIVE
from gearplay.parts.mesh.law.slopes import F_P, F_R, FLANK, FLANK_SLOPES
from gearplay.parts.registry import KINDS, MESH
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]

Shapes = NDArray[np.float64] | NDArray[np.complex128]

AXES = ("x", "y", "theta")


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A case about its equilibrium: M x'' + C x' + K x = f in its free coordinates.

    ``coordinates`` are their names, ``rotor.x`` and so on, shape [coordinate].
    """

    case: Case
    equilibrium: Equilibrium

    @property
    def linear(self) -> Linear:
        """Linear system in the layout of the kernels."""
        return self.equilibrium.linear

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the free coordinates, ``rotor.x``, ``rotor.y`` [m] and ``rotor.theta`` [rad]."""
        names = self.linear.smooth.packed.rotor_names
        return tuple(f"{names[place // 3]}.{AXES[place % 3]}" for place in self.linear.free)

    @cached_property
    def mass(self) -> Floats:
        """Masses and inertias [kg, kg m^2], shape [coordinate]."""
        return self.linear.mass

    @cached_property
    def stiffness(self) -> Floats:
        """K [N/m, N/rad, N m/rad], shape [coordinate, coordinate]."""
        return self.linear.stiffness(self.equilibrium.matrix)

    @cached_property
    def damping(self) -> Floats:
        """Damping matrix C [N s/m, N s, N m s/rad], shape [coordinate, coordinate]."""
        return self.linear.damping(self.equilibrium.matrix)

    @cached_property
    def eigen(self) -> Eigen:
        """Its modes."""
        frames = self.linear.smooth.frames
        if not frames.turning:
            return solve_at_rest(self.mass, self.stiffness, self.damping, self.condensed)
        at = {int(place): k for k, place in enumerate(self.linear.free)}
        turning = np.zeros((len(at), len(at)))
        for place, k in at.items():
            if place % 3 == 0 and place + 1 in at:
                turning[at[place + 1], k] = frames.speeds[place // 3]
                turning[k, at[place + 1]] = -frames.speeds[place // 3]
        return solve_turning(self.mass, self.stiffness, self.damping, turning)

    @cached_property
    def condensed(self) -> Condensed:
        """The system without massless coordinates; raises `InputError` where one of them has no elastic support."""
        found = condense(self.stiffness, self.linear.springs(), self.mass == 0.0)
        if not isinstance(found, int):
            return found
        raise self.linear.unheld(int(self.linear.free[found]))

    @cached_property
    def elements(self) -> tuple[str, ...]:
        """Names of the elements, with their kinds, shape [element]."""
        smooth_case = self.linear.smooth
        counts: dict[str, int] = {}
        found = []
        for kind in self.linear.system.elements["kind"].tolist():
            name = KINDS[kind].name
            place = counts.get(name, 0)
            counts[name] = place + 1
            label = smooth_case.packed.labels.get(name, ())[place] if KINDS[kind].file.SIGNALS else str(place)
            if name == "support" and label in smooth_case.controlled:
                name = "support and servo" if label in self.case.supports else "servo"
            found.append(f"{name} {label}")
        return tuple(found)

    @cached_property
    def strain_shares(self) -> Floats:
        """Shares [1] of the elements in the strain energy of the modes, shape [mode, element]; 0 in free motions.

        Real and imaginary parts of complex shapes count.
        """
        linear, shapes = self.linear, self.eigen.shape
        parts = [shapes.real, shapes.imag] if np.iscomplexobj(shapes) else [shapes]
        total = np.zeros((len(shapes), linear.system.elements.size))
        for part in parts:
            wide = np.zeros((len(shapes), linear.size + linear.branch.impact_speeds.size))
            wide[:, linear.free] = part
            energies = np.zeros_like(total)
            strain_energies(
                linear.system, linear.branch, linear.slopes, wide, np.zeros(wide.shape[1]), energies
            )
            total += energies
        whole = total.sum(axis=1, keepdims=True)
        own = np.abs(shapes) ** 2 @ np.abs(np.diag(self.stiffness))
        strained = np.abs(whole) > FREE_TURNING * own[:, None]
        if len(parts) == 1:  # a frequency at rest is strain, however soft
            strained |= (self.eigen.frequency > 0.0)[:, None] & (whole > 0.0)
        shares: Floats = np.divide(total, whole, out=np.zeros_like(total), where=strained)
        return shares

    def kinetic_shares(self, shapes: Shapes) -> Floats:
        """Return the share [1] of each rotor in the kinetic energy of displacements, shape [mode, rotor]."""
        energy = self.mass * np.abs(shapes) ** 2
        shares = np.zeros((len(shapes), self.linear.rotors))
        for k, place in enumerate(self.linear.free):
            shares[:, place // 3] += energy[:, k]
        shares /= shares.sum(axis=1, keepdims=True)
        return shares

    def line_of_action(self, label: str) -> tuple[Floats, float, float]:
        """Return the input of a unit tooth error of a mesh: its gradient, shape [coordinate], stiffness and damping.

        Of the flank that the load closes: penetration [m] by the coordinates, N/m, N s/m. Raises `InputError` for a mesh that
        there is not, or whose flanks are open.
        """
        linear, labels = self.linear, [mesh.label for mesh in self.case.meshes]
        if label not in labels:
            raise InputError.of("mesh", label, "must be a mesh of the case", f"Meshes: {', '.join(labels)}")
        n = labels.index(label)
        mesh, out = linear.system.records[MESH][n], np.zeros(OUT_SIZE)
        mesh_geometry(linear.system, n, 0.0, self.equilibrium.state, linear.branch.memory, out)
        closed = (
            [DRIVE]
            if n in linear.bilateral
            else [flank for flank in (DRIVE, BACK) if linear.branch.modes[mesh.contact + flank] != OPEN]
        )
        if len(closed) != 1:
            rule = "must have one of its flanks closed by the load, or no backlash"
            raise InputError.of("mesh", label, rule, "Raise the load, or the backlash")
        flank = closed[0]
        row = linear.slopes.elements[mesh.element]
        at, sign = FLANK + FLANK_SLOPES * flank, 1.0 - 2.0 * flank
        n_x, n_y = out[N_D_X + 2 * flank], out[N_D_Y + 2 * flank]
        whole = np.zeros(3 * linear.rotors)
        whole[3 * mesh.b : 3 * mesh.b + 3] += [
            n_x, n_y, sign * mesh.sigma * mesh.rho_b + out[ARM_B_X] * n_y - out[ARM_B_Y] * n_x,
        ]  # fmt: skip
        whole[3 * mesh.a : 3 * mesh.a + 3] += [
            -n_x, -n_y, sign * mesh.sigma * mesh.rho_a - (out[ARM_A_X] * n_y - out[ARM_A_Y] * n_x),
        ]  # fmt: skip
        if mesh.frame >= 0:
            whole[3 * mesh.frame + 2] += sign * out[BY_FRAME]
        return sign * whole[linear.free], float(row[at + F_P]), float(row[at + F_R])


def linear_system(case: Case, *, load: str = "operating", speed: float | None = None) -> LinearSystem:
    """Return a case as a linear system about its equilibrium.

    ``load`` is "operating" or "none"; ``speed`` [rad/s] is that of its leading rotor, None for a train at rest under its load.
    Raises `InputError` for an unknown load, an invalid speed, or a massless rotor without an elastic support,
    `SimulationError` where no equilibrium is found.
    """
    if load not in ("operating", "none"):
        raise InputError.of("load", load, "must be operating or none", "Choose one")
    plain = smooth(case, load=load, speed=speed)
    system = LinearSystem(case, find_equilibrium(Linear(plain)))
    if not np.all(system.mass):
        _ = system.condensed  # refuses what nothing holds
    return system


def places_of(system: LinearSystem, names: Sequence[str]) -> list[int]:
    """Return the places of coordinates; `InputError` for one that is unknown or held."""
    found = []
    for name in names:
        if name not in system.coordinates:
            free = ", ".join(system.coordinates)
            raise InputError.of("force", name, "must be a coordinate that is free to move", f"Free: {free}")
        found.append(system.coordinates.index(name))
    return found
