"""Initial speeds: given ones, the others by rolling contact, outwards from prescribed rotations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.train import rolling
from gearplay.parts.mesh.train.geometry import carrier_of
from gearplay.parts.mesh.train.linear_conditions import matrix_of, picked, solved_by_rank, vanishing

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]

ROUNDING = 1e-12
"""Relative difference of speeds that are the same but for rounding."""


def given_speeds(case: Case) -> dict[str, float]:
    """Return the speeds [rad/s] that ``initial.omega`` gives."""
    return {n: r.initial.omega for n, r in case.rotors.items() if r.initial.omega is not None}


def matching_speeds(case: Case, nominal: Floats, without: str | None = None) -> Floats:
    """Return every rotor's speed at t = 0 [rad/s], shape [rotor].

    A given ``initial.omega`` and a prescribed speed are kept. The other speeds fulfil, as far as they can and in this order:
    rolling together with prescribed and held rotors alone; rolling at all meshes and joints; starting speeds of servos, 0 of
    position drives; those of carriers as drives start; the least difference from all speeds as drives start. Conditions of one
    rank that contradict each other are fulfilled in the sense of least squares.

    Parameters
    ----------
    case
        A valid case.
    nominal
        Its nominal speeds [rad/s], shape [rotor].
    without
        A rotor whose ``initial.omega`` is taken as not given.

    """
    driven = rolling.starting_speeds(case, nominal)
    given = given_speeds(case)
    given.pop(without or "", None)
    if not given:
        return driven
    places = {name: i for i, name in enumerate(case.rotors)}
    drives = {n: r.drive for n, r in case.rotors.items() if r.drive is not None}
    prescribed = [n for n, drive in drives.items() if drive.prescribes]
    loops = [n for n, d in drives.items() if n not in {*given, *prescribed} and d.nominal_speed() is not None]
    carriers = {carrier_of(case, n) for n in case.rotors} - {None}
    rolls = matrix_of(rolling.conditions(case, places, held=False), len(places))
    holds = matrix_of(rolling.holds(case, places, without=given), len(places))
    untouched = np.all(rolls[:, [places[n] for n in given]] == 0.0, axis=1)
    known = {n: float(driven[places[n]]) for n in prescribed} | given
    found = solved_by_rank(
        [
            picked(places, known),
            vanishing(np.concatenate([rolls[untouched], holds])),
            vanishing(rolls),
            picked(places, {n: float(driven[places[n]]) for n in loops}),
            picked(places, {n: float(driven[places[n]]) for n in carriers if n is not None}),
            (np.eye(len(places)), driven),
        ],
        len(places),
    )
    size = max(1e-300, *map(abs, known.values()), float(np.max(np.abs(driven))))
    found = np.where(np.abs(found - driven) <= ROUNDING * size, driven, found)
    found[np.abs(found) <= ROUNDING * size] = 0.0
    for name, speed in known.items():
        found[places[name]] = speed
    return found
