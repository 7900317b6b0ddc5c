"""Energy, work and momentum: what the equations must keep, and what the printed ones do not."""

import numpy as np
import pytest

from building import (
    Document,
    Floats,
    Instant,
    Measured,
    case_of,
    free_pair_case,
    merged,
    simulate_one,
    states_along,
)
from gearplay.integrate.run import ONSETS
from gearplay.model.initial import initial_state

TIMES = np.linspace(0.005, 0.1, 20)


def energy_along(document: Document, times: Floats, member: int = 0) -> tuple[Floats, Floats]:
    """Return the energy [J] at the start and at each time, and the onsets of each contact."""
    case = case_of(document)
    packed, states, motion = states_along(document, times, member)
    instant = Instant(packed)
    start = instant.energy(0.0, initial_state(case, packed, member=member))
    return np.array(
        [start, *(instant.energy(t, y) for t, y in zip(times, states, strict=True))]
    ), motion.tallies[:, ONSETS]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["internal", "external"])
@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_undamped_free_motion_conserves_energy(kind: str, model: str, seed: int, measured: Measured) -> None:
    """Kinetic plus elastic energy is constant to 1e-8 through 100 ms of impacts on flanks and sleeves."""
    document = merged(free_pair_case(kind, model, seed), {"run": {"tolerance": 1e-12}})
    energy, onsets = energy_along(document, TIMES)
    assert np.all(onsets >= 5), "every sleeve and both flanks were hit several times"
    residual = float(np.max(np.abs(energy / energy[0] - 1.0)))
    measured("energy residual over 0.1 s at tolerance 1e-12", residual, "1e-8")
    assert residual < 1e-8


def test_ensemble_members_conserve_energy() -> None:
    """Drawn initial states conserve it as well, with the spin of a running pair on top of the rattle."""
    document = merged(
        free_pair_case("internal", "coupled", 3),
        {
            "rotors": {"pinion": {"initial": {"omega": 2.0}}, "ring": {"initial": {"omega": 0.4}}},
            "run": {"tolerance": 1e-12},
        },
    )
    for member in (1, 2):
        energy, onsets = energy_along(document, TIMES, member)
        assert np.sum(onsets) > 20
        assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-8


def test_energy_error_falls_with_the_tolerance() -> None:
    """The residual is the integrator's, not the model's: it falls at least fiftyfold over four decades."""
    drift = []
    for tolerance in (1e-8, 1e-12):
        document = merged(free_pair_case("internal", "coupled", 2), {"run": {"tolerance": tolerance}})
        energy, _ = energy_along(document, TIMES[:4])
        drift.append(np.max(np.abs(energy / energy[0] - 1.0)))
    assert drift[1] < drift[0] / 50.0


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_printed_coupled_equations_do_not_conserve_energy(kind: str) -> None:
    """As published, backlash moves with the centres but the force ignores it: the energy is off by > 50 %."""
    document = merged(free_pair_case(kind, "coupled", 1), {"run": {"tolerance": 1e-12}})
    document["meshes"][0]["backlash"] = 2e-4  # wide enough that the printed force never jumps
    energy, onsets = energy_along({**document, "formulation": "as_published"}, TIMES[:6])
    assert np.all(onsets >= 5)
    assert np.max(np.abs(energy / energy[0] - 1.0)) > 0.5


@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_parametric_work_closes_the_balance(model: str, measured: Measured) -> None:
    """With K(psi), dE/dt = 1/2 K'(psi) psi_dot (p_d^2 + p_b^2): the work is the change of energy."""
    amplitude, mean, order = 4e7, 1.3e8, 10
    document = free_pair_case("internal", model, 1)
    document["meshes"][0]["stiffness"] = {
        "kind": "fourier",
        "mean": mean,
        "terms": [{"order": order, "amplitude": amplitude, "phase": 0.4}],
    }
    document["rotors"]["pinion"]["initial"]["omega"] += 6.0
    document["rotors"]["ring"]["initial"]["omega"] += 2.0
    document["run"] = {"duration": 0.02, "sampling": 5e6, "tolerance": 1e-12}
    signals = ["drive_penetration", "back_penetration", "pinion.theta", "pinion.omega"]
    run = simulate_one(document, signals=signals)
    p = np.maximum(run.signal("drive_penetration", "pinion-ring"), 0.0)
    q = np.maximum(run.signal("back_penetration", "pinion-ring"), 0.0)
    slope = -order * amplitude * np.sin(20.0 * order * run.signal("theta", "pinion") + 0.4)
    power = 0.5 * slope * 20.0 * run.signal("omega", "pinion") * (p**2 + q**2)
    last = run.time[-1]
    work = float(np.trapezoid(power, run.time))
    energy, onsets = energy_along(document, np.array([last]))
    assert np.all(onsets >= 3)
    assert abs(work) > 5e-4 * energy[0]
    change = float(energy[1] - energy[0])
    measured(
        "parametric work against change of energy, relative difference", abs(change / work - 1.0), "2e-6"
    )
    assert change == pytest.approx(work, rel=2e-6)


def test_transmission_error_works_like_a_moving_tooth() -> None:
    """With e(psi), dE/dt = (F_d - F_b) de/dt: the error moves the tooth, it is no force on the shaft."""
    document = free_pair_case("external", "coupled", 1)
    document["meshes"][0]["transmission_error"] = [{"order": 10, "amplitude": 1e-6, "phase": 0.3}]
    document["rotors"]["pinion"]["initial"]["omega"] += 6.0
    document["rotors"]["wheel"]["initial"]["omega"] -= 2.0
    document["run"] = {"duration": 0.02, "sampling": 5e6, "tolerance": 1e-12}
    run = simulate_one(document, signals=["drive_force", "back_force", "pinion.theta", "pinion.omega"])
    rate = 1e-5 * np.cos(200.0 * run.signal("theta", "pinion") + 0.3) * 20.0 * run.signal("omega", "pinion")
    power = rate * (run.signal("drive_force", "pinion-wheel") - run.signal("back_force", "pinion-wheel"))
    energy, onsets = energy_along(document, run.time[-1:])
    assert np.all(onsets >= 3)
    work = float(np.trapezoid(power, run.time))
    assert abs(work) > 5e-4 * energy[0]
    assert energy[1] - energy[0] == pytest.approx(work, rel=1e-5)


def test_losses_of_damping_never_add_energy() -> None:
    """With restitution below 1 and mesh damping the energy falls at every look, to under half in 100 ms."""
    document = merged(free_pair_case("internal", "coupled", 1), {"run": {"tolerance": 1e-11}})
    document["meshes"][0]["damping"] = {"ratio": 0.05, "depth": 1e-6}
    for sleeve in document["sleeves"].values():
        sleeve["restitution"] = 0.8
    energy, _ = energy_along(document, np.linspace(1e-4, 0.1, 1000))
    assert np.all(np.diff(energy) < 1e-10 * energy[0])
    assert energy[-1] < 0.5 * energy[0]


# -- momentum ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["internal", "external"])
@pytest.mark.parametrize("runout", [0.0, 2e-5])
def test_free_pair_keeps_linear_and_angular_momentum(kind: str, runout: float) -> None:
    """Two floating gears, damped mesh and all: sum m v and sum (r x m v + J omega) are constant to 1e-12."""
    onsets = 0.0
    for seed in range(4):
        document = free_pair_case(kind, "coupled", seed)
        document["sleeves"], document["run"]["tolerance"] = {}, 1e-11
        document["meshes"][0]["damping"] = {"ratio": 0.1, "depth": 1e-6}
        document["rotors"]["pinion"]["initial"]["omega"] += 3.0
        for name, rotor in document["rotors"].items():
            rotor["floating"] = True
            rotor["runout"] = {"amplitude": runout, "phase": 1.0 if name == "pinion" else 2.0}
        packed, states, motion = states_along(document, np.linspace(1e-3, 0.01, 10))
        onsets += np.sum(motion.tallies[:, ONSETS])
        first = initial_state(case_of(document), packed)
        P, L = zip(*(momenta(document, packed.system.rotors, y) for y in [first, *states]), strict=True)
        size = float(np.sum(packed.system.rotors.mass * np.hypot(first[6:12:3], first[7:12:3])))
        np.testing.assert_allclose(P, [P[0]] * len(P), rtol=0.0, atol=1e-12 * size)
        np.testing.assert_allclose(L, L[0], rtol=1e-12)
    assert onsets >= 5


def momenta(document: Document, rotors: Floats, y: Floats) -> tuple[Floats, float]:
    """Return linear [N s] and angular momentum [N m s] about the origin of a pair at rest nominally."""
    places = {"pinion": 0.08 if document["rotors"].get("ring") else 0.0, "ring": 0.0, "wheel": 0.16}
    linear, angular = np.zeros(2), 0.0
    for i, name in enumerate(document["rotors"]):
        (x, y_, _), (v_x, v_y, omega) = y[3 * i : 3 * i + 3], y[6 + 3 * i : 9 + 3 * i]
        assert rotors.nominal_speed[i] == 0.0
        p = rotors.mass[i] * np.array([v_x, v_y])
        linear += p
        angular += (places[name] + x) * p[1] - y_ * p[0] + rotors.inertia[i] * omega
    return linear, angular
