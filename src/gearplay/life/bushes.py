"""Wear of plain bearings: load over directions in a simulated block, depth of journal and bush, the clearance that follows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.results.result import Result

Floats = NDArray[np.float64]
DIRECTIONS = 360
ANGLES: Floats = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
"""Directions [rad] at which depths are computed: of a bush from its centre, of a journal in the frame that turns with it."""
SURFACES = ("journal", "bush")
ROCKS = 0.5
"""Share of the way of a journal in its bush that is net rotation, up to which it rocks: all of the block counts then."""


def wearing_bushes(case: Case) -> list[str]:
    """Return the rotors whose plain bearings wear, planets on pins among them."""
    return [name for name, sleeve in case.sleeves.items() if sleeve.wear is not None]


def bush_rates(result: Result, name: str) -> dict[str, Floats]:
    """Return how fast journal and bush wear over a block [m/s] by surface, shape [direction].

    Each contact is spread over the arc, whose pressure wears it by k F |omega| / (arc L), omega the spin of the journal against
    the bush; turning within the bush, the whole journal wears by k F / L a turn. Counted are the last whole turns of the block.
    """
    case = result.case
    sleeve = case.sleeves[name]
    wear = sleeve.wear
    assert wear is not None
    found = {surface: np.zeros(DIRECTIONS) for surface in SURFACES}
    members = len(result.runs)
    for member in range(members):
        f_x, f_y = (result.signal(f"sleeve_force_{axis}", name, member) for axis in "xy")
        force, towards = np.hypot(f_x, f_y), np.arctan2(-f_y, -f_x)
        turn, spin = (result.signal(signal, name, member) for signal in ("theta", "omega"))
        carried = (
            (0.0, 0.0)
            if sleeve.on is None
            else tuple(result.signal(signal, sleeve.on, member) for signal in ("theta", "omega"))
        )
        counted = _whole_turns(case, name, turn - carried[0])
        rate = force * np.abs(spin - carried[1]) / (np.sum(counted) * members * wear.length)
        for surface, frame, k in zip(SURFACES, (turn, carried[0]), wear.coefficients, strict=True):
            found[surface] += k * _over_arc((towards - frame)[counted], rate[counted], wear.arc)
    return found


def _whole_turns(case: Case, name: str, turn: Floats) -> NDArray[np.bool_]:
    """Return which samples of the rotation of a journal in its bush [rad] are of the last whole turns, all where it rocks."""
    net = abs(turn[-1] - turn[0])
    total = net / (2.0 * math.pi) * len(turn) / max(len(turn) - 1, 1)
    if net <= ROCKS * float(np.sum(np.abs(np.diff(turn)))):
        return np.ones(len(turn), dtype=bool)
    if total < 1.0 - 1e-9:
        least = math.ceil(1e3 * case.run.duration / total) / 1e3
        rule = f"must be at least {least:g} s, a turn of {name} in its bush"
        raise InputError.of("run.duration", f"{case.run.duration:g} s", rule, "Raise it")
    whole = math.floor(total + 1e-9)
    step = net / (len(turn) - 1)
    return np.asarray(np.abs(turn[-1] - turn) < 2.0 * math.pi * whole - 0.5 * step)


def _over_arc(towards: Floats, rate: Floats, arc: float) -> Floats:
    """Return densities over direction [1/rad] of rates at directions [rad], each spread evenly over an arc, shape [direction]."""
    step = 2.0 * math.pi / DIRECTIONS
    at = (towards / step) % DIRECTIONS
    lower = np.floor(at).astype(np.int64) % DIRECTIONS
    upper = at - np.floor(at)
    density = np.bincount(lower, (1.0 - upper) * rate, DIRECTIONS)
    density += np.bincount((lower + 1) % DIRECTIONS, upper * rate, DIRECTIONS)
    reach = np.minimum(ANGLES, 2.0 * math.pi - ANGLES) / step
    spread = np.clip(0.5 * arc / step + 0.5 - reach, 0.0, 1.0)
    spread /= spread.sum() * step
    found = np.fft.irfft(np.fft.rfft(density) * np.fft.rfft(spread), DIRECTIONS)
    return np.maximum(found, 0.0)  # rounding


def openings(depth: Floats) -> tuple[float, float, float]:
    """Return depths [m] in the direction of the largest wear and opposite to it, and that direction [rad].

    >>> [round(each, 9) for each in openings(1e-6 + 0.0 * ANGLES)[:2]]
    [1e-06, 1e-06]
    """
    direction = float(np.angle(np.sum(depth * np.exp(1j * ANGLES)))) % (2.0 * math.pi)
    at, other = (float(np.interp(angle % (2.0 * math.pi), ANGLES, depth, period=2.0 * math.pi))
                 for angle in (direction, direction + math.pi))  # fmt: skip
    return at, other, direction


def clearance_of_wear(depths: dict[str, Floats]) -> float:
    """Return the radial clearance [m] that wear adds: half the play added along the direction of the largest wear."""
    return 0.5 * sum(sum(openings(depth)[:2]) for depth in depths.values())


def worn_sleeves(case: Case, sleeves: dict[str, dict[str, Floats]]) -> dict[str, Any]:
    """Return the changes of a case by wear of plain bearings: clearances, and centres of bushes.

    Of a planet, whose set has one table for all pins, both are in the entry of its pin among the ``pin_errors``.
    """
    changes: dict[str, Any] = {}
    pins: dict[str, dict[int, tuple[float, float, float]]] = {}
    for name, depths in sleeves.items():
        sleeve = case.sleeves[name]
        deepest, opposite, direction = openings(depths["bush"])
        off = 0.5 * (deepest - opposite)
        x, y = sleeve.offset[0] + off * math.cos(direction), sleeve.offset[1] + off * math.sin(direction)
        clearance = sleeve.radial_clearance + clearance_of_wear(depths)
        table, _, member = name.partition(".")
        if member.startswith("planet") and table in case.planetary:
            pins.setdefault(table, {})[int(member.removeprefix("planet"))] = (clearance, x, y)
            continue
        at = f"planetary.{name}.sleeve" if member and table in case.planetary else f"sleeves.{name}"
        changes |= {f"{at}.radial_clearance": clearance, f"{at}.offset": [x, y]}
    return changes | {
        f"planetary.{table}.pin_errors": _worn_pins(case, table, found) for table, found in pins.items()
    }


def _worn_pins(case: Case, table: str, pins: dict[int, tuple[float, float, float]]) -> list[dict[str, float]]:
    """Return the pin errors of a set with clearances and centres [m] of worn pins by planet; offsets count in fixed axes."""
    planetary = case.planetary[table]
    assert planetary.pin is not None
    found = []
    for planet, (clearance, x, y) in pins.items():
        direction = planetary.planets.directions[planet - 1]
        c, s = math.cos(direction), math.sin(direction)
        added = max(0.0, clearance - planetary.pin.radial_clearance)
        found.append(
            {"planet": planet, "radial": x * c + y * s, "tangential": y * c - x * s, "clearance": added}
        )
    return found
