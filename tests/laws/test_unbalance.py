"""Unbalance: the planar body is exact. Closed forms, conserved quantities, the tangent against differences."""

import math

import numpy as np
import pytest

from building import Document, Measured, case_of, simulate_one
from gearplay.solver.flow import Flow

MASS, INERTIA, AMOUNT, PHASE = 0.5, 1e-3, 2e-3, 0.6  # kg, kg m^2, kg m
G = 9.80665


def disc(**rotor: object) -> Document:
    """Return one unbalanced disc; without more its centre is held."""
    return {
        "rotors": {
            "disc": {
                "mass": MASS,
                "inertia": INERTIA,
                "unbalance": {"amount": AMOUNT, "phase": PHASE},
                **rotor,
            }
        },
        "run": {"duration": 0.2, "sampling": 1e4, "tolerance": 1e-12},
    }


def test_a_free_body_turns_about_its_centre_of_mass(measured: Measured) -> None:
    """In space: the centre of mass goes straight on, the speed stays, the axis circles at the eccentricity."""
    document = disc(floating=True, initial={"omega": 50.0, "vx": 0.1, "theta": 0.2})
    run = simulate_one(document)
    psi, e = run.signal("theta", "disc") + PHASE, AMOUNT / MASS
    x = run.signal("x", "disc") + e * np.cos(psi)
    y = run.signal("y", "disc") + e * np.sin(psi)
    v_x, v_y = 0.1 - e * 50.0 * math.sin(0.2 + PHASE), e * 50.0 * math.cos(0.2 + PHASE)
    worst = max(
        float(np.max(np.abs(x - x[0] - v_x * run.time))), float(np.max(np.abs(y - y[0] - v_y * run.time)))
    )
    measured("free unbalanced body: centre of mass [m]", worst, "1e-11")
    assert worst < 1e-11
    assert np.max(np.abs(run.signal("omega", "disc") - 50.0)) < 1e-8


@pytest.mark.parametrize("shaken", [False, True])
def test_a_held_disc_is_a_pendulum(shaken: bool, measured: Measured) -> None:
    """J alpha = U (u x g): large swings keep their energy, and a housing that rises at g doubles the weight."""
    document = disc(initial={"theta": 0.3, "omega": 0.0})
    document["gravity"] = [0.0, -G]
    if shaken:
        quarter = {"kind": "record", "values": [G] * 8, "sampling": 10.0, "direction": math.radians(90.0)}
        document["base"] = {"acceleration": quarter}
    run = simulate_one(document)
    weight = 2.0 * G if shaken else G
    psi = run.signal("theta", "disc") + PHASE
    energy = 0.5 * INERTIA * run.signal("omega", "disc") ** 2 + AMOUNT * weight * np.sin(psi)
    worst = float(np.ptp(energy) / (AMOUNT * weight))
    measured(f"unbalanced pendulum, shaken {shaken}: energy, relative", worst, "1e-9")
    assert worst < 1e-9
    assert np.ptp(psi) > 0.2


def test_rotor_on_support__whirls_as_the_jeffcott_rotor(measured: Measured) -> None:
    """Driven at a constant speed above its critical one: the axis circles at U w^2 / (k - m w^2), against the unbalance."""
    k, speed = 2e5, 1000.0
    radius = AMOUNT * speed**2 / (k - MASS * speed**2)
    start = {"x": radius * math.cos(PHASE), "y": radius * math.sin(PHASE)}
    start |= {"vx": -radius * speed * math.sin(PHASE), "vy": radius * speed * math.cos(PHASE)}
    document = disc(drive={"kind": "speed", "speed": speed}, initial=start)
    document["supports"] = {"disc": {"stiffness": [k, k]}}
    run = simulate_one(document)
    worst = float(np.max(np.abs(run.signal("x", "disc") - radius * np.cos(speed * run.time + PHASE))))
    measured("whirl of an unbalanced rotor [m]", worst, "1e-9")
    assert worst < 1e-9 < abs(radius)
    assert radius < 0.0, "above the critical speed"


def test_rotation_and_whirl_exchange_energy_only(measured: Measured) -> None:
    """A free rotor on a support without damping: energy of body and spring is kept, while the speed changes."""
    k = 2e5
    document = disc(initial={"omega": 600.0, "x": 1e-4})
    document["supports"] = {"disc": {"stiffness": [k, k]}}
    run = simulate_one(document)
    at = {name: run.signal(name, "disc") for name in ("x", "y", "theta", "vx", "vy", "omega")}
    psi = at["theta"] + PHASE
    energy = 0.5 * MASS * (at["vx"] ** 2 + at["vy"] ** 2) + 0.5 * INERTIA * at["omega"] ** 2
    energy += AMOUNT * at["omega"] * (at["vy"] * np.cos(psi) - at["vx"] * np.sin(psi))
    energy += 0.5 * k * (at["x"] ** 2 + at["y"] ** 2)
    worst = float(np.ptp(energy) / energy[0])
    measured("unbalanced rotor on a support: energy, relative", worst, "1e-9")
    assert worst < 1e-9
    assert np.ptp(at["omega"]) > 1.0


TORQUE = {"drive": {"kind": "torque", "torque": 1.0, "terms": [{"order": 2.0, "amplitude": 0.5}]}}
DRIVES: dict[str, Document] = {
    "torque": TORQUE | {"initial": {"omega": 100.0, "x": 1e-4}},
    "heavy": TORQUE | {"initial": {"omega": 100.0, "x": 1e-4}, "mass": 50.0, "inertia": 5.0},
    "speed": {"drive": {"kind": "speed", "speed": 100.0}, "initial": {"x": 1e-4}},
}


@pytest.mark.parametrize("drive", DRIVES)
def test_the_tangent_of_an_unbalanced_rotor_is_exact(drive: str, measured: Measured) -> None:
    """Against differences of the flow, with a support, a torque in rotation or a prescribed speed, and a housing that shakes."""
    document = disc(**DRIVES[drive])
    document["supports"] = {"disc": {"stiffness": [2e5, 3e5], "damping": [10.0, 20.0]}}
    document["base"] = {"acceleration": {"kind": "harmonic", "amplitude": 30.0, "frequency": 100.0}}
    flow = Flow(case_of(document))
    start, span = flow.start(), 5e-3
    exact = flow.go(start, span, changes=np.eye(flow.size)).changes
    for c in flow.free:
        h = 1e-5 * flow.natural[c]
        plus, minus = (flow.go(start + s * h * np.eye(flow.size)[c], span).state for s in (1.0, -1.0))
        difference = (plus - minus) / (2.0 * h)
        worst = float(
            np.max(np.abs(difference - exact[c]) / flow.natural) / np.max(np.abs(exact[c]) / flow.natural)
        )
        assert worst < 1e-6, c
    measured(f"tangent of an unbalanced rotor, {drive}, relative", worst, "1e-6")


def test_a_heavy_body_turns_about_its_centre_of_mass() -> None:
    """Of 5 kg m^2 as of 1e-3: rotation and way of the axis react on each other, so a driven torque is not its inertia's alone."""
    document = disc(
        floating=True, mass=50.0, inertia=5.0, drive={"kind": "torque", "torque": 3.0}, initial={"omega": 0.0}
    )
    document["rotors"]["disc"]["unbalance"] = {"amount": 10.0}
    run = simulate_one(document)
    about = 5.0 - 10.0**2 / 50.0  # kg m^2, about the centre of mass
    assert np.allclose(run.signal("omega", "disc"), 3.0 / about * run.time, rtol=1e-9, atol=1e-12)
