"""Geometry of random pairs against thicknesses at the base circles, and of one tooth against its outline."""

import math

import numpy as np
import pytest

from drawn_pairs import drawn, paired
from gearplay.toothing.gear import DrawnGear, inv, inverse_involute
from gearplay.toothing.pair import GearPair
from gearplay.toothing.potential_energy import fillet


def some_gear(
    rng: np.random.Generator, teeth: int, alpha: float, beta: float, *, internal: bool = False
) -> DrawnGear:
    return drawn(
        2.0,
        teeth,
        float(rng.uniform(-0.2, 0.7)),
        alpha=alpha,
        beta=beta,
        internal=internal,
        thickness_change=float(rng.uniform(-0.1, 0.02)),
    )


@pytest.mark.parametrize("internal", [False, True])
def test_backlash_is_base_pitch_less_thicknesses(internal: bool) -> None:
    """p_b - 2 r_b1 sigma_1 - 2 r_b2 sigma_2 + 2 c0 inv alpha_w; of a ring 2 r_b2 sigma_2 - 2 r_b1 sigma_1 - 2 c0 inv alpha_w."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        alpha, beta = float(rng.uniform(15.0, 25.0)), float(rng.choice([0.0, 8.0, 20.0]))
        one = some_gear(rng, int(rng.integers(15, 40)), alpha, beta)
        other = some_gear(rng, int(rng.integers(60, 120)), alpha, beta, internal=internal)
        pair = paired(one, other)
        if math.isnan(pair.distance):
            continue
        pair = pair.at(pair.distance + float(rng.uniform(-0.1, 0.1)))
        widths = 2.0 * one.base_radius * one.half_angle, 2.0 * other.base_radius * other.half_angle
        opened = 2.0 * pair.least_distance * inv(math.acos(pair.least_distance / pair.distance))
        expected = widths[1] - widths[0] - opened if internal else one.base_pitch - sum(widths) + opened
        assert pair.backlash == pytest.approx(expected, abs=1e-12)
        assert pair.at(pair.tight_distance).backlash == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("internal", [False, True])
def test_thickness_at_the_reference_circle(internal: bool) -> None:
    """Half angle there times the diameter is the transverse thickness of the tooth, of a ring that of the space."""
    rng = np.random.default_rng(4)
    for beta in (0.0, 15.0):
        gear = some_gear(rng, 61, 20.0, beta, internal=internal)
        across = 2.0 * gear.reference_radius * gear.half_angle_at(gear.reference_radius)
        thickness = math.pi * gear.transverse_module - across if internal else across
        assert thickness * math.cos(gear.helix_angle) == pytest.approx(gear.normal_thickness, rel=1e-12)
        thicker = (
            drawn(2.0, 61, 0.3, internal=internal).normal_thickness
            - drawn(2.0, 61, internal=internal).normal_thickness
        )
        assert thicker == pytest.approx(
            (-1.0 if internal else 1.0) * 2.0 * 0.3 * 2.0 * math.tan(math.radians(20.0))
        )


def test_inverse_involute() -> None:
    for angle in (1e-2, 0.1, 0.35, 0.8, 1.4):
        assert inverse_involute(inv(angle)) == pytest.approx(angle, rel=1e-10)
    assert inverse_involute(0.0) == 0.0
    assert math.isnan(inverse_involute(-1e-3))


def test_tips_and_roots_of_a_shifted_ring() -> None:
    """A positive shift moves tip and root circles of a ring outwards, away from its axis."""
    plain, moved = drawn(3.0, 60, internal=True), drawn(3.0, 60, 0.5, internal=True)
    assert moved.tip - plain.tip == pytest.approx(1.5)
    assert moved.root - plain.root == pytest.approx(1.5)
    assert plain.tip < plain.reference_radius < plain.root


def test_sliding_is_the_difference_of_both_flanks() -> None:
    """At a place rho from T1 the flanks move across at omega_1 rho and omega_2 (T2's way): equal at the pitch point."""
    for internal in (False, True):
        pair = paired(drawn(4.0, 21), drawn(4.0, 63, internal=internal))
        places = np.array([2.0, 9.0, 17.0])
        ratio = 21 / 63
        across = ratio * (pair.base_tangent + places) if internal else ratio * (pair.base_tangent - places)
        expected = places - across
        assert pair.sliding(places) == pytest.approx(expected, rel=1e-12)
        assert float(pair.sliding(np.array(pair.pitch_place))) == pytest.approx(0.0, abs=1e-12)


def test_overlap_ratio() -> None:
    """Facewidth times sin(beta) over pi m_n."""
    gears = [drawn(4.0, z, beta=12.0, facewidth=30.0 + z) for z in (20, 60)]
    pair = GearPair(*gears, 170.0)
    assert pair.overlap_ratio == pytest.approx(
        50.0 * math.sin(math.radians(12.0)) / (math.pi * 4.0), rel=1e-12
    )


@pytest.mark.parametrize("beta", [0.0, 21.0])
def test_fillet_joins_root_circle_and_involute(beta: float) -> None:
    """The trochoid starts on the root circle, tangent to it, and ends on the involute with its direction."""
    gear = drawn(4.5, 27, 0.23, beta=beta, thickness_change=-0.15)
    gamma = np.array([0.5 * math.pi, 0.5 * math.pi - 1e-6, gear.pressure_angle + 1e-6, gear.pressure_angle])
    x, y = fillet(gear, gamma)
    radius, half = np.hypot(x, y), np.arctan2(x, y)
    assert radius[0] == pytest.approx(gear.root, rel=1e-12)
    assert abs(radius[1] - radius[0]) < 1e-3 * abs(radius[0] * (half[1] - half[0]))
    assert half[3] == pytest.approx(gear.half_angle_at(float(radius[3])), abs=1e-12)
    slope = (half[3] - half[2]) / (radius[3] - radius[2])
    step = 1e-6
    flank = (gear.half_angle_at(radius[3] + step) - gear.half_angle_at(radius[3] - step)) / (2.0 * step)
    assert slope == pytest.approx(flank, rel=1e-4)
