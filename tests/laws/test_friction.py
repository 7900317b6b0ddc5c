"""Friction of sleeves and teeth against closed forms, and the printed tooth force where it pulls or jumps.

Steady rolling on fixed centres under a load torque T on the driven gear of base radius r; p = pi m cos(alpha) is
the base pitch, x from -p/2 to p/2 the distance of the contact from the pitch point along the line of action, x_T
that of the tangent point of the driven gear. With l = sign(omega_2 (omega_2 - omega_1)) (+1: external pairs, and a
ring that drives; -1: a pinion that drives a ring) the torques on the driven gear balance where

    T = F (r + mu l sign(x) (x_T - x)).

The term of x_T is odd in x: the mean lever arm over a mesh period is r - l mu p / 4. A constant force, of a mesh
that vibrates slowly against the mesh frequency, is T over the mean arm; a stiff mesh carries the mean of T over the
arm.
"""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import ALPHA, Document, pair_document, single_rotor_document

MU = 0.2
BASE = 0.5 * 4e-3 * math.cos(ALPHA)  # m, base radius per tooth
PITCH = 2.0 * math.pi * BASE
RATE = 12000.0  # rad/s of the mesh phase


@pytest.mark.parametrize("omega", [3.0, 0.05])
def test_sleeve_friction__coulomb_force_and_its_cubic(omega: float) -> None:
    """-mu N (1.5 u - 0.5 u^3), u = omega R / v_f up to 1, on a journal that turns on the bottom of its bush."""
    sleeve = {"radial_clearance": 1e-4, "law": "hunt-crossley", "stiffness": 1e10, "exponent": 1.5}
    sleeve |= {"restitution": 1.0, "friction_coefficient": MU, "friction_speed": 1e-3, "shaft_radius": 0.01}
    document = single_rotor_document(sleeve, initial={"x": 0.0, "y": -1.01e-4, "omega": omega})
    ds = gp.simulate(document, duration=1e-4).ds.isel(time=0)
    normal = 1e10 * 1e-6**1.5
    assert float(ds.sleeve_force_y[0]) == pytest.approx(normal, rel=1e-9)
    u = min(omega * 0.01 / 1e-3, 1.0)
    assert float(ds.sleeve_force_x[0]) == pytest.approx(-MU * normal * (1.5 * u - 0.5 * u**3), rel=1e-6)


SIDES = ("journal", "bush")


def journal_and_bush(table: str) -> Document:
    """Return a journal and a bush free in the plane, rubbing; the sleeve is in the table of one of them."""
    sign, other = (1.0, "bush") if table == "journal" else (-1.0, "journal")
    sleeve = {"radial_clearance": 1e-4, "law": "hunt-crossley", "stiffness": 1e9, "restitution": 0.8}
    sleeve |= {"friction_coefficient": MU, "friction_speed": 0.05, "shaft_radius": 0.01}
    starts = {"journal": {"omega": 60.0}, "bush": {"omega": -20.0}}
    starts[table] |= {"x": 0.0, "y": -sign * 1.01e-4, "vx": sign * 0.3, "vy": -sign * 0.2}
    bodies = {"journal": {"mass": 0.3, "inertia": 1e-5}, "bush": {"mass": 0.5, "inertia": 2e-4}}
    common = {"position": [0.0, 0.0], "floating": True}
    rotors = {
        name: body | common | {"initial": {"theta": 0.0, **starts[name]}} for name, body in bodies.items()
    }
    del rotors[table]["floating"]
    return {
        "rotors": rotors,
        "sleeves": {table: sleeve | {"rotor_side": table, "on": other}},
        "run": {"duration": 5e-3, "sampling": 1e4, "tolerance": 1e-11},
    }


def test_sleeve_friction__is_the_same_in_the_table_of_the_journal_and_of_the_bush() -> None:
    """The rotor is the journal on a bush, or the bush around a journal: one contact, one motion of one relative to the other."""
    runs = [gp.simulate(journal_and_bush(table)).ds for table in SIDES]
    first, second = (
        {name: ds[name].sel(rotor=list(SIDES)).values for name in ("x", "y", "theta", "omega")} for ds in runs
    )
    assert np.ptp(first["omega"][:, 0]) > 5.0  # friction acts
    for name, tolerance in (("theta", 1e-9), ("omega", 1e-6)):
        np.testing.assert_allclose(first[name], second[name], rtol=0.0, atol=tolerance)
    for name in ("x", "y"):
        np.testing.assert_allclose(np.diff(first[name]), np.diff(second[name]), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("table", SIDES)
def test_sleeve_friction__keeps_linear_and_angular_momentum(table: str) -> None:
    document = journal_and_bush(table)
    ds = gp.simulate(document).ds
    mass, inertia = (
        np.array([document["rotors"][name][key] for name in SIDES]) for key in ("mass", "inertia")
    )
    x, y, vx, vy, omega = (ds[name].sel(rotor=list(SIDES)).values for name in ("x", "y", "vx", "vy", "omega"))
    assert np.ptp(omega[:, 0]) > 5.0
    for momentum, scale in (
        (vx @ mass, 0.1),
        (vy @ mass, 0.1),
        ((x * vy - y * vx) @ mass + omega @ inertia, 1e-3),
    ):
        assert float(np.ptp(momentum)) < 1e-10 * scale


def rolling(kind: str, wheel_drives: bool, ratio: float, torque: float) -> tuple[Document, float, float]:
    """Return a pair that rolls under load, the driven base radius and l; ``ratio``: natural over mesh frequency."""
    wheel = "ring" if kind == "internal" else "wheel"
    driver, driven = (wheel, "pinion") if wheel_drives else ("pinion", wheel)
    teeth = {"pinion": 20, wheel: 60}
    document = pair_document(kind)
    document["sleeves"] = {}
    radius = BASE * teeth[driven]
    mass = document["rotors"][driven]["inertia"] / radius**2
    mean = mass * (ratio * RATE) ** 2
    sense = -1.0 if kind == "internal" and not wheel_drives else 1.0
    way = 1.0 if kind == "internal" else -1.0
    document["meshes"][0] |= {
        "driver": driver,
        "driven": driven,
        "friction_coefficient": MU,
        "stiffness": {"kind": "harmonic", "mean": mean},
        "damping": {"maximum": mass * ratio * RATE, "depth": 1e-9},
    }
    lag = torque / (radius - sense * MU * PITCH / 4.0) / mean / radius
    document["rotors"][driver] |= {
        "drive": {"kind": "speed", "speed": RATE / teeth[driver]},
    }
    document["rotors"][driven] |= {"load": {"torque": torque}, "initial": {"theta": -way * lag}}
    return document, radius, sense


def mean_force(document: Document, first: int, samples: int) -> float:
    """Return the mean normal force [N] over the mesh period after ``first`` periods."""
    period = 2.0 * math.pi / RATE
    document["run"] = {
        "duration": period,
        "transient": first * period,
        "sampling": samples / period,
        "tolerance": 1e-9,
    }
    ds = gp.simulate(document, signals=["drive_force", "back_force"]).ds.isel(time=slice(0, samples))
    assert float(ds.back_force.max()) == 0.0
    assert float(ds.drive_force.min()) > 0.0
    return float(ds.drive_force.mean())


PAIRS = pytest.mark.parametrize("wheel_drives", [False, True])
KINDS = pytest.mark.parametrize("kind", ["external", "internal"])


@KINDS
@PAIRS
def test_tooth_friction__slow_mesh_carries_the_load_over_the_mean_arm(kind: str, wheel_drives: bool) -> None:
    document, radius, sense = rolling(kind, wheel_drives, 1.0 / 15.0, 5.0)
    expected = 5.0 / (radius - sense * MU * PITCH / 4.0)
    assert abs(expected * radius / 5.0 - 1.0) > 5e-3  # what friction changes
    assert mean_force(document, 40, 400) == pytest.approx(expected, rel=1.5e-4)


@KINDS
@PAIRS
def test_tooth_friction__stiff_mesh_carries_the_mean_of_load_over_arm(kind: str, wheel_drives: bool) -> None:
    document, radius, sense = rolling(kind, wheel_drives, 60.0, 5.0)
    x = PITCH * ((np.arange(4000) + 0.5) / 4000 - 0.5)
    lever = radius + sense * MU * np.sign(x) * (sense * radius * math.tan(ALPHA) - x)
    expected = 5.0 * float(np.mean(1.0 / lever))
    assert expected * (radius - sense * MU * PITCH / 4.0) > 5.0 * 1.004
    assert mean_force(document, 3, 400) == pytest.approx(expected, rel=4e-4)


def at_start(document: Document, formulation: str, **starts: dict[str, float]) -> Any:
    """Return the signals at the start of an internal pair without sleeves' forces."""
    document["formulation"] = formulation
    for name, start in starts.items():
        document["rotors"][name]["initial"] = {"x": 0.0, "y": 0.0, "theta": 0.0, **start}
    return gp.simulate(document, duration=1e-4).ds.isel(time=0)


def test_wedged_pair__both_flanks_carry_half_of_the_overlap() -> None:
    document = pair_document(
        "internal", sleeves={"pinion": {"radial_clearance": 1e-3}, "ring": {"radial_clearance": 1e-3}}
    )
    backlash = float(at_start(document, "geometric", pinion={"x": 2e-4}, ring={}).backlash[0])
    assert backlash < 0.0
    middle = {"theta": 0.5 * 1e-4 / (60 * BASE)}
    ds = at_start(document, "geometric", pinion={"x": 2e-4}, ring=middle)
    for force in (ds.drive_force[0], ds.back_force[0]):
        assert float(force) == pytest.approx(-0.5 * backlash * 1.3e8, rel=1e-9)


def test_printed_force__jumps_where_the_backlash_is_negative() -> None:
    document = pair_document(
        "internal", sleeves={"pinion": {"radial_clearance": 1e-3}, "ring": {"radial_clearance": 1e-3}}
    )
    forces = []
    for turn in (-1e-9, 1e-9):
        theta = (2e-4 * math.sin(ALPHA) + turn) / 0.04
        ds = at_start(document, "as_published", ring={"x": 2e-4}, pinion={"theta": theta})
        forces.append(float(ds.drive_force[0] - ds.back_force[0]))
    backlash = float(ds.backlash[0])
    assert backlash < 0.0
    assert forces[1] - forces[0] == pytest.approx(-1.3e8 * backlash, rel=1e-3)


def test_printed_force__pulls_on_a_damped_retreat() -> None:
    document = pair_document("internal", mesh={"damping": {"maximum": 1e5, "depth": 1e-6}})
    starts = {"pinion": {"theta": 2e-6 / 0.04, "omega": 0.0}, "ring": {"omega": 0.05 / 0.12}}
    assert float(at_start(document, "as_published", **starts).drive_force[0]) == pytest.approx(
        1.3e8 * 2e-6 - 1e5 * 0.05, rel=1e-6
    )
    assert float(at_start(document, "geometric", **starts).drive_force[0]) == 0.0
