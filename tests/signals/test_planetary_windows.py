"""Contacts of one tooth in planetary sets, and tooth-by-tooth averages of planets and sun."""

import math

import numpy as np
import pytest

import gearplay as gp
from gearplay.signals import event_periods, planetary_average

RPM = 2.0 * math.pi / 60.0
# Mesh frequency [Hz], sun tooth, planet's flank, ring tooth, hunting tooth of sun and planet [s]: computed independently.
PRINTED = {
    (17, 37, 91, 3, 800): (190.987654, 0.029670, 0.193730, 0.158824, 3.293407),
    (20, 20, 60, 3, 1500): (375.0, 0.017778, 0.053333, 0.053333, 0.053333),
    (24, 30, 84, 4, 1200): (373.333333, 0.016071, 0.080357, 0.056250, 0.321429),
}


@pytest.mark.parametrize("machine", PRINTED)
def test_events__printed(machine: tuple[int, int, int, int, int]) -> None:
    *teeth, rpm = machine
    found = event_periods(*teeth, rpm * RPM)
    values = (found.mesh_frequency, found.sun, found.planet, found.ring, found.hunting)
    assert values == pytest.approx(PRINTED[machine], abs=1e-6)


def test_events__against_the_characteristic_frequencies_of_a_case() -> None:
    from gearplay.parts.planetary.frequencies import set_frequencies

    case = gp.load_case("planetary-reducer")
    table, known = case.planetary["stage"], set_frequencies(case, "stage")
    sun = known.mesh / table.sun.teeth + known.carrier
    found = event_periods(
        table.sun.teeth, table.planets.teeth, table.ring.teeth, table.planets.count, 2 * math.pi * sun
    )
    values = (1 / found.sun, 1 / found.planet, 1 / found.ring, found.mesh_frequency)
    assert values == pytest.approx((known.sun, known.planet, known.ring, known.mesh), rel=1e-12)


SUN, PLANET, RING, COUNT, CARRIER, RATE = 17, 37, 91, 3, 2.0, 8000.0


def passing(seconds: float = 40.0) -> tuple[gp.Channel, list[np.ndarray]]:
    """Return what a sensor on the ring records while three planets pass, each heard near it only, and their signals' phases."""
    t = np.arange(int(RATE * seconds)) / RATE
    carrier = 2 * np.pi * CARRIER * t
    x, phases = np.zeros(t.size), []
    for k in range(COUNT):
        place = carrier - 2 * np.pi * k / COUNT
        near = np.maximum(0.0, np.cos(place)) ** 40
        phase = place * RING / PLANET  # planet relative to the carrier
        x += near * np.cos((k + 2) * phase + k)
        phases.append(phase)
    return gp.Channel("acc", x, RATE, "m/s^2"), phases


@pytest.mark.parametrize("number", [1, 2, 3])
def test_windows__tell_planets_apart(number: int) -> None:
    """Planet k carries the order k + 1 of its own turn; its average holds that one alone, as high as its window lets it pass."""
    channel, _ = passing()
    found = planetary_average(channel, 2 * np.pi * CARRIER, SUN, PLANET, RING, COUNT, number=number)
    transform = 2.0 * np.abs(np.fft.rfft(found.average)) / found.average.size
    assert int(np.argmax(transform)) == number + 1
    others = np.delete(transform, number + 1)
    assert np.max(others) < 0.02 * transform[number + 1]
    assert transform[number + 1] == pytest.approx(1.0, abs=0.02)
    assert found.periods >= 78


def test_windows__of_the_sun() -> None:
    t = np.arange(int(RATE * 40)) / RATE
    turn = 2 * np.pi * CARRIER * t * RING / SUN  # sun relative to the carrier
    found = planetary_average(gp.Channel("acc", np.cos(5 * turn), RATE), 2 * np.pi * CARRIER, SUN, PLANET, RING, COUNT,
                              gear="sun")  # fmt: skip
    np.testing.assert_allclose(found.average, np.cos(5 * found.angle), atol=2e-3)
    assert found.residual_share < 1e-3


def test_windows__find_the_damaged_tooth() -> None:
    channel, phases = passing()
    tooth = 2 * np.pi * 11.5 / PLANET
    off = (phases[0] - tooth + np.pi) % (2 * np.pi) - np.pi
    near = np.maximum(0.0, np.cos(2 * np.pi * CARRIER * channel.time)) ** 40
    hit = gp.Channel("acc", channel.values + 3.0 * near * np.exp(-((off * PLANET / 1.5) ** 2)), RATE)
    found, before = (
        planetary_average(each, 2 * np.pi * CARRIER, SUN, PLANET, RING, COUNT) for each in (hit, channel)
    )
    at = found.angle[int(np.argmax(found.average - before.average))]
    assert int(at * PLANET / (2 * np.pi)) == 11


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gear": "ring"}, "must be a gear that the window follows"),
        ({"number": 4}, "whole number from 1 to 3"),
        ({"teeth": 0}, "whole number from 1"),
        ({"sun": 20, "planet": 20, "ring": 60, "teeth": 2}, "must be 20 or more, by which the planet steps"),
        ({"ring": 10}, "more teeth than the sun"),
        ({"carrier": 0.0}, "greater than 0 rad/s"),
        ({"place": 1e300}, "must be a number from"),
        ({"place": np.nan}, "must be a number from"),
        ({"planets": 0}, "whole number from 1"),
        ({"carrier": 2 * np.pi * 1.5}, "must last until every tooth has passed"),
    ],
)
def test_refusals(change: dict[str, object], words: str) -> None:
    channel, _ = passing(10.0)
    given = {
        "carrier": 2 * np.pi * CARRIER,
        "sun": SUN,
        "planet": PLANET,
        "ring": RING,
        "planets": COUNT,
    } | change
    with pytest.raises(gp.InputError, match=words) as caught:
        planetary_average(channel, **given)  # type: ignore[arg-type]
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize(
    "given", [(17, 37, 91, 3, -1.0), (17, 37, 91, 3, math.nan), (2, 37, 91, 3, 1.0), (91, 37, 17, 3, 1.0)]
)
def test_events__refusals(given: tuple[int, int, int, int, float]) -> None:
    with pytest.raises(gp.InputError):
        event_periods(*given)
