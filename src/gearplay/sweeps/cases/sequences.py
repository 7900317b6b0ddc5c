"""Sequences of cases along an axis: held speeds with ramps between them, or windows of a run-up."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.sweeps.plans.plan import Carry
from gearplay.vocabulary.errors import Fault, InputError

Floats = NDArray[np.float64]


class Chain:
    """The carried axis of a plan: the changes of each of its cases in addition to the varied fields.

    Raises `InputError` where the ramp does not fit into the transient.
    """

    def __init__(self, carry: Carry, path: str, values: tuple[float, ...], base: Case) -> None:
        self.carry, self.drive = carry, path.removesuffix(".speed")
        self.values, self.run = np.array(values), base.run
        if carry.mode == "steps" and carry.ramp > base.run.transient:
            rule = f"must fit into the transient of each case, {base.run.transient:g} s, where nothing is recorded"
            raise InputError(
                Fault("carry.ramp", f"{carry.ramp:g} s", rule, "Lengthen run.transient, or shorten it")
            )

    def way(self, direction: str) -> Floats:
        """Return the speeds in the order in which a direction passes them [rad/s]."""
        return self.values if direction == "up" else self.values[::-1]

    def edges(self, direction: str) -> Floats:
        """Return the speeds between the windows of a run-up [rad/s]: half-way, and as far beyond the ends.

        >>> from gearplay.model.reading import load_case
        >>> chain = Chain(Carry(axis="speed", mode="run-up"), "rotors.pinion.drive.speed", (1.0, 2.0, 4.0), load_case("han2021"))
        >>> chain.edges("down").tolist()
        [5.0, 3.0, 1.5, 0.5]
        """
        way = self.way(direction)
        middles = 0.5 * (way[1:] + way[:-1])
        return np.concatenate([[2.0 * way[0] - middles[0]], middles, [2.0 * way[-1] - middles[-1]]])

    def changes(self, speed: float, direction: str) -> dict[str, Any]:
        """Return the changes of the case at a speed, by path."""
        at = int(np.argmin(np.abs(self.way(direction) - speed)))
        if self.carry.mode == "run-up":
            low, high = self.edges(direction)[at : at + 2]
            return {**self._ramp(float(low), float(high), self.run.duration), "run.transient": 0.0}
        if at == 0:
            return {}
        return self._ramp(float(self.way(direction)[at - 1]), speed, self.carry.ramp)

    def _ramp(self, low: float, high: float, time: float) -> dict[str, Any]:
        return {f"{self.drive}.speed": high, f"{self.drive}.start_speed": low, f"{self.drive}.ramp": time}

    def lead(self, direction: str) -> dict[str, Any] | None:
        """Return the changes for what runs before a run-up: its first speed, held for the transient; None without one."""
        if self.carry.mode == "steps" or self.run.transient == 0.0:
            return None
        start = float(self.edges(direction)[0])
        return {
            f"{self.drive}.speed": start,
            "run.transient": 0.0,
            "run.duration": self.run.transient,
            "run.sampling": 1.0,
        }

    def slowness(self, speed: float, direction: str) -> float:
        """Return the mean speed of a case over its nominal one, which is that at its end."""
        if self.carry.mode == "steps":
            return 1.0
        at = int(np.argmin(np.abs(self.way(direction) - speed)))
        low, high = self.edges(direction)[at : at + 2]
        return float(0.5 * (low + high) / high)
