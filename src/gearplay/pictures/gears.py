"""Geometry of a drawn mechanism: involute outlines, relative rotation in mesh, windows of the plane for its views.

A mechanism is what `gearplay.results.mechanism.mechanism_of` returns, a gear one entry of its ``gears``.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import inv

Floats = NDArray[np.float64]
Gear = Mapping[str, Any]
Mechanism = Mapping[str, Any]
FLANK = 7
"""Points of a flank."""


def outline(gear: Gear, gap: float = 0.0) -> Floats:
    """Return the closed outline of a gear's teeth about its centre [m], shape [point, 2]; of a ring that of its spaces.

    ``gap`` is the backlash to draw [m], of which each gear of a mesh takes half.

    >>> pair = {"teeth": 20, "module": 0.004, "pressure_angle": math.radians(20.0), "internal": False}
    >>> spur = outline(pair | {"addendum": 1.0, "dedendum": 1.25, "shift": 0.0})
    >>> [round(1e3 * float(each), 3) for each in (np.hypot(*spur.T).min(), np.hypot(*spur.T).max())]
    [35.0, 44.0]
    """
    z, m, alpha, internal = gear["teeth"], gear["module"], gear["pressure_angle"], gear["internal"]
    r = 0.5 * m * z
    base = r * math.cos(alpha)
    tip = r + (gear["dedendum"] if internal else gear["addendum"]) * m
    root = r - (gear["addendum"] if internal else gear["dedendum"]) * m
    half = math.pi / (2 * z) + gear["shift"] + (1.0 if internal else -1.0) * gap / (4.0 * r)
    rho = np.linspace(max(root, base), tip, FLANK)
    at = half + inv(alpha) - (np.tan(slope := np.arccos(np.minimum(1.0, base / rho))) - slope)
    at = np.maximum(at, 0.02 / z)
    if root < base:
        rho, at = np.r_[root, rho], np.r_[at[0], at]
    middle = 2.0 * math.pi * np.arange(z)[:, None] / z
    angle = np.concatenate([middle - at, middle + at[::-1]], axis=1).ravel()
    radius = np.tile(np.r_[rho, rho[::-1]], z)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return np.vstack([points, points[:1]])


def toward(a: Gear, b: Gear) -> float:
    """Return the direction [rad] from gear a's centre to the pitch point with gear b."""
    angle = math.atan2(b["y"] - a["y"], b["x"] - a["x"])
    if a["internal"]:
        return angle
    return angle + math.pi if b["internal"] else angle


def pitch_point(a: Gear, b: Gear) -> tuple[float, float]:
    """Return the pitch point of two gears [m]."""
    sense = -1 if a["internal"] or b["internal"] else 1
    distance = math.dist((a["x"], a["y"]), (b["x"], b["y"]))
    angle, r = toward(a, b), distance * a["teeth"] / abs(a["teeth"] + sense * b["teeth"])
    return a["x"] + r * math.cos(angle), a["y"] + r * math.sin(angle)


def phases(gears: Sequence[Gear], meshes: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the angle [rad] of each gear at nominal rotation, mesh by mesh, so that teeth meet spaces."""
    named = {gear["name"]: gear for gear in gears}
    found: dict[str, float] = {}
    for turn in range(len(meshes) + 1):
        for mesh in meshes:
            a, b = named[mesh["driver"]], named[mesh["driven"]]
            if a["name"] not in found and b["name"] not in found:
                if turn == 0 and found:
                    continue
                found[a["name"]] = toward(a, b)
            if b["name"] in found and a["name"] not in found:
                a, b = b, a
            if b["name"] in found:
                continue
            r_a, r_b = (0.5 * gear["module"] * gear["teeth"] for gear in (a, b))
            pitch, beta = math.pi * a["module"], toward(a, b)
            arc = (found[a["name"]] - beta) * r_a
            arc -= pitch * round(arc / pitch)
            found[b["name"]] = beta + math.pi - arc / r_b + math.pi / b["teeth"]
            if a["internal"] or b["internal"]:
                found[b["name"]] = beta + arc / r_b
    return found


def usual_shaft(module: float | None, roots: Sequence[float]) -> float:
    """Return the radius of a drawn shaft [m] by the module of its gears, at most half of the root radii on its axis [m].

    >>> usual_shaft(0.005, []), usual_shaft(0.001, [0.00725])
    (0.007, 0.003625)
    """
    return min([0.6 * (module or 0.004) + 0.004, *(0.5 * root for root in roots)])


def root_radius(gear: Gear) -> float:
    """Return the radius of the circle within the teeth of an external gear [m]."""
    return float(gear["module"] * (0.5 * gear["teeth"] - gear["dedendum"]))


def rim_radius(gear: Gear) -> float:
    """Return the radius that a drawn gear takes up [m]: of a ring its rim, without teeth its ``disc``, else thrice its shaft."""
    if not (gear["teeth"] and gear["module"]):
        return float(gear.get("disc", 3.0 * gear["shaft"]))
    return float(0.5 * gear["module"] * gear["teeth"] + (3.0 if gear["internal"] else 1.2) * gear["module"])


def magnification(mechanism: Mechanism, times: float = 1.0) -> float:
    """Return the magnification of small motions: ``times`` the one that draws the largest clearance as a quarter of a module."""
    module = next((gear["module"] for gear in mechanism["gears"] if gear["module"]), 0.01)
    plays = [each["clearance"] for each in mechanism["sleeves"]]
    plays += [each["backlash"] for each in mechanism["meshes"]]
    return float(times * 0.25 * module / max(1e-7, *(play for play in plays if math.isfinite(play)), 0.0))


def sides_of(mechanism: Mechanism) -> dict[str, int]:
    """Return 0 or 1 for each gear by name, different for any two that mesh: its fill in a drawing."""
    sides: dict[str, int] = {}
    for gear in mechanism["gears"]:
        sides.setdefault(gear["name"], 0)
        waiting = [gear["name"]]
        while waiting:
            here = waiting.pop()
            for mesh in mechanism["meshes"]:
                pair = (mesh["driver"], mesh["driven"])
                other = pair[1 - pair.index(here)] if here in pair else here
                if other not in sides:
                    sides[other] = 1 - sides[here]
                    waiting.append(other)
    return sides


class Look(NamedTuple):
    """A window of the plane: its middle, half its width and height [m], and its title.

    A close-up of a sleeve has the radius of the drawn shaft [m] and the place of the sleeve, whose bush it follows.
    """

    x: float
    y: float
    half_x: float
    half_y: float
    words: str = ""
    shaft: float | None = None
    sleeve: int | None = None


def gear_on(mechanism: Mechanism, rotor: str) -> Gear:
    """Return the first gear of a rotor."""
    found: Gear = next(gear for gear in mechanism["gears"] if gear["rotor"] == rotor)
    return found


def pair_of(mechanism: Mechanism, mesh: Mapping[str, Any]) -> tuple[Gear, Gear]:
    """Return driver and driven gear of a mesh."""
    named = {gear["name"]: gear for gear in mechanism["gears"]}
    return named[mesh["driver"]], named[mesh["driven"]]


def axis_of(mechanism: Mechanism, gear: Gear) -> tuple[float, float]:
    """Return the centre of a gear's carrier, else its own [m]."""
    on = next((each["on"] for each in mechanism["carried"] if each["rotor"] == gear["rotor"]), None)
    hub = gear_on(mechanism, on) if on is not None else gear
    return hub["x"], hub["y"]


def arm_of(mechanism: Mechanism, gear: Gear) -> float:
    """Return the distance of a gear's centre from its carrier's axis [m]."""
    return math.dist(axis_of(mechanism, gear), (gear["x"], gear["y"]))


def whole_look(mechanism: Mechanism) -> Look:
    """Return the window that all gears fit in, wherever their carriers turn."""
    gears = mechanism["gears"]
    axes = np.array([axis_of(mechanism, gear) for gear in gears])
    around = np.array([[arm_of(mechanism, gear) + rim_radius(gear)] for gear in gears])
    low, high = (axes - around).min(axis=0), (axes + around).max(axis=0)
    return Look(*(0.5 * (low + high)).tolist(), *(0.53 * (high - low)).tolist())


def sleeve_look(mechanism: Mechanism, name: str | None, factor: float) -> Look | None:
    """Return the close-up of a sleeve, the first if none is named; its clearance is magnified by ``factor``."""
    sleeves = mechanism["sleeves"]
    if not sleeves:
        return None
    chosen = next((each for each in sleeves if each["name"] == name), sleeves[0])
    gear, clearance = gear_on(mechanism, chosen["name"]), chosen["clearance"]
    usual = gear["shaft"]
    shaft, half, words = usual, 2.0 * usual, f"bearing of {chosen['name']}"
    if clearance > 0.0:
        play = max(factor * clearance, 0.02 * usual)
        shaft = min(2.5 * play, usual)
        half, words = 1.3 * (shaft + play), f"{chosen['kind']} of {chosen['name']}, {1e6 * clearance:.4g} µm"
    return Look(gear["x"], gear["y"], half, half, words, shaft, sleeves.index(chosen))


def mesh_look(mechanism: Mechanism, name: str | None) -> Look | None:
    """Return the close-up of a mesh, the first if none is named."""
    meshes = mechanism["meshes"]
    if not meshes:
        return None
    chosen = next((each for each in meshes if each["name"] == name), meshes[0])
    a, b = pair_of(mechanism, chosen)
    half = 1.8 * math.pi * a["module"]
    words = f"mesh {chosen['name']}, backlash {1e6 * chosen['backlash']:.4g} µm"
    return Look(*pitch_point(a, b), half, half, words)
