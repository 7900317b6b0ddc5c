"""What kind of motion a response is: what must not change the verdict, the edges between kinds, and what is refused."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from chaotic_orbits import henon, logistic
from gearplay.nonlinear.kinds import thresholds
from gearplay.nonlinear.kinds.classify import Response, classify
from gearplay.nonlinear.kinds.recurrence import closeness_loss, forecast_error
from gearplay.nonlinear.kinds.repetition import find_order, misfit
from gearplay.nonlinear.kinds.stationarity import block_change
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
N = np.arange(600.0)
FINE = np.array([1e-6, 1e-6])


def pair(turns: float, size: Floats | float = 1.0) -> Floats:
    """Return a rotation by so many turns a period, seen from two sides."""
    angle = 2.0 * np.pi * turns * N
    return np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)


HENON = henon(1.4, 0.3, 0.1, 600, cut=100)
SETTLING = pair(0.5**0.5, np.exp(-N / 1500.0)) + pair(0.3**0.5)
MOTIONS = {
    "at rest": np.ones((600, 2)),
    "periodic": pair(3.0 / 7.0) + 0.3 * pair(2.0 / 7.0),
    "quasi-periodic": pair(0.5**0.5) + 0.2 * pair(0.3**0.5),
    "chaotic": HENON,
    "transient": SETTLING,
}


@pytest.mark.parametrize("kind", MOTIONS)
def test_each_kind(kind: str) -> None:
    """One plain case of each kind, with its order and a reason that ends like a sentence."""
    found = classify(MOTIONS[kind], resolution=FINE)
    assert found.kind == kind
    assert found.order == {"at rest": 1, "periodic": 7}.get(kind)
    assert found.reason.endswith(".")
    assert all(np.isfinite(value) for value in found.evidence.values())


CHANGES: dict[str, Callable[[Floats], tuple[Floats, Any]]] = {
    "scaled": lambda x: (x * [1e9, 1e-9], FINE * [1e9, 1e-9]),
    "mirrored": lambda x: (-x, FINE),
    "shifted": lambda x: (x + np.array([1e3, -50.0]), FINE),
    "permuted": lambda x: (x[:, ::-1], FINE),
    "with a constant": lambda x: (np.column_stack([np.full(len(x), 7.0), x]), np.append(0.1, FINE)),
    "with noise of the resolution": lambda x: (
        np.column_stack([x, 0.1 * np.random.default_rng(0).normal(size=len(x))]),
        np.append(FINE, 0.1),
    ),
    "with one resolution": lambda x: (x, 1e-6),
}


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("kind", MOTIONS)
def test_kind__is_invariant_under_scaling_and_sampling(kind: str, change: str) -> None:
    """Scales, offsets, the order of signals and signals that say nothing leave the verdict and its numbers alone."""
    plain = classify(MOTIONS[kind], resolution=FINE)
    samples, resolution = CHANGES[change](MOTIONS[kind])
    found = classify(samples, resolution=resolution)
    assert (found.kind, found.order) == (plain.kind, plain.order)
    for name in {"loss", "k", "line share"} & set(plain.evidence):
        assert found.evidence[name] == pytest.approx(plain.evidence[name], rel=1e-3, abs=1e-3)


def test_rest_and_a_motion_that_repeats_every_period() -> None:
    """Both stand still in the section; the swing within a period tells them apart."""
    still = 1.0 + 1e-6 * np.random.default_rng(2).normal(size=(300, 2))
    assert classify(still, resolution=FINE).kind == "at rest"
    assert classify(still, resolution=FINE, swing=[0.0, 2e-6]).kind == "at rest"
    found = classify(still, resolution=FINE, swing=[0.0, 1e-3])
    assert (found.kind, found.order, found.evidence["swing"]) == ("periodic", 1, pytest.approx(1000.0))


@pytest.mark.parametrize("order", [2, 5, 8, 12, 36])
def test_orders_with_noise_of_the_resolution(order: int) -> None:
    """The smallest number of periods after which a section repeats is found, up to an eighth of the record."""
    generator = np.random.default_rng(order)
    samples = np.resize(generator.normal(size=order), 300) + 1e-3 * generator.normal(size=300)
    found = classify(samples, resolution=1e-3)
    assert (found.kind, found.order) == ("periodic", order)
    assert found.evidence["misfit"] < 1.5


def test_a_small_torus_is_no_cycle_of_high_order() -> None:
    """A rotation of 20 resolutions comes back to within one of them with some order; that makes no cycle of it."""
    turns = 0.5 * (5.0**0.5 - 1.0)
    rotation = np.cos(2.0 * np.pi * turns * np.arange(2000.0))
    assert misfit(20.0 * rotation[:, None], 233).repeats
    assert classify(rotation, resolution=0.05).kind != "periodic"
    assert classify(np.resize(rotation[:233], 2000), resolution=1e-3).order == 233


def test_a_cycle_seen_too_seldom() -> None:
    """A cycle that the record holds five times is suspected, not stated."""
    found = classify(np.resize(np.random.default_rng(4).normal(size=80), 400), resolution=1e-3)
    assert (found.kind, found.evidence["order"]) == ("undecided", 80)
    assert "5.0 of the 8 cycles" in found.reason


def test_one_burst_is_no_repetition() -> None:
    """A cycle that one sample leaves far within the spread that noise may have does not repeat."""
    samples = np.resize([0.0, 1.0, 3.0], 3000) + 1e-5 * np.sin(np.arange(3000.0) ** 2)
    assert find_order(samples[:, None] / 1e-3) is not None
    samples[1500] += 0.02
    assert find_order(samples[:, None] / 1e-3) is None


def test_a_torus_near_a_simple_ratio_and_a_thin_one() -> None:
    """Five turns of a slow beat are enough, and so is a second frequency of a hundredth of the first motion."""
    assert classify(pair(2.0 / 5.0 + 1.0 / 600.0), resolution=FINE).kind == "quasi-periodic"
    thin = pair(1.0 / 3.0) + 0.01 * pair(0.5**0.5)
    assert classify(thin, resolution=1e-4).kind == "quasi-periodic"
    assert classify(thin, resolution=0.01).kind == "periodic"


def test_a_beat_slower_than_the_record_is_not_called_a_torus() -> None:
    """Half a turn in the record is a drift, one and a half are too few to tell."""
    assert classify(np.cos(np.pi * N / 600.0), resolution=1e-4).kind == "transient"
    assert classify(np.cos(3.0 * np.pi * N / 600.0), resolution=1e-4).kind == "undecided"


@pytest.mark.parametrize(
    ("rate", "periods", "bands"), [(3.58, 800, 4), (3.65, 400, 2), (3.8282, 2000, 1), (3.9, 300, 1)]
)
def test_chaos_in_bands_and_intermittent(rate: float, periods: int, bands: int) -> None:
    """The cycle through the bands does not hide the chaos within, nor laminar phases the bursts."""
    found = classify(logistic(rate, 0.3, periods), resolution=1e-5)
    assert (found.kind, found.evidence["bands"]) == ("chaotic", bands)


@pytest.mark.slow
@pytest.mark.parametrize("time", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("turns", [0.0, 0.5, 0.61803])
def test_slow_decays_onto_a_cycle(time: float, turns: float) -> None:
    """A decay over a fifth to five times the record is seen whether it creeps, alternates or turns."""
    decay = 0.2 * np.exp(-N / (time * 600.0)) * np.cos(2.0 * np.pi * turns * N)
    assert classify(np.resize([0.0, 1.0, 0.4], 600) + decay, resolution=1e-4).kind == "transient"


def test_settled_halves() -> None:
    """A motion that ends, or begins, as a cycle has not settled, and the reason says where."""
    later = np.where(N < 400, HENON[:, 0], np.resize([0.0, 1.0], 600))
    assert "last quarter repeats with order 2" in classify(later, resolution=1e-6).reason
    assert "first quarter repeats with order 2" in classify(later[::-1], resolution=1e-6).reason
    assert classify(later, resolution=1e-6).kind == classify(later[::-1], resolution=1e-6).kind == "transient"


def test_a_start_far_from_a_cycle_that_hardly_attracts() -> None:
    """The decay is no exponential: neither a torus nor chaos is claimed."""
    assert classify(logistic(3.449, 0.3, 500, cut=0), resolution=1e-6).kind in ("transient", "undecided")


def test_chaos_whose_size_jumps() -> None:
    """Chaos fluctuates and is no transient; of another size from the middle on it is."""
    assert classify(HENON, resolution=FINE).kind == "chaotic"
    assert classify(HENON * np.where(N < 300, 1.0, 0.5)[:, None], resolution=FINE).kind == "transient"


def test_noise_is_not_chaos() -> None:
    """Noise above the stated resolution is left undecided, and so is motion of a few resolutions."""
    generator = np.random.default_rng(0)
    assert classify(generator.normal(size=(600, 2)), resolution=0.01).kind == "undecided"
    found = classify(np.resize([0.0, 1.0], 600) + 0.08 * generator.normal(size=600), resolution=0.01)
    assert found.kind == "undecided"
    assert "noise" in found.reason
    assert "finer resolution" in classify(3.0 * generator.normal(size=600), resolution=1.0).reason


def test_classification__undersampled_chaos_is_chaos_given_its_exponent() -> None:
    """Every twelfth step of a logistic map, whose neighbours part by a factor of two a step, looks like noise."""
    seldom = logistic(4.0 - 1e-9, 0.3, 12 * 600)[::12]
    alone = classify(seldom, resolution=1e-5)
    assert (alone.kind, "noise" in alone.reason) == ("undecided", True)
    assert classify(seldom, resolution=1e-5, exponent=(12.0 * np.log(2.0), 0.1)).kind == "chaotic"
    assert classify(seldom, resolution=1e-5, exponent=(-0.5, 0.01)).kind == "undecided"


def test_a_small_signal_that_does_not_repeat_beside_a_large_cycle() -> None:
    """What decides is the signal that moves about repetition, however small beside one that repeats exactly."""
    cycle = np.resize([0.0, 1.0, 3.0], 600)
    for small, kind in (
        (np.cos(N * 2.0**0.5), "quasi-periodic"),
        (HENON[:, 0], "chaotic"),
        (0.0 * N, "periodic"),
    ):
        both = np.column_stack([cycle, 2.5e-5 * small])
        assert classify(both, resolution=1e-6).kind == kind


def verdict(samples: Floats, value: float, error: float = 1e-3) -> Response:
    return classify(samples, resolution=FINE, exponent=(value, error))


def test_the_exponent_has_a_voice() -> None:
    """It confirms what it agrees with, and makes undecided what it contradicts; a zero within its error is zero."""
    assert verdict(MOTIONS["chaotic"], 0.42).kind == "chaotic"
    assert verdict(MOTIONS["chaotic"], 0.0).kind == "undecided"
    assert verdict(MOTIONS["quasi-periodic"], 0.005).kind == "quasi-periodic"
    assert verdict(MOTIONS["quasi-periodic"], 0.1, 0.05).kind == "quasi-periodic"
    assert verdict(MOTIONS["quasi-periodic"], 0.1).kind == "undecided"
    assert verdict(MOTIONS["quasi-periodic"], -0.1).kind == "undecided"
    assert verdict(MOTIONS["periodic"], -0.1).kind == "periodic"
    found = verdict(MOTIONS["periodic"], 0.1)
    assert found.kind == "undecided"
    assert "exponent 0.1 ± 0.002 per period (95 %)" in found.reason


def test_closeness_is_kept_on_a_torus_and_lost_in_chaos() -> None:
    """States of a torus keep their closeness to a hundredth, states of the Henon map lose all of it."""
    regular = pair(0.5**0.5)
    assert closeness_loss(regular / regular.std(axis=0), 1e-6) == pytest.approx(0.0, abs=0.01)
    orbit = henon(1.4, 0.3, 0.1, 2000)
    scaled = (orbit - orbit.mean(axis=0)) / orbit.std(axis=0)
    assert closeness_loss(scaled, 1e-6) == pytest.approx(1.0, abs=0.06)
    assert np.isnan(closeness_loss(scaled, 1.0))  # no two states are closer than what means nothing


def test_forecast_error__separates_chaos_from_white_and_coloured_noise() -> None:
    orbit, noise = henon(1.4, 0.3, 0.1, 2000), np.random.default_rng(0).normal(size=(2000, 2))
    assert forecast_error(orbit) < 0.05
    assert forecast_error(noise) == pytest.approx(1.0, abs=0.15)
    for i in range(1, len(noise)):
        noise[i] += 0.9 * noise[i - 1]
    assert forecast_error(noise) > 0.9


def test_a_torus_that_saturates_keeps_its_closeness() -> None:
    """One signal that rests at two levels most of the time takes a wider delay to be seen as the torus that it is."""
    angle = 2.0 * np.pi * 0.5**0.5 * N
    flat = np.tanh(2.0 * (np.cos(angle) + np.cos(0.37 * angle)))
    assert closeness_loss((flat / flat.std())[:, None], 1e-6) < 0.2
    assert classify(flat, resolution=1e-6).kind == "quasi-periodic"


def test_block_change_has_the_distribution_of_students_t() -> None:
    """The best of 11 steps and a line, of 3 features of noise, exceeds the 1 % point of t in 4 to 36 %."""
    from scipy.special import stdtrit

    generator, limit = np.random.default_rng(3), float(stdtrit(14.0, 0.995))
    found = [block_change(generator.normal(size=(321, 1))) for _ in range(500)]
    assert 0.04 < np.mean(np.array(found) > limit) < 0.36


@pytest.mark.parametrize(
    ("samples", "arguments", "words"),
    [
        (np.zeros((99, 2)), {"resolution": 1.0}, "at least 100 periods"),
        (np.full((200, 2), np.nan), {"resolution": 1.0}, "period 0, 200 in all"),
        (np.zeros((200, 2)), {"resolution": 0.0}, "above 0"),
        (np.zeros((200, 2)), {"resolution": [1.0, -1.0]}, "above 0"),
        (np.zeros((200, 2)), {"resolution": np.inf}, "finite"),
    ],
)
def test_refusals(samples: Floats, arguments: dict[str, Any], words: str) -> None:
    """What cannot be judged is refused in words, not by a verdict."""
    with pytest.raises(InputError, match=words):
        classify(samples, **arguments)


def test_thresholds_are_those_of_the_documentation() -> None:
    """At most ten, each in the table of docs/nonlinear.md with its value, and each stating a unit."""
    page = (Path(__file__).parents[2] / "docs" / "nonlinear.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `([A-Z_]+)` \| ([\d.]+) \|", page, re.MULTILINE))
    values = {name: value for name, value in vars(thresholds).items() if name.isupper()}
    assert {name: float(value) for name, value in rows.items()} == values
    assert len(values) <= 10
    source = Path(thresholds.__file__).read_text(encoding="utf-8")
    assert all(re.search(rf'^{name}: Final = .*\n"""\[\w', source, re.MULTILINE) for name in values)
