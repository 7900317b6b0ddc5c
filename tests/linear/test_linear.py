"""The linear view: equilibrium against statics, response against simulation, energies, speed, saved answers, pictures."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.linear.eigen import solve_at_rest
from gearplay.linear.system import linear_system
from pictures import faults_of
from planetary_sets import planetary_document

MESH = {"driver": "motor", "driven": "fan", "module": 4e-3, "backlash": 5e-5}


def torsional() -> gp.Case:
    """Return a linear case: two gears that only turn, mesh pressed and fully damped, a fan on a shaft to the ground."""
    return gp.load_case(
        {
            "rotors": {
                "motor": {
                    "teeth": 20,
                    "mass": 1.0,
                    "inertia": 2e-4,
                    "drive": {
                        "kind": "torque",
                        "torque": 20.0,
                        "terms": [{"frequency": 300.0, "amplitude": 0.2, "phase": "90 deg"}],
                    },
                },
                "fan": {"teeth": 40, "mass": 2.0, "inertia": 3e-3},
            },
            "supports": {"fan": {"torsional_stiffness": 3e4, "torsional_damping": 2.0}},
            "meshes": [
                {
                    **MESH,
                    "stiffness": {"kind": "harmonic", "mean": 1e8},
                    "damping": {"maximum": 400.0, "depth": 1e-6},
                }
            ],
            "run": {"duration": 0.1, "transient": 0.4, "sampling": 6e4, "tolerance": 1e-11},
        }
    )


def test_linear_response__equals_the_settled_simulation(measured: Measured) -> None:
    case = torsional()
    result = gp.simulate(case)
    t = result.time()
    basis = np.stack([np.cos(2e2 * 3 * math.pi * t), np.sin(2e2 * 3 * math.pi * t), np.ones_like(t)], axis=1)
    for rotor in ("motor", "fan"):
        fit, *_ = np.linalg.lstsq(basis, result.signal("theta", rotor), rcond=None)
        response = gp.frequency_response(
            case, force="motor.torque", at=f"{rotor}.theta", frequencies=300.0
        ).ds
        amplitude, phase = 0.2 * float(response["amplitude"][0, 0]), float(response["phase"][0, 0])
        assert math.hypot(fit[0], fit[1]) == pytest.approx(amplitude, rel=1e-6)
        assert math.atan2(-fit[1], fit[0]) == pytest.approx(
            phase, abs=1e-6
        )  # the term is a cosine: 90 deg of a sine
        measured(f"amplitude of {rotor}", abs(math.hypot(fit[0], fit[1]) / amplitude - 1.0), "relative")


def test_damping_ratios_are_those_of_the_damped_eigenvalues() -> None:
    """Two masses with unlike dampers: against the roots of the characteristic polynomial."""
    mass, stiffness = np.array([1.0, 2.0]), np.array([[300.0, -100.0], [-100.0, 200.0]])
    damping = np.array([[4.0, -1.0], [-1.0, 1.0]])
    found = solve_at_rest(mass, stiffness, damping)
    roots = np.roots([2.0, 2 * 4 + 1, 2 * 300 + 4 + 200 - 1, 800 + 300 - 200, 300 * 200 - 1e4])
    roots = roots[np.argsort(np.abs(roots))][::2]
    np.testing.assert_allclose(found.damping_ratio, -roots.real / np.abs(roots), rtol=1e-9)
    np.testing.assert_allclose(
        np.sort(found.frequency) * 2.0 * math.pi, np.sqrt(np.roots([2.0, -800.0, 5e4])[::-1]), rtol=1e-12
    )


def test_the_equilibrium_is_that_of_statics() -> None:
    """A torque of 20 N m turns the fan by 2 T / k and presses the teeth by F / k."""
    found = gp.modes(torsional()).ds
    force = 20.0 / (0.04 * math.cos(math.radians(20.0)))
    at = dict(zip(found["coordinate"].values, found["static_displacement"].values, strict=True))
    assert at["fan.theta"] == pytest.approx(-40.0 / 3e4, rel=1e-9)
    pressed = math.cos(math.radians(20.0)) * (0.04 * at["motor.theta"] + 0.08 * at["fan.theta"])
    assert pressed == pytest.approx(force / 1e8, rel=1e-6)
    assert list(found["closed"].values) == [1, 0]


def test_without_a_load_there_is_no_contact() -> None:
    loaded, free = gp.modes(torsional()), gp.modes(torsional(), load="none")
    assert free.ds["closed"].values.sum() == 0
    assert free.ds["frequency"].values[0] == 0.0
    assert free.ds["frequency"].values[1] == pytest.approx(math.sqrt(3e4 / 3e-3) / (2.0 * math.pi))
    assert loaded.ds["frequency"].values[0] > 0.0


def test_shares_of_energy_add_up() -> None:
    found = gp.modes(planetary_document())
    strain, kinetic = found.ds["strain_energy_share"].values, found.ds["kinetic_energy_share"].values
    moving = found.ds["frequency"].values > 0.0
    np.testing.assert_allclose(strain[moving].sum(axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(kinetic.sum(axis=1), 1.0, atol=1e-12)
    shapes, system = found.ds["shape"].values, linear_system(gp.load_case(planetary_document()))
    np.testing.assert_allclose((shapes * system.mass) @ shapes.T, np.eye(len(shapes)), atol=1e-9)
    energy = 0.5 * np.einsum("mi,ij,mj->m", shapes, system.stiffness, shapes)
    np.testing.assert_allclose(
        energy, 0.5 * (2.0 * np.pi * found.ds["frequency"].values) ** 2, rtol=1e-6, atol=1e-3
    )


def test_each_spring_has_its_own_share_of_energy() -> None:
    """Three discs in a row on a spring to the ground: half the stiffness times the square of each spring's own twist."""
    disc = {"mass": 1.0, "inertia": 2e-3}
    shafts = [
        {"between": ["a", "b"], "torsional_stiffness": 3e3},
        {"between": ["b", "c"], "torsional_stiffness": 1e3},
    ]
    found = gp.modes(
        {
            "rotors": dict.fromkeys("abc", disc),
            "supports": {"a": {"torsional_stiffness": 500.0}},
            "couplings": shafts,
            "run": {"duration": 1.0},
        }
    ).ds
    turns = found["shape"].sel(coordinate=["a.theta", "b.theta", "c.theta"])
    turns = turns.values[found["frequency"].values > 0.0]
    assert len(turns) == 3
    a, b, c = turns.T
    energies = {
        "support a": 500.0 * a**2,
        "coupling a-b": 3e3 * (a - b) ** 2,
        "coupling b-c": 1e3 * (b - c) ** 2,
    }
    shares = found["strain_energy_share"].sel(element=list(energies)).values[found["frequency"].values > 0.0]
    expected = np.array(list(energies.values())).T
    np.testing.assert_allclose(shares, expected / expected.sum(axis=1, keepdims=True), atol=1e-9)


def test_a_servo_is_its_gains() -> None:
    """Gain on the integral: a spring to the ground; on the speed: its damper."""
    wheel = {"mass": 1.0, "inertia": 2e-3}
    servo = {
        "kind": "servo",
        "speed": 10.0,
        "proportional_gain": 0.4,
        "integral_gain": 80.0,
        "torque_limit": 50.0,
    }
    found = gp.modes({"rotors": {"wheel": {**wheel, "drive": servo}}, "run": {"duration": 1.0}})
    omega = math.sqrt(80.0 / 2e-3)
    assert found.ds["frequency"].values[0] == pytest.approx(omega / (2.0 * math.pi))
    assert found.ds["damping_ratio"].values[0] == pytest.approx(0.4 / (2.0 * math.sqrt(80.0 * 2e-3)))
    assert found.ds["element"].values.tolist() == ["servo wheel"]


def test_a_turning_carrier_splits_the_modes_of_its_planets() -> None:
    """A body on isotropic springs on a table that turns: omega - Omega and omega + Omega, seen from there."""
    turntable = {"mass": 1.0, "inertia": 1e6, "drive": {"kind": "speed", "speed": 30.0}}
    case = {
        "rotors": {"table": turntable, "body": {"mass": 2.0, "inertia": 1e-3, "position": [0.1, 0.0]}},
        "supports": {"body": {"stiffness": [2e4, 2e4], "on": "table"}},
        "run": {"duration": 0.1},
    }
    rest = gp.modes(case).ds["frequency"].values
    assert rest[1:] * 2.0 * math.pi == pytest.approx([100.0, 100.0])
    turning = gp.modes(case, speed="30 rad/s").ds
    assert np.sort(turning["frequency"].values)[1:] * 2.0 * math.pi == pytest.approx([70.0, 130.0])
    assert turning["shape_imaginary"].dims == ("mode", "coordinate")
    diagram = gp.campbell(case, np.linspace(1.0, 60.0, 20)).ds
    by_mode = np.sort(2.0 * math.pi * diagram["frequency"].values, axis=1)[:, 1:]
    np.testing.assert_allclose(by_mode[:, 0], 100.0 - diagram["speed"].values, rtol=1e-6)
    np.testing.assert_allclose(by_mode[:, 1], 100.0 + diagram["speed"].values, rtol=1e-6)


def test_orders_meet_modes_where_they_are_equal() -> None:
    speeds = np.linspace(10.0, 400.0, 40)
    case = gp.replace(torsional(), {"rotors.motor.drive.terms": []})
    found = gp.campbell(case, speeds).ds
    assert found.attrs["lead"] == "motor"
    assert found["order"].values.tolist() == ["motor-fan", "2 x motor-fan", "motor", "fan"]
    natural = gp.modes(case).ds["frequency"].values
    assert natural[0] * 2.0 * math.pi / 20.0 == pytest.approx(found["crossing_speed"].values[1], rel=1e-9)
    assert found["crossing_order"].values[1] == "motor-fan"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gp.modes(torsional(), load="full"), "must be operating or none"),
        (lambda: gp.campbell(torsional(), [3.0, 2.0]), "must be 2 to 100000 rising numbers"),
        (lambda: gp.campbell(torsional(), ["3 kg", "4 kg"]), "speed"),
        (
            lambda: gp.frequency_response(torsional(), force="motor.push", at="fan.theta", frequencies=1.0),
            "must be a force or torque on a rotor",
        ),
        (
            lambda: gp.frequency_response(torsional(), force="motor.torque", at="fan.x", frequencies=1.0),
            "must be a coordinate that is free to move",
        ),
        (
            lambda: gp.frequency_response(torsional(), force="motor.torque", at="fan.theta", frequencies=-1.0),
            "frequencies of 0 Hz or more",
        ),
        (
            lambda: gp.frequency_response(
                gp.replace(torsional(), {"rotors.motor.drive.torque": 0.0}),
                force="motor-fan.transmission_error", at="fan.theta", frequencies=1.0,
            ),
            "must have one of its flanks closed by the load",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(call: Any, words: str) -> None:
    with pytest.raises(gp.InputError, match=words.replace("(", r"\(")):
        call()


def test_campbell_picture__names_every_order_and_marks_as_the_legend_does() -> None:
    """The shaft of the fan, 6 Hz of 2000 Hz at most, has its name too; modes at 0 Hz have no line and no entry."""
    case = gp.replace(torsional(), {"rotors.motor.drive.terms": [], "supports.fan.torsional_stiffness": 3e5})
    found = gp.campbell(case, np.linspace(10.0, 80.0, 12))
    figure = found.plot()
    ax = figure.axes[0]
    assert {text.get_text() for text in ax.texts} == set(found.ds["order"].values.tolist())
    assert faults_of(figure) == []
    entries = dict(
        zip(
            (t.get_text() for t in figure.legends[0].get_texts()),
            figure.legends[0].legend_handles,
            strict=True,
        )
    )
    drawn = next(line for line in ax.lines if line.get_marker() == "o")
    assert entries["crossings"].get_markerfacecolor() == drawn.get_markerfacecolor() == "white"
    assert len(entries) == 2 + len(
        {str(k) for k in found.ds["kind"].values[found.ds["frequency"].values[0] > 0.0]}
    )


def test_shapes_picture__has_rings_in_its_legend_where_there_are_some() -> None:
    entries = {
        rings: [text.get_text() for text in gp.modes(case).plot().legends[0].get_texts()]
        for rings, case in ((False, torsional()), (True, "pinion-idler-ring"))
    }
    assert [any("ring" in each for each in entries[rings]) for rings in (False, True)] == [False, True]


@pytest.mark.slow
def test_answers_come_back_from_their_files_and_have_pictures(tmp_path: Path) -> None:
    case = planetary_document()
    answers = [
        gp.modes(case),
        gp.modes(case, speed=50.0),
        gp.campbell(case, [10.0, 20.0, 30.0]),
        gp.frequency_response(
            case,
            force="stage.sun-stage.planet1.transmission_error",
            at=["stage.carrier.theta"],
            frequencies=[10.0, 20.0],
        ),
    ]
    for at, answer in enumerate(answers):
        place = tmp_path / f"{at}.nc"
        answer.save(place)
        again = gp.read_result(place)
        assert type(again) is type(answer)
        assert again.ds.identical(answer.ds.assign_attrs(again.ds.attrs))
        assert again.message == answer.message
        figure = again.plot()
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
        for ax in figure.axes:
            if ax.get_visible():
                box = ax.get_window_extent()
                low, high = pixels.shape[0] - int(box.y1), pixels.shape[0] - int(box.y0)
                inside = pixels[low:high, int(box.x0) : int(box.x1)]
                assert np.mean(np.any(inside < 200, axis=-1)) > 0.002
