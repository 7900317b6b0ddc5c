"""What the equations may not notice: where the axes point, mirror images, names and order, units."""

import copy
import math

import numpy as np
import pytest

from building import (
    ALPHA,
    Document,
    Floats,
    case_of,
    free_pair_case,
    merged,
    mesh_at,
    pair_document,
    simulate_one,
)
from gearplay.model.pack import pack
from gearplay.parts.mesh.geometry import PSI, PSI_RATE

SPAN = 0.01  # s: below 20 ms trajectories compare point by point


def busy_pair(kind: str) -> Document:
    """Return a driven, loaded, damped pair with runout, transmission error and gravity."""
    document = free_pair_case(kind, "coupled", 5)
    wheel = document["meshes"][0]["driven"]
    for name, rotor in document["rotors"].items():
        del rotor["initial"]["omega"]
        rotor["radial_damping"] = 2.0
        rotor["runout"] = {"amplitude": 1e-5, "phase": 0.7 if name == "pinion" else 2.1}
    document["rotors"]["pinion"] |= {"drive": {"kind": "speed", "speed": 60.0}, "position": [0.0, 0.0]}
    A0 = 0.16 if kind == "external" else -0.08
    document["rotors"][wheel] |= {
        "load": {"torque": 1.0, "drag": 1e-3, "friction": 0.1},
        "position": [A0, 0.0],
    }
    sleeve = {
        "law": "lankarani-nikravesh",
        "restitution": 0.9,
        "shaft_radius": 0.01,
        "friction_coefficient": 0.1,
    }
    for name in document["sleeves"]:
        document["sleeves"][name] |= sleeve
    document["meshes"][0] |= {
        "stiffness": {"kind": "harmonic", "mean": 1.3e8, "amplitude": 2e7, "phase": 0.3},
        "damping": {"maximum": 500.0, "depth": 1e-6},
        "transmission_error": [{"order": 1, "amplitude": 5e-6, "phase": 0.6}],
    }
    return merged(
        document, {"gravity": [3.0, -9.0], "run": {"duration": SPAN, "sampling": 1e5, "tolerance": 1e-10}}
    )


def turned(v: list[float], angle: float) -> list[float]:
    """Return a vector turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return [c * v[0] - s * v[1], s * v[0] + c * v[1]]


def motion(document: Document, names: list[str]) -> tuple[Floats, Floats]:
    """Return displacements, shape [rotor, 2, time], and rotations, shape [rotor, time]."""
    run = simulate_one(document, signals=["x", "y", "theta"])
    assert len(run.log) >= 10, "contacts open and close"
    places = np.array([[run.signal(c, n) for c in "xy"] for n in names])
    return places, np.array([run.signal("theta", n) for n in names])


@pytest.mark.parametrize("kind", ["internal", "external"])
@pytest.mark.parametrize("angle", [0.5 * math.pi, 1.0, -2.5])
def test_turning_the_system_turns_the_motion(kind: str, angle: float) -> None:
    """Rotate positions, velocities, gravity and runout by any angle: the motion is the rotated one."""
    document = busy_pair(kind) | {"mesh_phases": "from_zero"}  # teeth turn with the places
    other = copy.deepcopy(document)
    other["gravity"] = turned(document["gravity"], angle)
    for rotor in other["rotors"].values():
        start = rotor["initial"]
        start["x"], start["y"] = turned([start["x"], start["y"]], angle)
        start["vx"], start["vy"] = turned([start["vx"], start["vy"]], angle)
        rotor["position"] = turned(rotor["position"], angle)
        rotor["runout"]["phase"] += angle
    names = list(document["rotors"])
    (p, theta), (q, theta_q) = motion(document, names), motion(other, names)
    expected = np.array([turned(list(v), angle) for v in p])
    np.testing.assert_allclose(q, expected, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(theta_q, theta, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_mirror_image_moves_as_the_mirrored_motion(kind: str) -> None:
    """Mirror y, all rotations and the drive's sense: the drive flank changes side, the motion is mirrored."""
    document = busy_pair(kind)
    other = copy.deepcopy(document)
    other["gravity"][1] *= -1.0
    for rotor in other["rotors"].values():
        for key in ("y", "vy"):
            rotor["initial"][key] *= -1.0
        rotor["runout"]["phase"] *= -1.0
    other["rotors"]["pinion"]["drive"]["speed"] *= -1.0
    mesh = other["meshes"][0]
    # psi changes sign: cosines keep their sign with -phase, sines with pi - phase
    mesh["stiffness"]["phase"] *= -1.0
    mesh["transmission_error"][0]["phase"] = math.pi - mesh["transmission_error"][0]["phase"]
    names = list(document["rotors"])
    (p, theta), (q, theta_q) = motion(document, names), motion(other, names)
    np.testing.assert_allclose(q[:, 0], p[:, 0], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(q[:, 1], -p[:, 1], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(theta_q, -theta, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_order_of_rotors_and_sleeves_does_not_matter(kind: str) -> None:
    """The same case listed backwards gives the same motion by name."""
    document = busy_pair(kind)
    other = {**document}
    for table in ("rotors", "sleeves"):
        other[table] = dict(reversed(list(document[table].items())))
    names = list(document["rotors"])
    (p, theta), (q, theta_q) = motion(document, names), motion(other, names)
    np.testing.assert_allclose(q, p, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(theta_q, theta, rtol=0.0, atol=1e-9)


def test_naming_the_other_gear_driver_exchanges_the_flanks_only() -> None:
    """An external pair with constant stiffness does not know which gear is called driver: flanks swap names.

    The uncoupled model does know: its one line of action is that of the drive flank.
    """
    document = free_pair_case("external", "coupled", 6)
    base = 0.002 * math.cos(ALPHA)
    document["rotors"]["pinion"]["initial"] |= {"omega": 3.0, "theta": 0.0}
    document["rotors"]["wheel"]["initial"] |= {"omega": -1.3, "theta": -4e-5 / (60 * base)}
    document["rotors"]["pinion"]["position"], document["rotors"]["wheel"]["position"] = (
        [0.0, 0.0],
        [0.16, 0.0],
    )
    document["run"]["duration"] = SPAN
    other = copy.deepcopy(document)
    other["meshes"][0] |= {"driver": "wheel", "driven": "pinion"}
    # touching at theta = 0 is now the other flank: go across the backlash
    other["rotors"]["wheel"]["initial"]["theta"] += 100e-6 / (60 * base)
    # the first given speed sets the sense: list the wheel first, as its driver
    other["rotors"] = dict(reversed(list(other["rotors"].items())))
    runs = [simulate_one(d) for d in (document, other)]
    labels = ["pinion-wheel", "wheel-pinion"]
    for signal, swapped in (("drive_penetration", "back_penetration"), ("drive_force", "back_force")):
        a, b = runs[0].signal(signal, labels[0]), runs[1].signal(swapped, labels[1])
        scale = 1.0 if signal == "drive_penetration" else 1e8
        np.testing.assert_allclose(b, a, rtol=0.0, atol=1e-11 * scale)
    assert len(runs[0].log) >= 10
    for name in ("pinion", "wheel"):
        np.testing.assert_allclose(runs[1].signal("x", name), runs[0].signal("x", name), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_rescaling_length_mass_and_time_rescales_the_motion(kind: str) -> None:
    """Every quantity scaled by its dimension (length 1.7, mass 3, time 0.6): x'(0.6 t) = 1.7 x(t)."""
    length, mass, time = 1.7, 3.0, 0.6
    speed, force = length / time, mass * length / time**2
    document = busy_pair(kind)
    other = copy.deepcopy(document)
    other["gravity"] = [g * length / time**2 for g in document["gravity"]]
    for rotor in other["rotors"].values():
        start = rotor["initial"]
        start["x"], start["y"] = length * start["x"], length * start["y"]
        start["vx"], start["vy"] = speed * start["vx"], speed * start["vy"]
        rotor["position"] = [length * x for x in rotor["position"]]
        rotor["mass"] *= mass
        rotor["inertia"] *= mass * length**2
        rotor["radial_damping"] *= mass / time
        rotor["runout"]["amplitude"] *= length
        if "drive" in rotor:
            rotor["drive"]["speed"] /= time
        else:
            rotor["load"] = {
                "torque": rotor["load"]["torque"] * force * length,
                "drag": rotor["load"]["drag"] * force * length * time,
                "friction": rotor["load"]["friction"] * force * length,
                "friction_speed": 0.01 / time,
            }
    for sleeve in other["sleeves"].values():
        sleeve["radial_clearance"] *= length
        sleeve["stiffness"] *= force / length**1.5
        sleeve["minimum_impact_speed"] = 1e-4 * speed
        sleeve["shaft_radius"] *= length
        sleeve["friction_speed"] = 1e-3 * speed
    mesh = other["meshes"][0]
    mesh["module"], mesh["backlash"] = length * mesh["module"], length * mesh["backlash"]
    mesh["stiffness"] |= {key: mesh["stiffness"][key] * force / length for key in ("mean", "amplitude")}
    mesh["damping"] = {"maximum": 500.0 * force / speed, "depth": 1e-6 * length}
    mesh["transmission_error"][0]["amplitude"] *= length
    other["run"] |= {"duration": time * SPAN, "sampling": 1e5 / time}
    names = list(document["rotors"])
    (p, theta), (q, theta_q) = motion(document, names), motion(other, names)
    assert q.shape == p.shape
    np.testing.assert_allclose(q / length, p, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(theta_q, theta, rtol=0.0, atol=1e-8)


def test_a_train_that_turns_as_a_block_passes_no_teeth() -> None:
    """Sun and carrier at one speed: the mesh phase stands still, since no tooth passes another."""
    turning = {"kind": "speed", "speed": 30.0}
    rotors = {
        "sun": {"teeth": 20, "mass": 0.3, "inertia": 2e-4, "drive": turning, "position": [0.0, 0.0]},
        "planet": {"teeth": 20, "mass": 0.2, "inertia": 2e-4},
        "carrier": {"mass": 0.5, "inertia": 2e-3, "drive": turning, "position": [0.0, 0.0]},
    }
    document = merged(pair_document("external"), {"rotors": {"pinion": None, "wheel": None, **rotors}})
    document["sleeves"] = {"planet": {**document["sleeves"]["pinion"], "on": "carrier"}}
    document["meshes"][0] |= {"driver": "sun", "driven": "planet"}
    packed = pack(case_of(document))
    for t in (0.0, 0.1):
        out = mesh_at(packed, 0, np.zeros(18), t)
        assert out[PSI] == pytest.approx(0.0, abs=1e-9)
        assert out[PSI_RATE] == pytest.approx(0.0, abs=1e-9)
