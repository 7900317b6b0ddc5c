"""Motion in rolling bearings: trajectories, energy and momentum, the line of the passing elements, the linear form."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

import gearplay as gp
from building import Document, Floats, Measured, case_of, merged, simulate_one
from gearplay.model.pack import pack
from parts.bearing.shafts import BALLS, shaft

# States x, y [m] at 6 ms of an independent integration (agreement of its own 2e-13 m).
TRAJECTORIES: dict[str, tuple[Document, Floats]] = {
    "balls": (
        shaft(
            BALLS | {"internal_clearance": 1e-5, "damping": {"value": 0.5}},
            weight=100.0,
            drive={"kind": "speed", "speed": "3000 rpm"},
            initial={"y": -8e-6},
        ),
        np.array([-4.800459090769276e-07, -8.00103946737837e-06]),
    ),
    "rattling": (
        shaft(
            {
                "rolling_elements": 9,
                "element_diameter": 7.94e-3,
                "pitch_diameter": 39.04e-3,
                "internal_clearance": 2e-5,
                "stiffness": 9.2e9,
                "damping": {"value": 0.3},
            },
            weight=5.0,
            mass=0.5,
            drive={"kind": "speed", "speed": "6000 rpm"},
            unbalance={"amount": 2e-6},
            initial={"x": 4e-6, "y": -6e-6},
        ),
        np.array([-1.6775346489119173e-06, -7.851028284934052e-06]),
    ),
    "rollers, waviness": (
        shaft(
            {
                "rolling_elements": 13,
                "element_diameter": 7.5e-3,
                "pitch_diameter": 46e-3,
                "internal_clearance": 6e-6,
                "stiffness": 2e8,
                "exponent": 10.0 / 9.0,
                "damping": {"value": 0.2},
                "waviness": [
                    {"order": 13, "amplitude": 5e-7, "phase": 0.3, "ring": "outer"},
                    {"order": 5, "amplitude": 4e-7, "phase": 1.0, "ring": "inner"},
                ],
            },
            weight=300.0,
            mass=3.0,
            drive={"kind": "speed", "speed": "1800 rpm"},
            initial={"y": -5e-6},
        ),
        np.array([-1.1437120937091958e-07, -5.02804501477432e-06]),
    ),
}


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_trajectory(name: str, measured: Measured) -> None:
    document, expected = TRAJECTORIES[name]
    document = merged(document, {"run": {"duration": 6.1e-3, "sampling": 1e4, "tolerance": 1e-12}})
    run = simulate_one(document)
    worst = float(np.max(np.abs([run.signal("x", "shaft")[60], run.signal("y", "shaft")[60]] - expected)))
    measured(f"bearing, {name}: trajectory at 6 ms [m]", worst, "1e-11")
    assert worst < 1e-11


def rattling(**bearing: Any) -> Document:
    """Return a free carrier and a disc in a bearing on it: no force from outside."""
    return {
        "rotors": {
            "carrier": {
                "mass": 1.0,
                "inertia": 2e-3,
                "floating": True,
                "initial": {"omega": 40.0, "vx": 0.01},
            },
            "disc": {
                "mass": 0.4,
                "inertia": 1e-4,
                "position": [0.05, 0.02],
                "initial": {"x": 2e-5, "omega": 300.0, "vy": 0.02},
            },
        },
        "bearings": {"disc": BALLS | {"internal_clearance": 4e-5, "on": "carrier"} | bearing},
        "run": {"duration": 0.02, "sampling": 1e5, "tolerance": 1e-11},
    }


def kinetic(document: Document, run: Any) -> Floats:
    total = np.zeros(run.time.size)
    for name, rotor in document["rotors"].items():
        v2 = run.signal("vx", name) ** 2 + run.signal("vy", name) ** 2
        total += 0.5 * rotor["mass"] * v2 + 0.5 * rotor["inertia"] * run.signal("omega", name) ** 2
    return total


def potential(document: Document, run: Any) -> Floats:
    """Return the elastic energy [J] of the bearing of `rattling`, from the motion alone."""
    bearing = document["bearings"]["disc"]
    at = {n: np.array([run.signal(n, r) for r in ("carrier", "disc")]) for n in ("x", "y", "theta")}
    c, s = np.cos(at["theta"][0]), np.sin(at["theta"][0])
    e_x = at["x"][1] - at["x"][0] + 0.05 - (0.05 * c - 0.02 * s)
    e_y = at["y"][1] - at["y"][0] + 0.02 - (0.05 * s + 0.02 * c)
    g = bearing["element_diameter"] / bearing["pitch_diameter"]
    shares = (0.5 * (1.0 - g), 0.5 * (1.0 + g))
    outer = bearing.get("rotor_ring") == "outer"
    share_a, share_b = shares[::-1] if outer else shares
    cage = share_a * at["theta"][1] + share_b * at["theta"][0]
    total, n = np.zeros(run.time.size), bearing.get("exponent", 1.5)
    for k in range(bearing["rolling_elements"]):
        angle = cage + 2.0 * math.pi * k / bearing["rolling_elements"]
        depth = (-1.0 if outer else 1.0) * (e_x * np.cos(angle) + e_y * np.sin(angle))
        for wave in bearing.get("waviness", ()):
            ring = at["theta"][1 if (wave["ring"] == "outer") == outer else 0]
            depth = depth + wave["amplitude"] * np.cos(wave["order"] * (angle - ring))
        depth = np.maximum(depth - 0.5 * bearing["internal_clearance"], 0.0)
        total += bearing["stiffness"] / (n + 1.0) * depth ** (n + 1.0)
    return total


@pytest.mark.parametrize(
    "bearing",
    [
        {},
        {"rotor_ring": "outer", "exponent": 10.0 / 9.0, "stiffness": 2e8},
        {
            "waviness": [
                {"order": 7, "amplitude": 2e-6, "ring": "inner"},
                {"order": 3, "amplitude": 3e-6, "ring": "outer"},
            ]
        },
        {"damping": {"value": 0.5}},
        {"cage_torque": False},
        {"cage_torque": False, "damping": {"value": 0.5}},
    ],
)
def test_momentum_is_kept_and_energy_closes(bearing: Document, measured: Measured) -> None:
    """The energy changes by what the bearing loses and, without torques of the cage, by what the cage puts in."""
    document = rattling(**bearing)
    document["run"]["sampling"] = 2e6
    document["run"]["duration"] = 4e-3
    run = simulate_one(document)
    at = {
        n: np.array([run.signal(n, r) for r in ("carrier", "disc")]) for n in ("x", "y", "vx", "vy", "omega")
    }
    masses, inertias = np.array([1.0, 0.4]), np.array([2e-3, 1e-4])
    x, y = at["x"] + [[0.0], [0.05]], at["y"] + [[0.0], [0.02]]
    spin = masses @ (x * at["vy"] - y * at["vx"]) + inertias @ at["omega"]
    push = masses @ at["vx"]
    kept = max(float(np.ptp(spin)) / float(np.max(np.abs(spin))), float(np.ptp(push)) / 0.01)
    energy = kinetic(document, run) + potential(document, run)
    gained = run.signal("bearing_cage_power", "disc") - run.signal("bearing_power_loss", "disc")
    expected = np.concatenate([[0.0], cumulative_simpson(gained, x=run.time)])
    off = float(np.max(np.abs(energy - energy[0] - expected)))
    size = float(np.max(potential(document, run)))
    measured("bearing on a carrier: momentum, relative", kept, "1e-9")
    measured("bearing on a carrier: energy, of the largest elastic one", off / size, "1e-5")
    assert run.counters.events > 4
    assert kept < 1e-9
    assert off < (1e-5 if np.any(gained) else 1e-8) * size + 1e-12 * float(energy[0])
    if "damping" not in bearing:
        assert not np.any(run.signal("bearing_power_loss", "disc"))
    if bearing.get("cage_torque", True):
        assert not np.any(run.signal("bearing_cage_power", "disc"))
    else:
        assert not np.any(run.signal("bearing_torque", "disc"))


def test_the_strongest_line_is_that_of_the_passing_elements() -> None:
    """Variable compliance of a slow shaft: BPFO and its multiples."""
    document = shaft(
        BALLS | {"internal_clearance": 1e-5, "damping": {"value": 200.0}},
        weight=100.0,
        drive={"kind": "speed", "speed": "120 rpm"},
        initial={"y": -8.3e-6},
    )
    passes = 2.0 * 0.5 * 8 * (1.0 - 7.9375 / 33.5026)
    document["run"] = {
        "duration": 12.0 / passes,
        "transient": 0.2,
        "sampling": 64 * passes,
        "tolerance": 1e-8,
    }
    run = gp.simulate(document)
    y = run.ds["y"].sel(rotor="shaft").values
    lines = np.abs(np.fft.rfft(y - np.mean(y))) * 2.0 / y.size
    frequency = np.fft.rfftfreq(y.size, 1.0 / (64 * passes))
    top = float(frequency[int(np.argmax(lines))])
    assert top == pytest.approx(passes, rel=1e-3)
    assert lines[12] == pytest.approx(0.114047e-6, rel=0.02), "that of the static displacement"


def test_the_linear_form_of_a_preload_is_a_support(measured: Measured) -> None:
    """Frequencies of a preloaded bearing without a load: those of a support of Z/2 n K d^(n-1)."""
    stiffness = 0.5 * 8 * 1.5 * 1.334e10 * math.sqrt(5e-6)
    one = shaft(BALLS | {"internal_clearance": -1e-5})
    other = {k: v for k, v in one.items() if k != "bearings"} | {
        "supports": {"shaft": {"stiffness": [stiffness] * 2}}
    }
    found, expected = (gp.modes(case_of(each)).ds["frequency"].values for each in (one, other))
    worst = float(np.max(np.abs(found / expected - 1.0)))
    measured("bearing: modes of a preload against a support, relative", worst, "1e-6")
    assert worst < 1e-6
    turning = gp.modes(case_of(one), speed=300.0).ds["frequency"].values
    assert turning == pytest.approx(expected, rel=1e-6)


def test_the_linear_form_is_the_mean_over_the_cage() -> None:
    """Under a load: the force averaged over the angles of the cage, by a sum of its own."""
    play, weight = 5e-6, 100.0
    found = gp.modes(case_of(shaft(BALLS | {"internal_clearance": 2.0 * play}, weight=weight)))
    down = -float(found.ds["static_displacement"].values[1])
    at = 2.0 * math.pi * (np.arange(200_000) + 0.5) / 200_000
    depth = np.maximum(down * np.cos(at) - play, 0.0)
    force = 8 * float(np.mean(1.334e10 * depth**1.5 * np.cos(at)))
    assert force == pytest.approx(weight, rel=2e-3)
    along = 8 * float(np.mean(1.5 * 1.334e10 * np.sqrt(depth) * np.cos(at) ** 2))
    assert (2.0 * math.pi * found.ds["frequency"].values.max()) ** 2 * 2.0 == pytest.approx(along, rel=2e-2)


def test_a_bearing_repeats_with_its_elements() -> None:
    """Recurrence rates: passes of the elements, waves of the turning ring."""
    from gearplay.parts.registry import recurrence_rates

    bearing = BALLS | {"waviness": [{"order": 7, "amplitude": 1e-6, "ring": "inner"}]}
    system = pack(case_of(shaft(bearing, drive={"kind": "speed", "speed": 100.0}))).system
    rates = recurrence_rates(system, np.array([100.0]), np.zeros(1))
    assert rates == pytest.approx([800.0 * 0.5 * (1.0 - 7.9375 / 33.5026), 700.0])
