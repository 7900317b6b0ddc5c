"""Random trains of two and three stages: shafts with several gears, laid out at angles, every mesh with a module of its own."""

from typing import Any

import numpy as np

from cross.random_systems import LAWS, _load, _sleeve
from cross.train_parts import body, gear, mesh_of
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.model.reading import load_case


def staged_case(seed: int) -> dict[str, Any]:
    """Return the resolved case of a seed (SI floats), its starts drawn and written out."""
    rng = np.random.default_rng([18, seed])
    stages = 2 + seed % 2
    rotors: dict[str, Any] = {}
    meshes: list[dict[str, Any]] = []
    teeth = int(rng.integers(18, 26))
    rotors["input"] = {
        **body(rng, 0.03),
        **gear(rng, teeth),
        "drive": {
            "kind": "speed",
            "speed": float(rng.uniform(20.0, 60.0)) * (-1.0 if seed % 3 == 1 else 1.0),
        },
    }
    driver, speed, before = "input", rotors["input"]["drive"]["speed"], teeth
    for stage in range(1, stages):
        name = f"shaft{stage}"
        wheel, pinion = gear(rng, int(rng.integers(30, 50))), gear(rng, int(rng.integers(18, 24)))
        rotors[name] = {**body(rng, 0.06), "gears": {"wheel": wheel, "pinion": pinion}}
        meshes.append(mesh_of(rng, driver, f"{name}.wheel", float(rng.choice([1.5e-3, 2e-3])), seed + stage))
        speed *= -before / wheel["teeth"]
        driver, before = f"{name}.pinion", pinion["teeth"]
    inner = seed % 4 == 2
    last = gear(rng, int(rng.integers(60, 80)) if inner else int(rng.integers(30, 50)), internal=inner)
    # The last gear stands in a table of one, which a mesh need not name.
    rotors["output"] = (
        {**body(rng, 0.08), "gears": {"only": last}} if seed % 2 else {**body(rng, 0.08), **last}
    )
    meshes.append(mesh_of(rng, driver, "output", 2.5e-3, seed))
    speed *= (1.0 if inner else -1.0) * before / last["teeth"]
    _load(rng, {"load": seed % 3 != 2, "drag": seed % 2, "friction": seed % 5 == 0}, rotors["output"], speed)
    borne = [name for name in rotors if name != "input" or seed % 2]
    case = {
        "title": f"staged system {seed}",
        "backlash_model": "uncoupled" if seed % 5 == 3 else "coupled",
        "gravity": [2.0, -9.0] if seed % 2 else [0.0, 0.0],
        "rotors": rotors,
        "sleeves": {name: _sleeve(rng, LAWS[seed % 5], seed % 4 == 1, False) for name in borne},
        "meshes": meshes,
    }
    return started(case, seed)


def started(case: dict[str, Any], seed: int) -> dict[str, Any]:
    """Write a drawn start, which does not wedge, into the rotors."""
    made = load_case({**case, "run": {"duration": 0.01, "seed": seed}})
    packed = pack(made)
    state = initial_state(made, packed, member=1)
    n = len(case["rotors"])
    rng = np.random.default_rng([19, seed])
    for i, (name, rotor) in enumerate(case["rotors"].items()):
        x, y, theta = (float(v) for v in state[3 * i : 3 * i + 3])
        vx, vy, omega = (float(v) for v in state[3 * (n + i) : 3 * (n + i) + 3])
        start = {"x": x, "y": y, "vx": 20.0 * vx, "vy": 20.0 * vy} if name in case["sleeves"] else {}
        if "drive" not in rotor:
            kick = float(rng.uniform(-0.5, 0.5))
            start |= {"theta": theta, "omega": omega + float(packed.system.rotors["nominal_speed"][i]) + kick}
        if start:
            rotor["initial"] = start
    return case
