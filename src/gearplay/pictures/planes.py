"""Axial planes of a train, drawn side by side."""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from gearplay.pictures.gears import Gear, rim_radius, root_radius, usual_shaft

ASPECT = 0.9
"""Width to height of the place for a drawing of the whole."""
COAXIAL = 1e-6
"""Distance [m] of two axes that are drawn as one."""
GAP = 0.04
"""Between planes, of the larger side of one."""
Box = tuple[float, float, float, float]


def apart(mechanism: Mapping[str, Any], *, gap: float = GAP, disc: float | None = None) -> dict[str, Any]:
    """Return a mechanism whose planes do not cover each other.

    Its gears are moved where needed and hold their ``plane`` and the radius of their drawn ``shaft`` [m]; ``axes`` are pairs of
    places [m] where one shaft, or two coupled ones, are drawn. ``gap`` is between planes, of the larger side of one.
    With ``disc`` [m] rotors without teeth that carry nothing are discs of that radius, each in a plane of its own.
    """
    planes = _planes(mechanism, joined=disc is None)
    gears = [{**gear, "plane": plane} for gear, plane in zip(mechanism["gears"], planes, strict=True)]
    gears = [{**gear, "shaft": _shaft(gear, gears)} for gear in gears]
    if disc is not None:
        gears = [gear if gear["teeth"] and gear["module"] else {**gear, "disc": disc} for gear in gears]
    gears = min((_spread(gears, axis, gap) for axis in (0, 1)), key=_size)
    pairs = [pair for pair in combinations(gears, 2) if pair[0]["rotor"] == pair[1]["rotor"]]
    for each in mechanism["couplings"]:
        one, other = (next(gear for gear in gears if gear["rotor"] == name) for name in each["between"])
        pairs.append((one, other))
    axes = [[a["x"], a["y"], b["x"], b["y"]] for a, b in pairs if a["plane"] != b["plane"]]
    return {**mechanism, "gears": gears, "axes": axes}


def _shaft(gear: Gear, gears: Sequence[Gear]) -> float:
    """Return the radius of a gear's drawn shaft [m]: within the roots of all gears of its plane that share its axis."""
    toothed = [each for each in gears if each["plane"] == gear["plane"] and each["teeth"] and each["module"]]
    around = [each for each in toothed if math.dist((each["x"], each["y"]), (gear["x"], gear["y"])) < COAXIAL]
    module = gear["module"] or min((each["module"] for each in toothed), default=None)
    return usual_shaft(module, [root_radius(each) for each in around if not each["internal"]])


def _planes(mechanism: Mapping[str, Any], *, joined: bool) -> list[int]:
    """Return the number of each gear's plane: its meshes, its carrier, and if ``joined`` discs coupled to it."""
    gears = mechanism["gears"]
    lead = list(range(len(gears)))

    def find(k: int) -> int:
        while lead[k] != k:
            k = lead[k]
        return k

    def named(name: str, key: str = "rotor") -> int:
        return next(k for k, gear in enumerate(gears) if gear[key] == name)

    def join(a: int, b: int) -> None:
        lead[find(b)] = find(a)

    for mesh in mechanism["meshes"]:
        join(named(mesh["driver"], "name"), named(mesh["driven"], "name"))
    for each in mechanism["carried"]:
        join(named(each["on"]), named(each["rotor"]))
    hubs = {each["on"] for each in mechanism["carried"]}
    for each in mechanism["couplings"] if joined else ():
        ends = [named(name) for name in each["between"]]
        if any(gears[k]["rotor"] not in hubs and not gears[k]["teeth"] for k in ends):
            join(*ends)  # a plain disc
    known = list(dict.fromkeys(find(k) for k in range(len(gears))))
    return [known.index(find(k)) for k in range(len(gears))]


def _box(gears: Sequence[Gear]) -> Box:
    """Return left, right, low and high end [m] of the drawn gears."""
    rims = [rim_radius(gear) for gear in gears]
    ends = [
        pick(gear[axis] + sign * rim for gear, rim in zip(gears, rims, strict=True))
        for axis in "xy"
        for pick, sign in ((min, -1.0), (max, 1.0))
    ]
    return ends[0], ends[1], ends[2], ends[3]


def _size(gears: Sequence[Gear]) -> float:
    left, right, low, high = _box(gears)
    return max((right - left) / ASPECT, high - low)


def _spread(gears: Sequence[Gear], axis: int, wide: float) -> list[dict[str, Any]]:
    """Return the gears; a plane that would cover an earlier one is moved past all earlier ones: along x (0) or down y (1)."""
    placed: list[Box] = []
    moved = [dict(gear) for gear in gears]
    for plane in sorted({gear["plane"] for gear in gears}):
        mine = [gear for gear in moved if gear["plane"] == plane]
        left, right, low, high = _box(mine)
        shift = [0.0, 0.0]
        if any(left < b[1] and b[0] < right and low < b[3] and b[2] < high for b in placed):
            gap = wide * max(right - left, high - low)
            if axis == 0:
                shift[0] = max(b[1] for b in placed) + gap - left
            else:
                shift[1] = min(b[2] for b in placed) - gap - high
        placed.append((left + shift[0], right + shift[0], low + shift[1], high + shift[1]))
        for gear in mine:
            gear["x"] += shift[0]
            gear["y"] += shift[1]
    return moved
