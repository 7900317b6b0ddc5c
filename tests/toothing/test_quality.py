"""Tolerances of ISO 1328-1 and deviations drawn within them."""

import math

import numpy as np
import pytest

from depth import sized
from drawn_pairs import drawn
from gearplay.toothing.quality import (
    cumulative_deviation,
    draw_deviations,
    gear_tolerances,
    runout,
    single_deviation,
    tolerances,
)

PROFILE = np.linspace(0.0, 1.0, 401)


@pytest.mark.parametrize(
    ("diameter", "module", "quality", "printed"),
    [
        (0.06, 3e-3, 7, (12.52, 36.96056, 10.52, 13.3, 16.95761, 33.26451)),
        (0.24, 4e-3, 5, (6.84, 23.80056, 5.84, 7.2, 9.27068, 21.42051)),
    ],
)
def test_tolerances(diameter: float, module: float, quality: int, printed: tuple[float, ...]) -> None:
    """f_p, F_p, f_Ha, f_fa, F_a, F_r [um]."""
    found = tolerances(diameter=diameter, module=module, quality=quality)
    values = (
        found.single_pitch, found.cumulative_pitch, found.profile_slope, found.profile_form, found.profile, found.runout,
    )  # fmt: skip
    assert [1e6 * value for value in values] == pytest.approx(printed, abs=5.1e-6)


def test_classes_differ_by_the_root_of_two() -> None:
    finer, coarser = (tolerances(diameter=0.1, module=2e-3, quality=quality) for quality in (8, 10))
    assert coarser.cumulative_pitch == pytest.approx(2.0 * finer.cumulative_pitch, rel=1e-14)


def test_drawn_gears_are_within_their_class() -> None:
    """1000 gears: pitch deviations at half of their tolerances at least, none beyond; profiles, runout."""
    rng = np.random.default_rng(1)
    for _ in range(sized(1000, 100)):
        beta, internal, quality = rng.uniform(0.0, 30.0), bool(rng.integers(2)), int(rng.integers(1, 12))
        module, teeth = 1e-3 * rng.uniform(0.5, 20.0), int(rng.integers(5, 200))
        gear = drawn(module, teeth, beta=beta, alpha=rng.uniform(17.5, 25.0), internal=internal)
        allowed = gear_tolerances(gear, quality)
        found = draw_deviations(gear, quality, rng)
        for flank in (found.left, found.right):
            assert flank.pitch.shape == (teeth,)
            assert flank.pitch.mean() == pytest.approx(0.0, abs=1e-18)
            assert 0.5 - 1e-12 <= single_deviation(flank.pitch) / allowed.single_pitch <= 1.0 + 1e-12
            assert 0.5 - 1e-12 <= cumulative_deviation(flank.pitch) / allowed.cumulative_pitch <= 1.0 + 1e-12
            profile = flank.profile(PROFILE)
            line = np.polynomial.Polynomial.fit(PROFILE, profile, 1).convert()
            assert abs(line.coef[1]) <= allowed.profile_slope
            assert np.ptp(profile - line(PROFILE)) == pytest.approx(0.5 * allowed.profile_form, rel=1e-4)
            assert np.ptp(profile) <= allowed.profile
        assert runout(gear, found.left.pitch, found.right.pitch) <= allowed.runout


def test_drawn_pitch_deviations_are_met_exactly() -> None:
    """Ranges of 60 teeth are not shortened: the drawn shares come out, to rounding, for four uniform numbers each."""
    gear, wanted = drawn(4e-3, 60), []
    allowed = gear_tolerances(gear, 6)
    for seed in range(sized(200, 20)):
        shares = np.random.default_rng(seed).uniform(0.0, 1.0, (2, 2))
        found = draw_deviations(gear, 6, np.random.default_rng(seed))
        for flank, (cumulative, single) in zip((found.left, found.right), shares, strict=True):
            got = cumulative_deviation(flank.pitch) / allowed.cumulative_pitch
            wanted.append(abs(got - 0.5 * (1.0 + cumulative)) < 1e-13)
            got = single_deviation(flank.pitch) / allowed.single_pitch
            wanted.append(abs(got - 0.5 * (1.0 + single)) < 1e-12)
    assert np.mean(wanted) > 0.95  # a draw in a hundred has too much runout at its shares


def test_drawn_deviations_are_uniform() -> None:
    """Kolmogorov-Smirnov distance of both pitch deviations and the slope from a uniform law, 1 % level."""
    gear, count = drawn(2e-3, 120), sized(1000, 200)
    allowed, rng = gear_tolerances(gear, 8), np.random.default_rng(7)
    found = [draw_deviations(gear, 8, rng).left for _ in range(count)]
    for values, low, high in (
        ([cumulative_deviation(each.pitch) for each in found], 0.5, allowed.cumulative_pitch),
        ([single_deviation(each.pitch) for each in found], 0.5, allowed.single_pitch),
        ([each.slope for each in found], -1.0, allowed.profile_slope),
    ):
        at = (np.sort(values) / high - low) / (1.0 - low)
        steps = np.arange(count + 1) / count
        assert max(np.max(at - steps[:-1]), np.max(steps[1:] - at)) < 1.63 / math.sqrt(count)


@pytest.mark.parametrize("internal", [False, True])
def test_runout_of_an_eccentric_gear(internal: bool) -> None:
    """Flanks moved by e along their normals: the balls move by e, the runout is 2 e."""
    gear, offset = drawn(2e-3, 40, internal=internal), 1e-5
    side, tangent = (-1 if internal else 1), math.tan(gear.transverse_angle)
    tooth = 2.0 * math.pi * np.arange(40) / 40 - side * math.pi / 40  # a space lies in the direction of e
    at_left, at_right = tooth + side * math.pi / 80, tooth - side * math.pi / 80
    left = offset * (-np.sin(at_left) + tangent * np.cos(at_left))
    right = offset * (-np.sin(at_right) - tangent * np.cos(at_right))
    assert runout(gear, left, right) == pytest.approx(2.0 * offset, rel=1e-13)


def test_too_few_teeth() -> None:
    with pytest.raises(ValueError, match="begins at 5 teeth, not 4"):
        draw_deviations(drawn(2e-3, 4), 7, np.random.default_rng(1))
