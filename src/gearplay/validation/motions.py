"""Frequencies, statics and motions, computed as a user would: modes, signals and runs of cases."""

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

import gearplay as gp

RPM = 2.0 * math.pi / 60.0
RIGID = {"kind": "harmonic", "mean": 1e13}
"""Teeth that are rigid to the digits of the sources."""


def _of_kind(found: Any, kind: str, multiplicity: int) -> list[float]:
    """Return frequencies [Hz] of a kind, each once; NaN in front where one has another multiplicity."""
    chosen = found.ds["kind"].values == kind
    values = found.ds["frequency"].values[chosen][::multiplicity].tolist()
    alike = np.all(found.ds["multiplicity"].values[chosen] == multiplicity)
    return values if alike else [math.nan, *values]


def planetary_set(planets: int, backlash_model: str = "coupled") -> Sequence[float]:
    """Rotational, translational and planet frequencies [Hz] of the bundled set of Lin and Parker."""
    changes = {"planetary.stage.planets.count": planets, "backlash_model": backlash_model}
    found = gp.modes(gp.replace(gp.load_case("lin-parker-1999"), changes))
    return [
        *_of_kind(found, "rotational", 1)[1:],
        *_of_kind(found, "translational", 2),
        *_of_kind(found, "planet", 1),
    ]


def three_planets() -> Sequence[float]:
    """Lin and Parker, 3 planets."""
    return planetary_set(3)


def four_planets() -> Sequence[float]:
    """Lin and Parker, 4 planets."""
    return planetary_set(4)


def cooley_parker() -> Sequence[float]:
    """Frequencies over sqrt(k_p / m_p)."""
    found, unit = gp.modes("cooley-parker-2012"), math.sqrt(1e7 / 1.86) / (2.0 * math.pi)
    values = [*_of_kind(found, "rotational", 1), *_of_kind(found, "translational", 2)]
    return [value / unit for value in values]


def pair_in_bearings() -> Sequence[float]:
    """Frequencies [Hz] of the pair of Yi et al. under a small load, in bearings, then the torsional one with held centres."""
    wheel = {"teeth": 20, "mass": 6.57, "inertia": 0.0365}
    document: dict[str, Any] = {
        "rotors": {
            "pinion": {**wheel, "drive": {"kind": "torque", "torque": 1.0}},
            "gear": {**wheel, "load": {"torque": 1.0}},
        },
        "meshes": [
            {
                "driver": "pinion", "driven": "gear", "module": 0.01, "backlash": 1e-4,
                "stiffness": {"kind": "harmonic", "mean": 5.17925e8},
            }
        ],
        "run": {"duration": 0.01},
    }  # fmt: skip
    bearings = {name: {"stiffness": [1e8, 1e8]} for name in ("pinion", "gear")}
    free = gp.modes(document | {"supports": bearings}).ds["frequency"].values.tolist()
    return [*free[1:], float(gp.modes(document).ds["frequency"].values[-1])]


def train(
    rotors: dict[str, Any], shafts: dict[tuple[str, str], float], *meshes: tuple[str, str]
) -> dict[str, Any]:
    """Return a torsional train: inertias [kg m^2], or inertias and teeth; stiffnesses [N m/rad] of shafts; pairs in mesh."""
    table = {}
    for name, given in rotors.items():
        inertia, teeth = given if isinstance(given, tuple) else (given, None)
        table[name] = {"mass": 1.0, "inertia": inertia} | ({"teeth": teeth} if teeth else {})
    return {
        "rotors": table,
        "couplings": [{"between": list(ends), "torsional_stiffness": k} for ends, k in shafts.items()],
        "meshes": [
            {"driver": a, "driven": b, "module": 0.02, "backlash": 0.0, "stiffness": RIGID} for a, b in meshes
        ],
        "run": {"duration": 1.0},
    }


def _shaft(length: float, diameter: float) -> float:
    """Return G pi d^4 / (32 l) [N m/rad] of steel of 68 GPa."""
    return 68e9 * math.pi * diameter**4 / (32.0 * length)


def _frequencies(document: dict[str, Any], count: int) -> Sequence[float]:
    """Return the first elastic natural frequencies [Hz]."""
    found: list[float] = gp.modes(document).ds["frequency"].values[1 : 1 + count].tolist()
    return found


def geared_pair() -> Sequence[float]:
    """Return frequencies [Hz] of a motor, a pair of gears and two discs."""
    shafts = {("motor", "one"): 1e4, ("two", "a"): 5e3, ("one", "b"): 5e3}
    bodies = {"motor": 400e-6, "one": (25e-6, 40), "two": (25e-6, 40), "a": 700e-6, "b": 700e-6}
    return _frequencies(train(bodies, shafts, ("one", "two")), 3)


def five_discs() -> Sequence[float]:
    """Return frequencies [Hz] of example 9.7.1."""
    bodies = {"a": 3.5e-3, "b": 3.5e-3, "c": 3.5e-3, "d": 0.15, "e": 0.05}
    shafts = {("a", "b"): 12e3, ("b", "c"): 12e3, ("c", "d"): 14e3, ("d", "e"): 10e3}
    return _frequencies(train(bodies, shafts), 4)


def branched_train() -> Sequence[float]:
    """Return frequencies [Hz] of example 9.6.3: a turbine with two propellers."""
    bodies = {
        "turbine": 3200.0, "one": (200.0, 50), "two": (200.0, 50), "three": (800.0, 80), "four": (800.0, 80),
        "port": 450.0, "starboard": 450.0,
    }  # fmt: skip
    shafts = {
        ("turbine", "one"): _shaft(2.5, 0.2),
        ("three", "port"): _shaft(3.5, 0.25),
        ("four", "starboard"): _shaft(3.5, 0.25),
    }
    return _frequencies(train(bodies, shafts, ("one", "two"), ("one", "three"), ("two", "four")), 3)


def wind_turbine() -> Sequence[float]:
    """Blades and generator [rad/s]."""
    shafts = {("blades", "inner"): 3.67e8, ("inner", "outer"): 5.496e9}
    document = train({"blades": 1e7, "inner": 5770.0, "outer": 97030.0}, shafts)
    return [2.0 * math.pi * value for value in _frequencies(document, 2)]


def planetary_events() -> Sequence[float]:
    """Mesh frequency [Hz], time between contacts of a sun tooth and a planet's flank [s] of 17/37/91, sun at 800 rpm."""
    found = gp.signals.event_periods(17, 37, 91, 3, 800.0 * RPM)
    return [found.mesh_frequency, found.sun, found.planet]


def bearing_orders() -> Sequence[float]:
    """FTF, BPFO, BPFI, BSF per turn of an ER-10K."""
    found = gp.signals.bearing_orders(8, 0.3125 * 0.0254, 1.319 * 0.0254)
    return [found.ftf, found.bpfo, found.bpfi, found.bsf]


def deep_groove_orders() -> Sequence[float]:
    """FTF, BPFO, BPFI and twice BSF per turn of a 6205."""
    found = gp.signals.bearing_orders(9, 0.3126 * 0.0254, 1.537 * 0.0254)
    return [found.ftf, found.bpfo, found.bpfi, 2.0 * found.bsf]


def clearance_classes() -> Sequence[float]:
    """Least and largest clearance [um] of classes CN and C3 of a bearing 6205, from the findings of `gearplay check`."""
    values: list[float] = []
    for grade in ("CN", "C3"):
        document = {
            "rotors": {"shaft": {"mass": 1.0, "inertia": 1e-3}},
            "bearings": {"shaft": {"catalogue": "6205", "groove_ratio": 0.52, "internal_clearance": grade}},
            "run": {"duration": 0.01},
        }
        words = " ".join(finding.message for finding in gp.check_case(document))
        range_of_class = re.search(r"([\d.]+) to ([\d.]+) um \(ISO 5753\)", words)
        values += [math.nan] * 2 if range_of_class is None else map(float, range_of_class.groups())
    return values


def bearing_statics() -> Sequence[float]:
    """Displacement [um] under 100 N at three radial plays, with a ball under the load and with the load between two balls."""
    values = []
    for play in (0.0, 5.0, 20.0):
        for turned in (0.0, math.pi / 8.0):
            values.append(_displacement(play, turned))
    return values


def _displacement(play: float, turned: float) -> float:
    """Return where a damped shaft comes to rest [um] in a ball bearing with a radial play [um], its balls turned by an angle."""
    down = -0.5 * math.pi
    bearing = {
        "rolling_elements": 8, "element_diameter": 7.9375e-3, "pitch_diameter": 33.5026e-3, "stiffness": 1.334e10,
        "internal_clearance": 2e-6 * play, "cage_phase": down + turned,
    }  # fmt: skip
    document: dict[str, Any] = {
        "gravity": [0.0, -50.0],
        "rotors": {
            "shaft": {
                "mass": 2.0,
                "inertia": 1e-3,
                "radial_damping": 15e3,
                "drive": {"kind": "speed", "speed": 0.0},
            }
        },
        "bearings": {"shaft": bearing},
        "run": {"duration": 0.03, "sampling": 1e3, "tolerance": 1e-10},
    }
    return -1e6 * float(gp.simulate(document).ds["y"].values.ravel()[-1])


def warm_housing() -> Sequence[float]:
    """Growth of the backlash [um] beyond that of the teeth, steel gears at 80 mm in aluminium, 100 K warmer."""
    steel, backlash = 11.5e-6, 1e-4
    wheel = {"teeth": 40, "mass": 1.0, "inertia": 1e-3, "material": {"expansion": steel}}
    document: dict[str, Any] = {
        "rotors": {
            "one": {**wheel, "drive": {"kind": "speed", "speed": 20.0}},
            "two": {**wheel, "load": {"torque": 1.0}},
        },
        "meshes": [
            {
                "driver": "one", "driven": "two", "module": "2 mm", "backlash": backlash,
                "stiffness": {"kind": "harmonic", "mean": 1e8},
            }
        ],
        "environment": {"temperature": "120 degC", "housing": {"expansion": 23.1e-6}},
        "run": {"duration": 1e-3, "sampling": 1e5},
    }  # fmt: skip
    found = float(gp.simulate(document).ds["backlash"].values.ravel()[0])
    return [1e6 * (found - backlash * (1.0 + 100.0 * steel))]
