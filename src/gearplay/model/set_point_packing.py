"""Packing of set-points over time: pieces behind the other records, sines behind the other terms."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.drive.set_points import Piece, SetPoint
from gearplay.schema.records import harmonic_rows

Floats = NDArray[np.float64]


class SetPoints:
    """Set-points of a case, added one by one and placed together; ``stops`` are the times [s] that no step may pass."""

    def __init__(self) -> None:
        self._pieces: list[Piece] = []
        self._waves: list[tuple[float, float, float]] = []
        self._owners: list[Any] = []
        self.stops: set[float] = set()

    def add(
        self,
        record: Any,
        given: SetPoint[Any] | None,
        *,
        of_speed: bool = False,
        lead: float = 0.0,
        scale: float = 1.0,
    ) -> float:
        """Fill the fields of a record; return the angular frequency [rad/s] of the sine, 0 without one.

        ``of_speed`` is whether a trapezoid is that of the rate, ``lead`` [s] the share of the rate that is added,
        ``scale`` the factor of its values.
        """
        if given is None:
            record.set_point, record.set_points, record.wave = 0, 0, -1
            return 0.0
        record.steepest = scale * given.steepest(lead=lead, of_speed=of_speed)
        pieces = [
            (begin, scale * value, scale * rate, scale * half)
            for begin, value, rate, half in given.pieces(of_speed=of_speed)
        ]
        return self._add(record, given, pieces, given.stops(of_speed=of_speed), scale)

    def add_motion(self, rotor: Any, given: SetPoint[Any], nominal: float) -> float:
        """Fill the fields of a rotor with the rotation that a speed prescribes, less the ``nominal`` one [rad/s].

        Return the angular frequency [rad/s] of the sine, 0 without one.
        """
        return self._add(rotor, given, given.integral(nominal), given.stops())

    def _add(
        self, record: Any, given: SetPoint[Any], pieces: list[Piece], stops: set[float], scale: float = 1.0
    ) -> float:
        record.set_point, record.set_points, record.wave = len(self._pieces), len(pieces), -1
        self._pieces += pieces
        self.stops |= stops
        wave = given.wave()
        if wave is not None:
            record.wave = len(self._waves)
            self._waves.append((wave[0], scale * wave[1], wave[2]))
        self._owners.append(record)
        return 0.0 if wave is None else wave[0]

    def place(self, terms: list[Any], record: Floats) -> Floats:
        """Add sines to ``terms``; return ``record`` with the pieces behind. Only once."""
        for owner in self._owners:
            owner.set_point += len(record)
            owner.wave += len(terms) if owner.wave >= 0 else 0
        terms += harmonic_rows(self._waves)
        return np.concatenate([record, np.array(self._pieces, dtype=np.float64).reshape(-1, 4)])
