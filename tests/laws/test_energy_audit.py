"""Energy is accounted for: input = output + losses + stored, by the signals of a result, in random dissipative systems."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from building import Document, Floats, Measured, case_of, simulate_one
from depth import sized
from gearplay.parts.joining import JoinedRows
from gearplay.solver.trajectory import Trajectory

LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "gonthier")
K_STOP = 900.0  # of a stop in parallel to a coupling, beyond its play
K_PLAY, K_LATERAL, K_SUPPORT = 300.0, 5e6, (2e7, 3e7)


def system(seed: int) -> Document:
    """Return a motor, a coupling with play, a pair of gears in sleeves, a flywheel on a support; each with its losses."""
    rng = np.random.default_rng([29, seed])

    def draw(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def sleeve() -> dict[str, Any]:
        return {
            "radial_clearance": 2e-5,
            "law": str(rng.choice(LAWS)),
            "stiffness": 3e9,
            "restitution": draw(0.5, 0.95),
            "friction_coefficient": float(rng.choice([0.0, 0.1])),
            "friction_speed": 0.05,
            "shaft_radius": 0.01,
        }

    drive: dict[str, Any] = {
        "kind": "torque",
        "torque": 2.0,
        "terms": [{"frequency": 300.0, "amplitude": 3.0}],
    }
    if rng.random() < 0.5:
        drive = {"kind": "speed", "speed": draw(50.0, 150.0), "ripple": [{"order": 2, "amplitude": 0.01}]}
    spin = drive.get("speed", 100.0)
    start = {} if drive["kind"] == "speed" else {"initial": {"omega": spin}}
    return {
        "gravity": [0.0, -9.81],
        "rotors": {
            "motor": {"mass": 1.0, "inertia": 1e-3, "drive": drive, **start},
            "pinion": {"teeth": 20, "mass": 0.5, "inertia": 2e-4, "initial": {"omega": spin}},
            "wheel": {
                "teeth": 40,
                "mass": 1.5,
                "inertia": 2e-3,
                "initial": {"omega": -0.5 * spin, "y": draw(-1e-5, 1e-5)},
                "radial_damping": draw(0.0, 20.0),
                "load": {"torque": draw(0.0, 4.0), "drag": draw(0.0, 0.01)},
            },
            "flywheel": {
                "mass": 3.0,
                "inertia": 6e-3,
                "initial": {"omega": -0.5 * spin},
                "unbalance": {"amount": float(rng.choice([0.0, 1e-3]))},
                "load": {
                    "torque": 1.0,
                    "terms": [{"order": 3.0, "amplitude": 2.0}],
                    "friction": draw(0.0, 0.5),
                },
            },
        },
        "sleeves": {"pinion": sleeve(), "wheel": sleeve()},
        "couplings": [
            {
                "between": ["motor", "pinion"],
                "torsional_stiffness": K_PLAY,
                "torsional_damping": draw(0.0, 0.02),
                "play": 2e-3,
            },
            {
                "between": ["wheel", "flywheel"],
                "torsional_stiffness": K_PLAY,
                "torsional_damping": draw(0.0, 0.02),
                "lateral_stiffness": K_LATERAL,
                "lateral_damping": draw(0.0, 50.0),
            },
            {
                "between": ["wheel", "flywheel"],
                "torsional_stiffness": K_STOP,
                "torsional_damping": draw(0.0, 0.02),
                "play": 1e-3,
            },
        ],
        "supports": {"flywheel": {"stiffness": list(K_SUPPORT), "damping": [draw(0.0, 90.0), 30.0]}},
        "meshes": [
            {
                "driver": "pinion",
                "driven": "wheel",
                "module": 2e-3,
                "backlash": 5e-5,
                "stiffness": {"kind": "harmonic", "mean": 5e7, "amplitude": 5e6},
                "damping": {"maximum": draw(0.0, 300.0)},
                "transmission_error": [{"order": 1, "amplitude": 1e-6}],
                "friction_coefficient": float(rng.choice([0.0, 0.1])),
            }
        ],
        "run": {"duration": 4e-3, "sampling": 5e6, "tolerance": 1e-11},
    }


def audit(document: Document) -> tuple[float, float]:
    """Return the largest gap [J] between stored energy and what came in and went out, and the largest energy [J]."""
    run, case = simulate_one(document), case_of(document)
    names = list(case.rotors)
    kinetic, power = np.zeros(run.time.size), np.zeros(run.time.size)
    for name, rotor in case.rotors.items():
        v_x, v_y, omega = (run.signal(word, name) for word in ("vx", "vy", "omega"))
        kinetic += 0.5 * rotor.mass * (v_x**2 + v_y**2) + 0.5 * rotor.inertia * omega**2
        kinetic -= rotor.mass * case.gravity[1] * run.signal("y", name)
        if rotor.unbalance is not None:
            theta, amount = run.signal("theta", name), rotor.unbalance.amount
            kinetic += amount * omega * (v_y * np.cos(theta) - v_x * np.sin(theta))
            kinetic -= amount * case.gravity[1] * np.sin(theta)
        power += (run.signal("drive_torque", name) + run.signal("load_torque", name)) * omega
        power -= run.signal("rotor_power_loss", name)
    for name in case.sleeves:
        power -= run.signal("sleeve_power_loss", name)
    for _, label, _ in case.named_joints():
        power -= run.signal("coupling_power_loss", label)
    power -= run.signal("support_power_loss", "flywheel")
    power += run.signal("mesh_power_input", "pinion-wheel") - run.signal("mesh_power_loss", "pinion-wheel")
    stored = kinetic + elastic(run, document)
    brought = cumulative_simpson(power, dx=1.0 / run.sampling, initial=0.0)
    assert len(names) == 4
    return float(np.max(np.abs(stored - stored[0] - brought))), float(np.max(np.abs(stored)))


def elastic(run: Trajectory, document: Document) -> Floats:
    """Return what the springs store [J]."""
    total = np.zeros(run.time.size)
    for name, sleeve in document["sleeves"].items():
        depth = np.maximum(run.signal("sleeve_penetration", name), 0.0)
        total += sleeve["stiffness"] / 2.5 * depth**2.5
    twist = [run.signal("coupling_twist", label) for label in ("motor-pinion", "wheel-flywheel")]
    total += 0.5 * K_PLAY * (np.maximum(np.abs(twist[0]) - 1e-3, 0.0) ** 2 + twist[1] ** 2)
    total += 0.5 * K_STOP * np.maximum(np.abs(twist[1]) - 5e-4, 0.0) ** 2
    for word, stiffness in zip(("x", "y"), K_SUPPORT, strict=True):
        away = run.signal(word, "flywheel")
        total += 0.5 * stiffness * away**2 + 0.5 * K_LATERAL * (run.signal(word, "wheel") - away) ** 2
    stiffness = 5e7 + 5e6 * np.cos(20.0 * run.signal("theta", "pinion"))
    for flank in ("drive", "back"):
        depth = np.maximum(run.signal(f"{flank}_penetration", "pinion-wheel"), 0.0)
        total += 0.5 * stiffness * depth**2
    return total


def test_energy_audits_close(measured: Measured) -> None:
    """200 random systems at full depth: the books close to 1e-7 of the largest energy."""
    worst, lost = 0.0, 0.0
    for seed in range(sized(200, 20)):
        gap, energy = audit(system(seed))
        worst = max(worst, gap / energy)
        assert gap < 1e-7 * energy, seed
        lost = max(lost, energy)
    measured("energy audit: largest gap over the largest energy", worst, "1e-7")
    assert lost > 0.0


def test_a_prescribed_drive_tells_its_torque(measured: Measured) -> None:
    """A steady pair under a load: the drive torque is the load's by the ratio of the teeth; accelerated, J alpha more."""
    document = system(0)
    document["rotors"] = {
        "one": {"teeth": 20, "mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 50.0}},
        "two": {"teeth": 40, "mass": 1.0, "inertia": 1e-3, "load": {"torque": 6.0}},
    }
    mesh = document["meshes"][0] | {"driver": "one", "driven": "two", "damping": {"maximum": 500.0}}
    mesh |= {
        "friction_coefficient": 0.0,
        "transmission_error": [],
        "stiffness": {"kind": "harmonic", "mean": 5e7},
    }
    document = {"rotors": document["rotors"], "meshes": [mesh]}
    document["run"] = {"duration": 0.1, "transient": 0.4, "sampling": 1e4, "tolerance": 1e-10}
    found = simulate_one(document).signal("drive_torque", "one")
    measured("drive torque of a loaded pair, relative", float(np.max(np.abs(found / 3.0 - 1.0))), "1e-6")
    assert np.max(np.abs(found / 3.0 - 1.0)) < 1e-6
    document["rotors"]["one"]["drive"] = {"kind": "speed", "speed": 50.0, "ramp": 10.0}
    document["rotors"]["two"] |= {"load": {"torque": 6.0}}
    found = simulate_one(document).signal("drive_torque", "one")
    both = 1e-3 + 1e-3 / 4.0  # kg m^2, reduced to the driver
    assert float(np.mean(found)) == pytest.approx(3.0 + both * 5.0, rel=1e-4)


def test_a_flying_rotor_has_its_torques_too() -> None:
    """Nothing touches: a prescribed drive carries drag alone, a load has its own torque."""
    one: Document = {"mass": 1.0, "inertia": 1e-3, "load": {"drag": 0.02}}
    run_of: Document = {"run": {"duration": 0.01, "sampling": 1e4}}
    run = simulate_one({"rotors": {"one": one | {"drive": {"kind": "speed", "speed": 5.0}}}} | run_of)
    assert np.allclose(run.signal("drive_torque", "one"), 0.1)
    assert np.allclose(run.signal("rotor_power_loss", "one"), 0.5)
    loaded = {"drive": {"kind": "torque", "torque": 0.3}, "load": {"torque": 0.1, "drag": 0.02}}
    run = simulate_one({"rotors": {"one": one | loaded | {"initial": {"omega": 5.0}}}} | run_of)
    assert np.allclose(run.signal("drive_torque", "one"), 0.3)
    assert np.allclose(run.signal("load_torque", "one"), -0.1)
    assert np.allclose(run.signal("rotor_power_loss", "one"), 0.02 * run.signal("omega", "one") ** 2)


def test_joined_rotors_have_the_torques_of_their_springs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flying in closed form and integrated a prescribed drive tells the same torque: that of the coupling behind it."""
    document: Document = {
        "rotors": {
            "motor": {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 50.0}},
            "wheel": {"mass": 1.0, "inertia": 2e-3, "load": {"torque": 0.5, "drag": 0.01}, "initial": {"omega": 49.0}},
        },
        "couplings": [{"between": ["motor", "wheel"], "torsional_stiffness": 200.0, "torsional_damping": 0.01}],
        "run": {"duration": 0.05, "sampling": 1e4, "tolerance": 1e-12},
    }  # fmt: skip
    flown = simulate_one(document)
    monkeypatch.setattr("gearplay.parts.assembly.join_rotors", lambda rotors, *_: apart(len(rotors)))
    integrated = simulate_one(document)
    assert flown.counters.steps < integrated.counters.steps
    for signal, rotor in (("drive_torque", "motor"), ("load_torque", "wheel"), ("rotor_power_loss", "wheel")):
        one, other = flown.signal(signal, rotor), integrated.signal(signal, rotor)
        assert np.ptp(other) > 0.0 or signal == "load_torque"
        assert np.allclose(one, other, rtol=1e-8, atol=1e-8 * np.abs(other).max()), signal
    turn = flown.signal("omega", "motor") - flown.signal("omega", "wheel")
    twist = flown.signal("theta", "motor") - flown.signal("theta", "wheel")
    assert np.allclose(flown.signal("drive_torque", "motor"), 200.0 * twist + 0.01 * turn, atol=1e-9)


def apart(count: int) -> JoinedRows:
    """Return that no rotors are joined."""
    return JoinedRows(places=np.tile(np.array([-1, 0], dtype=np.int64), 3 * count))
