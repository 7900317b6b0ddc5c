"""Packing of set-points over time: pieces behind the other records, sines behind the other terms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.schema.records import harmonic_rows

if TYPE_CHECKING:
    from gearplay.parts.drive.set_points import Piece, SetPoint
    from gearplay.parts.protocol import Packing


def add_set_point(
    packing: Packing,
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
    packing.stops |= given.stops(of_speed=of_speed)
    return _add(packing, record, given, pieces, scale)


def add_motion(packing: Packing, rotor: Any, given: SetPoint[Any], nominal: float) -> float:
    """Fill the fields of a rotor with the rotation that a speed prescribes, less the ``nominal`` one [rad/s].

    Return the angular frequency [rad/s] of the sine, 0 without one.
    """
    packing.stops |= given.stops()
    return _add(packing, rotor, given, given.integral(nominal))


def _add(
    packing: Packing, record: Any, given: SetPoint[Any], pieces: list[Piece], scale: float = 1.0
) -> float:
    wave = given.wave()
    record.set_points, record.wave = len(pieces), -1

    def place() -> None:
        record.set_point = len(packing.record)
        packing.record = np.concatenate([packing.record, np.array(pieces, dtype=np.float64).reshape(-1, 4)])
        if wave is not None:
            rows = harmonic_rows([(wave[0], scale * wave[1], wave[2])])
            record.wave, _ = packing.add_terms(rows)

    packing.later.append(place)
    return 0.0 if wave is None else wave[0]
