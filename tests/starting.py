"""Random trains that differ in the order of their tables alone."""

import itertools
import math
import random
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gearplay as gp
from gearplay.integrate.switches import make_memory
from gearplay.kernels.layout import omega_of, theta_of, vx_of, x_of
from gearplay.model.case import Case
from gearplay.model.initial import Starts
from gearplay.model.pack import Packed, pack
from gearplay.model.touch import gaps_of_mesh

Document = dict[str, Any]
MODULE = 2e-3


def _mesh(rng: random.Random, driver: str, driven: str) -> Document:
    mesh = {
        "driver": driver,
        "driven": driven,
        "module": MODULE,
        "pressure_angle": math.radians(20.0),
        "backlash": rng.uniform(80e-6, 150e-6),
        "stiffness": {"kind": "harmonic", "mean": 1e8},
    }
    if rng.random() < 0.5:
        mesh["angle"] = rng.uniform(-math.pi, math.pi)
    if rng.random() < 0.5:
        mesh["transmission_error"] = [
            {"order": rng.randint(1, 3), "amplitude": rng.uniform(1e-6, 6e-6), "phase": rng.uniform(0.0, 6.0)}
        ]
    return mesh


def _gear(rng: random.Random) -> Document:
    runout = {"amplitude": rng.uniform(0.0, 25e-6), "phase": rng.uniform(0.0, 6.0)}
    return {"teeth": rng.randint(17, 45), "runout": runout}


def train(seed: int) -> Document:
    """Return a tree of three to five meshes: shafts of one or two gears, couplings, sleeves, any kind of drive or start."""
    rng = random.Random(seed)
    rotors: Document = {"g0": {"mass": 0.3, "inertia": 1e-4, **_gear(rng)}}
    meshes: list[Document] = []
    couplings: list[Document] = []
    gears = ["g0"]
    for k in range(1, rng.randint(3, 4) + 1):
        name, parent = f"g{k}", rng.choice(gears)
        body: Document = {"mass": 0.3, "inertia": 1e-4}
        if rng.random() < 0.3:
            rotors[name] = {**body, "gears": {"wheel": _gear(rng), "pinion": _gear(rng)}}
            ends, mine = [f"{name}.wheel", f"{name}.pinion"], f"{name}.wheel"
        else:
            rotors[name] = {**body, **_gear(rng)}
            ends, mine = [name], name
        pair = (parent, mine) if rng.random() < 0.8 else (mine, parent)
        meshes.append(_mesh(rng, *pair))
        gears += ends
    if rng.random() < 0.5:
        on = rng.choice([*rotors])
        rotors["disc"] = {"mass": 1.0, "inertia": 1e-3}
        ratio = rng.choice([1.0, -2.5, 0.5])
        between = ["disc", on] if rng.random() < 0.5 else [on, "disc"]
        couplings.append({"between": between, "torsional_stiffness": 1e3, "ratio": ratio})
        if rng.random() < 0.5:
            rotors["motor"] = {"mass": 1.0, "inertia": 1e-3}
            couplings.append({"between": ["motor", "disc"], "torsional_stiffness": 1e3})
    sleeves = {
        name: {"radial_clearance": 40e-6, "stiffness": 1e10, "restitution": 0.9}
        for name in rotors
        if rng.random() < 0.4
    }
    _moved(rng, rotors)
    return {
        "rotors": rotors,
        "sleeves": sleeves,
        "meshes": meshes,
        "couplings": couplings,
        "run": {"duration": 1e-3, "seed": seed},
    }


def _moved(rng: random.Random, rotors: Document) -> None:
    """Drive a train, or give some of its rotors speeds; turn one, or none."""
    names = [*rotors]
    kind = rng.choice(["speed", "torque", "servo", "none", "two"])
    one, other = rng.sample(names, 2)
    if kind == "speed":
        rotors[one]["drive"] = {"kind": "speed", "speed": rng.uniform(-50.0, 50.0)}
    elif kind == "servo":
        gains = {"proportional_gain": 1.0, "integral_gain": 1.0, "torque_limit": 10.0}
        rotors[one]["drive"] = {"kind": "servo", "speed": rng.uniform(-50.0, 50.0), **gains}
    elif kind in ("torque", "two"):
        for name in (one, other) if kind == "two" else (one,):
            rotors[name]["drive"] = {"kind": "torque", "torque": rng.uniform(-5.0, 5.0)}
    if kind != "speed" and rng.random() < 0.6:
        rotors[other]["initial"] = {"omega": rng.uniform(-50.0, 50.0)}
        if rng.random() < 0.5:
            rotors[other]["initial"]["theta"] = rng.uniform(-0.5, 0.5)


def planetary(seed: int) -> Document:
    """Return a planetary set whose planets have runouts of their own; sun, ring and carrier driven, held or free."""
    rng = random.Random(seed)
    count = rng.choice([3, 4])
    runout = {"amplitude": 15e-6, "phase": 0.4}
    members: Document = {
        "sun": {"teeth": 24, "mass": 0.4, "inertia": 4e-4, "runout": runout},
        "ring": {"teeth": 60, "mass": 2.0, "inertia": 3e-2, "runout": {"amplitude": 10e-6, "phase": 2.0}},
        "carrier": {"mass": 1.5, "inertia": 6e-3},
    }
    drive = {"kind": "torque", "torque": 20.0}
    if rng.random() < 0.5:
        drive = {"kind": "speed", "speed": rng.uniform(-100.0, 100.0)}
    driven, held = rng.sample([*members], 2)
    members[driven]["drive"] = drive
    if rng.random() < 0.7:
        members[held]["fixed"] = True
    return {
        "rotors": {},
        "planetary": {
            "stage": {
                "module": 4e-3,
                "backlash": rng.uniform(80e-6, 150e-6),
                "stiffness": {"kind": "harmonic", "mean": 1.3e8},
                "planets": {"count": count, "teeth": 18, "mass": 0.5, "inertia": 5e-4},
                "pin": {"radial_clearance": 20e-6, "stiffness": 1e10, "restitution": 0.9},
                "eccentricities": [
                    {"planet": k + 1, "amplitude": rng.uniform(0.0, 20e-6), "phase": rng.uniform(0.0, 6.0)}
                    for k in range(count)
                ],
                **members,
            }
        },
        "run": {"duration": 1e-3, "seed": seed},
    }


def expanded(document: Document) -> Document:
    """Return a case with planetary sets as tables of rotors, pins and meshes of their own, names without a dot."""
    whole = gp.load_case(document).model_dump(mode="json", exclude_none=True)
    del whole["planetary"]

    def renamed(value: Any) -> Any:
        if isinstance(value, str):
            return value.replace("stage.", "")
        if isinstance(value, list):
            return [renamed(each) for each in value]
        if isinstance(value, dict):
            return {renamed(key): renamed(each) for key, each in value.items()}
        return value

    return renamed(whole)  # type: ignore[no-any-return]


def orders(document: Document, most: int = 24) -> Iterator[Document]:
    """Yield the document with its meshes in every order, or in ``most`` of them, the other tables shuffled too."""
    rng = random.Random(0)
    every = list(itertools.permutations(document["meshes"]) if len(document["meshes"]) < 7 else ())
    if not every:
        every = [tuple(rng.sample(document["meshes"], len(document["meshes"]))) for _ in range(most)]
    for meshes in rng.sample(every, min(most, len(every))):
        shuffled = {
            table: dict(rng.sample([*document[table].items()], len(document[table])))
            for table in ("rotors", "sleeves", "supports")
            if table in document
        }
        couplings = rng.sample(document.get("couplings", []), len(document.get("couplings", [])))
        yield {**document, **shuffled, "couplings": couplings, "meshes": list(meshes)}


def starts_of(document: Document) -> tuple[Case, Packed, Starts]:
    """Return a case, packed, with its starts."""
    case = gp.load_case(document)
    packed = pack(case)
    return case, packed, Starts(case, packed)


def by_name(case: Case, packed: Packed, y: NDArray[np.float64]) -> dict[str, list[float]]:
    """Return every rotor's (x, y, theta, vx, vy, omega) in a state."""
    speeds, system = packed.system.rotors["nominal_speed"], packed.system
    found = {}
    for i, name in enumerate(case.rotors):
        omega = float(y[omega_of(system, i)] + speeds[i])
        found[name] = [*y[x_of(i) : theta_of(i) + 1], *y[vx_of(system, i) : omega_of(system, i)], omega]
    return found


def depths(case: Case, packed: Packed, y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the penetrations of drive and back flanks at a state [m], shape [mesh, flank]."""
    memory = make_memory(packed.system)
    found = [gaps_of_mesh(packed, j, y, memory) for j in range(len(case.meshes))]
    return np.array([(p_d, -b_t - p_d) for p_d, b_t in found])
