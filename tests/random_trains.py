"""Random trains of the whole vocabulary of a case, and the invariants of contact that every motion must keep."""

from itertools import pairwise
from typing import Any

import numpy as np

from gearplay.results.result import Result

Document = dict[str, Any]
LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "gonthier")
MODULE = 2e-3


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(np.log10(low), np.log10(high)))


def _sleeve(rng: np.random.Generator) -> Document:
    """Return a sleeve: often without clearance, or with an offset beyond it, so that it is loaded from the start."""
    clearance = float(rng.choice([0.0, 5e-6, 2e-5, 1e-4]))
    exponent = float(rng.choice([1.0, 1.5]))
    sleeve: Document = {
        "radial_clearance": clearance,
        "law": str(rng.choice(LAWS)),
        "stiffness": _log(rng, 1e8, 5e9) if exponent == 1.0 else _log(rng, 1e10, 1e12),
        "exponent": exponent,
        "restitution": 1.0 if rng.random() < 0.3 else float(rng.uniform(0.2, 0.99)),
    }
    if rng.random() < 0.35:
        reach = clearance * rng.uniform(0.3, 1.0) if rng.random() < 0.3 else clearance + _log(rng, 1e-7, 1e-5)
        angle = rng.uniform(0.0, 2.0 * np.pi)
        sleeve["offset"] = [float(reach * np.cos(angle)), float(reach * np.sin(angle))]
    if rng.random() < 0.2:
        sleeve |= {"friction_coefficient": 0.1, "friction_speed": 0.1, "shaft_radius": 0.01}
    return sleeve


def _stiffness(rng: np.random.Generator) -> Document:
    mean = _log(rng, 2e7, 5e8)
    kind = rng.integers(4)
    if kind == 0:
        return {"kind": "harmonic", "mean": mean, "amplitude": float(mean * rng.choice([0.0, 0.2]))}
    if kind == 1:
        return {"kind": "square", "single": mean, "double": float(mean * rng.uniform(1.1, 1.8))}
    if kind == 2:
        phases = np.sort(rng.uniform(0.0, 6.2, 6))
        phases += 0.01 * np.arange(6)
        values = mean * rng.uniform(0.7, 1.3, 6)
        return {"kind": "table", "phase": phases.tolist(), "stiffness": values.tolist()}
    terms = [
        {"order": k, "amplitude": float(0.1 * mean / k), "phase": float(rng.uniform(0, 6))} for k in (1, 2)
    ]
    return {"kind": "fourier", "mean": mean, "terms": terms}


def _mesh(rng: np.random.Generator, driver: str, driven: str, *, friction: bool | None) -> Document:
    mesh: Document = {
        "driver": driver,
        "driven": driven,
        "module": MODULE,
        "backlash": float(rng.choice([1e-5, 2e-5, 6e-5, 2e-4])),
        "stiffness": _stiffness(rng),
    }
    if rng.random() < 0.5:
        mesh["damping"] = {
            "ratio": float(rng.uniform(0.01, 0.3)),
            "depth": float(rng.choice([2e-7, 1e-6, 5e-6])),
        }
    if rng.random() < 0.4:
        amplitude = _log(rng, 5e-7, 2e-5)
        mesh["transmission_error"] = [{"order": int(rng.integers(1, 4)), "amplitude": amplitude}]
    if friction or (friction is None and rng.random() < 0.25):
        mesh |= {
            "friction_coefficient": float(rng.uniform(0.02, 0.2)),
            "friction_speed": _log(rng, 1e-3, 1e-2),
        }
    return mesh


def _drive(rng: np.random.Generator) -> Document:
    kind = str(rng.choice(["speed", "torque", "servo", "position"]))
    speed = float(rng.choice([-1.0, 1.0])) * _log(rng, 1.0, 300.0)
    if kind == "speed":
        return {"kind": "speed", "speed": speed}
    if kind == "torque":
        drive: Document = {"kind": "torque", "torque": float(rng.uniform(-5.0, 5.0))}
        if rng.random() < 0.6:
            drive["terms"] = [
                {"frequency": _log(rng, 20.0, 2000.0), "amplitude": float(rng.uniform(0.1, 4.0))}
            ]
        return drive
    if kind == "servo":
        gains = {"proportional_gain": _log(rng, 1e-2, 1.0), "integral_gain": _log(rng, 0.1, 10.0)}
        return {"kind": "servo", "speed": speed, "torque_limit": float(rng.uniform(2.0, 10.0)), **gains}
    gain = _log(rng, 1.0, 50.0)
    return {
        "kind": "position",
        "angle": float(rng.uniform(-0.3, 0.3)),
        "proportional_gain": gain,
        "derivative_gain": float(rng.choice([0.0, 0.01])) * gain,
        "torque_limit": float(rng.uniform(2.0, 10.0)),
    }


def _base(rng: np.random.Generator) -> Document:
    if rng.random() < 0.5:
        acceleration: Document = {
            "kind": "harmonic",
            "amplitude": _log(rng, 1.0, 300.0),
            "frequency": _log(rng, 20.0, 2000.0),
        }
    else:
        start, lasts = float(rng.uniform(0.0, 4e-3)), _log(rng, 5e-4, 5e-3)
        acceleration = {
            "kind": "half-sine",
            "amplitude": _log(rng, 10.0, 500.0),
            "duration": lasts,
            "start": start,
        }
    return {"acceleration": acceleration | {"direction": float(rng.uniform(0.0, 6.28))}}


def train(rng: np.random.Generator, tolerance: float, *, friction: bool | None = None) -> Document:
    """Return a random train: a motor, perhaps behind a coupling, and two to four gears in a chain, from `rng` alone.

    With ``friction`` true every mesh has Coulomb friction, false none, otherwise some of them.
    """
    count = int(rng.integers(2, 5))
    names = [f"g{i}" for i in range(count)]
    rotors: Document = {}
    case: Document = {"rotors": rotors, "sleeves": {}, "supports": {}, "couplings": [], "meshes": []}
    for name in names:
        rotors[name] = {
            "teeth": int(rng.integers(18, 60)),
            "mass": _log(rng, 0.1, 2.0),
            "inertia": _log(rng, 5e-5, 5e-3),
            "radial_damping": float(rng.choice([0.0, 20.0, 200.0])),
        }
        place = rng.random()
        if place < 0.55:
            case["sleeves"][name] = _sleeve(rng)
        elif place < 0.7:
            case["supports"][name] = {
                "stiffness": [_log(rng, 1e7, 1e9), _log(rng, 1e7, 1e9)],
                "damping": [100.0, 100.0],
            }
    if rng.random() < 0.15:
        rotors[names[-1]]["runout"] = {"amplitude": _log(rng, 1e-6, 2e-5), "phase": float(rng.uniform(0, 6))}
    drive = _drive(rng)
    if rng.random() < 0.5:
        rotors["motor"] = {"mass": 1.0, "inertia": _log(rng, 5e-5, 5e-3), "drive": drive}
        coupling: Document = {"between": ["motor", names[0]], "torsional_stiffness": _log(rng, 500.0, 2e4)}
        if rng.random() < 0.6:
            coupling["torsional_damping"] = _log(rng, 1e-3, 0.3)
        if rng.random() < 0.3:
            coupling["play"] = _log(rng, 1e-4, 1e-2)
        if rng.random() < 0.3:
            coupling["ratio"] = float(rng.choice([-2.0, -1.0, 2.0]))
        case["couplings"].append(coupling)
    else:
        rotors[names[0]]["drive"] = drive
    load: Document = {}
    if rng.random() < 0.5:
        load["torque"] = _log(rng, 0.05, 5.0)
    if rng.random() < 0.4:
        load["drag"] = _log(rng, 1e-4, 1e-1)
    if rng.random() < 0.2:
        load["friction"] = _log(rng, 0.01, 1.0)
    rotors[names[-1]]["load"] = load
    if rng.random() < 0.15:
        rotors[names[int(rng.integers(count))]]["unbalance"] = {"amount": _log(rng, 1e-6, 1e-4)}
    case["meshes"] = [_mesh(rng, a, b, friction=friction) for a, b in pairwise(names)]
    if rng.random() < 0.3:
        case["base"] = _base(rng)
    if rng.random() < 0.3:
        case["gravity"] = [0.0, -9.81]
    for part in ("sleeves", "supports", "couplings"):
        if not case[part]:
            del case[part]
    return case | {"run": {"duration": 0.01, "sampling": 5e4, "tolerance": tolerance, "max_steps": 60_000}}


def broken_contacts(result: Result, depth: float) -> list[str]:
    """Return what breaks the invariant of contact: flanks deeper than ``depth`` [m] count as closed, parted ones as open."""
    ds, found = result.ds, []
    if "mesh" not in ds.dims:
        return found
    state = ds.contact_state.values.astype(int)
    for bit, flank in ((1, "drive"), (2, "back")):
        p, force = ds[f"{flank}_penetration"].values, ds[f"{flank}_force"].values
        closed = state & bit > 0
        for what, wrong in (
            ("open", (p > depth) & ~closed),
            ("closed", (p < -depth) & closed),
            ("pulls", force < -1e-6),
        ):
            if wrong.any():
                row, mesh = (int(k) for k in np.argwhere(wrong)[0])
                at = f"{ds.mesh.values[mesh]}.{flank} at {float(ds.time.values[row]):.6g} s"
                found.append(f"{at}: {what}, p = {p[row, mesh]:.3g} m, F = {force[row, mesh]:.3g} N")
    return found
