"""Mean acceleration of a moving housing over intervals of time, in closed form."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.housing_motion import (
    AMPLITUDE,
    COSINE,
    COUNT,
    END,
    KIND,
    NONE,
    PHASE,
    RATE,
    RECORD,
    SINE,
    START,
    STEP,
)
from gearplay.kernels.layout import System

Floats = NDArray[np.float64]


class HousingMotion(NamedTuple):
    """The acceleration a(t) of a housing along its direction, as `kernels.housing_motion` has it.

    ``slots`` are those of `System.base`, ``pieces`` those of its record, shape [piece, 4].
    """

    slots: Floats
    pieces: Floats

    @classmethod
    def of(cls, system: System) -> Self | None:
        """Return the motion of a system's housing; None where it does not move."""
        if system.base[KIND] == NONE:
            return None
        return cls(system.base, system.record[: int(system.base[COUNT])])

    def means(self, times: Floats) -> Floats:
        """Return the mean acceleration from each time to the next [m/s^2], along x and y, shape [2, time - 1].

        The increment of the housing's velocity over the interval divided by its length: of a sine
        a sin(w t_mid + phase) sin(x) / x with x = w h / 2, of a record the integral of its pieces.
        """
        slots = self.slots
        inside = np.clip(times, slots[START], slots[END])
        rise = self._recorded(inside) if slots[KIND] == RECORD else self._of_sine(inside)
        direction = np.array([[slots[COSINE]], [slots[SINE]]])
        return direction * rise / np.diff(times)

    def _of_sine(self, times: Floats) -> Floats:
        """Return the increments of velocity [m/s] between times while the sine acts."""
        slots, span = self.slots, np.diff(times)
        middle = 0.5 * (times[1:] + times[:-1]) - slots[START]
        mean = np.sin(slots[RATE] * middle + slots[PHASE]) * np.sinc(slots[RATE] * span / (2.0 * np.pi))
        rise: Floats = slots[AMPLITUDE] * mean * span
        return rise

    def _recorded(self, times: Floats) -> Floats:
        """Return the increments of velocity [m/s] between times within the record."""
        slots = self.slots
        integrals = self.pieces / np.arange(1.0, 5.0)  # of c_k u^k: c_k / (k + 1) u^(k + 1)
        at = (times - slots[START]) / slots[STEP]
        piece = np.clip(at.astype(np.int64), 0, len(integrals) - 1)
        u = (at - piece)[:, None]
        within = np.sum(integrals[piece] * u ** np.arange(1, 5), axis=1)
        passed = np.concatenate([[0.0], np.cumsum(np.sum(integrals, axis=1))])
        rise: Floats = slots[STEP] * (np.diff(passed[piece]) + np.diff(within))
        return rise
