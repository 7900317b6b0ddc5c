"""Simulated conditions: cases, swing of the driven gear, lines of spectra, verdicts that depend on them."""

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.studies.han2021.article import AMPLITUDE, Condition, conditions, printed, stored
from gearplay.studies.han2021.comparison import OPEN, REPRODUCED, by_model
from gearplay.studies.han2021.findings import findings
from gearplay.studies.han2021.report import story
from gearplay.studies.han2021.simulation import (
    LATER,
    SWITCHED,
    ConditionResult,
    Settings,
    SimulatedLine,
    Work,
    base_case,
    condition_case,
    find_lines,
    run_condition,
    run_study,
    swing_frequency,
)


def test_swing_frequency__pendulum_under_the_mesh_force_of_the_drag() -> None:
    case = gp.replace(gp.load_case("han2021"), {"rotors.ring.load.drag": 3e-4})
    force = 3e-4 * (120.0 / 3.0 * math.pi / 30.0) / (0.12 * math.cos(math.radians(20.0)))
    assert swing_frequency(case) == pytest.approx(
        math.sqrt(force / (0.8 * 100e-6)) / (2.0 * math.pi), rel=1e-12
    )


def test_swing_frequency__root_of_speed_over_clearance() -> None:
    base = gp.load_case("han2021")
    scaled = {
        c.label: swing_frequency(condition_case(base, c, "coupled"))
        / math.sqrt(c.speed_rpm / c.radial_clearance_um)
        for c in conditions()
    }
    assert max(scaled.values()) == pytest.approx(min(scaled.values()), rel=1e-12)


def test_condition_case__speed_clearance_backlash_model() -> None:
    for condition in conditions():
        case = condition_case(gp.load_case("han2021"), condition, "uncoupled")
        drive = case.rotors["pinion"].drive
        assert drive is not None
        assert drive.kind == "speed"
        assert drive.speed == pytest.approx(condition.speed_rpm * math.pi / 30.0)
        assert case.sleeves["ring"].radial_clearance == pytest.approx(1e-6 * condition.radial_clearance_um)
        assert case.meshes[0].backlash == pytest.approx(1e-6 * condition.backlash_um)
        assert case.backlash_model == "uncoupled"


def test_log_level__amplitude_and_error_of_the_mean_square() -> None:
    rng = np.random.default_rng(5)
    drawn = [rng.lognormal(0.0, 0.8, 24) for _ in range(4000)]
    lines = [SimulatedLine(40.0, math.sqrt(float(np.mean(each**2))), 2.0, tuple(each)) for each in drawn]
    levels = np.array([line.log_level() for line in lines])
    np.testing.assert_allclose(10.0 ** levels[:, 0], [line.amplitude for line in lines])
    assert np.median(levels[:, 1]) == pytest.approx(float(np.std(levels[:, 0])), rel=0.35)
    assert SimulatedLine(40.0, 0.1, 2.0, (0.1,)).log_level() == (-1.0, math.inf)


def test_swing_frequency__tilted_rig() -> None:
    """Without drag the ring hangs like a pendulum as long as the clearance; with it, forces add as vectors."""
    hanging = {"rotors.ring.load.drag": 0.0, "gravity": [0.3, -0.4]}
    case = gp.replace(gp.load_case("han2021"), hanging)
    assert swing_frequency(case) == pytest.approx(math.sqrt(0.5 / 100e-6) / (2.0 * math.pi), rel=1e-12)
    force = 3e-4 * (120.0 / 3.0 * math.pi / 30.0) / (0.12 * math.cos(math.radians(20.0)))
    along, across = (force * f(math.radians(20.0)) / 0.8 for f in (math.sin, math.cos))
    balanced = {"rotors.ring.load.drag": 3e-4, "gravity": [-along, -across]}
    assert swing_frequency(gp.replace(gp.load_case("han2021"), balanced)) == pytest.approx(0.0, abs=1e-6)


DAMPING, DENSITY, MASS = 0.4, 3e-8, 0.8  # N s/m, m^2/s^4/Hz, kg


def pressed(members: int, **changes: object) -> ConditionResult:
    """Simulate a coupled pair at 60 rpm whose flank and shaft stay in contact: drag and no excitation."""
    settings = Settings(parameters="assumed", members=members, transient=20.0, history=0.01)
    pair = {
        "rotors.ring.load.drag": 1e-3,
        "rotors.ring.radial_damping": DAMPING,
        "meshes.0.transmission_error": [],
        "rotors.ring.runout.amplitude": 0.0,
        "rotors.pinion.runout.amplitude": 0.0,
    }
    base = gp.replace(base_case(settings.variants[0], settings), pair | changes)
    condition = Condition(60.0, 100.0, 100.0)
    return run_condition(condition_case(base, condition, "coupled"), condition, "coupled", settings, Work())


@pytest.mark.slow
def test_lasting__free_swing_decays_by_its_damping() -> None:
    """Amplitude falls as exp(-c t / 2 m), its frequency that of the pressed pendulum, tilt included."""
    found = pressed(6)
    assert found.lasting == pytest.approx(math.exp(-DAMPING * LATER / (2.0 * MASS)), rel=0.1)
    assert found.lines[0].frequency == pytest.approx(found.swing_frequency, rel=0.1)
    assert found.floor == 0.0


@pytest.mark.slow
def test_lasting__swing_excited_by_the_floor() -> None:
    """The swing, across the line of action, is an oscillator in noise: its acceleration has the mean square S w^2 m / 4 c."""
    floor = {
        "kind": "spectral-density",
        "density": [[0.5, DENSITY], [8.0, DENSITY]],
        "direction": "-20 deg",
        "per_member": True,
    }
    found = pressed(12, base={"acceleration": floor})
    omega = 2.0 * math.pi * found.swing_frequency
    square = math.cos(math.radians(20.0)) ** 2 * DENSITY * omega**2 * MASS / (4.0 * DAMPING)
    near = np.abs(np.array(found.frequency) - found.swing_frequency) < 1.0
    # Amplitudes are those of sines, so their squares count twice; Hann's window counts each bin 1.5 times.
    seen = np.sum(np.array(found.amplitude)[near] ** 2) / (2.0 * 1.5)
    assert math.sqrt(seen) == pytest.approx(math.sqrt(square), rel=0.25)
    assert found.lasting == pytest.approx(1.0, abs=0.6)
    assert found.floor == pytest.approx(math.sqrt(7.5 * DENSITY), rel=1e-9)


def test_find_lines__not_the_sidebands() -> None:
    """Sidebands of 2 f_m at the distance of f_r, which are higher than 2 f_m."""
    t = np.arange(4000) / 1000.0
    tones = {20.0: 0.0, 60.0: 1.0, 57.2: 3.0, 120.0: 1.0, 122.8: 3.0, 117.2: 3.0, 2.8: 5.0}
    samples = np.zeros(4000) + sum(a * np.sin(2.0 * math.pi * f * t) for f, a in tones.items())
    spectrum = gp.signals.amplitude_spectrum(samples, 1000.0)
    _, once, twice = find_lines(spectrum, Condition(180.0, 100.0, 100.0))
    assert once.frequency == pytest.approx(60.0, abs=0.1)
    assert twice.frequency == pytest.approx(120.0, abs=0.1)
    assert twice.amplitude == pytest.approx(1.0, rel=0.1)


def test_run_study__each_condition_as_alone() -> None:
    """Two conditions run at a time: the same numbers as one by one, in their order, and progress that only grows."""
    settings = Settings(members=2, duration=1.0, transient=0.1, history=0.01)
    shown: list[tuple[float, float]] = []
    work = Work(lambda label, done, total: shown.append((done, total)))
    results = run_study(settings, work, names=(SWITCHED,))
    assert [each.condition for each in results] == list(conditions())
    variant = settings.variants[2]
    case = condition_case(base_case(variant, settings), conditions()[3], variant.model)
    assert results[3] == run_condition(case, conditions()[3], SWITCHED, settings, Work())
    assert all(before < after + 1e-9 for (before, _), (after, _) in itertools.pairwise(shown))
    assert shown[-1][0] == pytest.approx(6 * 2 * 1.1, rel=1e-12)
    assert all(total == pytest.approx(shown[-1][0], rel=1e-12) for _, total in shown)


def test_run_study__ends_where_it_is_stopped() -> None:
    work = Work()
    calls = []

    def stopping(identity: Any, make: Any) -> Any:
        calls.append(identity)
        work.stop.set()
        return make()

    with pytest.raises(KeyboardInterrupt):
        run_study(Settings(members=1), dataclasses.replace(work, keep=stopping))
    assert 1 <= len(calls) <= 2


@pytest.mark.slow
def test_findings__amplitudes_met_only_where_the_swing_lasts() -> None:
    settings = Settings(members=2, duration=1.0, transient=0.2, history=0.01)
    results = run_study(settings)
    claim = "The coupled model meets the measured amplitudes."
    seen = {}
    for share in (0.1, 1.0):
        made = [
            dataclasses.replace(
                r,
                lasting=share,
                lines=tuple(
                    line._replace(amplitude=test)
                    for line, test in zip(
                        r.lines, printed("test", AMPLITUDE)[conditions().index(r.condition)], strict=True
                    )
                ),
            )
            for r in results
        ]
        models = by_model(made)
        assert models["coupled"].lasting_shares == [share] * 6
        assert models["coupled"].swing_lasts == (share == 1.0)
        finding = next(f for f in findings(models, stored("claims"), calibrated=True) if f.claim == claim)
        seen[share] = finding.verdict
        assert ("does not last" in finding.evidence) == (share == 0.1)
        said = f"{LATER:g} s later it has {100 * share:.0f} to {100 * share:.0f} % of its amplitude"
        assert said in finding.evidence
        believe = story(models, settings, stored("claims"))[-1][1]
        assert ("does not keep up" in believe) == (share == 0.1)
    assert seen == {0.1: OPEN, 1.0: REPRODUCED}
