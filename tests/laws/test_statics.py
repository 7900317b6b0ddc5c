"""Statics: what the drive flank carries, what the bearings carry, and by how much the centres part."""

import math

import numpy as np
import pytest

from building import ALPHA, Document, case_of, merged, pair_document, simulate_one
from gearplay.parts.mesh.train.geometry import base_radii

SPRING = {
    "radial_clearance": 0.0,
    "law": "hunt-crossley",
    "stiffness": 1e8,
    "exponent": 1.0,
    "restitution": 1.0,
}
SETTLE = {"duration": 0.02, "transient": 0.2, "sampling": 1e4, "tolerance": 1e-9}


def settling(document: Document, torque: float, driven: str) -> Document:
    """Return the document with a slow speed drive, a load and enough damping to come to rest."""
    rotors = {
        name: {"radial_damping": math.sqrt(SPRING["stiffness"] * rotor["mass"])}
        for name, rotor in document["rotors"].items()
    }
    rotors["pinion"]["drive"] = {"kind": "speed", "speed": 1.0}
    rotors[driven]["load"] = {"torque": torque}
    sleeves = dict.fromkeys(document["rotors"], SPRING)
    document = merged(document, {"rotors": rotors, "sleeves": sleeves, "run": SETTLE})
    for mesh in document["meshes"]:
        mesh["damping"] = {"ratio": 0.3, "depth": 1e-9}
    return document


def benchmark(kind: str) -> Document:
    """Return the published pair 20/20 of module 10 mm (or its internal cousin 20/60), 300 N m of load."""
    document = pair_document(kind, mesh={"module": 10e-3})
    wheel = "wheel" if kind == "external" else "ring"
    teeth = 20 if kind == "external" else 60
    body = {"mass": 6.57, "inertia": 0.0365}
    rotors = {"pinion": dict(body), wheel: {**body, "teeth": teeth}}
    return settling(merged(document, {"rotors": rotors}), 300.0, wheel)


@pytest.mark.parametrize("kind", ["external", "internal"])
def test_bearings_carry_the_mesh_force_once(kind: str) -> None:
    """F = T / r_b; each bearing carries F sin alpha_w along, F cos alpha_w across, not twice that."""
    document = benchmark(kind)
    wheel = document["meshes"][0]["driven"]
    label = f"pinion-{wheel}"
    run = simulate_one(document)
    force = float(np.mean(run.signal("drive_force", label)))
    radius = base_radii(case_of(document), 0)[1]
    assert force == pytest.approx(300.0 / radius, rel=1e-7)
    assert np.all(run.signal("back_force", label) == 0.0)
    alpha_w = float(np.mean(run.signal("working_pressure_angle", label)))
    for name in ("pinion", wheel):
        f = np.array([float(np.mean(run.signal(f"sleeve_force_{c}", name))) for c in "xy"])
        x = np.array([float(np.mean(run.signal(c, name))) for c in "xy"])
        assert np.hypot(*f) == pytest.approx(force, rel=1e-7)
        np.testing.assert_allclose(f, -SPRING["stiffness"] * x, rtol=1e-7)
    # in the axes of the actual centres
    vector = np.array([float(np.mean(run.signal(c, wheel) - run.signal(c, "pinion"))) for c in "xy"])
    vector[0] += 0.2 if kind == "external" else -0.2
    u = vector / np.hypot(*vector)
    reaction = np.array([float(np.mean(run.signal(f"sleeve_force_{c}", wheel))) for c in "xy"])
    assert abs(reaction @ u) == pytest.approx(force * math.sin(alpha_w), rel=1e-6)
    assert abs(reaction @ np.array([-u[1], u[0]])) == pytest.approx(force * math.cos(alpha_w), rel=1e-6)
    # the mesh pushes an external pair's centres apart, a ring's and its pinion's together
    assert reaction @ u * (1.0 if kind == "external" else -1.0) < 0.0


def test_published_data_set() -> None:
    """The 20/20 pair of module 10 mm at 300 N m: F = 3192.5 N, bearings give 21.86 um along the centres.

    The centres also turn a little: A0^2 = (A - D sin alpha_w)^2 + (D cos alpha_w)^2 with D = 2 F / k.
    """
    run = simulate_one(benchmark("external"))
    force = float(np.mean(run.signal("drive_force", "pinion-wheel")))
    assert force == pytest.approx(3192.5, abs=0.05)
    A = float(np.mean(run.signal("center_distance", "pinion-wheel")))
    cosine = 0.2 * math.cos(ALPHA) / A
    sine = math.sqrt(1.0 - cosine**2)
    D = 2.0 * force / SPRING["stiffness"]
    assert D * sine == pytest.approx(21.86e-6, abs=0.005e-6)
    assert pytest.approx(D * sine + math.sqrt(0.2**2 - (D * cosine) ** 2), abs=1e-12) == A


def test_uncoupled_pair_has_the_same_mesh_force_on_its_fixed_line_of_action() -> None:
    """F = T / r_b and reactions F sin alpha0, F cos alpha0 exactly, whatever the displacement."""
    run = simulate_one({**benchmark("external"), "backlash_model": "uncoupled"})
    force = float(np.mean(run.signal("drive_force", "pinion-wheel")))
    assert force == pytest.approx(300.0 / (0.1 * math.cos(ALPHA)), rel=1e-7)
    assert abs(np.mean(run.signal("sleeve_force_x", "wheel"))) == pytest.approx(
        force * math.sin(ALPHA), rel=1e-7
    )
    assert abs(np.mean(run.signal("sleeve_force_y", "wheel"))) == pytest.approx(
        force * math.cos(ALPHA), rel=1e-7
    )


def test_idler_bearing_carries_the_vector_sum_of_both_meshes() -> None:
    """Pinion, idler, ring in line: both meshes carry T / r_b(ring), the torque ratio is z_p / z_g."""
    document = pair_document()
    document["rotors"]["idler"] = {"teeth": 25, "mass": 0.3, "inertia": 3e-4}
    document["sleeves"]["idler"] = {}
    common = document["meshes"][0]
    document["meshes"] = [{**common, "driven": "idler"}, {**common, "driver": "idler"}]
    document["rotors"]["ring"]["teeth"] = 75
    run = simulate_one(settling(document, 30.0, "ring"))
    base = 0.002 * math.cos(ALPHA)
    expected = 30.0 / (75 * base)
    forces = {
        label: float(np.mean(run.signal("drive_force", label))) for label in ("pinion-idler", "idler-ring")
    }
    for force in forces.values():
        assert force == pytest.approx(expected, rel=1e-7)
    assert forces["pinion-idler"] * 20 * base == pytest.approx(30.0 * 20 / 75, rel=1e-7)
    bearing = {
        name: np.array([float(np.mean(run.signal(f"sleeve_force_{c}", name))) for c in "xy"])
        for name in ("pinion", "idler", "ring")
    }
    # bearings hold the whole train still: their forces sum to zero, so the idler's is minus the others' sum
    np.testing.assert_allclose(bearing["idler"], -bearing["pinion"] - bearing["ring"], atol=1e-6 * expected)
    # across the centres both meshes push the idler the same way, along them against each other
    along, across = abs(bearing["idler"][0]), abs(bearing["idler"][1])
    assert across == pytest.approx(2.0 * expected * math.cos(ALPHA), rel=2e-3)
    assert along < 2e-3 * expected


def test_gravity_alone_is_carried_by_the_sleeve() -> None:
    """A disc at rest in its sleeve: reaction m g, penetration (m g / K)^(1/n)."""
    sleeve = {
        "radial_clearance": 50e-6,
        "law": "hunt-crossley",
        "stiffness": 1e9,
        "exponent": 1.5,
        "restitution": 0.5,
    }
    document = {
        "gravity": [3.0, -9.0],
        "rotors": {"disc": {"mass": 2.0, "inertia": 1e-3, "radial_damping": 3000.0}},
        "sleeves": {"disc": sleeve},
        "run": {"duration": 0.01, "transient": 0.5, "sampling": 1e4, "tolerance": 1e-9},
    }
    run = simulate_one(document)
    np.testing.assert_allclose(run.signal("sleeve_force_x", "disc"), -6.0, rtol=1e-6)
    np.testing.assert_allclose(run.signal("sleeve_force_y", "disc"), 18.0, rtol=1e-6)
    depth = (2.0 * math.hypot(3.0, 9.0) / 1e9) ** (1.0 / 1.5)
    np.testing.assert_allclose(run.signal("sleeve_penetration", "disc"), depth, rtol=1e-6)
