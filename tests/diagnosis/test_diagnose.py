"""Diagnosis of synthetic records: twelve conditions, a bearing as in public records, speeds, refusals."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from depth import FULL
from gearplay.diagnosis.doubts import _shows_cage
from gearplay.diagnosis.hypotheses import HEALTHY, TOLD
from gearplay.diagnosis.machine import described, machine_of_case, machine_of_teeth
from gearplay.diagnosis.measures import measured
from gearplay.diagnosis.named_lines import named_envelope, named_spectrum
from gearplay.diagnosis.shaft_speed import FoundSpeed
from machine_records import BEARINGS, CONDITIONS, NAMES, bearing_record, event_times, machine_record, ringing

PAIR = {"teeth": "23:61", "bearings": BEARINGS, "speed": "1500 rpm"}


def named(condition: str, seed: int, **more: Any) -> tuple[bool, dict[str, Any]]:
    """Return whether the condition is named first, and the first hypothesis."""
    channel, _ = machine_record(condition, seed)
    first = gp.diagnose(channel, **(PAIR | more)).hypotheses()[0]
    return first["name"] == NAMES[condition], first


@pytest.mark.parametrize("condition", CONDITIONS)
def test_conditions__one_record_of_each(condition: str) -> None:
    right, first = named(condition, 41)
    assert right, first


@pytest.mark.slow
def test_conditions__first_in_ninety_per_cent_and_never_wrong_with_the_stated_confidence() -> None:
    found = [
        named(condition, seed) for seed in range(1000, 1005 if FULL else 1002) for condition in CONDITIONS
    ]
    assert sum(right for right, _ in found) >= 0.9 * len(found)
    wrong = [first for right, first in found if not right]
    assert all(first["confidence"] < TOLD for first in wrong), wrong


@pytest.mark.slow
def test_weak_conditions__a_wrong_name_is_never_stated() -> None:
    """At 0.3 of the severity and twice the noise most conditions drown: what is then named first is not stated."""
    for seed in range(3 if FULL else 1):
        for condition in CONDITIONS:
            channel, _ = machine_record(condition, 2000 + seed, severity=0.3, noise=0.6)
            first = gp.diagnose(channel, **PAIR).hypotheses()[0]
            assert first["name"] in (NAMES[condition], HEALTHY) or first["confidence"] < TOLD, (
                condition,
                first,
            )


@pytest.mark.slow
def test_healthy_machines__raise_no_alarm() -> None:
    for seed in range(20 if FULL else 5):
        channel, _ = machine_record("healthy", 3000 + seed)
        assert not gp.diagnose(channel, **PAIR).told


def test_healthy_record__lowers_thresholds() -> None:
    """A modulation of 0.15 does not count by itself, and counts against a healthy record with less."""
    channel, _ = machine_record("eccentric 1", 100, severity=0.4)
    healthy, _ = machine_record("healthy", 7)
    alone, against = gp.diagnose(channel, **PAIR), gp.diagnose(channel, healthy=healthy, **PAIR)
    assert alone.hypotheses()[0]["name"] == HEALTHY
    assert against.hypotheses()[0]["name"] == NAMES["eccentric 1"]
    assert any(np.isfinite(index["healthy"]) for index in against.indices())
    mesh = next(line for line in against.lines("spectrum") if line["name"] == "mesh")
    assert np.isfinite(mesh["healthy"])
    assert "Without a healthy record" in " ".join(alone.cannot_be_told)
    assert "Without a healthy record" not in " ".join(against.cannot_be_told)


@pytest.mark.parametrize("off", [-0.02, 0.0, 0.02])
def test_speed__is_found_from_the_mesh_line(off: float) -> None:
    channel, f = machine_record("tooth 2", 12)
    found = gp.diagnose(channel, teeth="23:61", speed=2 * np.pi * f * (1.0 + off))
    assert float(found.ds["shaft_speed"]) == pytest.approx(f, rel=2e-6)
    assert found.ds.attrs["speed_source"] == "mesh"
    assert found.hypotheses()[0]["name"] == NAMES["tooth 2"]


def test_speed__a_channel_of_a_drifting_shaft() -> None:
    """The speed falls by a tenth: lines smear in time, not over the angle."""
    rate, n = 20_000.0, 160_000
    t = np.arange(n) / rate
    speed = 25.0 * (1.0 - 0.1 * t / t[-1])
    angle = 2 * np.pi * np.cumsum(speed) / rate
    off = (angle - 1.0 + np.pi) % (2 * np.pi) - np.pi
    loss = 1.0 - 0.5 * np.exp(-((off * 23 / 3.0) ** 2))
    x = loss * (np.cos(23 * angle) + 0.4 * np.cos(46 * angle)) + 0.1 * np.random.default_rng(
        0
    ).standard_normal(n)
    rpm = gp.Channel("n", 60.0 * speed, rate, "rpm")
    found = gp.diagnose(gp.Channel("acc", x, rate, "g"), teeth="23:61", speed=rpm)
    assert found.told
    assert found.hypotheses()[0]["name"] == "damaged tooth on gear 1 (23 teeth)"
    assert found.ds.attrs["speed_source"] == "measured"


@pytest.mark.parametrize(
    ("part", "name", "line"), [("inner", "inner ring", 162.2), ("outer", "outer ring", 107.4)]
)
def test_bearing__as_in_the_public_records(part: str, name: str, line: float) -> None:
    """6205 at 1797 rpm: BPFI 162.2 Hz, BPFO 107.4 Hz, in the envelope."""
    found = gp.diagnose(bearing_record(part), bearings="9, 7.94mm, 39.04mm", speed="1797 rpm")
    first = found.hypotheses()[0]
    assert (first["name"], found.told) == (f"bearing, {name}", True)
    own = next(each for each in found.lines("envelope") if each["name"] == f"BPF{part[0].upper()}")
    assert own["frequency"] == pytest.approx(line, rel=0.01)
    assert found.ds.attrs["speed_source"] == "shaft"
    # No multiple of FTF but those of BPFO stands: a cage is ruled out.
    assert found.cannot_be_told == ["Gears cannot be told: no teeth are given."]


@pytest.mark.parametrize(("turns", "shown"), [(9.0, False), (12.0, True), (300.0, True)])
def test_cage__shows_where_its_lines_are_apart_from_the_turns(turns: float, shown: bool) -> None:
    """At 0.398 turns the multiples of FTF lie 0.4, 0.2, 0.2, 0.4, 0.01, 0.4 turns from those of the turn: 2 lines in ten."""
    machine = described(None, None, "6205")
    noise = gp.Channel(
        "a", np.random.default_rng(1).standard_normal(round(turns / 30.0 * 12_000.0)), 12_000.0
    )
    found = measured(noise, machine, FoundSpeed(30.0, 0.01, "shaft"))
    assert _shows_cage(machine, found, 0) is shown


def test_bearing__noise_alone_shows_none() -> None:
    noise = gp.Channel("a", np.random.default_rng(3).standard_normal(120_000), 12_000.0)
    found = gp.diagnose(noise, bearings="9, 7.94mm, 39.04mm", speed="1797 rpm")
    assert found.hypotheses()[0]["name"] == HEALTHY
    assert not found.told
    assert found.ds.attrs["speed_source"] == "nominal"


def test_high_multiples_of_a_slipping_ring__have_its_name() -> None:
    """Outer ring 0.6 % off its kinematic place: peaks at 5 and more times the line found have its name."""
    rng, n, rate = np.random.default_rng(2), 40_000, 20_000.0
    line = 1.006 * 107.36
    times = event_times(line, 2.0, 0.003, rng)
    x = ringing(times, np.ones(times.size), n, rate, 4000.0, 900.0) + 0.2 * rng.standard_normal(n)
    found = gp.diagnose(gp.Channel("a", x, rate), bearings="6205", speed="1797 rpm")
    high = [
        each
        for each in found.lines("envelope")
        if each["frequency"] > 4.5 * line and each["prominence"] > 6.0
    ]
    assert len([each for each in high if each["name"].endswith("x BPFO")]) >= 4
    for each in high:
        h = round(each["frequency"] / line)
        assert each["frequency"] == pytest.approx(h * line, rel=2e-3)
        assert each["name"] in (f"{h} x BPFO", "4 x BPFI")


def damaged_bearing() -> gp.Channel:
    """Return the acceleration of a pair 23:61 at 1500 rpm with shocks at 76.3 Hz, the outer ring of an ER-10K."""
    rng, n, rate = np.random.default_rng(1), 20_000, 20_000.0
    t = np.arange(n) / rate
    turn = 1.0 + 0.2 * np.cos(2 * np.pi * 25.0 * t) + 0.08 * np.cos(2 * np.pi * 25.0 * 23 / 61 * t)
    mesh = sum(a * np.cos(2 * np.pi * h * 575.0 * t + h) for h, a in ((1, 0.3), (2, 0.12), (3, 0.05)))
    times = (np.arange(77) + 0.005 * rng.standard_normal(77)) / 76.308
    shocks = ringing(times, np.full(times.size, 0.5), n, rate, 4200.0, 800.0)
    x = turn * mesh + shocks + 0.05 * np.sin(2 * np.pi * 25.0 * t) + 0.05 * rng.standard_normal(n)
    return gp.Channel("acc", x, rate)


def test_speed_that_no_line_supports__states_no_cause() -> None:
    """Given as 1800 rpm, nothing at multiples of that speed is stated."""
    found = gp.diagnose(damaged_bearing(), teeth="23:61", speed="1800 rpm")
    assert found.ds.attrs["speed_source"] == "nominal"
    assert not found.told
    assert all(each["confidence"] <= 0.6 for each in found.hypotheses())


def test_bearing_of_other_geometry__states_no_cause() -> None:
    """A single line of the damaged ring lies at a sideband of the other bearing's element, and is no evidence alone."""
    right = gp.diagnose(damaged_bearing(), bearings="ER-10K", speed="1500 rpm")
    assert (right.hypotheses()[0]["name"], right.told) == ("bearing, outer ring", True)
    wrong = gp.diagnose(damaged_bearing(), bearings="9, 7.94mm, 39.04mm", speed="1500 rpm")
    assert not wrong.told


def test_lines_at_one_place__no_confidence() -> None:
    """2.0023 turns of an element and BPFI of the other shaft's bearing, 2.0418, meet midway within slip."""
    rng, n, f = np.random.default_rng(5), 120_000, 25.0
    times = event_times(2.022 * f, 6.0, 0.005, rng)
    load = 1.0 + 0.7 * np.cos(2 * np.pi * f * 23 / 61 * times)
    x = ringing(times, load, n, 20_000.0, 4000.0, 900.0) + 0.3 * rng.standard_normal(n)
    x += np.cos(2 * np.pi * 23 * f * np.arange(n) / 20_000.0)
    found = gp.diagnose(gp.Channel("acc", x, 20_000.0), **PAIR)
    first, second = (each["name"] for each in found.hypotheses()[:2])
    assert {first, second} == {"bearing 1, rolling element", "bearing 2, inner ring"}
    assert not found.told
    assert any("cannot be ruled out" in sentence and second in sentence for sentence in found.cannot_be_told)


def test_lines_on_a_turn__no_confidence() -> None:
    """Random shocks twice a turn: an element turns 2.0023 times a turn, which six seconds do not resolve."""
    rng, n, f = np.random.default_rng(1), 120_000, 25.0
    times = np.arange(0.0, 6.0, 0.5 / f) + rng.normal(0.0, 0.03 / f, 300)
    x = ringing(
        times, 1.5 * np.abs(rng.standard_normal(300)), n, 20_000.0, 4000.0, 900.0
    ) + 0.3 * rng.standard_normal(n)
    x += np.cos(2 * np.pi * 23 * f * np.arange(n) / 20_000.0)
    found = gp.diagnose(gp.Channel("acc", x, 20_000.0), **PAIR)
    assert found.hypotheses()[0]["name"] == "bearing 1, rolling element"
    assert not found.told
    assert "multiples of a shaft's turn" in " ".join(found.cannot_be_told)


@pytest.mark.parametrize("condition", ["tooth 1", "tooth 2", "inner 1"])
def test_strong_shocks_with_a_period__are_no_rattle(condition: str) -> None:
    channel, _ = machine_record(condition, 8, severity=6.0)
    found = gp.diagnose(channel, **PAIR)
    assert (found.hypotheses()[0]["name"], found.told) == (NAMES[condition], True)


def test_one_knock__is_no_rattle() -> None:
    channel, _ = machine_record("healthy", 5)
    values = channel.values.copy()
    values[60_000:60_400] += 20.0 * np.exp(-0.01 * np.arange(400)) * np.sin(np.arange(400))
    assert not gp.diagnose(gp.Channel("acc", values, channel.sampling), **PAIR).told


@pytest.mark.compiled
def test_a_simulated_rattle__is_named() -> None:
    """The unloaded pair of the article rattles without a period; without a bearing nothing else explains its shocks."""
    from gearplay.results.recorded import record_of

    result = gp.simulate("han2021", duration=6.0, transient=1.0, sampling=2e4, signals=["ax", "ay"])
    found = gp.diagnose(record_of(result), case="han2021", channel="ring.ax", quick=True)
    assert found.hypotheses()[0]["name"] == "rattle of the flanks"
    assert any("bush" in sentence for sentence in found.cannot_be_told)


def test_multiples_of_a_turn__have_its_name_where_they_are_well_apart() -> None:
    """A quiet floor with lines at twelve and seventeen turns and between two; with bins of an eighth of a turn none is named."""
    machine, turn = machine_of_teeth("23:47"), 15.0
    named_alike = {"12 x turn of shaft 1", "17 x turn of shaft 1", "unnamed"}
    for bin_width, source, names in (
        (0.5, "shaft", named_alike),
        (2.5, "shaft", {"unnamed"}),
        (0.5, "nominal", {"unnamed"}),
    ):
        speed = FoundSpeed(turn, 1e-3, source)
        frequency = bin_width * np.arange(2000)
        amplitude = 1e-3 * np.random.default_rng(5).rayleigh(size=frequency.size)
        for place in (12.0, 17.0, 13.4):
            amplitude[round(place * turn / bin_width)] = 1.0
        for named in (named_envelope, named_spectrum):
            found = named(frequency, amplitude, machine, speed)
            assert {line.name for line in found if line.amplitude == 1.0} == names


def test_peaks_near_a_multiple_of_a_turn__are_named_within_one_line_in_both_spectra() -> None:
    machine, turn, speed = machine_of_teeth("23:47"), 15.0, FoundSpeed(15.0, 1e-3, "shaft")
    frequency = 0.5 * np.arange(2000)
    amplitude = 1e-3 * np.random.default_rng(5).rayleigh(size=frequency.size)
    for place in (7.0 * turn + 0.5, 9.0 * turn + 1.0, 31.0 * turn - 0.5, 33.0 * turn - 1.0):
        amplitude[round(place / 0.5)] = 1.0
    for named in (named_envelope, named_spectrum):
        found = [line.name for line in named(frequency, amplitude, machine, speed) if line.amplitude == 1.0]
        assert sorted(found) == ["31 x turn of shaft 1", "7 x turn of shaft 1", "unnamed", "unnamed"]


def test_machine__of_a_case_and_of_its_teeth_are_one() -> None:
    case, teeth = machine_of_case(gp.load_case("two-stage-reducer")), machine_of_teeth("32:96, 48:80")
    for one, other in ((case.shafts, teeth.shafts), (case.gears, teeth.gears), (case.meshes, teeth.meshes)):
        assert [each.order for each in one] == pytest.approx([each.order for each in other], rel=1e-12)
    assert [gear.teeth for gear in case.gears] == [32, 96, 48, 80]
    assert case.speed == pytest.approx(30.0)


def test_machine__of_a_planetary_set_has_its_events() -> None:
    machine = machine_of_case(gp.load_case("planetary-reducer"))
    orders = {gear.name: gear.order * machine.speed for gear in machine.gears}  # type: ignore[operator]
    found = gp.signals.event_periods(17, 37, 91, 3, 2 * np.pi * machine.speed)  # type: ignore[operator]
    expected = {"stage.sun": 1 / found.sun, "stage.planet": 1 / found.planet, "stage.ring": 1 / found.ring}
    assert orders == pytest.approx(expected)


def test_planetary_set__a_damaged_planet() -> None:
    """Shocks each time one flank of a planet meets, through a resonance."""
    machine = machine_of_case(gp.load_case("planetary-reducer"))
    rate, seconds = 20_000.0, 20.0
    event = machine.gears[1].order * float(machine.speed or 0.0)
    n, rng = int(rate * seconds), np.random.default_rng(1)
    times = np.arange(0.1, seconds, 1.0 / event)
    x = ringing(times, 2.0 + 0.4 * rng.standard_normal(times.size), n, rate, 3000.0, 800.0)
    mesh = machine.meshes[0].order * float(machine.speed or 0.0)
    x += np.cos(2 * np.pi * mesh * np.arange(n) / rate) + 0.2 * rng.standard_normal(n)
    found = gp.diagnose(gp.Channel("acc", x, rate, "g"), case="planetary-reducer", quick=True)
    assert found.hypotheses()[0]["name"] == "damaged tooth on stage.planet"
    assert "Which planet it is cannot be told" in " ".join(found.cannot_be_told)


def test_result__comes_back_from_its_file_and_draws(tmp_path: Path) -> None:
    channel, _ = machine_record("outer 1", 3)
    found = gp.diagnose(gp.Record((channel,), "bench $1"), **PAIR)
    found.save(tmp_path / "d.nc")
    again = gp.read_result(tmp_path / "d.nc")
    assert type(again) is type(found)
    assert again.message == found.message
    assert again.hypotheses() == found.hypotheses()
    assert json.dumps(again.lines()) == json.dumps(found.lines())
    figure = found.plot()
    assert len(figure.axes) == 3
    assert [ax.get_xlabel() != "" for ax in figure.axes] == [True] * 3
    assert "outer ring" in found._repr_html_()


def test_two_lines_of_one_peak__have_the_nearest_name() -> None:
    channel, _ = machine_record("inner 1", 3)
    found = [
        line["frequency"]
        for line in gp.diagnose(channel, **PAIR).lines("envelope")
        if np.isfinite(line["frequency"])
    ]
    assert len(found) == len(set(found))


STILL = gp.replace(gp.load_case("han2021"), {"rotors.pinion.drive.speed": "0 rpm"})
NOISE = gp.Channel("acc", np.random.default_rng(0).standard_normal(40_000), 10_000.0, "g")
REFUSED: dict[str, tuple[str, Callable[[], object]]] = {
    "nothing described": ("teeth: is required where neither a case nor a bearing", lambda: gp.diagnose(NOISE, speed="1500 rpm")),
    "case and teeth": ("must not be given with a case", lambda: gp.diagnose(NOISE, case="han2021", teeth="23:61")),
    "no speed": ("must be given, within 2 %", lambda: gp.diagnose(NOISE, teeth="23:61")),
    "speed 0": ("must not be 0", lambda: gp.diagnose(NOISE, teeth="23:61", speed=0.0)),
    "speed without unit": ("has no unit", lambda: gp.diagnose(NOISE, teeth="23:61", speed="1500")),
    "speed nan": ("speed", lambda: gp.diagnose(NOISE, teeth="23:61", speed=float("nan"))),
    "speed as a list": ("speed", lambda: gp.diagnose(NOISE, teeth="23:61", speed=[1.0])),  # type: ignore[arg-type]
    "speed too high": ("a tenth of the sampling", lambda: gp.diagnose(NOISE, teeth="23:61", speed="90000 rpm")),
    "speed too low": ("must last 10 turns", lambda: gp.diagnose(NOISE, teeth="23:61", speed="60 rpm")),
    "teeth in words": ("numbers of teeth", lambda: gp.diagnose(NOISE, teeth="many", speed="1500 rpm")),
    "teeth of none": ("numbers of teeth", lambda: gp.diagnose(NOISE, teeth="0:61", speed="1500 rpm")),
    "teeth without end": ("numbers of teeth", lambda: gp.diagnose(NOISE, teeth="9" * 4000, speed="1500 rpm")),
    "too many stages": ("at most 20 stages", lambda: gp.diagnose(NOISE, teeth=",".join(["23:61"] * 50), speed="1500 rpm")),
    "teeth as a number": ("must be text", lambda: gp.diagnose(NOISE, teeth=23, speed="1500 rpm")),  # type: ignore[arg-type]
    "bearing of two": ("geometry, or one of 6205, ER-10K", lambda: gp.diagnose(NOISE, bearings="8, 7.9mm", speed="1500 rpm")),
    "bearing without unit": ("has no unit", lambda: gp.diagnose(NOISE, bearings="8, 7.9, 33.5", speed="1500 rpm")),
    "bearing turned round": ("must hold 8 elements", lambda: gp.diagnose(NOISE, bearings="8,33mm,8mm", speed="1500 rpm")),
    "bearing elsewhere": ("shaft 1, the only", lambda: gp.diagnose(NOISE, bearings="8,7.9mm,33mm@2", speed="1500 rpm")),
    "many bearings": ("at most 40", lambda: gp.diagnose(NOISE, bearings=["8,7.9mm,33mm"] * 99, speed="1500 rpm")),
    "bearing as a number": ("bearings", lambda: gp.diagnose(NOISE, bearings=8, speed="1500 rpm")),  # type: ignore[arg-type]
    "no record": ("must be a Record or a Channel", lambda: gp.diagnose([1.0], teeth="23:61", speed="1 rpm")),  # type: ignore[arg-type]
    "no healthy record": ("must be a Record", lambda: gp.diagnose(NOISE, healthy=3, teeth="23:61", speed="1500 rpm")),  # type: ignore[arg-type]
    "at rest": ("must vary", lambda: gp.diagnose(gp.Channel("a", np.ones(9999), 1e4), teeth="23:61", speed="1500 rpm")),
    "short": ("at least 2048", lambda: gp.diagnose(gp.Channel("a", np.ones(9), 1e4), teeth="23:61", speed="1500 rpm")),
    "not finite": ("finite", lambda: gp.diagnose(gp.Channel("a", np.full(9999, np.inf), 1e4), teeth="23:61", speed="1500 rpm")),
    "members of nothing": ("members = 5: must be given with a case", lambda: gp.diagnose(NOISE, members=5, **PAIR)),
    "members, quick": ("members = 5: must be given", lambda: gp.diagnose(NOISE, members=5, case="han2021", quick=True)),
    "a case at rest": ("must prescribe a speed", lambda: gp.diagnose(NOISE, case=STILL)),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_refusals(kind: str) -> None:
    words, call = REFUSED[kind]
    with pytest.raises(gp.InputError, match=words) as caught:
        call()
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize(
    "values",
    [
        np.where(np.arange(9999) == 5000, 1.0, 0.0),
        np.arange(9999.0),
        np.tile([1.0, -1.0], 5000),
        1e139 * np.random.default_rng(0).standard_normal(9999).clip(-1, 1),
        1e-200 * np.random.default_rng(0).standard_normal(9999),
        np.sin(np.arange(9999) * 0.3) > 0,
    ],
)
@pytest.mark.filterwarnings("error")
def test_odd_records__end_in_an_answer(values: Any) -> None:
    found = gp.diagnose(gp.Channel("a", values, 1e4), **(PAIR | {"bearings": BEARINGS[:1]}))
    shares = [each["confidence"] for each in found.hypotheses()]
    assert all(0.0 <= share <= 1.0 for share in shares)


@pytest.mark.slow
def test_clean_record__neither_cage_nor_speed_come_from_what_strong_lines_leave() -> None:
    """A dented outer ring through a rig, without noise: lines of the turns and the cage are hairlines beside BPFO."""
    bearing = {
        "catalogue": "6205", "internal_clearance": "10 um", "groove_ratio": 0.52,
        "damping": {"kind": "hunt-crossley", "value": "100 s/m"},
    }  # fmt: skip
    case = {
        "gravity": ["0 m/s^2", "-9.81 m/s^2"],
        "rotors": {"shaft": {"mass": 8.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": "1797 rpm"}}},
        "bearings": {"shaft": bearing},
        "faults": [{"kind": "outer", "at": "shaft", "depth": "4 um", "arc": "5 deg", "angle": "-90 deg"}],
        "run": {"duration": 2.0, "transient": 0.2, "sampling": 2e4},
    }
    rig = {
        "accelerometers": {"s": {"rotor": "shaft", "kind": "356A02", "angle": "-90 deg"}},
        "collector": {"sampling": "25.6 kHz", "range": "2 V", "bits": 24},
    }
    record = gp.measure(case, rig).channel("s.recorded")
    found = gp.diagnose(record, bearings=["6205"], speed="1797 rpm", quick=True)
    first = found.hypotheses()[0]
    assert (first["name"], first["confidence"] >= TOLD) == ("bearing, outer ring", True)
    assert float(found.ds["shaft_speed"]) == pytest.approx(1797.0 / 60.0, rel=1e-3)
