"""Ripple of a prescribed speed: the closed form, what follows it, the work it does, and the touches it causes."""

import math

import numpy as np
import pytest

from building import (
    Document,
    Floats,
    Instant,
    Measured,
    case_of,
    merged,
    pair_document,
    simulate_one,
    states_along,
)
from gearplay.integrate.run import ONSETS
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from laws.test_free_motion import random_flyer, rippling

SPEED = 4.0 * math.pi  # rad/s, 120 rpm
RIPPLE = [
    {"order": 1, "amplitude": 0.05, "phase": 0.3},
    {"order": 7, "amplitude": 0.02, "phase": -2.0},
    {"order": 64, "amplitude": 0.01, "phase": 1.5},
]


def closed_form(times: Floats, speed: float = SPEED) -> tuple[Floats, Floats, Floats]:
    """Return angle [rad], speed [rad/s] and acceleration [rad/s^2] of the driven shaft, written apart from the kernels."""
    theta, omega, alpha = speed * times, np.full_like(times, speed), np.zeros_like(times)
    for term in RIPPLE:
        k, a, phase = term["order"], term["amplitude"], term["phase"]
        psi = k * speed * times + phase
        theta += a / k * (math.cos(phase) - np.cos(psi))
        omega += speed * a * np.sin(psi)
        alpha += speed * a * k * speed * np.cos(psi)
    return theta, omega, alpha


def rippling_pair(kind: str = "internal", speed: float = SPEED, **changes: Document) -> Document:
    """Return a pair whose pinion's speed ripples."""
    drive = {"kind": "speed", "speed": speed, "ripple": RIPPLE}
    return merged(pair_document(kind, rotors={"pinion": {"drive": drive}}), changes)


@pytest.mark.parametrize("held", [False, True], ids=["in a sleeve", "held"])
@pytest.mark.parametrize("speed", [SPEED, -30.0])
@pytest.mark.parametrize(
    "signals", [None, ["pinion.theta", "pinion.omega"]], ids=["all signals", "no forces"]
)
def test_driven_shaft__follows_the_closed_form(
    held: bool, speed: float, signals: list[str] | None, measured: Measured
) -> None:
    """Through impacts, sustained contact and flight, whatever the tolerance: angle and speed are exact at every sample."""
    document = rippling_pair(speed=speed)
    document["rotors"]["ring"]["load"] = {"torque": 0.05}
    document["rotors"]["ring"]["initial"] = {"vx": 0.03, "vy": 0.02}
    if held:
        del document["sleeves"]["pinion"]
    document["run"] = {"duration": 0.3, "transient": 0.2, "sampling": 1e4, "tolerance": 1e-5}
    run = simulate_one(document, signals=signals)
    assert run.counters.events > 100
    theta, omega, _ = closed_form(run.time, speed)
    worst = max(
        float(np.max(np.abs(run.signal("omega", "pinion") / omega - 1.0))),
        float(np.max(np.abs(run.signal("theta", "pinion") / theta - 1.0))),
    )
    measured("relative difference of a rippling shaft from its closed form", worst, "1e-12")
    assert worst < 1e-12


def test_untouched_shaft__follows_the_closed_form() -> None:
    """Blocks of samples in flight are filled by a loop of their own."""
    disc = {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": SPEED, "ripple": RIPPLE}}
    run = simulate_one({"rotors": {"disc": disc}, "run": {"duration": 1.0, "sampling": 1e4}})
    theta, omega, _ = closed_form(run.time)
    np.testing.assert_allclose(run.signal("theta", "disc"), theta, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(run.signal("omega", "disc"), omega, rtol=1e-12)
    assert run.counters.steps <= 2, "a ripple alone is flown in one stride"


def test_the_centre_of_a_rippling_disc_falls_like_any_other() -> None:
    """A ripple turns the disc and leaves the parabola of its centre alone."""
    drive = {"kind": "speed", "speed": SPEED, "ripple": RIPPLE}
    start = {"vx": 0.1, "vy": 0.2}
    disc = {"mass": 1.0, "inertia": 1e-3, "drive": drive, "floating": True, "initial": start}
    run = {"duration": 0.05, "sampling": 1e4}
    fall = simulate_one({"rotors": {"disc": disc}, "gravity": [0.0, -9.81], "run": run})
    assert np.max(np.abs(fall.signal("x", "disc") - 0.1 * fall.time)) < 1e-12
    assert np.max(np.abs(fall.signal("y", "disc") - (0.2 - 0.5 * 9.81 * fall.time) * fall.time)) < 1e-12


@pytest.mark.parametrize("kind", ["internal", "external"])
def test_a_heavily_loaded_gear_follows_kinematically(kind: str) -> None:
    """On rigid shafts the wheel has the pinion's speed over the ratio, and the flank carries T + J alpha / ratio."""
    wheel, ratio = ("ring", 3.0) if kind == "internal" else ("wheel", -3.0)
    document = rippling_pair(kind)
    document["sleeves"] = {}
    document["meshes"][0]["damping"] = {"ratio": 0.2, "depth": 1e-9}
    document["rotors"][wheel]["load"] = {"torque": 5.0}
    document["run"] = {"duration": 0.5, "transient": 0.05, "sampling": 1e4, "tolerance": 1e-10}
    run = simulate_one(document)
    _, omega, alpha = closed_form(run.time)
    # the highest order is at 0.06 of the mesh's natural frequency: 0.4 % of its own amplitude
    error = ratio * run.signal("omega", wheel) - omega
    assert np.max(np.abs(error)) < 0.005 * 0.01 * SPEED
    base = 0.12 * math.cos(math.radians(20.0))
    expected = (5.0 + 9.0e-3 * alpha / abs(ratio)) / base
    force = run.signal("drive_force", f"pinion-{wheel}")
    assert np.ptp(expected) > 0.05 * np.mean(expected), "the ripple is felt"
    assert np.max(np.abs(force - expected)) < 0.005 * np.ptp(expected)


def test_the_drives_work_closes_the_balance(measured: Measured) -> None:
    """Kinetic and elastic energy change by the work of the drive, (J alpha + r_b (F_d - F_b)) omega, less the load's."""
    document = rippling_pair(
        rotors={
            "ring": {"load": {"torque": 1.0}, "initial": {"vx": 0.03}},
            "pinion": {"initial": {"vy": 0.02}},
        },
        run={"duration": 0.02, "sampling": 5e6, "tolerance": 1e-12},
    )
    run = simulate_one(document, signals=["drive_force", "back_force", "omega"])
    force = run.signal("drive_force", "pinion-ring") - run.signal("back_force", "pinion-ring")
    _, omega, alpha = closed_form(run.time)
    torque = 1.88e-4 * alpha + 0.04 * math.cos(math.radians(20.0)) * force
    power = torque * omega - 1.0 * run.signal("omega", "ring")
    work = float(np.trapezoid(power, run.time))
    packed, states, motion = states_along(document, run.time[-1:])
    instant = Instant(packed)
    start = initial_state(case_of(document), packed)
    change = instant.energy(run.time[-1], states[0]) - instant.energy(0.0, start)
    assert np.all(motion.tallies[[0, 1, 2], ONSETS] >= 3), "sleeves and drive flank were hit"
    assert abs(work) > 1e-3 * instant.energy(0.0, start)
    measured(
        "work of a rippling drive against change of energy, relative difference",
        abs(change / work - 1.0),
        "1e-5",
    )
    assert change == pytest.approx(work, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_no_sample_overlaps_an_open_contact(seed: int) -> None:
    """A sample every microsecond, while rotors fly and while others are integrated: what is open has a gap."""
    generator = np.random.default_rng([22, seed])
    document = rippling(random_flyer(generator), generator)
    document["formulation"] = "geometric"
    document["run"] |= {"duration": 0.1, "sampling": 1e6, "tolerance": 1e-9}
    run = simulate_one(document, member=1)
    wheel = next(name for name in document["rotors"] if name != "pinion")
    state = run.signal("contact_state", f"pinion-{wheel}").astype(int)
    for bit, signal in ((1, "drive_penetration"), (2, "back_penetration")):
        gap = run.signal(signal, f"pinion-{wheel}")[state & bit == 0]
        assert gap.size == 0 or np.max(gap) < 1e-12
    for name in document["sleeves"]:
        force = np.hypot(run.signal("sleeve_force_x", name), run.signal("sleeve_force_y", name))
        assert np.max(run.signal("sleeve_penetration", name)[force == 0.0]) < 1e-12
    assert run.counters.events > 10


def test_a_gap_that_only_the_ripple_closes_is_found() -> None:
    """A wheel at rest relative to the train, in mid-gap, with no force: the pinion's swing reaches it and no earlier."""
    backlash, base = 20e-6, 0.04 * math.cos(math.radians(20.0))
    amplitude = 1.6 * 0.5 * backlash / base  # of the swing on the base circle: 0 to 1.6 half gaps
    document = pair_document()
    document["sleeves"] = {}
    document["meshes"][0]["backlash"] = backlash
    document["rotors"]["pinion"]["drive"] = {
        "kind": "speed",
        "speed": SPEED,
        "ripple": [{"order": 5, "amplitude": 5 * 0.5 * amplitude, "phase": 0.0}],
    }
    document["rotors"]["ring"]["initial"] = {"theta": -0.5 * backlash / (3.0 * base) * -1.0}
    document["run"] = {"duration": 0.2, "sampling": 1e4, "tolerance": 1e-9}
    run = simulate_one(document)
    # swing amplitude/2 (1 - cos(5 omega t)) on the base circle is half a gap at the first touch
    first = math.acos(1.0 - backlash / base / amplitude) / (5.0 * SPEED)
    assert run.log[0, 0] == pytest.approx(first, rel=1e-9)
    assert run.log[0, 1] == 0.0, "no sleeves: contact 0 is the drive flank"


def test_it_starts_with_the_ripple_and_everyone_else_at_nominal_speed() -> None:
    packed = pack(case_of(rippling_pair()))
    y = initial_state(case_of(rippling_pair()), packed)
    _, omega, _ = closed_form(np.zeros(1))
    assert y[2] == 0.0
    assert packed.system.rotors[0].nominal_speed + y[8] == pytest.approx(omega[0], rel=1e-15)
    assert y[11] == 0.0
