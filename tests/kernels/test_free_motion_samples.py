"""Samples in flight: each depends on its time alone, and signals follow from the states as their formulas say."""

import numpy as np
import pytest

import gearplay as gp

DRAG, DRY, DAMPING, LOAD = 2e-4, 1e-4, 0.05, 3e-4
"""Of the ring: drag [N m s/rad], dry friction [N m], radial damping [N s/m], load torque [N m]."""


@pytest.fixture(scope="module")
def flown() -> gp.Result:
    """Return a run that is in flight nine tenths of its time, teeth with errors, toothings out of round."""
    changes = {
        "rotors.ring.load.drag": DRAG,
        "rotors.ring.load.friction": DRY,
        "rotors.ring.load.friction_speed": 0.01,
        "rotors.ring.load.torque": LOAD,
        "rotors.ring.radial_damping": DAMPING,
        "run.duration": 0.2,
        "run.transient": 0.1,
        "run.sampling": 10_000.0,
    }
    return gp.simulate(gp.replace(gp.load_case("han2021"), changes))


def signal(result: gp.Result, name: str) -> np.ndarray:
    return np.asarray(result.signal(name))


def flights(result: gp.Result) -> np.ndarray:
    """Return which samples are of flights."""
    touches = signal(result, "ring.sleeve_penetration") >= 0.0
    for flank in ("drive", "back"):
        touches |= signal(result, f"pinion-ring.{flank}_penetration") >= 0.0
    assert 0.0 < np.mean(touches) < 0.3
    return ~touches


def test_a_sample_depends_on_its_time_alone(flown: gp.Result) -> None:
    """Not on where a block of samples begins, nor on what was looked at before: at another rate it is the same, bit for bit."""
    run = flown.runs[0]
    finer = gp.simulate(flown.case, sampling=4.0 * flown.case.run.sampling).runs[0]
    assert np.array_equal(finer.values[::4], run.values)
    for column in run.columns:
        alone = flown.signal(f"{column.label}.{column.signal}", sampling=2.0 * flown.case.run.sampling)
        assert np.array_equal(alone[::2], run.signal(column.signal, column.label)), column


def test_geometry_in_flight_is_that_of_the_centres(flown: gp.Result) -> None:
    case = flown.case
    mesh, sleeve = case.meshes[0], case.sleeves["ring"]
    x, y = signal(flown, "ring.x"), signal(flown, "ring.y")
    assert signal(flown, "ring.sleeve_penetration") == pytest.approx(
        np.hypot(x, y) - sleeve.radial_clearance, abs=1e-18
    )
    distance = signal(flown, "pinion-ring.center_distance")
    nominal = 0.5 * mesh.module * (60 - 20)
    assert float(np.max(np.abs(distance - nominal))) < 1e-4
    angle = np.arccos(nominal * np.cos(mesh.pressure_angle) / distance)
    assert signal(flown, "pinion-ring.working_pressure_angle") == pytest.approx(angle, abs=1e-14)


def test_powers_in_flight_are_those_of_the_speeds(flown: gp.Result) -> None:
    free = flights(flown)
    spin, v_x, v_y = (signal(flown, f"ring.{name}")[free] for name in ("omega", "vx", "vy"))
    lost = DRAG * spin**2 + DRY * np.abs(spin) + DAMPING * (v_x**2 + v_y**2)
    assert signal(flown, "ring.rotor_power_loss")[free] == pytest.approx(lost, rel=1e-13)
    assert np.all(np.abs(signal(flown, "ring.load_torque")) == LOAD)
    assert np.all(signal(flown, "pinion.drive_torque")[free] == 0.0)  # nothing is driven in flight
    for axis in ("x", "y"):
        speed, acceleration = signal(flown, f"ring.v{axis}")[free], signal(flown, f"ring.a{axis}")[free]
        assert acceleration == pytest.approx(-DAMPING / flown.case.rotors["ring"].mass * speed, rel=1e-12)


def test_the_torque_of_a_drive_that_ripples_turns_its_rotor() -> None:
    """Inertia times the acceleration that the drive prescribes, where nothing else acts."""
    amplitude, order = 1e-3, 3.0
    changes = {
        "rotors.pinion.drive.ripple": [{"order": 3, "amplitude": amplitude, "phase": 0.0}],
        "run.duration": 0.05,
        "run.transient": 0.0,
        "run.sampling": 5000.0,
    }
    result = gp.simulate(gp.replace(gp.load_case("han2021"), changes))
    pinion = result.case.rotors["pinion"]
    assert pinion.drive is not None
    most = pinion.inertia * amplitude * order * float(pinion.drive.speed) ** 2
    torque = signal(result, "pinion.drive_torque")[flights(result)]
    assert most * 0.99 < float(np.max(np.abs(torque))) < most * 1.01
