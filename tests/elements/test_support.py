"""Supports: against closed forms, and random ones on the ground and on a carrier for the tests of all elements."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, simpson
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import agm, ellipj

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import load_case
from gearplay.parts.support.law import KIND
from gearplay.vocabulary.errors import InputError

MASS, INERTIA = 0.4, 1e-4  # kg, kg m^2


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc on a support on a carrier that is on one itself."""

    def support(torsional: float) -> dict[str, Any]:
        stiffness = rng.uniform(1e5, 1e7, 2)
        damping = rng.uniform(1.0, 50.0, 2) if damped else np.zeros(2)
        if plain:  # the axes of a support do not turn with a turned mechanism
            stiffness[1], damping[1] = stiffness[0], damping[0]
        given: dict[str, Any] = {"stiffness": stiffness.tolist(), "damping": damping.tolist()}
        if rng.random() < 0.5:
            given["cubic_stiffness"] = float(rng.uniform(1e13, 1e15))
        if not plain and damped and rng.random() < 0.5:  # in full: an unsymmetric matrix has no potential
            across = stiffness.min() * rng.uniform(-0.5, 0.5, 2)
            given["stiffness"] = [[stiffness[0], across[0]], [across[1], stiffness[1]]]
            given["damping"] = [[damping[0], 3.0], [-5.0, damping[1]]]
        return {
            **given,
            "torsional_stiffness": torsional * float(rng.uniform(10.0, 100.0)),
            "torsional_damping": float(rng.uniform(0.0, 0.01)) if damped else 0.0,
        }

    return {
        "gravity": [0.0, 0.0] if plain else [float(rng.uniform(-9.0, 9.0)), -9.81],
        "rotors": {
            "carrier": {"mass": 1.0, "inertia": 2e-3, "position": [0.0, 0.0], "initial": {"omega": 30.0}},
            "disc": {"mass": MASS, "inertia": INERTIA, "position": [0.05, 0.02]},
        },
        "supports": {"carrier": support(0.0), "disc": {**support(1.0), "on": "carrier"}},
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of all supports at t = 0."""
    total = 0.0
    for each in packed.system.records[KIND]:
        j, b = int(each.journal), int(each.carrier)
        e, turn, base = y[3 * j : 3 * j + 2].copy(), y[3 * j + 2], 0.0
        if b >= 0:
            base = y[3 * b + 2]
            c, s = math.cos(base), math.sin(base)
            offset = np.array([each.offset_x, each.offset_y])
            e += offset - y[3 * b : 3 * b + 2]
            e = np.array([c * e[0] + s * e[1], -s * e[0] + c * e[1]]) - offset
        total += 0.5 * (each.stiffness_x * e[0] ** 2 + each.stiffness_y * e[1] ** 2)
        total += 0.5 * (each.stiffness_xy + each.stiffness_yx) * e[0] * e[1]
        total += 0.25 * each.cubic_stiffness * float(e @ e) ** 2
        total += 0.5 * each.torsional_stiffness * (turn - base) ** 2
    return total


def disc(**support: Any) -> Document:
    """Return one disc on a support."""
    return {
        "rotors": {"disc": {"mass": MASS, "inertia": INERTIA}},
        "supports": {"disc": support},
        "run": {"duration": 0.02, "sampling": 1e5, "tolerance": 1e-12},
    }


def test_a_disc_swings_on_its_support_in_closed_form(measured: Measured) -> None:
    """Both directions, each as a damped oscillator of its own, theta too."""
    k, c, k_t = (2e5, 5e5), (20.0, 60.0), 30.0
    document = disc(stiffness=list(k), damping=list(c), torsional_stiffness=k_t)
    document["rotors"]["disc"]["initial"] = {"x": 1e-5, "y": -2e-5, "theta": 1e-3}
    run = simulate_one(document)

    def swing(start: float, stiffness: float, damping: float, mass: float) -> Floats:
        decay = damping / (2.0 * mass)
        w = math.sqrt(stiffness / mass - decay**2)
        found: Floats = (
            start * np.exp(-decay * run.time) * (np.cos(w * run.time) + decay / w * np.sin(w * run.time))
        )
        return found

    exact = {
        "x": swing(1e-5, k[0], c[0], MASS),
        "y": swing(-2e-5, k[1], c[1], MASS),
        "theta": swing(1e-3, k_t, 0.0, INERTIA),
    }
    worst = max(
        float(np.max(np.abs(run.signal(name, "disc") - value))) / float(np.max(np.abs(value)))
        for name, value in exact.items()
    )
    measured("support: swing against the closed form, relative", worst, "1e-9")
    assert worst < 1e-9
    assert np.allclose(
        run.signal("support_force_y", "disc"), -k[1] * exact["y"] - c[1] * run.signal("vy", "disc")
    )
    assert np.allclose(run.signal("support_torque", "disc"), -k_t * exact["theta"], atol=1e-9)


@pytest.mark.parametrize("flying", [True, False])
def test_a_full_matrix_acts_across(flying: bool, measured: Measured) -> None:
    """A cross-coupled bearing against the matrix exponential; what it loses is what the energy lacks."""
    k, c = [[2e5, 8e4], [-5e4, 3e5]], [[20.0, 6.0], [-3.0, 40.0]]
    document = disc(stiffness=k, damping=c)
    document["rotors"]["disc"]["initial"] = {"x": 1e-5, "y": -2e-5, "vx": 1e-3}
    if not flying:
        document["supports"]["disc"]["torsional_stiffness"] = 30.0
    run = simulate_one(document)
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array(k) / MASS, -np.array(c) / MASS]])
    start = np.array([1e-5, -2e-5, 1e-3, 0.0])
    exact = np.array([expm(system * t) @ start for t in run.time[::50]]).T
    found = np.array([run.signal(name, "disc")[::50] for name in ("x", "y", "vx", "vy")])
    worst = float(np.max(np.abs(found - exact)[:2])) / float(np.max(np.abs(exact[:2])))
    measured("support in full: motion against the matrix exponential, relative", worst, "1e-9")
    assert worst < 1e-9
    x, y, vx, vy = (run.signal(name, "disc") for name in ("x", "y", "vx", "vy"))
    energy = 0.5 * MASS * (vx**2 + vy**2) + 0.5 * (
        k[0][0] * x**2 + (k[0][1] + k[1][0]) * x * y + k[1][1] * y**2
    )
    lost = cumulative_simpson(run.signal("support_power_loss", "disc"), x=run.time)
    assert np.allclose(energy[0] - energy[1:], lost, atol=1e-6 * energy[0])


@pytest.mark.parametrize("stiffness", [2e5, 0.0])
def test_cubic__swing_and_period_are_those_of_the_duffing_oscillator(
    stiffness: float, measured: Measured
) -> None:
    """From rest at A along a slant: A cn(w t | m), w^2 = (k + k3 A^2) / M, of period 2 pi / (w agm(1, sqrt(1 - m)))."""
    amplitude, cubic, slant = 2e-4, 1e13, np.array([0.6, -0.8])
    document = disc(stiffness=[stiffness, stiffness], cubic_stiffness=cubic)
    document["run"]["duration"] = 0.05
    x, y = amplitude * slant
    document["rotors"]["disc"]["initial"] = {"x": x, "y": y}
    run = simulate_one(document)
    w = math.sqrt((stiffness + cubic * amplitude**2) / MASS)
    m = 0.5 * cubic * amplitude**2 / (stiffness + cubic * amplitude**2)
    exact = amplitude * slant[:, None] * ellipj(w * run.time, m)[1]
    found = np.array([run.signal(name, "disc") for name in "xy"])
    worst = float(np.max(np.abs(found - exact))) / amplitude
    measured(f"cubic support, k = {stiffness:g}: swing against cn, relative", worst, "1e-9")
    assert worst < 1e-9
    along = slant @ found
    down = np.flatnonzero((along[:-1] > 0.0) & (along[1:] <= 0.0))
    crossings = run.time[down] + 1e-5 * along[down] / (along[down] - along[down + 1])
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    expected = 2.0 * math.pi / (w * agm(1.0, math.sqrt(1.0 - m)))
    measured(
        f"cubic support, k = {stiffness:g}: period by agm, relative", abs(period / expected - 1.0), "1e-7"
    )
    assert len(crossings) > 5
    assert period == pytest.approx(expected, rel=1e-7)
    away = np.hypot(*found)
    assert np.allclose(run.signal("support_deflection", "disc"), away, rtol=1e-12, atol=0.0)
    assert np.allclose(
        run.signal("support_force_x", "disc"), -(stiffness + cubic * away**2) * found[0], rtol=1e-12
    )


def test_cubic__modes_stiffen_under_a_load() -> None:
    """At k e + k3 e^3 = M g: k + 3 k3 e^2 along the load, k + k3 e^2 across it; without a load those of k."""
    k, cubic = 2e4, 1e13
    document = disc(stiffness=[k, k], cubic_stiffness=cubic, torsional_stiffness=0.1)
    same = load_case(disc(stiffness=[k, k], cubic_stiffness=0.0))
    assert "cubic_stiffness" not in same.resolved()["supports"]["disc"]
    for load in (0.0, 100.0):
        document["gravity"] = [0.6 * load, -0.8 * load]
        e = brentq(lambda x: k * x + cubic * x**3 - MASS * load, 0.0, 1e-3, xtol=1e-18)  # noqa: B023
        exact = sorted([k + cubic * e**2, k + 3.0 * cubic * e**2])
        found = (2.0 * math.pi * gp.modes(document).ds["frequency"].values[-2:]) ** 2 * MASS
        assert np.allclose(found, exact, rtol=1e-9)


def test_a_matrix_along_the_axes_is_the_two_numbers() -> None:
    full = disc(stiffness=[[1e6, 0.0], [0.0, 3e6]], damping=[[5.0, 0.0], [0.0, 7.0]])
    for document in (full, disc(stiffness=[1e6, 3e6], damping=[5.0, 7.0])):
        document["rotors"]["disc"]["initial"] = {"x": 1e-5}
    records = [
        pack(case_of(document)).system.records[KIND]
        for document in (full, disc(stiffness=[1e6, 3e6], damping=[5.0, 7.0]))
    ]
    assert records[0] == records[1]
    assert load_case(full).supports["disc"].stiffness == ((1e6, 0.0), (0.0, 3e6))
    assert load_case(load_case(full).resolved()) == load_case(full)


@pytest.mark.parametrize(
    ("support", "text"),
    [
        ({"stiffness": [[1e6, 0.0], [0.0, -1e6]]}, r"supports.disc.stiffness.1.1.*0 or more on the diagonal"),
        ({"stiffness": [[1e6, 0.0], [0.0]]}, r"supports.disc.stiffness.1.*must have 2 items"),
        ({"stiffness": [[1e6, 0.0], 2e6]}, r"supports.disc.stiffness.1.*must be a list of 2 items"),
        (
            {"stiffness": [1e6, 1e6], "damping": 3.0},
            r"supports.disc.damping = 3.0: must be a list of 2 items",
        ),
        ({"stiffness": [-1e6, 1e6]}, r"supports.disc.stiffness.0.*0 N/m or more"),
        ({"cubic_stiffness": "-1 N/m^3"}, r"disc.cubic_stiffness = .-1 N/m\^3.: must be 0 N/m\^3 or more"),
        ({"cubic_stiffness": "1 N/m"}, r"disc.cubic_stiffness = .1 N/m.: is not a cubic stiffness"),
        ({"stiffness": [[1e6, "3 mm"], [0.0, 1e6]]}, r"supports.disc.stiffness.0.1"),
    ],
)
def test_a_bad_stiffness_is_refused(support: Document, text: str) -> None:
    with pytest.raises(InputError, match=text):
        load_case(disc(**support))


def test_a_carried_support_keeps_momentum_and_energy(measured: Measured) -> None:
    """A free carrier that spins and a disc on it: no force from outside, whatever the stiffness of the two axes."""
    document: Document = {
        "rotors": {
            "carrier": {
                "mass": 1.0,
                "inertia": 2e-3,
                "floating": True,
                "initial": {"omega": 40.0, "vx": 0.01},
            },
            "disc": {
                "mass": MASS,
                "inertia": INERTIA,
                "position": [0.05, 0.02],
                "initial": {"x": 2e-5, "omega": 0.0},
            },
        },
        "supports": {"disc": {"stiffness": [1e6, 3e5], "torsional_stiffness": 30.0, "on": "carrier"}},
        "run": {"duration": 0.02, "sampling": 2e4, "tolerance": 1e-12},
    }
    run = simulate_one(document)
    masses, inertias = np.array([1.0, MASS]), np.array([2e-3, INERTIA])
    at = {
        n: np.array([run.signal(n, r) for r in ("carrier", "disc")])
        for n in ("x", "y", "theta", "vx", "vy", "omega")
    }
    x, y = at["x"] + [[0.0], [0.05]], at["y"] + [[0.0], [0.02]]
    spin = masses @ (x * at["vy"] - y * at["vx"]) + inertias @ at["omega"]
    momentum = np.array([masses @ at["vx"], masses @ at["vy"]])
    c, s = np.cos(at["theta"][0]), np.sin(at["theta"][0])
    away = x[1] - x[0], y[1] - y[0]
    stretch = c * away[0] + s * away[1] - 0.05, -s * away[0] + c * away[1] - 0.02
    twist = at["theta"][1] - at["theta"][0]
    energy = 0.5 * masses @ (at["vx"] ** 2 + at["vy"] ** 2) + 0.5 * inertias @ at["omega"] ** 2
    energy += 0.5 * (1e6 * stretch[0] ** 2 + 3e5 * stretch[1] ** 2 + 30.0 * twist**2)
    worst = max(float(np.ptp(part)) / float(np.max(np.abs(part))) for part in (spin, momentum[0], energy))
    measured("support on a carrier: momentum and energy, relative", worst, "1e-9")
    assert worst < 1e-9
    assert np.ptp(stretch[0]) > 1e-5
    assert np.allclose(run.signal("support_deflection", "disc"), np.hypot(*stretch), rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("flying", [True, False])
def test_torsional_damper__loss_equals_the_power_of_the_rotor(*, flying: bool) -> None:
    """On the ground, in closed form and integrated: the lost power is c omega^2, the energy that is gone its integral."""
    document = disc(torsional_damping=0.02)
    document["rotors"]["disc"] |= {"inertia": 1e-3, "initial": {"omega": 30.0}}
    document["run"] = {"duration": 0.1, "sampling": 1e4, "tolerance": 1e-10}
    if not flying:
        document["rotors"]["disc"]["unbalance"] = {"amount": 1e-12}
    run = simulate_one(document)
    omega, lost = run.signal("omega", "disc"), run.signal("support_power_loss", "disc")
    assert np.allclose(lost, 0.02 * omega**2, rtol=1e-9)
    gone = 0.5 * 1e-3 * (omega[0] ** 2 - omega[-1] ** 2)
    assert float(simpson(lost, x=run.time)) == pytest.approx(gone, rel=1e-6)


@pytest.mark.parametrize("on", [None, "carrier"])
def test_a_torsional_stiffness_holds_the_nominal_speed(on: str | None) -> None:
    """0 on the ground, the carrier's on a carrier; the ring of a planetary set is held so."""
    document = disc(torsional_stiffness=30.0, **({"on": on} if on else {}))
    document["rotors"]["carrier"] = {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 7.0}}
    run = simulate_one(document)
    assert np.max(np.abs(run.signal("omega", "disc") - (7.0 if on else 0.0))) < 1e-9
    assert not np.any(run.signal("x", "disc")), "torsional keys alone free no centre"


def test_a_rotor_rides_on_one_carrier() -> None:
    document = disc(stiffness=[1e6, 1e6], on="carrier")
    document["rotors"]["carrier"] = {"mass": 1.0, "inertia": 1e-3}
    document["sleeves"] = {"disc": {"radial_clearance": 1e-5, "stiffness": "1e9 N/m^1.5"}}
    with pytest.raises(InputError, match=r'supports\.disc\.on = "carrier": must be the ground'):
        case_of(document)


def test_a_drive_against_a_torsional_stiffness_is_refused() -> None:
    document = disc(torsional_stiffness=30.0)
    document["rotors"]["disc"]["drive"] = {"kind": "speed", "speed": 7.0}
    with pytest.raises(InputError, match="torsional_stiffness holds it fast"):
        gp.simulate(case_of(document))
