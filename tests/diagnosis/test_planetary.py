"""Diagnosis of planetary sets: synthetic records in ten conditions, lines, causes to simulate."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from depth import FULL
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.hypotheses import HEALTHY, TOLD
from gearplay.diagnosis.machine import Machine, machine_of_case
from gearplay.diagnosis.planetary_set import PlanetarySet
from gearplay.diagnosis.result import Diagnosis
from gearplay.diagnosis.suspects import suspects_of
from planetary_records import CASE, CONDITIONS, NAMES, RATE, planetary_record, with_bearings


def diagnosed(condition: str, seed: int, **more: Any) -> Diagnosis:
    channel, _ = planetary_record(condition, seed, **more)
    return gp.diagnose(channel, case=with_bearings(), quick=True)


def stage() -> tuple[Machine, PlanetarySet]:
    machine = machine_of_case(gp.load_case(CASE))
    return machine, machine.sets[0]


@pytest.mark.parametrize("condition", ["planet tooth", "worn pin", "eccentric planet"])
def test_conditions__one_record_of_each_kind(condition: str) -> None:
    found = diagnosed(condition, 3)
    assert (found.hypotheses()[0]["name"], found.told) == (NAMES[condition], True)


@pytest.mark.slow
def test_conditions__first_in_ninety_per_cent_and_never_wrong_with_the_stated_confidence() -> None:
    every = [
        (condition, diagnosed(condition, seed).hypotheses()[0])
        for seed in range(3000, 3002 if FULL else 3001)
        for condition in CONDITIONS
    ]
    wrong = [(condition, first) for condition, first in every if first["name"] != NAMES[condition]]
    assert len(wrong) <= 0.1 * len(every)
    assert all(first["confidence"] < TOLD for _, first in wrong), wrong


HELD: dict[str, Any] = {
    "planetary.stage.sun.floating": False,
    "planetary.stage.pin": None,
    "planetary.stage.support": {"stiffness": ["3e8 N/m"] * 2, "damping": ["2e3 N s/m"] * 2},
    "planetary.stage.ring.support": {"stiffness": ["2e8 N/m"] * 2, "damping": ["5e3 N s/m"] * 2},
}
RIG = {
    "accelerometers": {"ring": {"kind": "352C33", "rotor": "stage.ring", "range": "5 m/s^2"}},
    "collector": {"sampling": "12.8 kHz", "bits": 24},
}


@pytest.mark.deep
@pytest.mark.compiled
def test_pin_off_its_place__is_told_from_an_eccentric_carrier_by_simulated_records() -> None:
    case = gp.replace(CASE, HELD)
    off = {"planetary.stage.pin_errors": [{"planet": 2, "tangential": "100 um"}]}
    faster = {"planetary.stage.sun.drive.speed": "808 rpm"}
    record = gp.measure(gp.replace(case, {**off, **faster}), RIG, duration=7.0, member=40, seed=77)
    found = gp.diagnose(gp.Record((record.channels[-1],), "bench"), case=case, rig=RIG, members=2)
    assert (found.hypotheses()[0]["name"], found.told) == ("uneven planets of stage", True)
    (cause,) = [each for each in found.checks() if each["alike"]]
    assert cause["name"] == "pin of a planet of stage off its place"
    assert 60.0 < float(cause["level"].split()[1]) < 160.0


@pytest.mark.slow
def test_weak_conditions__a_wrong_name_is_never_stated() -> None:
    for condition in CONDITIONS:
        first = diagnosed(condition, 4000, severity=0.4, noise=0.3).hypotheses()[0]
        assert first["name"] in (NAMES[condition], HEALTHY) or first["confidence"] < TOLD, (condition, first)


def test_speed__is_found_from_the_lines_that_passing_planets_leave() -> None:
    """91 mesh periods a turn of the carrier are no multiple of three planets: hardly any line at the mesh frequency itself."""
    channel, f = planetary_record("healthy", 5)
    found = gp.diagnose(channel, case=with_bearings(), quick=True)
    assert float(found.ds["shaft_speed"]) == pytest.approx(f, rel=1e-5)
    spectrum = {line["name"]: line for line in found.lines("spectrum")}
    assert spectrum["mesh stage - carrier of stage"]["amplitude"] > 10.0 * spectrum["mesh stage"]["amplitude"]


def test_which_planet__is_said_to_stay_open() -> None:
    found = diagnosed("planet tooth", 3)
    assert "Which planet it is cannot be told" in " ".join(found.cannot_be_told)
    assert "of which planet, cannot be told" in " ".join(diagnosed("worn pin", 3).cannot_be_told)


def test_short_record__leaves_eccentric_gears_open() -> None:
    channel, _ = planetary_record("eccentric planet", 3)
    part = gp.Channel("ring", channel.values[: int(5.0 * RATE)], RATE, "m/s^2")
    found = gp.diagnose(part, case=CASE, quick=True)
    assert "An eccentric sun of stage cannot be told" in " ".join(found.cannot_be_told)
    assert "eccentric stage.sun" not in [each["name"] for each in found.hypotheses()]


def test_lines__of_passing_planets_by_summing_them() -> None:
    """Of N like planets seen through any window the lines with h z + n a multiple of N remain; one alone fills all."""
    _, own = stage()
    size = 4096
    turn = np.arange(size) / size
    assert (own.planets, own.teeth) == (3, 91)

    def passing(shares: tuple[float, ...]) -> Any:
        x = np.zeros(size)
        for i, share in enumerate(shares):
            angle = 2 * np.pi * (turn + i / own.planets)
            x += share * np.exp(np.cos(angle)) * np.cos(own.teeth * angle)
        return np.abs(np.fft.rfft(x)) / size

    alike, uneven = (
        np.rint(np.array(orders) / own.carrier).astype(int) for orders in (own.alike(1), own.uneven(1))
    )
    assert np.min(passing((1.0, 1.0, 1.0))[alike]) > 0.01
    assert np.max(passing((1.0, 1.0, 1.0))[uneven]) < 1e-12
    assert np.min(passing((0.5, 1.0, 1.0))[uneven]) > 1e-4
    assert sorted([*alike, *uneven]) == list(range(91 - 3, 91 + 4))


@pytest.mark.parametrize(
    ("degrees", "silent"), [((0, 110, 240), False), ((0, 70, 180, 250), True), ((0, 120, 240), True)]
)
def test_lines__of_planets_at_any_angles_by_summing_them(degrees: tuple[int, ...], silent: bool) -> None:
    """Waves of like planets, each delayed by its angle, against the sum at each order; opposite planets leave no odd one."""
    own = PlanetarySet("a", tuple(np.radians(degrees)), 92, 0.2, 0.8, 0.5, (0, 1, 2), 0)
    size = 3600
    wave = np.exp(np.cos(2 * np.pi * np.arange(size) / size)) * np.cos(
        own.teeth * 2 * np.pi * np.arange(size) / size
    )
    one = np.abs(np.fft.rfft(wave))
    every = np.abs(np.fft.rfft(sum(np.roll(wave, -10 * angle) for angle in degrees)))
    for n in range(-4, 5):
        m = own.teeth + n
        assert own.sum_at(m) == pytest.approx(every[m] / one[m] / len(degrees), abs=1e-9)
    assert bool(own.uneven(1)) is silent


UNEQUAL = (0.0, 110.0, 240.0)


def unequal(condition: str, seed: int) -> Diagnosis:
    """Return the diagnosis of a record of three planets at unequal angles, with the case that has them."""
    channel, _ = planetary_record(condition, seed, angles=tuple(np.radians(UNEQUAL)))
    case = gp.replace(
        with_bearings(), {"planetary.stage.planets.angles": [f"{each} deg" for each in UNEQUAL]}
    )
    return gp.diagnose(channel, case=case, quick=True)


def test_unequal_angles__a_tooth_of_the_ring_as_each_planet_passes() -> None:
    found = unequal("ring tooth", 3)
    assert found.causes == [NAMES["ring tooth"]]
    open_ones = "Uneven planets of stage cannot be told: even ones at these angles leave lines at every turn of the carrier."
    assert open_ones in found.cannot_be_told


@pytest.mark.slow
@pytest.mark.parametrize("condition", ["sun tooth", "planet tooth", "eccentric sun", "eccentric planet"])
def test_unequal_angles__the_cause_is_stated(condition: str) -> None:
    assert unequal(condition, 3).causes == [NAMES[condition]]


def test_lines__of_an_eccentric_sun_and_planet_by_summing_them() -> None:
    """Against the carrier the sun turns 91/17 times as often, a planet 91/37: lines at the orders given, no others."""
    _, own = stage()
    turns = 17 * 37
    size = 1 << 18
    carrier = 2 * np.pi * turns * np.arange(size) / size

    def lines(swing: Any) -> set[int]:
        x = np.zeros(size)
        for i in range(own.planets):
            angle = carrier + 2 * np.pi * i / own.planets
            x += swing(i, angle) * (1.0 + np.cos(angle)) * np.cos(own.teeth * angle)
        amplitude = np.abs(np.fft.rfft(x)) / size
        return set(np.flatnonzero(amplitude > 1e-6).tolist())

    def places(orders: list[float]) -> set[int]:
        return {round(order / own.carrier * turns) for order in orders}

    sun, planet = own.sun / own.carrier, own.planet / own.carrier
    of_sun = lines(lambda i, _: np.cos(sun * carrier - 2 * np.pi * i / own.planets))
    of_planet = lines(lambda i, _: np.cos(planet * carrier) if i == 0 else 0.0)
    assert of_sun <= places(own.eccentric_sun(1))
    assert of_planet <= places(own.eccentric_planet(1))
    assert len(of_sun) >= 2
    assert len(of_planet) == 6


def test_ring_that_turns__has_no_event_at_a_place() -> None:
    """With the sun standing the teeth of the ring pass the sensor: its set has lines, its ring no hypothesis."""
    case = gp.replace(CASE, {"planetary.stage.sun.drive": None, "planetary.stage.sun.fixed": True,
                             "planetary.stage.ring.fixed": False,
                             "planetary.stage.ring.drive": {"kind": "speed", "speed": "300 rpm"}})  # fmt: skip
    (own,) = machine_of_case(case).sets
    assert own.teeth == 17
    noise = gp.Channel("a", np.random.default_rng(1).standard_normal(100_000), 8000.0, "m/s^2")
    found = gp.diagnose(noise, case=case, quick=True)
    assert "damaged tooth on stage.ring" not in [each["name"] for each in found.hypotheses()]


PAIRS = {
    "planetary.stage.contact": "pairs",
    "planetary.stage.sun_planet": None,
    "planetary.stage.planet_ring": None,
    "planetary.stage.stiffness": {"kind": "teeth", "method": "iso6336"},
    **{f"planetary.stage.{each}.facewidth": "40 mm" for each in ("sun", "planets", "ring")},
}


@pytest.mark.parametrize(
    ("kind", "place", "names"),
    [
        ("tooth", 0, ["crack of a tooth of stage.sun", "spall on a tooth of stage.sun"]),
        ("tooth", 1, ["crack of a tooth of stage.planet", "spall on a tooth of stage.planet"]),
        ("tooth", 2, ["spall on a tooth of stage.ring"]),
        ("eccentric", 0, ["a"]),
        ("eccentric", 1, ["a"]),
        ("planets", 0, ["pin of a planet of stage off its place", "eccentric stage.carrier"]),
    ],
)
def test_causes__of_each_hypothesis_are_changes_that_the_case_takes(
    kind: str, place: int, names: list[str]
) -> None:
    case = gp.replace(CASE, PAIRS)
    found, said = suspects_of(case, machine_of_case(case), [Hypothesis("a", kind, (), 1.0, 1.0, place)], {})
    assert [each.name for each in found] == [*names, "worn flanks of stage", "worn pins of stage"]
    assert said == []


def test_causes__of_a_planet_are_of_one_planet_and_add_to_what_is_there() -> None:
    case = gp.replace(CASE, {"planetary.stage.pin_errors": [{"planet": 2, "tangential": "10 um"}]})
    (pin, carrier, *_), _ = suspects_of(
        case, machine_of_case(case), [Hypothesis("a", "planets", (), 1.0, 1.0, 0)], {}
    )
    worse = gp.replace(case, pin.levels[0]).planetary["stage"].pin_errors
    assert [each.tangential for each in worse] == pytest.approx([25e-6, 10e-6, 0.0])
    # An eccentric carrier moves all pins alike, here along the first one.
    off = gp.replace(case, carrier.levels[0]).planetary["stage"].pin_errors
    for each, angle in zip(off, (0.0, 2 * np.pi / 3, 4 * np.pi / 3), strict=True):
        across = each.tangential - (10e-6 if each.planet == 2 else 0.0)
        moved = (each.radial + 1j * across) * np.exp(1j * angle)
        assert abs(moved - 25e-6) < 1e-12


def test_teeth__without_pairs_are_said_not_to_be_simulated() -> None:
    case = gp.load_case(CASE)
    _, said = suspects_of(case, machine_of_case(case), [Hypothesis("damage", "tooth", (), 1.0, 1.0, 1)], {})
    assert said == ['damage cannot be simulated: faults of single teeth need meshes with contact = "pairs".']
