"""Equilibria of a held train under a torque, one after another: contacts, springs and Coulomb friction of its rotors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.held import Held
from gearplay.linear.balance import balance
from gearplay.linear.equilibrium import Linear
from gearplay.vocabulary.errors import SimulationError

Floats = NDArray[np.float64]

ROUNDS = 60
"""Most changes between sticking and slipping at one torque."""
RESOLVED = 1e-3
"""Part of the torque that may be left over."""
BEYOND = 1e-9
"""Part of a friction torque by which a reaction may exceed it, and of a rotation by which it may go back."""


class Train:
    """A held train and its present equilibrium.

    `load` moves on to another torque: without friction to the equilibrium there, with friction by one step of the incremental
    minimum problem of rate-independent systems (A. Mielke, T. Roubicek, Rate-Independent Systems, 2015), exact where each rotor
    turns one way only in the step.
    """

    def __init__(self, held: Held, turn: float = 0.0) -> None:
        self.held, self.linear = held, Linear(held.smooth(turn))
        self.rotors: Any = self.linear.system.rotors
        free = self.linear.free
        self.natural = self.linear.smooth.packed.natural[free]
        self.out = int(np.flatnonzero(free == 3 * held.place + 2)[0])
        moved = {int(np.flatnonzero(free == 3 * i + 2)[0]): mu for i, mu in self._frictions(free)}
        self.friction: dict[int, float] = moved
        self.reset()

    def _frictions(self, free: NDArray[np.intp]) -> list[tuple[int, float]]:
        found = enumerate(self.held.friction.tolist())
        return [(i, mu) for i, mu in found if mu > 0.0 and 3 * i + 2 in free]

    def reset(self) -> None:
        """Return to the nominal positions, unloaded, all friction sticking."""
        self.linear.start()
        self.origin = self.linear.state[self.linear.free].copy()
        self.at = np.zeros(self.origin.size)
        self.slips = dict.fromkeys(self.friction, 0.0)
        self.dissipated = 0.0

    @property
    def angle(self) -> float:
        """Rotation of the loaded rotor from its nominal position [rad]."""
        return float(self.natural[self.out] * self.at[self.out])

    def load(self, torque: float) -> float:
        """Move on to a torque [N m]; return the rotation [rad]. Raises `SimulationError` where no equilibrium is found."""
        before = self.at.copy()
        for _ in range(ROUNDS):
            now, left = self._solve(torque, before)
            if not self._changed(now, before, left):
                self.at = now
                moved = self.natural * np.abs(now - before)
                self.dissipated += sum(mu * float(moved[k]) for k, mu in self.friction.items())
                return self.angle
        raise SimulationError(
            f"no static equilibrium found at {torque:.6g} N m on {self.held.at}: its frictions change between sticking and "
            "slipping without end"
        )

    def _solve(self, torque: float, start: Floats) -> tuple[Floats, Floats]:
        """Return the equilibrium of the slipping and free coordinates, and all forces there [N, N m]; scaled displacements."""
        linear, natural = self.linear, self.natural
        self.rotors.torque[self.held.place] = torque
        push = np.zeros(natural.size)
        for k, sense in self.slips.items():
            push[k] = -sense * self.friction[k]
        moving = np.array([self.slips.get(k, 1.0) != 0.0 for k in range(natural.size)])
        whole, forces = start.copy(), np.zeros(natural.size)

        def force(at: Floats) -> Floats | None:
            whole[moving] = at
            linear.state[linear.free] = self.origin + natural * whole
            found = linear.forces()
            if found is None or not np.isfinite(found).all():
                return None
            forces[:] = found + push
            scaled: Floats = (natural * forces)[moving]
            return scaled

        def stiffness() -> Floats:
            matrix = linear.stiffness(linear.matrix())[np.ix_(moving, moving)]
            scale = natural[moving]
            scaled: Floats = scale[:, None] * matrix * scale
            return scaled

        rubbing = max((natural[k] * mu for k, mu in self.friction.items()), default=0.0)
        acting = max(linear.acting(np.zeros(natural.size)), rubbing, 1e-30)
        found = balance(force, stiffness, start[moving], acting)
        if found is None:
            raise SimulationError("no static equilibrium: a pair cannot mesh where the case places it")
        if not found.balances:
            raise SimulationError(
                f"no static equilibrium found at {torque:.6g} N m on {self.held.at}: the forces do not balance. Check that "
                "something elastic holds every centre that is free"
            )
        force(found.at)
        if moving[self.out] and not abs(forces[self.out]) <= RESOLVED * (abs(torque) + rubbing):
            raise SimulationError(
                f"{torque:.4g} N m on {self.held.at} is within rounding of the forces in the train. Raise the torque"
            )
        return whole.copy(), forces.copy()

    def _changed(self, now: Floats, before: Floats, left: Floats) -> bool:
        """Update the sticking and slipping states that the solution contradicts; return whether any changed."""
        changed = False
        for k, mu in self.friction.items():
            sense = self.slips[k]
            if sense == 0.0 and abs(left[k]) > mu * (1.0 + BEYOND):
                self.slips[k] = float(np.sign(left[k]))
                changed = True
            elif sense * (now[k] - before[k]) < -BEYOND * max(abs(now[k]), 1e-6):
                self.slips[k] = 0.0
                changed = True
        return changed

    def compliance(self) -> float:
        """Return the slope of rotation over torque at the equilibrium [rad/(N m)]; sticking rotors are held."""
        shape = self.shape()
        return float(shape[self.out])

    def shape(self) -> Floats:
        """Return the displacements of the free coordinates per unit torque at the present equilibrium, shape [coordinate]."""
        moving = np.array([self.slips.get(k, 1.0) != 0.0 for k in range(self.natural.size)])
        found = np.zeros(self.natural.size)
        if not moving[self.out]:
            return found
        self.linear.state[self.linear.free] = self.origin + self.natural * self.at
        self.linear.forces()
        matrix = self.linear.stiffness(self.linear.matrix())[np.ix_(moving, moving)]
        scale = self.natural[moving]
        unit = np.zeros(self.natural.size)
        unit[self.out] = 1.0
        scaled, *_ = np.linalg.lstsq(
            scale[:, None] * matrix * scale, (self.natural * unit)[moving], rcond=1e-14
        )
        found[moving] = scale * scaled
        return found
