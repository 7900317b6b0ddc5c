"""Random planetary sets as one table each, and what they stand for, worked out independently of the package.

Twelve seeds, 0 to 11; the seed selects the features, and the numbers too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cross.random_systems import LAWS, _sleeve, _stiffness

NAME = "set"

# n: planets.  by: the input.  servo: its kind of drive.  back: clockwise.  held: the member that is kept from
# turning, and how ("fixed", "speed", "spring").  pins: bush | elastic.  free: how sun, ring and carrier are
# borne, h held, f floating, p support, b sleeve.  odd: teeth of a planet.  angles: unequal ones.
# errors, own, runout: so many pins beside their places, planets with a runout of their own, runout of all.
# kind, split: of the stiffness.  rub: friction of teeth.  rigid: backlash_model = "uncoupled".
# load: of the member that is left.  turned: the carrier is, at the start [rad].
FEATURES: tuple[dict[str, Any], ...] = (
    {"n": 3, "by": "sun", "held": "ring", "pins": "bush", "free": "fhh", "load": 1},
    {"n": 4, "by": "ring", "held": "sun", "pins": "elastic", "free": "hph", "errors": 2, "odd": 1, "load": 1},
    {"n": 3, "by": "carrier", "held": "sun", "pins": "bush", "free": "hfh", "errors": 1,
     "kind": "square", "load": 1},
    {"n": 5, "by": "carrier", "held": "ring", "pins": "bush", "free": "fhp", "runout": 1, "odd": 1,
     "load": 1},
    {"n": 4, "by": "sun", "held": "ring", "pins": "bush", "free": "phh", "rigid": 1, "errors": 1, "load": 1},
    {"n": 5, "by": "sun", "held": "carrier", "pins": "elastic", "free": "hfh", "own": 2, "odd": 1, "load": 1},
    {"n": 6, "by": "sun", "held": "ring", "pins": "elastic", "free": "bhh", "kind": "square", "own": 1,
     "load": 1},
    {"n": 3, "by": "sun", "held": "ring", "pins": "bush", "free": "fph", "angles": 1, "rub": 1, "load": 1},
    {"n": 2, "by": "ring", "held": "carrier", "pins": "bush", "free": "bhh", "own": 2, "runout": 1, "odd": 1},
    {"n": 3, "by": "carrier", "held": "ring", "pins": "elastic", "free": "fhf", "rigid": 1,
     "errors": 3, "load": 1},
    {"n": 4, "by": "sun", "held": "ring", "how": "spring", "pins": "bush", "free": "hpb", "runout": 1,
     "odd": 1},
    {"n": 3, "by": "sun", "held": "ring", "how": "speed", "pins": "bush", "free": "bff", "servo": 1,
     "split": 1,
     "rub": 1, "back": 1, "gravity": 1, "turned": 0.6, "load": 1, "errors": 3, "own": 1},
)  # fmt: skip
SEEDS = tuple(range(len(FEATURES)))
MEMBERS = ("sun", "ring", "carrier")


# ---------------------------------------------------------------------- numbers of teeth and members


def _teeth(rng: np.random.Generator, count: int, odd: bool) -> tuple[int, int]:
    """Return teeth of sun and planet that can be assembled, the planets apart and not all in phase."""
    while True:
        sun, planet = int(rng.integers(18, 40)), int(rng.integers(12, 28))
        apart = (sun + planet) * math.sin(math.pi / count) > planet + 3 if count > 1 else True
        if apart and planet % 2 == int(odd) and 2 * (sun + planet) % count == 0 and sun % count:
            return sun, planet


def _eccentric(rng: np.random.Generator) -> dict[str, float]:
    return {"amplitude": float(rng.uniform(3e-6, 12e-6)), "phase": float(rng.uniform(0.0, 6.0))}


def _springs(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "stiffness": [float(k) for k in 10.0 ** rng.uniform(6.5, 7.7, 2)],
        "damping": [float(c) for c in rng.uniform(0.0, 300.0, 2)],
    }


def _member(rng: np.random.Generator, how: str, seed: int) -> dict[str, Any]:
    """Return a member without teeth, borne as said, its centre moving a little at the start."""
    mass = float(rng.uniform(0.4, 1.5))
    made: dict[str, Any] = {
        "mass": mass,
        "inertia": mass * float(rng.uniform(0.02, 0.04)) ** 2,
        "initial": {},
    }
    if how == "h":
        return made
    if how == "f":
        made["floating"] = True
    elif how == "p":
        made["support"] = _springs(rng)
    else:
        made["sleeve"] = _sleeve(rng, LAWS[seed % 5], False, False)
        made["sleeve"]["offset"] = [float(v) for v in rng.uniform(-5e-6, 5e-6, 2)]
    x, y = (float(v) for v in rng.uniform(-5e-6, 5e-6, 2))
    v_x, v_y = (float(v) for v in rng.uniform(-0.03, 0.03, 2))
    return {**made, "initial": {"x": x, "y": y, "vx": v_x, "vy": v_y}}


def _drive(rng: np.random.Generator, feature: dict[str, Any]) -> dict[str, Any]:
    speed = float(rng.uniform(20.0, 60.0)) * (-1.0 if feature.get("back") else 1.0)
    if not feature.get("servo"):
        return {"kind": "speed", "speed": speed}
    gain = float(rng.uniform(0.1, 0.3))
    limit = 0.03 * gain * abs(speed)
    gains = {"proportional_gain": gain, "integral_gain": 100.0 * gain, "torque_limit": limit}
    return {"kind": "servo", "speed": speed, **gains}


# ---------------------------------------------------------------------- the table


def _toothing(rng: np.random.Generator, feature: dict[str, Any]) -> dict[str, Any]:
    """Return what the meshes of a set share."""
    kind, mean = feature.get("kind", "harmonic"), float(10.0 ** rng.uniform(7.2, 8.0))
    made: dict[str, Any] = {
        "module": float(rng.choice([1.5e-3, 2e-3])),
        "pressure_angle": math.radians(float(rng.choice([20.0, 22.5]))),
        "backlash": float(rng.uniform(60e-6, 120e-6)),
        "damping": {"maximum": float(rng.uniform(20.0, 200.0)), "depth": float(rng.uniform(1e-6, 3e-6))},
        "transmission_error": [
            {"order": 1, "amplitude": float(rng.uniform(1e-6, 4e-6)), "phase": float(rng.uniform(0.0, 6.0))},
            {"order": 2, "amplitude": 1e-6, "phase": float(rng.uniform(0.0, 6.0))},
        ],
    }
    if feature.get("split"):
        made |= {
            "sun_planet": _stiffness(rng, "fourier", mean),
            "planet_ring": _stiffness(rng, "table", 1.3 * mean),
        }
    else:
        made["stiffness"] = _stiffness(rng, kind, mean)
    if feature.get("rub"):
        made |= {"friction_coefficient": 0.1, "friction_speed": 0.02}
    return made


def _held(feature: dict[str, Any], member: dict[str, Any]) -> None:
    how = feature.get("how", "fixed")
    if how == "fixed":
        member["fixed"] = True
    elif how == "speed":
        member["drive"] = {"kind": "speed", "speed": 0.0}
    else:
        member["support"] = {
            **member.get("support", {}),
            "torsional_stiffness": 2e4,
            "torsional_damping": 1.0,
        }


def planetary_case(seed: int) -> dict[str, Any]:
    """Return the case document of a seed, SI floats, without a run."""
    feature, rng = FEATURES[seed], np.random.default_rng([43, seed])
    count = feature["n"]
    z_sun, z_planet = _teeth(rng, count, bool(feature.get("odd")))
    members = {name: _member(rng, how, seed) for name, how in zip(MEMBERS, feature["free"], strict=True)}
    members["sun"]["teeth"], members["ring"]["teeth"] = z_sun, z_sun + 2 * z_planet
    members[feature["by"]]["drive"] = _drive(rng, feature)
    _held(feature, members[feature["held"]])
    (last,) = set(MEMBERS) - {feature["by"], feature["held"]}
    members[last]["load"] = {"drag": float(rng.uniform(1e-3, 1e-2))}
    if feature.get("load"):
        # With friction, so much that teeth stay in contact while they pass the pitch point.
        members[last]["load"]["torque"] = float(rng.uniform(0.5, 3.0)) * (10.0 if feature.get("rub") else 1.0)
    if turned := feature.get("turned"):  # the sun goes along, so that it rolls in the ring that stands
        members["carrier"]["initial"]["theta"] = turned
        members["sun"]["initial"]["theta"] = turned * 2.0 * (z_sun + z_planet) / z_sun
    mass = float(rng.uniform(0.1, 0.4))
    planets: dict[str, Any] = {
        "count": count,
        "teeth": z_planet,
        "mass": mass,
        "inertia": mass * float(rng.uniform(0.012, 0.018)) ** 2,
        "load": {"drag": float(rng.uniform(1e-4, 1e-3))},
    }
    if feature["pins"] == "bush":
        planets["radial_damping"] = float(rng.uniform(1.0, 20.0))
    made = {**_toothing(rng, feature), **members, "planets": planets}
    _misplace(rng, feature, made)
    if feature["pins"] == "bush":
        made["pin"] = _sleeve(rng, LAWS[seed % 5], seed % 4 == 0, False)
        made["pin"]["radial_clearance"] = float(rng.uniform(10e-6, 40e-6))
    else:
        made["support"] = _springs(rng) | {"torsional_damping": float(rng.uniform(0.0, 1e-3))}
    return {
        "title": f"planetary set {seed}",
        "backlash_model": "uncoupled" if feature.get("rigid") else "coupled",
        "gravity": [2.0, -9.0] if feature.get("gravity") else [0.0, 0.0],
        "rotors": {},
        "meshes": [],
        "planetary": {NAME: made},
    }


def _misplace(rng: np.random.Generator, feature: dict[str, Any], made: dict[str, Any]) -> None:
    """Put pins, teeth and planets elsewhere than usual."""
    planets, count = made["planets"], feature["n"]
    if feature.get("runout"):
        for toothed in (made["sun"], made["ring"], planets):
            toothed["runout"] = _eccentric(rng)
    if feature.get("angles"):  # so many steps of the teeth from one planet to the next
        step = 2.0 * math.pi / (made["sun"]["teeth"] + made["ring"]["teeth"])
        third = 2.0 * math.pi / (3.0 * step)
        planets["angles"] = [0.3 + step * round(third * k + shift) for k, shift in enumerate((0, 2, -1))]
    numbers = [int(k) for k in rng.permutation(count) + 1]
    made["pin_errors"] = [
        {
            "planet": k,
            "tangential": float(rng.uniform(-15e-6, 15e-6)),
            "radial": float(rng.uniform(-15e-6, 15e-6)),
        }
        for k in numbers[: feature.get("errors", 0)]
    ]
    own = numbers[: feature.get("own", 0)]
    made["eccentricities"] = [{"planet": k, **_eccentric(rng)} for k in own]


# ---------------------------------------------------------------------- what it stands for


def _turns(member: dict[str, Any]) -> bool:
    drive = member.get("drive")
    return drive is not None and not (drive["kind"] == "speed" and drive["speed"] == 0.0)


def _stands(member: dict[str, Any]) -> bool:
    still = member.get("drive") is not None and not _turns(member)
    return bool(member.get("fixed")) or still or "torsional_stiffness" in member.get("support", {})


def sun_first(table: dict[str, Any]) -> bool:
    """Return whether power goes from the sun over the planets to the ring, or along the sun that stands."""
    turning = [name for name in MEMBERS if _turns(table[name])]
    if turning[:1] == ["carrier"]:
        return _stands(table["sun"]) and not _stands(table["ring"])
    return turning[:1] != ["ring"]


def _directions(table: dict[str, Any]) -> list[float]:
    planets = table["planets"]
    count = planets["count"]
    return planets.get("angles") or [2.0 * math.pi * k / count for k in range(count)]


def phases_of(table: dict[str, Any]) -> list[float]:
    """Return the phases of all meshes in closed form [rad], first those that drive the planets.

    A planet is driven on one flank of a tooth and drives with the other one, half a pitch away; opposite a
    tooth it has a tooth or, with an odd number, a gap.
    """
    z_sun, z_ring, angles = table["sun"]["teeth"], table["ring"]["teeth"], _directions(table)
    half = math.pi if table["planets"]["teeth"] % 2 == 0 else 0.0
    if sun_first(table):
        return [-z_sun * angle for angle in angles] + [z_sun * angle + half for angle in angles]
    return [-z_ring * angle for angle in angles] + [-z_ring * angle + half for angle in angles]


def _rotor_of(member: dict[str, Any]) -> dict[str, Any]:
    plain = {key: part for key, part in member.items() if key not in ("fixed", "support", "sleeve")}
    if member.get("fixed"):
        plain["drive"] = {"kind": "speed", "speed": 0.0}
    return {**plain, "position": [0.0, 0.0]}


def _beside(error: dict[str, Any], direction: float) -> list[float]:
    """Return where a pin is beside its place."""
    c, s = math.cos(direction), math.sin(direction)
    out, ahead = error.get("radial", 0.0), error.get("tangential", 0.0)
    return [out * c - ahead * s, out * s + ahead * c]


def expanded(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document with what its planetary sets stand for, members called ``set/member``."""
    rotors, meshes = dict(document["rotors"]), list(document["meshes"])
    borne: dict[str, dict[str, Any]] = {"sleeves": {}, "supports": {}}
    for name, table in document["planetary"].items():
        for member in MEMBERS:
            rotors[f"{name}/{member}"] = _rotor_of(table[member])
            for part, where in (("sleeve", "sleeves"), ("support", "supports")):
                if part in table[member]:
                    borne[where][f"{name}/{member}"] = table[member][part]
        rotors[f"{name}/ring"]["internal"] = True
        _add_planets(name, table, rotors, borne)
        meshes += _meshes_of(name, table)
    kept = {key: part for key, part in document.items() if key != "planetary"}
    return {**kept, **borne, "rotors": rotors, "meshes": meshes, "mesh_phases": "from_zero"}


def _add_planets(
    name: str, table: dict[str, Any], rotors: dict[str, Any], borne: dict[str, dict[str, Any]]
) -> None:
    planets = table["planets"]
    distance = 0.5 * table["module"] * (table["sun"]["teeth"] + planets["teeth"])
    errors = {error["planet"]: error for error in table.get("pin_errors", ())}
    own = {each["planet"]: each for each in table.get("eccentricities", ())}
    shared = {key: part for key, part in planets.items() if key not in ("count", "angles")}
    for k, direction in enumerate(_directions(table), start=1):
        at = [distance * math.cos(direction), distance * math.sin(direction)]
        planet = {**shared, "position": at}
        if k in own:
            planet["runout"] = {key: own[k][key] for key in ("amplitude", "phase")}
        rotors[f"{name}/planet{k}"] = planet
        where, part = ("sleeves", "pin") if "pin" in table else ("supports", "support")
        offset = _beside(errors.get(k, {}), direction)
        side = {"rotor_side": "bush"} if part == "pin" else {}
        borne[where][f"{name}/planet{k}"] = {**table[part], **side, "on": f"{name}/carrier", "offset": offset}


def _meshes_of(name: str, table: dict[str, Any]) -> list[dict[str, Any]]:
    first, last = ("sun", "ring") if sun_first(table) else ("ring", "sun")
    keys = ("module", "pressure_angle", "backlash", "damping", "transmission_error")
    shared = {key: table[key] for key in (*keys, "friction_coefficient", "friction_speed") if key in table}
    kinds = {"sun": table.get("sun_planet"), "ring": table.get("planet_ring")}
    planets = [f"planet{k + 1}" for k in range(table["planets"]["count"])]
    ends = [(first, planet, first) for planet in planets] + [(planet, last, last) for planet in planets]
    return [
        {
            **shared,
            "driver": f"{name}/{driver}",
            "driven": f"{name}/{driven}",
            "stiffness": kinds[side] or table["stiffness"],
            "phase": phase,
        }
        for (driver, driven, side), phase in zip(ends, phases_of(table), strict=True)
    ]
