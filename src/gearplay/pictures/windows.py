"""Windows of the plane on a mechanism: all of it, a close-up of a sleeve or of a mesh.

A mechanism is what `gearplay.results.mechanism.mechanism_of` returns.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from gearplay.pictures.gears import Gear, pitch_point, rim_radius

Mechanism = Mapping[str, Any]


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


def axis_of(mechanism: Mechanism, gear: Gear) -> tuple[float, float]:
    """Return the centre of what carries a gear, else its own [m]."""
    on = next((each["on"] for each in mechanism["carried"] if each["rotor"] == gear["rotor"]), None)
    hub = gear_on(mechanism, on) if on is not None else gear
    return hub["x"], hub["y"]


def reach(mechanism: Mechanism, gear: Gear) -> float:
    """Return how far from its carrier's axis a gear's centre lies [m]."""
    return math.dist(axis_of(mechanism, gear), (gear["x"], gear["y"]))


def whole_look(mechanism: Mechanism) -> Look:
    """Return the window that all gears fit in, wherever their carriers turn."""
    gears = mechanism["gears"]
    around = [reach(mechanism, gear) + rim_radius(gear) for gear in gears]
    axes = [axis_of(mechanism, gear) for gear in gears]
    low = [min(axis[k] - r for axis, r in zip(axes, around, strict=True)) for k in (0, 1)]
    high = [max(axis[k] + r for axis, r in zip(axes, around, strict=True)) for k in (0, 1)]
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    half = [0.53 * (b - a) for a, b in zip(low, high, strict=True)]
    return Look(middle[0], middle[1], half[0], half[1])


def sleeve_look(mechanism: Mechanism, name: str | None, factor: float) -> Look | None:
    """Return the close-up of a sleeve, the first if none is named; ``factor`` is how many times larger its clearance is drawn."""
    sleeves = mechanism["sleeves"]
    chosen = next((each for each in sleeves if each["name"] == name), sleeves[0] if sleeves else None)
    if chosen is None:
        return None
    gear, clearance = gear_on(mechanism, chosen["name"]), chosen["clearance"]
    usual = gear["shaft"]
    play = max(factor * clearance, 0.02 * usual)
    shaft = min(2.5 * play, usual) if clearance > 0.0 else usual
    half = 1.3 * (shaft + play) if clearance > 0.0 else 2.0 * shaft
    word = (
        f"sleeve of {chosen['name']}, {1e6 * clearance:.4g} µm"
        if clearance > 0.0
        else f"bearing of {chosen['name']}"
    )
    return Look(gear["x"], gear["y"], half, half, word, shaft, sleeves.index(chosen))


def mesh_look(mechanism: Mechanism, name: str | None) -> Look | None:
    """Return the close-up of a mesh, the first if none is named."""
    meshes = mechanism["meshes"]
    chosen = next((each for each in meshes if each["name"] == name), meshes[0] if meshes else None)
    if chosen is None:
        return None
    named = {gear["name"]: gear for gear in mechanism["gears"]}
    a, b = named[chosen["driver"]], named[chosen["driven"]]
    half = 1.8 * math.pi * a["module"]
    words = f"mesh {chosen['name']}, backlash {1e6 * chosen['backlash']:.4g} µm"
    return Look(*pitch_point(a, b), half, half, words)
