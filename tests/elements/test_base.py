"""The housing's motion: closed forms, records against their density, and random ones for the tests of all elements."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from depth import sized
from gearplay.model.pack import pack
from gearplay.model.toml_files import write_toml
from gearplay.nonlinear.orbits.period_map import common_period
from gearplay.parts.housing.schema import SpectralDensity
from gearplay.rig.measurement import mean_acceleration
from gearplay.rig.plan import Placement
from gearplay.solver.simulate import run_members
from gearplay.vocabulary.errors import InputError

G = 9.80665
V10 = (
    (20.0, 0.026),
    (50.0, 0.16),
    (800.0, 0.16),
    (2000.0, 0.026),
)  # Hz, g^2/Hz: shared validation numbers, V10
MASS = 0.5  # kg


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc on a support in a housing that shakes; one that does not for a mechanism that is to be turned."""
    return {
        "rotors": {"disc": {"mass": MASS, "inertia": 1e-3, "position": [0.01, 0.02], "floating": True}},
        "base": {
            "acceleration": {
                "kind": "harmonic",
                "amplitude": 0.0 if plain else float(rng.uniform(1.0, 20.0)),
                "frequency": float(rng.uniform(10.0, 500.0)),
                "direction": float(rng.uniform(0.0, 6.0)),
            }
        },
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def shaken(stiffness: float, damping: float, **acceleration: Any) -> Document:
    """Return a disc on a support in a housing that moves."""
    return {
        "rotors": {"disc": {"mass": MASS, "inertia": 1e-3}},
        "supports": {"disc": {"stiffness": [stiffness] * 2, "damping": [damping] * 2}},
        "base": {"acceleration": acceleration},
        "run": {"duration": 0.1, "sampling": 1e4, "tolerance": 1e-11},
    }


def test_a_harmonic_motion_shakes_an_oscillator_in_closed_form(measured: Measured) -> None:
    """Undamped, from rest: x = A (sin w t - w/w0 sin w0 t), A = -a / (w0^2 - w^2); along the direction given."""
    k, a, f, angle = 2e5, 4.0, 70.0, math.radians(30.0)
    run = simulate_one(shaken(k, 0.0, kind="harmonic", amplitude=a, frequency=f, direction=angle))
    w, w_0 = 2.0 * math.pi * f, math.sqrt(k / MASS)
    along = -a / (w_0**2 - w**2) * (np.sin(w * run.time) - w / w_0 * np.sin(w_0 * run.time))
    worst = max(
        float(np.max(np.abs(run.signal("x", "disc") - along * math.cos(angle)))),
        float(np.max(np.abs(run.signal("y", "disc") - along * math.sin(angle)))),
    )
    measured("harmonic base motion: displacement [m]", worst, "1e-12")
    assert worst < 1e-12 < 1e-6 < np.max(np.abs(along))
    assert np.allclose(run.signal("base_ay", "base"), a * math.sin(angle) * np.sin(w * run.time), atol=1e-12)


def test_shock__leaves_free_oscillations(measured: Measured) -> None:
    """Half a sine of duration T from t_0: the integral of Duhamel in closed form within it, free swings after it."""
    k, a, span, start = 2e5, 200.0, 3e-3, 0.011
    run = simulate_one(shaken(k, 0.0, kind="half-sine", amplitude=a, duration=span, start=start))
    w, w_0 = math.pi / span, math.sqrt(k / MASS)

    def within(t: Floats) -> Floats:
        found: Floats = -a / (w_0**2 - w**2) * (np.sin(w * t) - w / w_0 * np.sin(w_0 * t))
        return found

    t = run.time - start
    after = within(t) + np.where(
        t > span, within(t - span), 0.0
    )  # a second half sine undoes what would follow
    exact = np.where(t < 0.0, 0.0, after)
    worst = float(np.max(np.abs(run.signal("x", "disc") - exact)))
    measured("shock: displacement [m]", worst, "1e-12")
    assert worst < 1e-12 < 1e-5 < np.max(np.abs(exact))


def test_a_free_rotor_stays_behind_its_housing() -> None:
    """Without a spring it rests in space: relative to the housing it moves with -a; gravity adds; after a shock it flies."""
    document = shaken(1.0, 0.0, kind="half-sine", amplitude=50.0, duration=0.01)
    del document["supports"]
    document["rotors"]["disc"]["floating"] = True
    document["gravity"] = [0.0, -G]
    run = simulate_one(document)
    w = math.pi / 0.01
    speed = -50.0 / w * (1.0 - np.cos(w * np.minimum(run.time, 0.01)))
    assert np.max(np.abs(run.signal("vx", "disc") - speed)) < 1e-11
    assert np.max(np.abs(run.signal("vy", "disc") + G * run.time)) < 1e-11
    assert run.counters.steps < 200, "flies once the shock is over"


@pytest.mark.compiled
def test_measured_record__acts_as_the_sampled_acceleration(measured: Measured) -> None:
    """A sine in 40 values per period is that sine, by its spline."""
    k, f = 2e5, 50.0
    times = np.arange(0, 401) / (40.0 * f)
    values = (3.0 * np.sin(2.0 * math.pi * f * times)).tolist()
    sine = simulate_one(shaken(k, 5.0, kind="harmonic", amplitude=3.0, frequency=f)).signal("x", "disc")
    record = simulate_one(shaken(k, 5.0, kind="record", values=values, sampling=40.0 * f)).signal("x", "disc")
    worst = float(np.max(np.abs(record - sine)) / np.max(np.abs(sine)))
    measured("record of a sine against the sine, relative", worst, "1e-4")
    assert worst < 1e-4


def vibration(seed: int = 0) -> SpectralDensity:
    """Return V10's spectral density."""
    return SpectralDensity(density=[[f, f"{s} g^2/Hz"] for f, s in V10], seed=seed)  # type: ignore[arg-type]


def test_the_printed_level_of_random_vibration() -> None:
    """V10 prints 14.136 g rms for these points."""
    assert vibration().rms() / G == pytest.approx(14.136, abs=5e-4)


def test_records_have_the_density_in_each_octave(measured: Measured) -> None:
    """The mean over 64 records' own density in each octave is the asked one within 5 %."""
    span, seeds, edges = 2.0, 64, 20.0 * 2.0 ** np.arange(7)
    sums = np.zeros(len(edges) - 1)
    for seed in range(seeds):
        step, values = vibration(seed).record(span)
        lines = np.abs(np.fft.rfft(values)) ** 2 / values.size**2 * 2.0
        frequencies = np.fft.rfftfreq(values.size, step)
        sums += [np.sum(lines[(frequencies >= a) & (frequencies < b)]) for a, b in pairwise(edges)]
    found = sums / seeds
    fine = np.arange(20.0, edges[-1], 0.01)
    density = vibration().at(fine)
    asked = np.array([np.sum(density[(fine >= a) & (fine < b)]) * 0.01 for a, b in pairwise(edges)])
    worst = float(np.max(np.abs(found / asked - 1.0)))
    measured("records of a density: mean square in an octave, relative", worst, "0.05")
    assert worst < 0.05


@pytest.mark.slow
@pytest.mark.compiled
def test_an_oscillator_under_random_vibration_has_the_rms_of_the_integral(measured: Measured) -> None:
    """Mean square of the relative displacement over records against the integral of |H|^2 S, within 1 % at full depth (V10)."""
    f_0, zeta, seeds = 300.0, 0.1, sized(64, 8)
    w_0 = 2.0 * math.pi * f_0
    k, c = MASS * w_0**2, 2.0 * zeta * w_0 * MASS
    base = vibration().model_dump(mode="json")
    document = shaken(k, c, **base)
    document["run"] = {"duration": 2.0, "transient": 0.1, "sampling": 1e4, "tolerance": 1e-6}
    case = case_of(document)
    squares = []
    for seed in range(seeds):
        result = gp.simulate(gp.replace(case, {"base.acceleration.seed": seed}), signals=["disc.x"])
        squares.append(float(np.mean(result.ds.x.values**2)))
    f = np.arange(20.0, 2000.0, 0.01)
    response = 1.0 / ((w_0**2 - (2.0 * math.pi * f) ** 2) ** 2 + (2.0 * zeta * w_0 * 2.0 * math.pi * f) ** 2)
    exact = math.sqrt(float(np.sum(response * vibration().at(f))) * 0.01)
    found = math.sqrt(float(np.mean(squares)))
    spread = float(np.std(squares, ddof=1)) / math.sqrt(seeds) / (2.0 * exact**2)
    allowed = max(0.01, 3.0 * spread)
    measured(
        f"rms under random vibration, {seeds} records, relative", abs(found / exact - 1.0), f"{allowed:.2g}"
    )
    assert found == pytest.approx(exact, rel=allowed)
    assert spread < 0.02


def test_the_seed_decides_the_record_and_the_digest() -> None:
    one, two = (case_of(shaken(1e5, 1.0, **vibration(seed).model_dump(mode="json"))) for seed in (0, 1))
    assert one.sha256 != two.sha256
    assert not np.array_equal(vibration(0).record(0.1)[1], vibration(1).record(0.1)[1])
    assert np.array_equal(vibration(1).record(0.1)[1], vibration(1).record(0.1)[1])


def test_the_housing_is_shown_beside_the_rotors() -> None:
    """base_ax and base_ay have no dimension but time, and may be asked for alone."""
    case = case_of(shaken(1e5, 1.0, kind="harmonic", amplitude=3.0, frequency=50.0))
    ds = gp.simulate(case).ds
    assert ds.base_ax.dims == ("time",)
    assert gp.simulate(case, ensemble=3).ds.base_ax.dims == ("member", "time")
    alone = gp.simulate(case, signals=["base_ax"]).ds
    assert np.array_equal(alone.base_ax.values, ds.base_ax.values)


@pytest.mark.parametrize(
    ("acceleration", "words"),
    [
        ({"kind": "harmonic", "amplitude": 1.0}, "is required"),
        ({"kind": "harmonic", "amplitude": "1 m", "frequency": 1.0}, "m/s"),
        ({"kind": "sinus"}, "harmonic, half-sine, spectral-density, record"),
        ({"kind": "half-sine", "amplitude": 1.0, "duration": 0.0}, "greater than 0"),
        ({"kind": "spectral-density", "density": [[20.0, 1.0]]}, "must have 2 to 100 items"),
        ({"kind": "spectral-density", "density": [[20.0, 1.0], [10.0, 1.0]]}, "rising frequencies"),
        ({"kind": "spectral-density", "density": [[20.0, 1.0], [30.0, 0.0]]}, "greater than 0"),
        ({"kind": "record", "values": [1.0], "sampling": 1.0}, "must have 4 to 200000 items"),
    ],
)
def test_bad_motions_are_refused_in_words(acceleration: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gp.load_case(shaken(1e5, 1.0, **acceleration))


def test_a_record_that_gets_too_long_is_refused() -> None:
    document = shaken(1e5, 1.0, kind="spectral-density", density=[[20.0, 1.0], [1e6, 1.0]])
    document["run"]["duration"] = 1.0
    with pytest.raises(InputError, match="steps of a record long"):
        gp.simulate(case_of(document))


def test_a_record_may_lie_in_a_file_beside_its_case(tmp_path: Path) -> None:
    """Two columns, heads or none, commas or blanks; the case holds the values, so that it needs the file no more."""
    times = np.arange(200) / 2000.0
    values = 3.0 * np.sin(2.0 * math.pi * 40.0 * times)
    lines = "\n".join(f"{t:.9g}, {a:.17g}" for t, a in zip(times, values, strict=True))
    (tmp_path / "shaker.csv").write_text(f"time [s], a [m/s^2]\n{lines}\n")
    document = shaken(1e5, 5.0, kind="record", values=[], sampling=2000.0)
    del document["base"]["acceleration"]["values"], document["base"]["acceleration"]["sampling"]
    document["base"]["acceleration"]["file"] = "shaker.csv"
    named = write_toml(document)
    (tmp_path / "case.toml").write_text(named)
    read = gp.load_case(tmp_path / "case.toml")
    assert read.base is not None
    assert read.base.acceleration.values == pytest.approx(tuple(values))  # type: ignore[union-attr]
    assert gp.load_case(read.resolved()).sha256 == read.sha256
    for content, words in (
        ("0 1\n1 x\n", "line 2"),
        ("0 1\n1 2\n3 4\n", "equal, rising"),
        ("", "equal, rising"),
    ):
        (tmp_path / "shaker.csv").write_text(content)
        with pytest.raises(InputError, match=rf"base\.acceleration\.file.*{words}"):
            gp.load_case(tmp_path / "case.toml")
    (tmp_path / "shaker.csv").unlink()
    with pytest.raises(InputError, match="no such file"):
        gp.load_case(tmp_path / "case.toml")


def test_housing_record__a_short_run_uses_its_beginning() -> None:
    """A record of 0.03 s would hold no line between 20 and 22 Hz, so no motion at all."""
    narrow = [[20.0, 1.0], [22.0, 1.0]]
    squares = []
    for seed in range(64):
        step, values = SpectralDensity(density=narrow, seed=seed).record(0.03)  # type: ignore[arg-type]
        assert step * values.size == pytest.approx(8.0)
        squares.append(np.mean(values[: math.ceil(0.03 / step)] ** 2))
    assert np.mean(squares) == pytest.approx(2.0, rel=0.5)
    document = shaken(1e5, 1.0, kind="spectral-density", density=narrow)
    document["run"]["duration"] = 0.03
    assert np.std(gp.simulate(case_of(document)).signal("base_ax")) > 0.0


@pytest.mark.slow
@pytest.mark.compiled
def test_a_saved_result_gives_its_signals_back(tmp_path: Path) -> None:
    result = gp.simulate(
        case_of(shaken(1e5, 1.0, kind="harmonic", amplitude=3.0, frequency=50.0)), ensemble=2
    )
    result.save(tmp_path / "base.nc")
    read = gp.read_result(tmp_path / "base.nc")
    for name in ("base_ax", "disc.x"):
        assert np.array_equal(read.signal(name), result.signal(name))


@pytest.mark.compiled
def test_a_sensor_feels_the_housing_too() -> None:
    """On a stiff support in a housing that shakes slowly it records the housing's acceleration, not the little beside it."""
    document = shaken(1e9, 100.0, kind="harmonic", amplitude=5.0, frequency=40.0)
    document["run"] = {"duration": 1.0, "transient": 0.5, "sampling": 1e4, "tolerance": 1e-8}
    run = simulate_one(document)
    assert np.std(run.signal("ax", "disc")) < 0.01
    place = Placement("disc", 0.0)
    assert np.std(mean_acceleration(run, place)[:, 0]) == pytest.approx(5.0 / math.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, 1.0 / 50.0),
        ({"terms": [{"frequency": 20.0, "amplitude": 1.0}]}, 0.1),
        ({"terms": [{"order": 1.5, "amplitude": 1.0}]}, 0.08),
    ],
)
def test_the_period_is_that_of_all_excitation(changes: dict[str, Any], expected: float) -> None:
    """A shaken housing at 50 Hz, and terms of a load: in time, and of the rotation at 25 turns a second."""
    document = shaken(1e5, 5.0, kind="harmonic", amplitude=3.0, frequency=50.0)
    document["rotors"]["disc"] |= {"drive": {"kind": "speed", "speed": "1500 rpm"}, "load": changes}
    assert common_period(pack(case_of(document))) == pytest.approx(expected, rel=1e-12)


def test_the_bundled_pulsating_pair_repeats_with_its_turn() -> None:
    """20 teeth, a load of the first order: one turn, not one tooth."""
    assert common_period(pack(gp.load_case("pulsating-pair"))) == pytest.approx(0.06, rel=1e-12)


@pytest.mark.compiled
def test_housing_record__may_differ_by_member() -> None:
    """Told so, members have other records; members and seeds decide them; member 0, and a case not told so, have the seed's."""
    density = [[20.0, 1.0], [200.0, 1.0]]

    def records(*, seed: int = 0, **own: object) -> np.ndarray:
        document = shaken(1e5, 1.0, kind="spectral-density", density=density, **own)
        document["run"] |= {"duration": 0.2, "transient": 0.1, "seed": seed}
        runs = run_members(case_of(document), [0, 1, 2, 1], signals=["base_ax"])
        return np.array([run.signal("base_ax", "base") for run in runs])

    common, own, reseeded = records(), records(per_member=True), records(per_member=True, seed=1)
    assert np.array_equal(common[0], common[1])
    assert np.array_equal(common[0], own[0])
    assert np.array_equal(own[1], own[3])
    assert np.array_equal(reseeded[0], own[0])
    for a, b in ((own[1], own[0]), (own[2], own[1]), (reseeded[1], own[1])):
        assert abs(np.corrcoef(a, b)[0, 1]) < 0.5
    assert np.std(own[1]) == pytest.approx(math.sqrt(180.0), rel=0.3)


@pytest.mark.compiled
def test_spectral_density__record_covers_the_run() -> None:
    """Not as long as the case's own run, after which it would repeat."""
    document = shaken(1e5, 1.0, kind="spectral-density", density=[[20.0, 1.0], [200.0, 1.0]])
    document["run"] |= {"duration": 0.1, "transient": 0.1}
    run = run_members(case_of(document), [1], signals=["base_ax"], duration=0.4, transient=0.2)[0]
    record = run.signal("base_ax", "base")
    assert abs(np.corrcoef(record[: record.size // 2], record[record.size // 2 :])[0, 1]) < 0.5
