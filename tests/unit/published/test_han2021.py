"""The study's own formulas: the swing of the driven gear, the conditions' cases."""

import dataclasses
import math

import numpy as np
import pytest

from gearplay.model.reading import load_case, replace
from gearplay.published.article import Condition, conditions, printed
from gearplay.published.claims.summary import shipped_claims
from gearplay.published.comparison import lasting_shares, swing_lasts
from gearplay.published.findings import findings
from gearplay.published.han2021 import (
    LATER,
    ConditionResult,
    SimulatedLine,
    find_lines,
    run_condition,
    run_study,
    swing_frequency,
)
from gearplay.published.patterns import OPEN, REPRODUCED
from gearplay.published.settings import Settings, base_case, condition_case
from gearplay.published.summary import story
from gearplay.results.spectra import amplitude_spectrum


def test_swing_frequency_is_that_of_a_pendulum_under_the_drags_mesh_force() -> None:
    case = replace(load_case("han2021"), {"rotors.ring.load.drag": 3e-4})
    force = 3e-4 * (120.0 / 3.0 * math.pi / 30.0) / (0.12 * math.cos(math.radians(20.0)))
    assert swing_frequency(case) == pytest.approx(
        math.sqrt(force / (0.8 * 100e-6)) / (2.0 * math.pi), rel=1e-12
    )


def test_swing_frequency_goes_with_the_root_of_speed_over_clearance() -> None:
    base = load_case("han2021")
    scaled = {
        c.label: swing_frequency(condition_case(base, c, "coupled"))
        / math.sqrt(c.speed_rpm / c.radial_clearance_um)
        for c in conditions()
    }
    assert max(scaled.values()) == pytest.approx(min(scaled.values()), rel=1e-12)


def test_a_conditions_case_has_its_speed_clearance_backlash_and_model() -> None:
    for condition in conditions():
        case = condition_case(load_case("han2021"), condition, "uncoupled")
        drive = case.rotors["pinion"].drive
        assert drive is not None
        assert drive.kind == "speed"
        assert drive.speed == pytest.approx(condition.speed_rpm * math.pi / 30.0)
        assert case.sleeves["ring"].radial_clearance == pytest.approx(1e-6 * condition.radial_clearance_um)
        assert case.meshes[0].backlash == pytest.approx(1e-6 * condition.backlash_um)
        assert case.backlash_model == "uncoupled"


def test_the_level_of_a_line_is_its_amplitude_and_its_error_that_of_the_members_mean_square() -> None:
    rng = np.random.default_rng(5)
    drawn = [rng.lognormal(0.0, 0.8, 24) for _ in range(4000)]
    lines = [SimulatedLine(40.0, math.sqrt(float(np.mean(each**2))), 2.0, tuple(each)) for each in drawn]
    levels = np.array([line.log_level() for line in lines])
    np.testing.assert_allclose(10.0 ** levels[:, 0], [line.amplitude for line in lines])
    assert np.median(levels[:, 1]) == pytest.approx(float(np.std(levels[:, 0])), rel=0.35)
    assert SimulatedLine(40.0, 0.1, 2.0, (0.1,)).log_level() == (-1.0, math.inf)


def test_a_tilted_rig_presses_its_ring_too() -> None:
    """Without drag the ring hangs like a pendulum as long as the clearance; with it, forces add as vectors."""
    hanging = {"rotors.ring.load.drag": 0.0, "gravity": [0.3, -0.4]}
    case = replace(load_case("han2021"), hanging)
    assert swing_frequency(case) == pytest.approx(math.sqrt(0.5 / 100e-6) / (2.0 * math.pi), rel=1e-12)
    force = 3e-4 * (120.0 / 3.0 * math.pi / 30.0) / (0.12 * math.cos(math.radians(20.0)))
    along, across = (force * f(math.radians(20.0)) / 0.8 for f in (math.sin, math.cos))
    balanced = {"rotors.ring.load.drag": 3e-4, "gravity": [-along, -across]}
    assert swing_frequency(replace(load_case("han2021"), balanced)) == pytest.approx(0.0, abs=1e-6)


DAMPING, DENSITY, MASS = 0.4, 3e-8, 0.8  # N s/m, m^2/s^4/Hz, kg


def pressed(members: int, **changes: object) -> ConditionResult:
    """Run a coupled pair at 60 rpm whose flank and shaft stay in touch: the drag presses them, and nothing shakes them."""
    settings = Settings(parameters="assumed", members=members, transient=20.0, history=0.01)
    pair = {
        "rotors.ring.load.drag": 1e-3,
        "rotors.ring.radial_damping": DAMPING,
        "meshes.0.transmission_error": [],
        "rotors.ring.runout.amplitude": 0.0,
        "rotors.pinion.runout.amplitude": 0.0,
    }
    base = replace(base_case(settings.variants[0], settings), pair | changes)
    return run_condition(base, Condition(60.0, 100.0, 100.0), settings.variants[0], settings)


@pytest.mark.slow
def test_a_swing_that_nothing_keeps_up_dies_by_its_damping() -> None:
    """Amplitude falls as exp(-c t / 2 m), its frequency that of the pressed pendulum, tilt included."""
    found = pressed(6)
    assert found.lasting == pytest.approx(math.exp(-DAMPING * LATER / (2.0 * MASS)), rel=0.1)
    assert found.lines["radial"].frequency == pytest.approx(found.swing_frequency, rel=0.1)
    assert found.floor == 0.0


@pytest.mark.slow
def test_a_floor_that_shakes_keeps_the_swing_up() -> None:
    """The swing, across the line of action, is an oscillator in noise: its acceleration has the mean square S w^2 m / 4 c."""
    floor = {
        "kind": "spectral-density",
        "density": [[0.5, DENSITY], [8.0, DENSITY]],
        "direction": "-20 deg",
        "per_member": True,
    }
    found = pressed(24, base={"acceleration": floor})
    omega = 2.0 * math.pi * found.swing_frequency
    square = math.cos(math.radians(20.0)) ** 2 * DENSITY * omega**2 * MASS / (4.0 * DAMPING)
    near = np.abs(np.array(found.frequency) - found.swing_frequency) < 1.0
    # Amplitudes are those of sines, so their squares count twice; Hann's window counts each bin 1.5 times.
    seen = np.sum(np.array(found.amplitude)[near] ** 2) / (2.0 * 1.5)
    assert math.sqrt(seen) == pytest.approx(math.sqrt(square), rel=0.25)
    assert found.lasting == pytest.approx(1.0, abs=0.6)
    assert found.floor == pytest.approx(math.sqrt(7.5 * DENSITY), rel=1e-9)


def test_a_sideband_is_not_taken_for_a_line() -> None:
    """What stands a swing's frequency beside 2 f_m is higher than 2 f_m, and none of it."""
    t = np.arange(4000) / 1000.0
    tones = {20.0: 0.0, 60.0: 1.0, 57.2: 3.0, 120.0: 1.0, 122.8: 3.0, 117.2: 3.0, 2.8: 5.0}
    samples = np.zeros(4000) + sum(a * np.sin(2.0 * math.pi * f * t) for f, a in tones.items())
    found = find_lines(amplitude_spectrum(samples, 1000.0), Condition(180.0, 100.0, 100.0))
    assert found["mesh_1x"].frequency == pytest.approx(60.0, abs=0.1)
    assert found["mesh_2x"].frequency == pytest.approx(120.0, abs=0.1)
    assert found["mesh_2x"].amplitude == pytest.approx(1.0, rel=0.1)


@pytest.mark.slow
def test_amplitudes_count_as_met_only_where_the_swing_lasts() -> None:
    settings = Settings(members=2, duration=2.0, transient=1.0, history=0.01)
    results = run_study(settings)
    claim = "The coupled model meets the measured amplitudes."
    seen = {}
    for share in (0.1, 1.0):
        made = [
            dataclasses.replace(
                r,
                lasting=share,
                lines={
                    line: dataclasses.replace(
                        found, amplitude=printed(r.condition, line, "amplitude_as_printed").test
                    )
                    for line, found in r.lines.items()
                },
            )
            for r in results
        ]
        assert lasting_shares(made, "coupled") == [share] * 6
        assert swing_lasts(made, "coupled") == (share == 1.0)
        finding = next(f for f in findings(made, shipped_claims(), calibrated=True) if f.claim == claim)
        seen[share] = finding.verdict
        assert ("does not last" in finding.evidence) == (share == 0.1)
        said = f"{LATER:g} s later it has {100 * share:.0f} to {100 * share:.0f} % of its amplitude"
        assert said in finding.evidence
        believe = story(made, settings, shipped_claims())[-1][1]
        assert ("does not keep up" in believe) == (share == 0.1)
    assert seen == {0.1: OPEN, 1.0: REPRODUCED}
