"""A train reduced to one joint: its numbers in closed form, their spread, and the snippets for other programs."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

import gearplay as gp

COS = np.cos(np.radians(20.0))
K, C, B = 1.3e8, 900.0, 1e-4
R_1, R_2 = 40e-3 * COS, 120e-3 * COS


def pair(friction: float = 0.5, backlash: float = B) -> gp.Case:
    mesh = {
        "driver": "motor", "driven": "arm", "module": 4e-3, "backlash": backlash,
        "stiffness": {"kind": "harmonic", "mean": K}, "damping": {"law": "constant", "maximum": C},
    }  # fmt: skip
    rotors = {
        "motor": {"teeth": 20, "mass": 1.0, "inertia": 2e-3, "load": {"friction": 0.1}},
        "arm": {"teeth": 60, "mass": 3.0, "inertia": 0.05, "load": {"friction": friction}},
    }
    return gp.load_case({"rotors": rotors, "meshes": [mesh], "run": {"duration": 0.1}})


def test_numbers_of_a_pair() -> None:
    joint = gp.reduce(pair(), at="arm", hold="motor", torque="50 N m")
    expected = {
        "inertia": 0.05, "input_inertia": 9 * 2e-3, "half_width": 0.5 * B / R_2, "stiffness": K * R_2**2,
        "damping": C * R_2**2, "friction": 0.5,
    }  # fmt: skip
    for name, value in expected.items():
        assert joint.value(name) == pytest.approx(value, rel=1e-9), name


def test_first_frequency_of_the_joint_is_that_of_the_train() -> None:
    """Rayleigh's inertia of the static deflection: the frequency of a chain is met from above, closely."""
    rotors = {
        name: {"mass": 1.0, "inertia": J} for name, J in (("motor", 1.0), ("shaft", 1e-3), ("arm", 0.05))
    }
    couplings = [
        {"between": ["motor", "shaft"], "torsional_stiffness": 1e4},
        {"between": ["shaft", "arm"], "torsional_stiffness": 2e4},
    ]
    rotors["motor"]["drive"] = {"kind": "speed", "speed": 0.0}
    case = gp.load_case({"rotors": rotors, "couplings": couplings, "run": {"duration": 0.1}})
    joint = gp.reduce(case, at="arm", hold="motor", torque=10.0)
    assert joint.value("half_width") == pytest.approx(0.0, abs=1e-15)
    assert joint.value("inertia") == pytest.approx(0.05 + 1e-3 * (2 / 3) ** 2, rel=1e-9)
    own = np.sqrt(joint.value("stiffness") / joint.value("inertia")) / (2 * np.pi)
    first = float(gp.modes(case, load="none").ds["frequency"].values.min())
    assert first <= own <= 1.001 * first


@pytest.mark.parametrize(
    ("name", "at", "hold", "total"),
    [
        ("two-stage-reducer", "output", "input", 0.0127 + 0.0279 * (80 / 48) ** 2 + 4e-4 * 25),
        (  # sun 1 + z_r / z_s times as fast, planets z_r / z_p against the carrier, on pins that go round with it
            "planetary-reducer", "stage.carrier", "stage.sun",
            0.25 + 0.002 * (1 + 91 / 17) ** 2 + 3 * (0.045 * (91 / 37 - 1) ** 2 + 10.5 * 0.135**2),
        ),
    ],
)  # fmt: skip
def test_both_inertias_are_that_of_the_rolling_train(name: str, at: str, hold: str, total: float) -> None:
    """A torque turns the joint as fast as the train: its kinetic energy at rolling speeds, shafts between included."""
    joint = gp.reduce(name, at=at, hold=hold)
    assert joint.value("inertia") + joint.value("input_inertia") == pytest.approx(total, rel=1e-9)
    assert 0.0 < joint.value("inertia") < total


def test_spread_over_tolerances() -> None:
    drawn = {"name": "b", "path": "meshes.0.backlash", "low": "80 um", "high": "120 um"}
    joint = gp.reduce(
        pair(), at="arm", hold="motor", torque=50.0, members=100, tolerances={"parameters": [drawn]}
    )
    half = joint.ds["half_width_by_member"].values
    assert float(joint.ds["half_width_spread"]) == pytest.approx(np.std(half, ddof=1), rel=1e-12)
    assert float(joint.ds["half_width_spread"]) == pytest.approx(0.5 * 40e-6 / np.sqrt(12.0) / R_2, rel=0.02)
    assert float(joint.ds["stiffness_spread"]) == pytest.approx(0.0, abs=1e-6 * joint.value("stiffness"))
    assert "±" in dict(joint.rows())["half_width"]


def test_mujoco_snippet() -> None:
    """Limits of the second hinge: half the play, a spring and a damper per inertia of both sides in series.

    MuJoCo 4.0 with this snippet: static deflection within 4e-8, an oscillation in contact as the exact solution.
    """
    joint = gp.reduce(pair(), at="arm", hold="motor", torque=50.0)
    root = ElementTree.fromstring(f"<mujoco>{joint.mujoco('elbow')}</mujoco>")
    motor, play = root.iter("joint")
    assert motor.get("name") == "elbow"
    assert float(motor.get("frictionloss", "")) == pytest.approx(0.5)
    low, high = map(float, play.get("range", "").split())
    assert -low == high == pytest.approx(0.5 * B / R_2, rel=1e-8)
    inner, outer = (float(each.get("diaginertia", "").split()[2]) for each in root.iter("inertial"))
    armature = float(motor.get("armature", ""))
    assert armature + inner == pytest.approx(9 * 2e-3, rel=1e-8)
    spring, damper = (-float(each) for each in play.get("solreflimit", "").split())
    impedance = float(play.get("solimplimit", "").split()[0])
    series = 1.0 / (1.0 / outer + 1.0 / (armature + inner))
    assert spring * series / (1.0 - impedance) == pytest.approx(K * R_2**2, rel=1e-8)
    assert damper * series / (1.0 - impedance) == pytest.approx(C * R_2**2, rel=1e-8)


def test_urdf_and_modelica_snippets() -> None:
    joint = gp.reduce(pair(), at="arm", hold="motor", torque=50.0)
    root = ElementTree.fromstring(f"<robot name='r'>{joint.urdf('elbow')}</robot>")
    assert {link.get("name") for link in root.iter("link")} == {"elbow_base", "elbow_output"}
    dynamics = root.find("joint/dynamics")
    assert dynamics is not None
    assert float(dynamics.get("friction", "")) == pytest.approx(0.5)
    text = joint.modelica("Elbow")
    given = {
        name: float(value)
        for name, value in re.findall(r"([cdbJ])=([-+.e\d]+)", text.split("ElastoBacklash")[1].split(";")[0])
    }
    assert given == {
        "c": pytest.approx(K * R_2**2, rel=1e-8), "d": pytest.approx(C * R_2**2, rel=1e-8), "b": pytest.approx(B / R_2, rel=1e-8)
    }  # fmt: skip
    names = set(re.findall(r"Components\.\w+ (\w+)\(", text)) | {"flange_a", "flange_b"}
    ends = [
        end.split(".")[0].strip() for pair in re.findall(r"connect\((.*?)\)", text) for end in pair.split(",")
    ]
    assert set(ends) == names
    assert len(ends) == 2 * (len(names) - 1)
    assert "BearingFriction" not in gp.reduce(pair(0.0), at="arm", hold="motor", torque=50.0).modelica()
    stiff = gp.reduce(pair(backlash=0.0), at="arm", hold="motor", torque=50.0)
    assert "SpringDamper" in stiff.modelica()
    assert "limited" not in stiff.mujoco()


@pytest.mark.parametrize("name", ["", "a b", '"><body', "x;y", "1st", "ä"])
def test_names_that_would_break_a_snippet_are_refused(name: str) -> None:
    joint = gp.reduce(pair(), at="arm", hold="motor", torque=50.0)
    for make in (joint.mujoco, joint.urdf, joint.modelica):
        with pytest.raises(gp.InputError, match="must be a letter, then letters"):
            make(name)


def test_refusals() -> None:
    with pytest.raises(gp.InputError, match="is required, since the output has no load torque"):
        gp.reduce(pair(), at="arm", hold="motor")
    with pytest.raises(gp.InputError, match="must be a rotor of the case"):
        gp.reduce(pair(), at="leg", hold="motor")
