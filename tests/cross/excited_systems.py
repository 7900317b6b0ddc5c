"""Random trains with couplings, supports, torque terms, unbalances, friction of the teeth and a moving base.

Twenty seeds, 0 to 19; the seed selects the features, and the numbers too.  A train runs from a motor, or its
first gear, through one to three stages, or over a planet on an arm, to its last gear or a machine behind it.
Nothing here asks the package: starts are placed by the reference's own geometry.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cross.excited_starts import Case, Link, displace, start_in_gaps
from cross.random_systems import LAWS, _sleeve
from cross.reference import Reference
from cross.train_parts import body, gear, mesh_of

# front, rear: how a motor and a machine are joined to the train.  free: how its rotors are borne, in turn
# (`_bear`).  load, terms: f in time, o in rotation.  heavy: so many of the last rotors have an unbalance.
# back: clockwise.  rigid: backlash_model = "uncoupled".  rub: so many of the last meshes have friction.
FEATURES: tuple[dict[str, Any], ...] = (
    {"stages": 1, "free": "p", "load": "f"},
    {"stages": 1, "free": "sp", "front": "shaft", "base": "harmonic", "load": "o"},
    {"stages": 2, "free": "bs", "heavy": 2, "load": "fo", "rub": 2},
    {"stages": 1, "drive": "torque", "free": "sb", "front": "play", "rear": "sprung", "terms": "f"},
    {"stages": 1, "drive": "position", "free": "sp", "front": "shaft", "rub": 1},
    {"stages": 2, "free": "ps", "front": "play", "lateral": 1, "base": "half-sine", "load": "f"},
    {"stages": 1, "planet": "p", "free": "sp", "heavy": 2, "load": "o", "rub": 2},
    {"stages": 3, "free": "sb", "front": "shaft", "rear": "shaft", "load": "fo", "damper": 1},
    {"stages": 1, "free": "bp", "absorber": 1, "load": "f", "gravity": 1},
    {"stages": 2, "drive": "sampled", "free": "sh", "base": "harmonic", "gravity": 1},
    {"stages": 1, "planet": "b", "free": "bs", "front": "shaft", "base": "half-sine", "load": "f"},
    {"stages": 2, "drive": "torque", "free": "p", "terms": "o", "rear": "play", "lateral": 1, "load": "f"},
    {"stages": 1, "drive": "servo", "free": "bb", "front": "belt", "heavy": 2, "load": "fo"},
    {"stages": 2, "free": "sp", "rear": "play", "heavy": 3, "base": "harmonic", "rigid": 1, "back": 1, "rub": 2},
    {"stages": 1, "planet": "b", "free": "ps", "rear": "shaft", "gravity": 1, "heavy": 3, "back": 1, "load": "o"},
    {"stages": 1, "drive": "torque", "free": "bh", "inner": 1, "terms": "fo", "heavy": 2, "base": "harmonic", "rub": 1},
    {"stages": 3, "drive": "servo", "free": "psb", "front": "play", "base": "half-sine", "load": "f", "back": 1, "rub": 2},
    {"stages": 2, "free": "hb", "front": "shaft", "absorber": 1, "heavy": 3, "base": "harmonic", "load": "o"},
    {"stages": 1, "drive": "torque", "planet": "p", "free": "bb", "front": "play", "terms": "fo", "base": "harmonic"},
    {"stages": 1, "free": "ss", "inner": 1, "front": "play", "rear": "play", "lateral": 1, "heavy": 4, "load": "fo", "rub": 1},
)  # fmt: skip
SEEDS = tuple(range(len(FEATURES)))


# ---------------------------------------------------------------------- the train


def _stages(rng: np.random.Generator, feature: dict[str, Any], seed: int, case: Case) -> list[Link]:
    """Add the geared rotors of a train and its meshes."""
    rotors, meshes, links = case["rotors"], case["meshes"], []
    rotors["input"] = {**body(rng, 0.03), **gear(rng, int(rng.integers(18, 26)))}
    driver = "input"
    for stage in range(1, feature["stages"]):
        name = f"shaft{stage}"
        wheel, pinion = gear(rng, int(rng.integers(30, 50))), gear(rng, int(rng.integers(18, 24)))
        rotors[name] = {**body(rng, 0.06), "gears": {"wheel": wheel, "pinion": pinion}}
        meshes.append(mesh_of(rng, driver, f"{name}.wheel", 2e-3, seed + stage))
        links.append(("mesh", len(meshes) - 1, driver.partition(".")[0], name))
        driver = f"{name}.pinion"
    inner = bool(feature.get("inner"))
    rotors["output"] = {**body(rng, 0.08), **gear(rng, int(rng.integers(50, 70)), internal=inner)}
    meshes.append(mesh_of(rng, driver, "output", 2.5e-3, seed))
    links.append(("mesh", len(meshes) - 1, driver.partition(".")[0], "output"))
    return links


def _planet(rng: np.random.Generator, feature: dict[str, Any], seed: int, case: Case) -> list[Link]:
    """Add a sun, a planet on an arm that springs hold, and a ring, which is the output."""
    sun, planet = int(rng.integers(18, 24)), int(rng.integers(17, 22))
    module = 2.5e-3
    reach = 0.5 * module * (sun + planet)
    angle = float(rng.uniform(-math.pi, math.pi))
    case["rotors"] |= {
        "input": {**body(rng, 0.03), **gear(rng, sun), "position": [0.0, 0.0]},
        "planet": {**body(rng, 0.03), **gear(rng, planet)},
        "output": {**body(rng, 0.09), **gear(rng, sun + 2 * planet, internal=True)},
        "arm": {**body(rng, 0.06), "position": [0.0, 0.0]},
    }
    case["rotors"]["planet"]["position"] = [reach * math.cos(angle), reach * math.sin(angle)]
    case["rotors"]["output"]["position"] = [0.0, 0.0]
    for driver, driven in (("input", "planet"), ("planet", "output")):
        mesh = mesh_of(rng, driver, driven, module, seed)
        del mesh["angle"]
        mesh["pressure_angle"] = math.radians(20.0)
        case["meshes"].append(mesh)
    case["supports"]["planet"] = _support(rng) | {"on": "arm"}
    case["supports"]["arm"] = {
        "torsional_stiffness": float(rng.uniform(200.0, 2000.0)),
        "torsional_damping": float(rng.uniform(0.01, 0.1)),
    }
    if feature["planet"] == "b":
        case["sleeves"]["planet"] = _sleeve(rng, LAWS[seed % 5], False, False) | {"on": "arm"}
        case["supports"]["arm"] |= _support(rng)
    return [("mesh", 0, "input", "planet"), ("mesh", 1, "planet", "output")]


def _coupling(rng: np.random.Generator, kind: str, between: list[str], lateral: bool) -> dict[str, Any]:
    coupling: dict[str, Any] = {
        "between": between,
        "torsional_stiffness": float(10.0 ** rng.uniform(2.5, 3.5)),
        "torsional_damping": float(rng.choice([0.0, 0.02, 0.1])),
    }
    if kind == "play":
        coupling["play"] = float(rng.uniform(5e-4, 2e-3))
    if kind == "belt":
        coupling["ratio"] = -1.6
    if lateral:
        coupling["lateral_stiffness"] = float(10.0 ** rng.uniform(5.5, 6.5))
        coupling["lateral_damping"] = float(rng.uniform(10.0, 100.0))
    return coupling


def _ends(rng: np.random.Generator, feature: dict[str, Any], case: Case, links: list[Link]) -> list[Link]:
    """Add a motor before the train and a machine behind it, and the couplings to them."""
    lateral = bool(feature.get("lateral"))
    if front := feature.get("front"):
        case["rotors"] = {"motor": body(rng, 0.03), **case["rotors"]}
        case["couplings"].append(_coupling(rng, front, ["motor", "input"], lateral))
        links = [("coupling", 0, "motor", "input"), *links]
    if rear := feature.get("rear"):
        case["rotors"]["machine"] = body(rng, 0.06)
        # Named from behind, so that the torque on the first rotor is tried in both directions of the train.
        case["couplings"].append(_coupling(rng, rear, ["machine", "output"], lateral))
        links = [*links, ("coupling", len(case["couplings"]) - 1, "output", "machine")]
    if rear == "sprung":
        spring = {"torsional_stiffness": float(rng.uniform(20.0, 200.0)), "torsional_damping": 0.01}
        case["supports"]["machine"] = spring
    return links


# ---------------------------------------------------------------------- what bears it


def _support(rng: np.random.Generator) -> dict[str, Any]:
    stiffness = 10.0 ** rng.uniform(6.0, 7.7, 2)
    return {
        "stiffness": [float(k) for k in stiffness],
        "damping": [float(c) for c in rng.uniform(0.0, 300.0, 2)],
        "torsional_damping": float(rng.uniform(0.0, 5e-3)),
    }


def _bear(rng: np.random.Generator, feature: dict[str, Any], seed: int, case: Case) -> None:
    """Bear the rotors in turn: s a sleeve, p a support, b both, h held, with a damper of rotation."""
    carried = {"planet", "arm", "absorber"}
    for k, name in enumerate(name for name in case["rotors"] if name not in carried):
        how = feature["free"][k % len(feature["free"])]
        support = _support(rng)
        if how == "h":
            del support["stiffness"], support["damping"]
        if how in "sb":
            case["sleeves"][name] = _sleeve(rng, LAWS[(seed + k) % 5], seed % 4 == 1, False)
        if how in "pb" or (how == "h" and feature.get("damper")):
            case["supports"][name] = {**case["supports"].get(name, {}), **support}


def _absorber(rng: np.random.Generator, case: Case) -> None:
    """Hang a disc elastically on the output, beside its centre, so that it is carried round."""
    places = {rotor.name: rotor.position for rotor in Reference(case).rotors}
    x, y = places["output"]
    case["rotors"]["absorber"] = {**body(rng, 0.02), "position": [x + 0.02, y - 0.01]}
    case["supports"]["absorber"] = {
        "stiffness": [float(10.0 ** rng.uniform(5.0, 6.0)), float(10.0 ** rng.uniform(5.0, 6.0))],
        "damping": [20.0, 5.0],
        "torsional_stiffness": float(rng.uniform(5.0, 50.0)),
        "torsional_damping": float(rng.uniform(0.0, 0.01)),
        "on": "output",
    }


# ---------------------------------------------------------------------- what drives, loads and shakes it


def _terms(rng: np.random.Generator, kinds: str, size: float) -> list[dict[str, float]]:
    """Return terms of a torque [N m]: f in time, o in rotation."""
    terms = []
    for kind in kinds:
        term = {"amplitude": size * float(rng.uniform(0.3, 1.0)), "phase": float(rng.uniform(0.0, 6.0))}
        if kind == "f":
            term["frequency"] = float(rng.uniform(60.0, 600.0))
        else:
            term["order"] = float(rng.choice([1.0, 2.0, 2.5, 7.0, 12.0]))
        terms.append(term)
    return terms


def _drive(rng: np.random.Generator, feature: dict[str, Any]) -> dict[str, Any]:
    kind = feature.get("drive", "speed")
    if kind == "torque":
        torque = float(rng.uniform(0.5, 1.5))
        return {"kind": kind, "torque": torque, "terms": _terms(rng, feature["terms"], torque)}
    if kind in ("position", "sampled"):
        drive = {
            "kind": "position",
            "angle": float(rng.uniform(0.015, 0.02)),
            "proportional_gain": float(rng.uniform(40.0, 80.0)),
            "derivative_gain": float(rng.uniform(0.1, 0.3)),
            "integral_gain": float(rng.uniform(1e3, 4e3)),
        }
        drive["torque_limit"] = (
            0.6 * drive["proportional_gain"] * drive["angle"]
        )  # it starts there, and leaves
        if kind == "position":  # the sensor's rotor turns against the motor
            return drive | {"sensor": "output", "angle": -drive["angle"]}
        return drive | {"sample_time": 7e-4}
    speed = float(rng.uniform(20.0, 60.0)) * (-1.0 if feature.get("back") else 1.0)
    if kind == "speed":
        return {"kind": kind, "speed": speed}
    gain = float(rng.uniform(0.1, 0.3))
    return {
        "kind": kind,
        "speed": speed,
        "proportional_gain": gain,
        "integral_gain": 100.0 * gain,
        "torque_limit": 0.03 * gain * abs(speed),
    }


def _excite(rng: np.random.Generator, feature: dict[str, Any], case: Case) -> None:
    rotors = case["rotors"]
    next(iter(rotors.values()))["drive"] = _drive(rng, feature)
    last = rotors["machine" if "machine" in rotors else "output"]
    last["load"] = {"drag": float(rng.uniform(1e-3, 1e-2))}
    if load := feature.get("load"):
        torque = float(rng.uniform(0.3, 1.5))
        last["load"] |= {"torque": torque, "terms": _terms(rng, load, 1.6 * torque)}
    heavy = list(rotors.values())[-feature.get("heavy", 0) :] if feature.get("heavy") else []
    for rotor in heavy:
        rotor["unbalance"] = {
            "amount": float(rng.uniform(0.02, 0.1)) * math.sqrt(rotor["mass"] * rotor["inertia"]),
            "phase": float(rng.uniform(0.0, 6.0)),
        }
    if "base" in feature:
        case["base"] = {"acceleration": _shake(rng, feature["base"])}


def _shake(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    direction = float(rng.uniform(-math.pi, math.pi))
    if kind == "half-sine":
        times = {"duration": float(rng.uniform(2e-3, 4e-3)), "start": float(rng.uniform(1e-3, 3e-3))}
        return {"kind": kind, "amplitude": float(rng.uniform(50.0, 200.0)), **times, "direction": direction}
    return {
        "kind": kind,
        "amplitude": float(rng.uniform(10.0, 60.0)),
        "frequency": float(rng.uniform(60.0, 300.0)),
        "phase": float(rng.uniform(0.0, 6.0)),
        "direction": direction,
    }


def _rub(seed: int, meshes: list[dict[str, Any]]) -> None:
    """Give meshes friction, from a generator of its own; every other one keeps the usual speed of smoothing."""
    rng = np.random.default_rng([39, seed])
    for k, mesh in enumerate(meshes):
        mesh["friction_coefficient"] = float(rng.uniform(0.05, 0.2))
        mesh["friction_phase"] = float(rng.uniform(-6.0, 6.0))
        speed = float(10.0 ** rng.uniform(-2.3, -1.0))
        if (seed + k) % 2:
            mesh["friction_speed"] = speed


def excited_case(seed: int) -> Case:
    """Return the case of a seed, SI floats, without a run."""
    feature, rng = FEATURES[seed], np.random.default_rng([21, seed])
    case: Case = {
        "title": f"excited system {seed}",
        "backlash_model": "uncoupled" if feature.get("rigid") else "coupled",
        "gravity": [2.0, -9.0] if feature.get("gravity") else [0.0, 0.0],
        "rotors": {},
        "sleeves": {},
        "supports": {},
        "meshes": [],
        "couplings": [],
    }
    links = (_planet if "planet" in feature else _stages)(rng, feature, seed, case)
    links = _ends(rng, feature, case, links)
    if feature.get("absorber"):
        _absorber(rng, case)
    _bear(rng, feature, seed, case)
    _excite(rng, feature, case)
    displace(rng, case)
    start_in_gaps(rng, case, links)
    _rub(seed, case["meshes"][len(case["meshes"]) - feature.get("rub", 0) :])
    return case
