"""Key numbers of the output shaft against closed forms."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.results.output_shaft import output_of

RADIUS = {
    "pinion": 0.5 * 20 * 2e-3 * math.cos(math.radians(20.0)),
    "gear": 0.5 * 40 * 2e-3 * math.cos(math.radians(20.0)),
}
STIFFNESS = 2e8


def pair(**changes: Any) -> dict[str, Any]:
    """Return a reduction 20/40 with held centres, 100 rad/s on the pinion and 30 N m on the gear."""
    case: dict[str, Any] = {
        "rotors": {
            "pinion": {"teeth": 20, "mass": 0.3, "inertia": 1e-4, "drive": {"kind": "speed", "speed": 100.0}},
            "gear": {"teeth": 40, "mass": 1.0, "inertia": 1e-3, "load": {"torque": 30.0}},
        },
        "meshes": [
            {
                "driver": "pinion",
                "driven": "gear",
                "module": 2e-3,
                "backlash": 1e-4,
                "stiffness": {"kind": "harmonic", "mean": STIFFNESS, "amplitude": 0.0},
                "damping": {"ratio": 0.3, "law": "constant"},
            }
        ],
        "run": {"duration": 0.1, "transient": 0.2, "sampling": 2e4, "tolerance": 1e-8},
    }
    case["rotors"]["gear"]["load"] |= changes.pop("load", {})
    case["meshes"][0] |= changes.pop("mesh", {})
    return case | changes


def test_output__steady_load() -> None:
    """The teeth deflect by F / k along the line of action; the gear lags by that over its base radius and runs evenly."""
    shaft = gp.simulate(pair()).output
    assert (shaft.rotor, shaft.input) == ("gear", "pinion")
    assert shaft.ratio == pytest.approx(-0.5, rel=1e-12)
    force = 30.0 / RADIUS["gear"]
    assert shaft.values["wind_up"] == pytest.approx(force / STIFFNESS / RADIUS["gear"], rel=1e-6)
    assert shaft.values["mean_speed"] == pytest.approx(-50.0, rel=1e-9)
    assert shaft.values["speed_ripple"] < 1e-6
    assert shaft.values["mean_torque"] == pytest.approx(30.0, rel=1e-6)
    assert shaft.values["torque_ripple"] < 1e-3
    assert shaft.values["output_power"] == pytest.approx(1500.0, rel=1e-6)
    assert shaft.values["efficiency"] == pytest.approx(1.0, abs=1e-9)
    assert shaft.values["impacts_per_second"] == shaft.values["impact_power"] == 0.0


def test_output__slow_tooth_error() -> None:
    """A tooth error a sin(psi) far below the resonance moves the gear by 2 a / r_b peak to peak."""
    amplitude = 5e-6
    error = [{"order": 1, "amplitude": amplitude, "phase": 0.0}]
    case = pair(mesh={"transmission_error": error})
    case["rotors"]["pinion"]["drive"]["speed"] = 1.0
    case["run"]["duration"] = 0.7
    shaft = gp.simulate(case).output
    assert shaft.values["transmission_error"] == pytest.approx(2.0 * amplitude / RADIUS["gear"], rel=2e-4)
    rate = 20.0
    assert shaft.values["speed_ripple"] == pytest.approx(2.0 * amplitude * rate / RADIUS["gear"], rel=2e-4)
    angle = 2.0 * amplitude / RADIUS["gear"] * 3600.0 * math.degrees(1.0)
    assert f"{angle:.3g} arcsec" in dict(shaft.rows())["transmission error, peak to peak"]


@pytest.mark.parametrize("phase", [0.0, 0.5 * math.pi, 4.0])
def test_output__wind_up_free_of_errors_at_the_start(phase: float) -> None:
    """Over whole turns a tooth error and a run-out leave the mean lag at that of the load, wherever they are at the start."""
    case = pair(mesh={"transmission_error": [{"order": 1, "amplitude": 5e-6, "phase": phase}]})
    case["rotors"]["pinion"]["drive"]["speed"] = 40.0 * math.pi
    case["rotors"]["gear"]["runout"] = {"amplitude": 5e-6, "phase": phase}
    case["rotors"]["gear"]["initial"] = {"theta": 1e-3}
    shaft = gp.simulate(case).output
    force = 30.0 / RADIUS["gear"]
    assert shaft.values["wind_up"] == pytest.approx(force / STIFFNESS / RADIUS["gear"], rel=2e-3)


def test_output__torque_is_what_the_teeth_deliver() -> None:
    """Torque of the shaft from load and inertia equals that from the tooth force, in the mean of each sampling interval."""
    case = pair(mesh={"transmission_error": [{"order": 1, "amplitude": 5e-6, "phase": 0.0}]})
    result = gp.simulate(case, sampling=2e5)
    teeth = RADIUS["gear"] * (result.signal("drive_force") - result.signal("back_force"))
    assert result.output.values["torque_ripple"] == pytest.approx(np.ptp(teeth), rel=2e-3)
    assert result.output.values["mean_torque"] == pytest.approx(np.mean(teeth), rel=1e-4)


def test_output__efficiency_with_a_braked_shaft_between() -> None:
    """Drag d on a shaft that turns with w takes d w^2: the efficiency is P / (P + d w^2)."""
    case = pair()
    case["rotors"]["idler"] = {"teeth": 30, "mass": 0.5, "inertia": 5e-4, "load": {"drag": 2e-2}}
    first, drag = case["meshes"][0], 2e-2
    case["meshes"] = [first | {"driven": "idler"}, first | {"driver": "idler"}]
    shaft = gp.simulate(case).output
    speed = 100.0 * 20 / 30
    assert shaft.rotor == "gear"
    assert shaft.values["efficiency"] == pytest.approx(1500.0 / (1500.0 + drag * speed**2), rel=1e-6)
    assert "no friction" in shaft.note


def test_output__friction_and_drag_of_the_load_are_output() -> None:
    """What brakes the output is its load: torque, drag and dry friction add up, and cost no efficiency."""
    shaft = gp.simulate(pair(load={"drag": 0.1, "friction": 2.0})).output
    assert shaft.values["mean_torque"] == pytest.approx(30.0 + 0.1 * 50.0 + 2.0, rel=1e-6)
    assert shaft.values["efficiency"] == pytest.approx(1.0, abs=1e-9)


def test_output__power_of_impacts() -> None:
    """Impacts with delivered restitution e lose 1 - e^2 of their kinetic energy; a journal that bounces loses nothing else."""
    case = {
        "rotors": {"disc": {"mass": 0.5, "inertia": 1e-3, "initial": {"x": 5e-5, "vx": 0.02}}},
        "sleeves": {
            "disc": {
                "radial_clearance": 1e-4,
                "law": "lankarani-nikravesh",
                "stiffness": 1e10,
                "exponent": 1.5,
                "restitution": 0.8,
                "restitution_reading": "delivered",
            }
        },
        "gravity": [0.0, 0.0],
        "run": {"duration": 0.02, "sampling": 1e6, "tolerance": 1e-8},
    }
    result = gp.simulate(case)
    shaft = result.output_at("disc")
    assert shaft.values["impacts_per_second"] >= 100.0
    start, end = (
        0.25 * v**2 for v in (0.02, math.hypot(result.signal("disc.vx")[-1], result.signal("disc.vy")[-1]))
    )
    assert shaft.values["impact_power"] * (1.0 - 0.8**2) * 0.02 == pytest.approx(start - end, rel=1e-3)


def test_output__power_of_impacts_in_a_coupling() -> None:
    """Undamped, every end of the play is met at the same rate v of the twist, with v^2 / (2 (1/J_1 + ratio^2/J_2))."""
    rate, ratio, inertias = 4.0, -2.0, (2e-3, 5e-3)
    case = {
        "rotors": {
            name: {"mass": 1.0, "inertia": inertia, "initial": {"theta": 0.0, "omega": omega}}
            for name, inertia, omega in zip(("one", "two"), inertias, (rate, 0.0), strict=True)
        },
        "couplings": [{"between": ["one", "two"], "torsional_stiffness": 2e3, "play": 2e-3, "ratio": ratio}],
        "run": {"duration": 0.1, "sampling": 1e4, "tolerance": 1e-10},
    }
    values = gp.simulate(case).output_at("two").values
    energy = 0.5 * rate**2 / (1.0 / inertias[0] + ratio**2 / inertias[1])
    assert values["impacts_per_second"] > 300.0
    assert values["impact_power"] == pytest.approx(energy * values["impacts_per_second"], rel=1e-6)


def test_output__power_of_impacts_in_a_rolling_bearing() -> None:
    """Undamped between two opposite elements of a bearing that stands, every one is met with m v^2 / 2."""
    speed = 0.05
    bearing = {
        "rolling_elements": 2,
        "element_diameter": "5 mm",
        "pitch_diameter": "30 mm",
        "stiffness": 1e10,
    }
    case = {
        "rotors": {"disc": {"mass": 0.5, "inertia": 1e-3, "initial": {"vx": speed}}},
        "bearings": {"disc": bearing | {"internal_clearance": "50 um"}},
        "gravity": [0.0, 0.0],
        "run": {"duration": 0.05, "sampling": 1e4, "tolerance": 1e-10},
    }
    values = gp.simulate(case).output_at("disc").values
    assert values["impacts_per_second"] > 500.0
    assert values["impact_power"] == pytest.approx(0.25 * speed**2 * values["impacts_per_second"], rel=1e-6)


def test_output__power_of_impacts_on_a_carrier() -> None:
    """The mass behind a planet's impact on its pin is that of planet and carrier, whose inertia counts at the mean of r^2."""
    case = {
        "rotors": {
            "carrier": {"mass": 1.0, "inertia": 1e-3, "position": [0.0, 0.0]},
            "planet": {
                "mass": 0.4,
                "inertia": 1e-4,
                "position": [0.06, 0.0],
                "initial": {"vx": 0.02, "vy": 0.03},
            },
        },
        "sleeves": {
            "planet": {"radial_clearance": 5e-5, "stiffness": 1e10, "restitution": 0.9, "on": "carrier"}
        },
        "gravity": [0.0, 0.0],
        "run": {"duration": 0.05, "sampling": 1e4},
    }
    result = gp.simulate(case)
    contacts, power = result.contacts.values, result.output.values["impact_power"]
    mass = 1.0 / (1.0 / 0.4 + 0.5 * 0.06**2 / 1e-3)
    each = 0.5 * mass * contacts["rms_impact_speed"][0] ** 2
    assert contacts["impacts_per_second"][0] > 100.0
    assert power == pytest.approx(each * contacts["impacts_per_second"][0], rel=1e-9)


def test_output__members_and_files(tmp_path: Any) -> None:
    """Of an ensemble means and standard deviations over the members; a file gives the numbers of the result."""
    result = gp.simulate("han2021", duration=0.5, ensemble=3)
    shaft = result.output
    single = [float(np.ptp(result.signal("ring.omega", member=m))) for m in range(3)]
    assert shaft.each["speed_ripple"] == pytest.approx(single, rel=1e-9)
    assert shaft.values["speed_ripple"] == pytest.approx(np.mean(single), rel=1e-9)
    assert shaft.spread["speed_ripple"] == pytest.approx(np.std(single, ddof=1), rel=1e-9)
    result.save(tmp_path / "run.nc")
    stored = gp.read_result(tmp_path / "run.nc").output
    assert stored.values == pytest.approx(shaft.values, rel=1e-6, nan_ok=True)


def test_output__unknown_or_incomplete() -> None:
    """Another shaft by its name; a name that is none is refused; without its signals only impacts are left."""
    result = gp.simulate(pair(), signals=["drive_force"])
    with pytest.raises(gp.InputError, match=r"output = \"wheel\".*Choose from: pinion, gear"):
        result.output_at("wheel")
    known = {name for name, value in result.output.values.items() if math.isfinite(value)}
    assert known == {"impacts_per_second", "impact_power"}


def test_output__two_inputs_have_no_ratio() -> None:
    """A train with a second prescribed speed has no fixed ratio, hence no transmission error."""
    case = pair()
    case["rotors"]["gear"] |= {"drive": {"kind": "speed", "speed": -50.0}}
    shaft = gp.simulate(case).output
    assert math.isnan(shaft.ratio)
    assert "transmission error, peak to peak" not in dict(shaft.rows())


def test_output__of_a_shaft_without_a_load() -> None:
    """Between input and load a shaft has a motion and a transmission error, but delivers nothing outside."""
    case = pair()
    case["rotors"]["idler"] = {"teeth": 30, "mass": 0.5, "inertia": 5e-4}
    first = case["meshes"][0]
    case["meshes"] = [first | {"driven": "idler"}, first | {"driver": "idler"}]
    names = dict(gp.simulate(case).output_at("idler").rows())
    assert "transmission error, peak to peak" in names
    assert not {"mean torque", "efficiency", "mean power into the load"} & set(names)


def test_output__is_the_shaft_with_the_largest_load_at_speed() -> None:
    """A fan of 0.2 N m s/rad at 50 rad/s takes 10 N m, more than a pump of 5 N m on the shaft before it."""
    case = pair(load={"torque": 0.0, "drag": 0.2})
    case["rotors"]["idler"] = {"teeth": 30, "mass": 0.5, "inertia": 5e-4, "load": {"torque": 5.0}}
    first = case["meshes"][0]
    case["meshes"] = [first | {"driven": "idler"}, first | {"driver": "idler"}]
    assert output_of(gp.load_case(case)) == "gear"
