"""Random but reproducible gear systems for cross-checks, in the form of a resolved case (SI floats).

The seed modulo 20 selects the features (so that 0..19 cover them all), the seed itself the numbers.  Teeth
start inside their backlash and journals inside their clearance, with speeds at which several contacts open
and close within 10 ms.  A "heavy" system has so much damping that a force can end before its penetration.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "gonthier", "conformal")

# Features of the seeds 0..19.  pair: internal | external | chain | planet; "ring": the ring drives.
FEATURES: tuple[dict[str, Any], ...] = (
    {"pair": "internal", "law": 0, "load": 1},
    {"pair": "internal", "law": 1, "uncoupled": 1, "drag": 1},
    {"pair": "external", "law": 2, "both": 1, "error": 1},
    {"pair": "external", "law": 3, "uncoupled": 1, "negative": 1, "load": 1, "heavy": 1},
    {"pair": "internal", "law": 4, "gravity": 1, "both": 1},
    {"pair": "chain", "law": 0, "error": 1, "drag": 1},
    {"pair": "internal", "law": 2, "ring": 1, "stiffness": "fourier", "load": 1, "heavy": 1},
    {"pair": "internal", "law": 1, "drive": "torque", "floating": 1, "drag": 1},
    {"pair": "external", "law": 0, "drive": "servo", "stiffness": "square", "load": 1},
    {"pair": "internal", "law": 0, "published": 1, "drag": 1, "error": 1},
    {"pair": "external", "law": 3, "ramp": 1, "both": 1, "radial": 1},
    {"pair": "internal", "law": 0, "both": 1, "runout": 1, "error": 1, "negative": 1},
    {"pair": "external", "drive": "torque", "floating": 2, "uncoupled": 1},
    {"pair": "internal", "law": 3, "ring": 1, "negative": 1, "stiffness": "table", "gravity": 1, "heavy": 1},
    {"pair": "internal", "law": 1, "drive": "servo", "ramp": 1, "both": 1, "drag": 1, "heavy": 1},
    {"pair": "external", "law": 2, "published": 1, "uncoupled": 1, "both": 1, "load": 1},
    {"pair": "internal", "law": 0, "friction": 1, "both": 1, "load": 1},
    {"pair": "planet", "law": 1, "gravity": 1, "friction": 1},
    {"pair": "external", "law": 4, "runout": 1, "error": 1, "both": 1, "negative": 1, "heavy": 1},
    {"pair": "chain", "law": 3, "both": 1, "gravity": 1, "radial": 1, "runout": 1, "drive": "servo"},
)


def _sleeve(rng: np.random.Generator, law: str, friction: bool, heavy: bool) -> dict[str, Any]:
    sleeve: dict[str, Any] = {
        "radial_clearance": float(rng.uniform(20e-6, 100e-6)),
        "law": law,
        "stiffness": float(10.0 ** rng.uniform(9.0, 11.0)),
        "exponent": 1.5,
        "restitution": float(rng.uniform(0.6, 0.95)) * (0.3 if heavy else 1.0),
        "minimum_impact_speed": 1e-4,
    }
    if law == "conformal":
        sleeve |= {"shaft_radius": 0.01, "bed_exponent": 1.0, "bed_reference_penetration": 2e-6}
    if friction:
        sleeve |= {"friction_coefficient": 0.1, "friction_speed": 2e-3, "shaft_radius": 0.01}
    return sleeve


def _rotor(rng: np.random.Generator, teeth: int, module: float, internal: bool) -> dict[str, Any]:
    radius = 0.5 * module * teeth
    mass = float(rng.uniform(0.2, 1.0))
    gyration = float(rng.uniform(0.7, 1.0)) * radius * (1.1 if internal else 0.8)
    rotor: dict[str, Any] = {"teeth": teeth, "mass": mass, "inertia": mass * gyration**2}
    if internal:
        rotor["internal"] = True
    return rotor


def _stiffness(rng: np.random.Generator, kind: str, mean: float) -> dict[str, Any]:
    phase = float(rng.uniform(0.0, 2.0 * math.pi))
    if kind == "square":
        ratio = float(rng.uniform(1.4, 1.8))
        return {
            "kind": kind,
            "single": 0.8 * mean,
            "double": 1.2 * mean,
            "contact_ratio": ratio,
            "phase": phase,
        }
    if kind == "fourier":
        terms = [
            {"order": k, "amplitude": 0.1 * mean / k, "phase": float(rng.uniform(0.0, 6.0))}
            for k in (1, 2, 3)
        ]
        return {"kind": kind, "mean": mean, "terms": terms}
    if kind == "table":
        psi = [2.0 * math.pi * k / 8 for k in range(8)]
        values = [mean * float(rng.uniform(0.85, 1.15)) for _ in psi]
        return {"kind": kind, "phase": psi, "stiffness": values}
    return {"kind": kind, "mean": mean, "amplitude": 0.1 * mean, "phase": phase}


def _mesh(
    rng: np.random.Generator,
    case: dict[str, Any],
    driver: str,
    driven: str,
    module: float,
    feature: dict[str, Any],
) -> dict[str, Any]:
    rotors = case["rotors"]
    mean = float(10.0 ** rng.uniform(7.0, 8.0))
    inverse = 0.0
    for name in (driver, driven):
        radius = 0.5 * module * rotors[name]["teeth"]
        inverse += radius**2 / rotors[name]["inertia"]
    zeta = float(rng.uniform(0.02, 0.1)) * (10.0 if feature.get("heavy") else 1.0)
    mesh: dict[str, Any] = {
        "driver": driver,
        "driven": driven,
        "module": module,
        "pressure_angle": math.radians(20.0),
        "backlash": float(rng.uniform(60e-6, 160e-6)),
        "stiffness": _stiffness(rng, feature.get("stiffness", "harmonic"), mean),
        "damping": {
            "maximum": 2.0 * zeta * math.sqrt(mean / inverse),
            "depth": float(rng.uniform(1e-6, 3e-6)),
        },
    }
    if feature.get("error"):
        mesh["transmission_error"] = [
            {"order": 1, "amplitude": float(rng.uniform(2e-6, 6e-6)), "phase": float(rng.uniform(0.0, 6.0))},
            {"order": 3, "amplitude": 1e-6, "phase": float(rng.uniform(0.0, 6.0))},
        ]
    case["meshes"].append(mesh)
    return mesh


def _inside(rng: np.random.Generator, radius: float, rotor: dict[str, Any]) -> None:
    """Start a rotor's centre inside its clearance circle with 5 to 50 mm/s."""
    distance, direction = radius * float(rng.uniform(0.1, 0.6)), float(rng.uniform(0.0, 2.0 * math.pi))
    speed, heading = float(rng.uniform(5e-3, 50e-3)), float(rng.uniform(0.0, 2.0 * math.pi))
    rotor.setdefault("initial", {}).update(
        x=distance * math.cos(direction),
        y=distance * math.sin(direction),
        vx=speed * math.cos(heading),
        vy=speed * math.sin(heading),
    )


def _toothing(rotor: dict[str, Any]) -> tuple[float, float]:
    start, runout = rotor.get("initial", {}), rotor.get("runout", {"amplitude": 0.0, "phase": 0.0})
    angle = start.get("theta", 0.0) + runout["phase"]
    return (
        start.get("x", 0.0) + runout["amplitude"] * math.cos(angle),
        start.get("y", 0.0) + runout["amplitude"] * math.sin(angle),
    )


def _centre_gap(
    rng: np.random.Generator,
    case: dict[str, Any],
    mesh: dict[str, Any],
    speeds: dict[str, float],
    at_rest: bool,
) -> None:
    """Turn the driven rotor of a mesh into the middle of its backlash, with a speed of its own.

    The centres lie on the x axis; the change of backlash with their distance is left out.
    """
    rotors = case["rotors"]
    driver, driven = rotors[mesh["driver"]], rotors[mesh["driven"]]
    inner = bool(driver.get("internal") or driven.get("internal"))
    a, b = (driven, driver) if driven.get("internal") else (driver, driven)
    s = 1.0 if inner else -1.0
    sigma = -1.0 if speeds[mesh["driver"]] < 0.0 else 1.0
    if driver.get("internal"):
        sigma = -sigma
    base = 0.5 * mesh["module"] * math.cos(mesh["pressure_angle"])
    rho = {id(a): (-s if inner else 1.0) * base * a["teeth"], id(b): base * b["teeth"]}
    ca, cb = _toothing(a), _toothing(b)
    dy = cb[1] - ca[1]
    w = sigma * rho[id(driver)] * driver.get("initial", {}).get("theta", 0.0)
    w += s * sigma * math.cos(mesh["pressure_angle"]) * dy
    for term in mesh.get("transmission_error", []):
        angle = term["order"] * driver["teeth"] * driver.get("initial", {}).get("theta", 0.0)
        w += term["amplitude"] * math.sin(angle + term["phase"])
    target = -0.5 * mesh["backlash"]
    start = driven.setdefault("initial", {})
    start["theta"] = (target - w) / (sigma * rho[id(driven)])
    approach = float(rng.uniform(5e-3, 30e-3)) * (1.0 if rng.uniform() < 0.5 else -1.0)
    start["omega"] = (0.0 if at_rest else speeds[mesh["driven"]]) + approach / (base * driven["teeth"])


def _drive(rng: np.random.Generator, feature: dict[str, Any], rotor: dict[str, Any], inertia: float) -> float:
    """Give a rotor its drive; return its nominal speed (rad/s)."""
    kind = feature.get("drive", "speed")
    speed = float(rng.uniform(10.0, 40.0)) * (-1.0 if feature.get("negative") else 1.0)
    if kind == "torque":
        rotor["drive"] = {"kind": "torque", "torque": float(rng.uniform(0.2, 1.0))}
        return 0.0
    rotor["drive"] = {"kind": kind, "speed": speed}
    if kind == "servo":
        kp = inertia / 2e-3
        # at the start of a ramp the servo is free of its limit and reaches it on the way
        rotor["drive"] |= {
            "proportional_gain": kp,
            "integral_gain": kp / 5e-3,
            "torque_limit": 0.02 * kp * abs(speed),
        }
    if feature.get("ramp"):
        rotor["drive"]["ramp"] = float(rng.uniform(4e-3, 8e-3))
    return speed


def _load(rng: np.random.Generator, feature: dict[str, Any], rotor: dict[str, Any], speed: float) -> None:
    load: dict[str, float] = {}
    if feature.get("load") and speed:
        load["torque"] = float(rng.uniform(0.2, 1.0))
    if feature.get("drag"):
        load["drag"] = float(rng.uniform(1e-3, 1e-2))
    if feature.get("friction"):
        load |= {"friction": 0.2, "friction_speed": 0.05}
    if load:
        rotor["load"] = load


def random_case(seed: int) -> dict[str, Any]:
    """Return the resolved case of a seed (rotors, sleeves, meshes and options; SI floats)."""
    feature = FEATURES[seed % len(FEATURES)]
    rng = np.random.default_rng([20210834, seed])
    case: dict[str, Any] = {
        "title": f"random system {seed}",
        "formulation": "as_published" if feature.get("published") else "geometric",
        "backlash_model": "uncoupled" if feature.get("uncoupled") else "coupled",
        "gravity": [0.0, -9.81] if feature.get("gravity") else [0.0, 0.0],
        "rotors": {},
        "sleeves": {},
        "meshes": [],
    }
    rotors = case["rotors"]
    pair = feature["pair"]
    module = float(rng.choice([2e-3, 3e-3, 4e-3]))
    z1 = int(rng.integers(18, 24))
    if pair == "chain":
        rotors["pinion"] = _rotor(rng, z1, module, False)
        rotors["idler"] = _rotor(rng, z1 + 5, module, False)
        rotors["ring"] = _rotor(rng, 3 * z1, module, True)
        order = [("pinion", "idler"), ("idler", "ring")]
        sleeved = ["idler", "ring"] + (["pinion"] if feature.get("both") else [])
    elif pair == "external":
        rotors["pinion"] = _rotor(rng, z1, module, False)
        rotors["wheel"] = _rotor(rng, int(rng.integers(25, 40)), module, False)
        order = [("pinion", "wheel")]
        sleeved = ["wheel"] + (["pinion"] if feature.get("both") else [])
    else:
        rotors["pinion"] = _rotor(rng, z1, module, False)
        rotors["ring"] = _rotor(rng, 3 * z1, module, True)
        order = [("ring", "pinion")] if feature.get("ring") else [("pinion", "ring")]
        sleeved = ["ring"] + (["pinion"] if feature.get("both") else [])
    if pair == "planet":  # the pinion runs on a pin of a freely turning arm, the ring on the ground
        rotors["arm"] = {"mass": 0.5, "inertia": 4e-3, "initial": {"omega": float(rng.uniform(0.2, 0.5))}}
        sleeved = ["pinion", "ring"]

    first = order[0][0]
    speed = _drive(rng, feature, rotors[first], rotors[first]["inertia"])
    speeds = {first: speed}
    for driver, driven in order:
        inner = rotors[driver].get("internal") or rotors[driven].get("internal")
        ratio = rotors[driver]["teeth"] / rotors[driven]["teeth"] * (1.0 if inner else -1.0)
        speeds[driven] = speeds[driver] * ratio

    if feature.get("runout"):
        for name in (order[0][0], order[-1][1]):
            phase = float(rng.uniform(0.0, 6.0))
            rotors[name]["runout"] = {"amplitude": float(rng.uniform(5e-6, 20e-6)), "phase": phase}
    if feature.get("floating"):
        floating = [order[-1][1], first][: feature["floating"]]
        sleeved = [name for name in sleeved if name not in floating]
        if feature["floating"] == 1:
            sleeved.append(first)
        for name in floating:
            rotors[name]["floating"] = True
            _inside(rng, 30e-6, rotors[name])
    for name in sleeved:
        friction, heavy = bool(feature.get("friction")), bool(feature.get("heavy"))
        case["sleeves"][name] = _sleeve(rng, LAWS[feature["law"]], friction, heavy)
        _inside(rng, min(case["sleeves"][name]["radial_clearance"], 50e-6), rotors[name])
        if feature.get("radial"):
            rotors[name]["radial_damping"] = float(rng.uniform(1.0, 10.0))
    if pair == "planet":
        case["sleeves"]["pinion"]["on"] = "arm"
        rotors["arm"]["position"] = [0.0, 0.0]
    for driver, driven in order:
        mesh = _mesh(rng, case, driver, driven, module, feature)
        _centre_gap(rng, case, mesh, speeds, bool(feature.get("ramp")))
    last = order[-1][1]
    _load(rng, feature, rotors[last], speeds[last])
    return case
