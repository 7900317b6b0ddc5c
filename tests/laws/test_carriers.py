"""Gears on carriers: energy of every model, a set that turns as a block, damping beside the pin."""

import math
from typing import Any

import numpy as np
import pytest

from building import Document, Instant, Measured, case_of, merged, simulate_one, states_along
from gearplay.model.pack import pack

PIN = {
    "radial_clearance": 2e-5,
    "law": "hunt-crossley",
    "stiffness": 1e9,
    "exponent": 1.5,
    "restitution": 1.0,
}


def epicyclic(model: str, formulation: str = "geometric", **changes: Any) -> Document:
    """Return a planet that rolls round a held sun, its carrier free to turn."""
    document: Document = {
        "backlash_model": model,
        "formulation": formulation,
        "rotors": {
            "sun": {
                "position": [0.0, 0.0],
                "teeth": 20,
                "mass": 0.3,
                "inertia": 2e-4,
                "drive": {"kind": "speed", "speed": 0.0},
            },
            "planet": {"teeth": 20, "mass": 0.2, "inertia": 1.6e-4, "position": [0.08, 0.0]},
            "carrier": {"mass": 0.5, "inertia": 2e-3, "position": [0.0, 0.0]},
        },
        "sleeves": {"planet": {**PIN, "on": "carrier"}},
        "meshes": [
            {
                "driver": "sun",
                "driven": "planet",
                "module": 4e-3,
                "pressure_angle": math.radians(20.0),
                "backlash": 2e-5,
                "stiffness": {"kind": "harmonic", "mean": 1e8},
            }
        ],
        "run": {"duration": 5e-3, "sampling": 1e5, "tolerance": 1e-11},
    }
    return merged(document, changes)


@pytest.mark.parametrize(
    ("model", "formulation"),
    [("coupled", "geometric"), ("uncoupled", "geometric"), ("uncoupled", "as_published")],
)
def test_a_planet_rolling_round_a_held_sun_keeps_its_energy(
    model: str, formulation: str, measured: Measured
) -> None:
    """To 1e-5 over 5 ms of impacts. As published and coupled the force has no potential: energy is not kept there."""
    start = {"carrier": {"initial": {"omega": 20.0}}, "planet": {"initial": {"omega": 40.0}}}
    document = epicyclic(model, formulation, rotors=start)
    times = np.linspace(2.5e-4, 5e-3, 20)
    packed, states, run = states_along(document, times)
    instant = Instant(packed)
    energies = np.array([instant.energy(t, y) for t, y in zip(times, states, strict=True)])
    worst = float(np.max(np.abs(energies / energies[0] - 1.0)))
    measured(f"planet round a held sun, {formulation}, {model}: energy", worst, "1e-5")
    assert len(run.log) > 0
    assert worst < 1e-5


def test_a_set_that_is_given_one_speed_turns_as_a_block() -> None:
    """Sun, planet and carrier at 9 rad/s: the planet has its pin's velocity to 1e-6 m/s, the teeth roll no further."""
    spin = {"initial": {"omega": 9.0}}
    rotors = {"sun": {"drive": None, **spin}, "planet": spin, "carrier": spin}
    run = simulate_one(epicyclic("coupled", rotors=rotors))
    assert abs(run.signal("vx", "planet")[0]) < 1e-6
    assert abs(run.signal("vy", "planet")[0] - 9.0 * 0.08) < 1e-6
    rolled = run.signal("transmission_error_dynamic", "sun-planet")[:100]
    assert np.max(np.abs(np.gradient(rolled, run.time[:100]))) < 1e-4  # the planet still flies straight on
    assert np.all(run.signal("drive_force", "sun-planet")[:100] == 0.0)


def test_moved_carrier__planets_move_with_it() -> None:
    document = epicyclic(
        "coupled", rotors={"carrier": {"floating": True, "initial": {"theta": 0.5, "x": 1e-3, "vy": 0.2}}}
    )
    document["meshes"], document["rotors"]["sun"] = [], {"mass": 0.3, "inertia": 2e-4}
    run = simulate_one(document)
    x, y = run.signal("x", "planet")[0], run.signal("y", "planet")[0]
    assert x == pytest.approx(1e-3 + 0.08 * (math.cos(0.5) - 1.0), abs=1e-15)
    assert y == pytest.approx(0.08 * math.sin(0.5), abs=1e-15)
    assert run.signal("vy", "planet")[0] == 0.2
    assert run.signal("sleeve_penetration", "planet")[0] == pytest.approx(-2e-5, abs=1e-12)


def test_damping_of_a_carried_rotor_acts_beside_its_pin() -> None:
    """A planet that rides at rest in its bush feels no damping; one that moves in it is slowed, and its carrier pushed."""
    document = epicyclic(
        "coupled", rotors={"planet": {"radial_damping": 50.0}, "carrier": {"initial": {"omega": 10.0}}}
    )
    document["meshes"], document["rotors"]["sun"] = [], {"mass": 0.3, "inertia": 2e-4}
    document["rotors"]["carrier"]["mass"] = 0.5
    packed, states, _ = states_along(document, np.array([1e-3, 4e-3]))
    n = packed.system.rotors.size
    speeds = [math.hypot(y[3 * (n + 1)], y[3 * (n + 1) + 1]) for y in states]
    spins = [y[3 * (n + 2) + 2] for y in states]
    rotors: Any = packed.system.rotors
    momenta = [
        rotors.inertia[2] * spin
        + rotors.mass[1] * ((0.08 + y[3]) * y[3 * (n + 1) + 1] - y[4] * y[3 * (n + 1)])
        for y, spin in zip(states, spins, strict=True)
    ]
    assert speeds[1] > 0.7 * 0.8, "no brake against the ground"
    expected = rotors.inertia[2] * 10.0 + rotors.mass[1] * 0.08**2 * 10.0
    assert momenta == pytest.approx([expected, expected], rel=1e-7)


def test_a_turning_carrier_needs_no_coupled_model() -> None:
    """A driven carrier, held sun, no load: the uncoupled planet rolls along without a force."""
    document = epicyclic("uncoupled", rotors={"carrier": {"drive": {"kind": "speed", "speed": 30.0}}})
    document["sleeves"]["planet"]["radial_clearance"] = 0.0
    document["sleeves"]["planet"]["exponent"] = 1.0
    packed = pack(case_of(document))
    assert packed.system.rotors["nominal_speed"][1] == pytest.approx(60.0)
    run = simulate_one(document)
    centripetal = 0.2 * 0.08 * 30.0**2
    assert np.max(run.signal("drive_force", "sun-planet")) < 3.0 * centripetal
