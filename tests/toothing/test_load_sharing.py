"""Gaps of tips beyond the path of contact, load sharing at rest, the table of K over the mesh phase."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from drawn_pairs import drawn, paired, standard
from gearplay.toothing.load_sharing import static_sharing, tip_gaps
from gearplay.toothing.outline import closed_teeth
from gearplay.toothing.pair import GearPair
from gearplay.toothing.path_stiffness import PathStiffness, mirrored

BEYOND = np.array([0.02, 0.05, 0.1, 0.2])


def article(width: float = 0.01) -> GearPair:
    """Return 20/60, module 4 mm."""
    return paired(drawn(4e-3, 20, facewidth=width), drawn(4e-3, 60, facewidth=width))


def iso(pair: GearPair) -> PathStiffness:
    return PathStiffness(pair, "iso6336", 206e9, 0.3, math.inf)


def test_gaps_of_corners() -> None:
    """Module 4, 20/60: gaps [um] before A and after E, external; after E, internal."""
    for internal, before, after in (
        (False, [1.885835, 11.305177, 43.401999, 166.953469], [0.781294, 4.935210, 20.086640, 83.082171]),
        (True, None, [0.245872, 1.536207, 6.140776, 24.519211]),
    ):
        pair = standard(20, 60, internal, 4e-3)
        step = BEYOND * pair.first.base_pitch
        assert 1e6 * tip_gaps(pair, pair.path.tip_of_first + step) == pytest.approx(after, abs=6e-7)
        if before is not None:
            assert 1e6 * tip_gaps(pair, pair.path.tip_of_second - step) == pytest.approx(before, abs=6e-7)


def random_pair(rng: np.random.Generator) -> GearPair:
    """Return a pair of shifted gears whose tips stay within the base tangent points."""
    while True:
        internal = bool(rng.random() < 0.5)
        z_1 = int(rng.integers(18, 40))
        z_2 = int(rng.integers(z_1 + 25, 120)) if internal else int(rng.integers(18, 90))
        first = drawn(1e-3, z_1, rng.uniform(-0.1, 0.6), alpha=rng.uniform(17.5, 25.0))
        second = drawn(
            1e-3, z_2, rng.uniform(0.0, 0.6), alpha=math.degrees(first.pressure_angle), internal=internal
        )
        pair = paired(first, second)
        if math.isnan(pair.distance):
            continue
        pair = pair.at(pair.distance * (1.0 + rng.uniform(-1e-3, 1e-3)))
        path = pair.path
        if (
            path.tip_of_second > 0.0
            and path.tip_of_first < path.tangent_of_second
            and pair.contact_ratio > 1.1
        ):
            return pair


def flank_points(base: float, angle: float, low: float, high: float, count: int) -> NDArray[np.float64]:
    """Return points of an involute whose foot is at ``angle`` [rad], between two radii [m], shape [point, 2]."""
    tangent = np.sqrt(np.linspace(low, high, count) ** 2 / base**2 - 1.0)
    radius, at = base * np.sqrt(1.0 + tangent**2), angle - (tangent - np.arctan(tangent))
    return np.column_stack([radius * np.cos(at), radius * np.sin(at)])


def distance_of(points: NDArray[np.float64], curve: NDArray[np.float64]) -> float:
    """Return the least distance [m] of points from a polygon."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    least = math.inf
    for point in points:
        share = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0.0, 1.0)
        least = min(least, float(np.min(np.linalg.norm(start + share[:, None] * step - point, axis=1))))
    return least


@pytest.mark.parametrize("seed", range(12))
def test_gaps_are_distances_of_outlines(seed: int) -> None:
    """The gap of a corner is the distance of the tip point from the other flank as a polygon of 40 000 points, within 1 nm."""
    rng = np.random.default_rng(seed)
    pair = random_pair(rng)
    first, second, sign = pair.first, pair.second, pair.second.sign
    pitch = first.base_pitch
    for place, corner in (
        (pair.path.tip_of_second - rng.uniform(0.01, 0.1) * pitch, "second"),
        (pair.path.tip_of_first + rng.uniform(0.01, 0.1) * pitch, "first"),
    ):
        foot_1 = place / first.base_radius - pair.working_angle
        inv = math.tan(pair.working_angle) - pair.working_angle
        foot_2 = (pair.least_distance * inv - sign * first.base_radius * foot_1) / second.base_radius
        tip_2 = flank_points(second.base_radius, foot_2, second.tip, second.tip, 2)[:1]
        tip_1 = flank_points(first.base_radius, foot_1, first.tip, first.tip, 2)[:1]
        one = flank_points(first.base_radius, foot_1, first.base_radius * (1 + 1e-9), first.tip, 40_000)
        low, high = sorted((second.tip, second.tip + (10 if pair.internal else -3) * first.module))
        two = flank_points(
            second.base_radius, foot_2, max(low, second.base_radius * (1 + 1e-9)), high, 40_000
        )
        for points in (tip_2, two):  # about the first centre
            if pair.internal:
                points[:, 0] -= pair.distance
            else:
                points[:] = np.column_stack([pair.distance - points[:, 0], -points[:, 1]])
        measured = distance_of(tip_2, one) if corner == "second" else distance_of(tip_1, two)
        found = float(tip_gaps(pair, np.array([place]))[0])
        assert found > 0.0
        assert found == pytest.approx(measured, abs=1e-9)


def test_outlines_touch_at_the_pitch_point() -> None:
    """Drawn outlines of both gears meet at the pitch point and do not overlap along the line of centres."""
    for internal in (False, True):
        pair = standard(20, 60, internal, 4e-3)
        one, other = closed_teeth(pair, 2)
        pitch = np.array([pair.working_radii[0], 0.0])
        for outline in (one, other):
            start, step = outline[:-1], np.diff(outline, axis=0)
            share = np.clip(np.sum((pitch - start) * step, axis=1) / np.sum(step**2, axis=1), 0.0, 1.0)
            assert np.min(np.linalg.norm(start + share[:, None] * step - pitch, axis=1)) < 2e-5


@pytest.mark.parametrize(
    ("force", "place", "deflection", "shares"),
    [
        (2000.0, -0.05, 13.646891, (0.107628, 0.892372)),
        (2000.0, 0.0, 9.012647, (0.414232, 0.585768)),
        (2000.0, 0.2, 8.598573, (0.466968, 0.533032)),
        (2000.0, 0.69, 9.297392, (0.605847, 0.394153)),
        (2000.0, 0.8, 15.214375, (1.0, 0.0)),
        (20000.0, 0.8, 103.475849, (0.680119, 0.319881)),
    ],
)
def test_load_sharing(force: float, place: float, deflection: float, shares: tuple[float, float]) -> None:
    """Deflection [um] and shares of the entering and the leading pair, place of the entering one from A in base pitches."""
    pair = article()
    phase = (pair.path.start - pair.pitch_place) / pair.first.base_pitch + place
    found, forces, numbers = static_sharing(iso(pair), force, np.array([phase]))
    entering = list(numbers).index(0)
    assert 1e6 * found[0] == pytest.approx(deflection, abs=6e-7)
    assert forces[0, entering : entering + 2] / force == pytest.approx(shares, abs=6e-7)


def test_forces_of_the_pairs_add_up() -> None:
    """Sum of the pairs' forces is the force; pairs of one stiffness share alike where two carry."""
    pair = article()
    found = iso(pair)
    phases = np.linspace(0.0, 1.0, 101)
    _, forces, _ = static_sharing(found, 777.0, phases)
    assert forces.sum(axis=1) == pytest.approx(777.0, rel=1e-9)
    mirror = np.array(
        [(0.5 * (pair.path.start + pair.path.end) - pair.pitch_place) / pair.first.base_pitch + 0.5]
    )
    _, forces, _ = static_sharing(found, 777.0, mirror)  # two pairs as far from the middle either side
    assert np.sort(forces[0])[-2:] / 777.0 == pytest.approx([0.5, 0.5], rel=1e-9)


def evaluated(table: NDArray[np.float64], psi: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a periodic table of pieces at phases [rad]."""
    turned = psi % (2.0 * np.pi)
    piece = np.searchsorted(table[:, 0], turned, side="right") - 1
    x = (turned - table[piece, 0]) % (2.0 * np.pi)
    return np.sum(table[piece, 1:] * x[:, None] ** np.arange(4), axis=1)


@pytest.mark.parametrize("beta", [0.0, 12.0])
def test_table__is_the_sum_over_the_pairs(beta: float) -> None:
    """Exact but for the ramps of spur gears, which keep the mean; continuous; its mirror is K backwards."""
    gears = [drawn(4e-3, z, beta=beta, facewidth=0.02) for z in (20, 60)]
    found = iso(paired(*gears))
    phases = (np.arange(20_000) + 0.5) / 20_000
    total, table = found.total(phases), found.table
    over = evaluated(table, 2.0 * np.pi * phases)
    near = np.isclose(over, total, rtol=1e-12)
    assert np.mean(near) > (0.95 if beta == 0.0 else 0.9999)
    assert over.mean() == pytest.approx(total.mean(), rel=3e-5 if beta == 0.0 else 1e-12)
    assert np.max(np.abs(np.diff(over))) < 0.01 * total.mean()
    assert evaluated(mirrored(table), -2.0 * np.pi * phases) == pytest.approx(over, rel=1e-12)


def test_interference_cuts_the_path() -> None:
    """Within the first gear's tangent point nothing carries, though the ring's tip would reach there."""
    pair = paired(drawn(4e-3, 20, facewidth=0.01), drawn(4e-3, 60, facewidth=0.01, internal=True))
    assert pair.path.tip_of_second == pytest.approx(-0.150e-3, abs=5e-7)
    assert 1e3 * pair.clean_tip_diameter == pytest.approx(232.0705, abs=5e-5)
    assert np.isnan(tip_gaps(pair, np.array([-1e-5]))[0])
    clean = paired(pair.first, drawn(4e-3, 60, internal=True, tip_diameter=pair.clean_tip_diameter))
    assert clean.path.tip_of_second == pytest.approx(0.0, abs=1e-12)
