"""Random rolling bearings on the ground and on a carrier for the tests of all elements; their numbers against closed forms."""

import math
from typing import Any

import numpy as np

from building import Document, Floats, merged
from gearplay.model.pack import Packed
from gearplay.parts.bearing.law.record import KIND


def bearing(rng: np.random.Generator, *, damped: bool, plain: bool) -> dict[str, Any]:
    """Return a random bearing: balls or rollers, with clearance or preload."""
    rollers = not plain and bool(rng.random() < 0.4)
    found: dict[str, Any] = {
        "rolling_elements": int(rng.integers(7, 15)),
        "element_diameter": float(rng.uniform(5e-3, 8e-3)),
        "pitch_diameter": 0.045,
        "internal_clearance": float(rng.uniform(-1e-4, 5e-5) if plain else rng.uniform(4e-5, 2e-4)),
        "exponent": 10.0 / 9.0 if rollers else 1.5,
        "stiffness": float(10.0 ** (rng.uniform(7.5, 8.5) if rollers else rng.uniform(9.0, 10.5))),
        "cage_phase": float(rng.uniform(-3.0, 3.0)),
        "cage_torque": bool(rng.random() < 0.8),
        "rotor_ring": str(rng.choice(["inner", "outer"])),
    }
    if damped:
        found["damping"] = {"kind": "hunt-crossley", "value": float(rng.uniform(0.0, 1.0))}
    if plain:
        return found | {"cage_torque": True}
    waves = [
        {
            "order": int(rng.integers(1, 16)),
            "amplitude": float(rng.uniform(1e-6, 5e-6)),
            "phase": float(rng.uniform(-3.0, 3.0)),
            "ring": str(rng.choice(["inner", "outer"])),
        }
        for _ in range(int(rng.integers(0, 4)))
    ]
    return found | {"waviness": waves}


def shortened(dent: dict[str, Any], closer: bool) -> dict[str, Any]:
    """Return a dent with room for one of elements that are ``closer`` to each other than even ones."""
    return {**dent, "arc": 0.3 * dent["arc"]} if closer else dent


def dent(rng: np.random.Generator, bearings: dict[str, Any], kind: str) -> dict[str, Any]:
    """Return a random dent of one of the bearings, of any kind where none is given."""
    name = str(rng.choice(list(bearings)))
    kind = kind or str(rng.choice(["inner", "outer", "element"]))
    count = bearings[name]["rolling_elements"]
    widest = 0.8 * (math.pi if kind == "element" else 2.0 * math.pi / count)
    found = {
        "kind": kind,
        "at": name,
        "depth": float(rng.uniform(1e-6, 3e-5)),
        "arc": float(rng.uniform(0.1, 1.0) * widest),
        "angle": float(rng.uniform(-3.0, 3.0)),
    }
    return found | ({"element": int(rng.integers(0, count))} if kind == "element" else {})


def broken_cage(rng: np.random.Generator, bearings: dict[str, Any]) -> list[dict[str, Any]]:
    """Return one or two elements of one of the bearings, not neighbours, that the cage holds off their places."""
    name = str(rng.choice(list(bearings)))
    each = bearings[name]
    room = 2.0 * math.pi / each["rolling_elements"]
    room -= 2.0 * math.asin(each["element_diameter"] / each["pitch_diameter"])
    first = int(rng.integers(0, each["rolling_elements"]))
    return [
        {"kind": "cage", "at": name, "element": element % each["rolling_elements"], "angle": 0.9 * room * off}
        for element, off in zip(
            (first, first + 3), rng.uniform(-1.0, 1.0, int(rng.integers(1, 3))).tolist(), strict=False
        )
    ]


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a planet in a bearing on a carrier that is in a bearing itself."""
    damping = float(rng.choice([0.0, 20.0])) if damped else 0.0
    driven = (
        {"drive": {"kind": "speed", "speed": float(rng.choice([-300.0, 300.0]))}}
        if rng.random() < 0.6
        else {}
    )
    weightless = plain or rng.random() < 0.5
    bearings = {
        "carrier": bearing(rng, damped=damped, plain=plain),
        "planet": {**bearing(rng, damped=damped, plain=plain), "on": "carrier"},
    }
    cages = broken_cage(rng, bearings) if rng.random() < 0.4 else []
    return {
        "gravity": [0.0, 0.0] if weightless else [float(rng.uniform(-9.0, 9.0)), -9.81],
        "rotors": {
            "carrier": {"mass": 1.0, "inertia": 2e-3, "position": [0.0, 0.0], **driven},
            "planet": {"mass": 0.4, "inertia": 1e-4, "position": [0.05, 0.02], "radial_damping": damping},
        },
        "bearings": bearings,
        "faults": [
            *cages,
            *(
                shortened(dent(rng, bearings, "outer" if plain and rng.random() < 0.5 else ""), bool(cages))
                for _ in range(int(rng.integers(0, 4)))
            ),
        ],
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def carried(document: Document, sign: float, angle: float) -> Document:
    """Turn, or mirror, the directions of the elements at rotation 0."""
    phases = {
        name: {"cage_phase": sign * each["cage_phase"] + angle} for name, each in document["bearings"].items()
    }
    faults = [
        {**each, "angle": sign * each["angle"] + (0.0 if each["kind"] in ("element", "cage") else angle)}
        | ({"element": -each["element"] % count} if sign < 0.0 and "element" in each else {})
        for each in document.get("faults", ())
        for count in [document["bearings"][each["at"]]["rolling_elements"]]
    ]
    return merged(document, {"bearings": phases, "faults": faults})


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of all bearings at t = 0."""
    total, terms = 0.0, packed.system.terms
    for each in packed.system.records[KIND]:
        i, b = int(each.rotor), int(each.carrier)
        e, turn_a, turn_b = y[3 * i : 3 * i + 2] - [each.misplaced_x, each.misplaced_y], y[3 * i + 2], 0.0
        if b >= 0:
            turn_b = y[3 * b + 2]
            c, s = math.cos(turn_b), math.sin(turn_b)
            seat = np.array([each.offset_x, each.offset_y])
            e = e - y[3 * b : 3 * b + 2] + seat - [c * seat[0] - s * seat[1], s * seat[0] + c * seat[1]]
        for k in range(int(each.contacts)):
            angle = each.cage_phase + each.share_a * turn_a + each.share_b * turn_b
            angle += 2.0 * math.pi * k / int(each.contacts)
            if each.pitch_cosine == each.pitch_sine == 0.0:
                angle += terms[each.dents + 2 * each.dent_count + k, 0]
            depth = e[0] * math.cos(angle) + e[1] * math.sin(angle) - each.half_clearance
            depth += dents(each, terms, k, angle, turn_a, turn_b)
            for first, count, turn in (
                (each.waves_a, each.count_a, turn_a),
                (each.waves_b, each.count_b, turn_b),
            ):
                for order, cosine, sine in terms[first : first + count]:
                    depth += cosine * math.cos(order * (angle - turn)) - sine * math.sin(
                        order * (angle - turn)
                    )
            total += each.stiffness / (each.exponent + 1.0) * max(depth, 0.0) ** (each.exponent + 1.0)
    return total


def dents(each: Any, terms: Floats, k: int, angle: float, turn_a: float, turn_b: float) -> float:
    """Return the height [m] of all dents at element k, by their angles on ring or element."""
    height = 0.0
    for rate, phase, arc, depth, place, _ in terms[each.dents : each.dents + 2 * each.dent_count].reshape(
        -1, 6
    ):
        if place >= 0:
            from_middle = math.remainder(rate * (turn_a - turn_b) + phase, math.pi) if k == place else math.pi
        else:
            ring = phase - each.cage_phase + angle - (turn_a if place == -1 else turn_b)
            from_middle = math.remainder(ring, 2.0 * math.pi)
        if abs(from_middle) < 0.5 * arc:
            height -= depth * math.cos(math.pi * from_middle / arc)
    return height
