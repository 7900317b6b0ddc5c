"""Printed geometry and tooth stiffness of gears as drawn that `gearplay validate` does not print.

The NREL 5 MW drivetrain of A. R. Nejad and others, Wind Energ. Sci. 1 (2016) 79; ISO 6336-1; DIN 3967 with its example 27cd.
"""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from drawn_pairs import drawn, paired
from gearplay.toothing.allowances import distance_allowance, thickness_allowances
from gearplay.toothing.iso6336 import (
    flexibility,
    light_load_factor,
    mean_factor,
    parabola,
    single_stiffness,
)
from gearplay.toothing.pair import GearPair
from gearplay.toothing.path_stiffness import PathStiffness
from gearplay.toothing.potential_energy import tooth_compliance

E, NU = 206e9, 0.3
ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("gears", "distance", "ratio", "backlash"),
    [
        ((45.0, 19, 0.617, 978.808, 17, 0.802, 905.458, 0.0), 863.0, 1.114698963, 4.14),
        ((21.0, 18, 0.389, 432.838, 36, 0.504, 815.668, 0.0), 584.0, 1.370399731, -1.88),
        ((14.0, 24, 0.480, 380.7473416, 95, 0.669, 1395.3733938, 10.0), 861.0, 1.462659404, 0.86),
    ],
)
def test_wind_gearbox(gears: tuple[float, ...], distance: float, ratio: float, backlash: float) -> None:
    """Contact ratios of the three stages; shifts and distances as printed leave or take a few um of backlash."""
    m, z_1, x_1, d_1, z_2, x_2, d_2, beta = gears
    first = drawn(m, int(z_1), x_1, tip_diameter=d_1, beta=beta)
    pair = paired(first, drawn(m, int(z_2), x_2, tip_diameter=d_2, beta=beta), distance)
    assert pair.contact_ratio == pytest.approx(ratio, abs=2e-9)
    assert 1e3 * pair.backlash == pytest.approx(backlash, abs=5e-3)


def test_contact_ratio_above_two() -> None:
    def ratio(alpha: float, z_1: int, z_2: int, addendum: float, dedendum: float) -> float:
        gears = [drawn(3.0, z, alpha=alpha, addendum=addendum, dedendum=dedendum) for z in (z_1, z_2)]
        return paired(*gears).contact_ratio

    assert ratio(20.0, 40, 60, 1.25, 1.5) == pytest.approx(2.1344682, abs=5e-8)
    assert ratio(17.5, 60, 80, 1.35, 1.6) == pytest.approx(2.5759017, abs=5e-8)


@pytest.mark.parametrize(
    ("z_1", "x_1", "z_2", "x_2", "beta", "theoretical", "single", "ratio", "mesh"),
    [
        (19, 0.617, 17, 0.802, 0.0, 18.829182, 14.686762, 1.114698963, 15.950179),
        (18, 0.389, 36, 0.504, 0.0, 18.198806, 14.195069, 1.370399731, 18.138456),
        (24, 0.480, 95, 0.669, 10.0, 20.051822, 15.402808, 1.462659404, 20.747499),
    ],
)
def test_iso_stiffness_of_the_wind_gearbox(
    z_1: int, x_1: float, z_2: int, x_2: float, beta: float, theoretical: float, single: float, ratio: float, mesh: float
) -> None:  # fmt: skip
    gears = drawn(14.0, z_1, x_1, beta=beta), drawn(14.0, z_2, x_2, beta=beta)
    assert 1.0 / flexibility(*gears) == pytest.approx(theoretical, abs=5e-7)
    assert single_stiffness(*gears) == pytest.approx(single, abs=5e-7)
    assert single_stiffness(*gears) * mean_factor(ratio) == pytest.approx(mesh, abs=5e-7)


def test_iso_stiffness_of_a_helical_pair() -> None:
    """The standard's example 1; the light-load factor at 1 N/mm."""
    pair = paired(drawn(8.0, 17, 0.145, beta=15.8), drawn(8.0, 103, beta=15.8), 500.0)
    assert single_stiffness(pair.first, pair.second) == pytest.approx(13.401345, abs=5e-7)
    assert pair.contact_ratio == pytest.approx(1.549342, abs=5e-7)
    assert math.degrees(pair.working_angle) == pytest.approx(21.066100, abs=5e-7)
    assert light_load_factor(1e3) == pytest.approx(0.316228, abs=5e-7)
    assert light_load_factor(2e5) == 1.0


@pytest.mark.parametrize(
    ("pair", "overlap", "ripple"),
    [
        (
            paired(
                drawn(14e-3, 24, 0.48, beta=10.0, tip_diameter=0.3807473415936103, facewidth=0.36),
                drawn(14e-3, 95, 0.669, beta=10.0, tip_diameter=1.3953733938080409, facewidth=0.36),
                0.861,
            ),
            1.4213297,
            0.170144,
        ),
        (
            paired(
                drawn(4.5e-3, 27, 0.231415, beta=21.0, facewidth=0.05),
                drawn(4.5e-3, 51, 0.231415, beta=21.0, facewidth=0.05),
                0.19,
            ),
            1.2674673,
            0.122136,
        ),
    ],
)
def test_helical_stiffness(pair: GearPair, overlap: float, ripple: float) -> None:
    """The mean over a pitch is c_gamma b, exactly; peak to peak over mean at 1001 phases from A."""
    assert pair.overlap_ratio == pytest.approx(overlap, abs=5e-8)
    found = PathStiffness(pair, "iso6336", E, NU, math.inf)
    first = (pair.path.start - pair.pitch_place) / pair.first.base_pitch
    total = found.total(first + np.linspace(0.0, 1.0, 1001))
    assert np.ptp(total) / total[:-1].mean() == pytest.approx(ripple, abs=5e-6)
    c_gamma = single_stiffness(pair.first, pair.second) * mean_factor(pair.contact_ratio)
    many = found.total(np.arange(20_000) / 20_000)
    assert many.mean() == pytest.approx(1e9 * c_gamma * found.width, rel=1e-8)


def test_the_parabola_has_peak_and_mean_of_the_standard() -> None:
    """20/60: kappa 0.301107; the sum over a pitch is c_gamma, the peak c'."""
    gears = [drawn(4e-3, z, facewidth=0.01) for z in (20, 60)]
    pair = paired(*gears)
    assert parabola(pair.contact_ratio) == pytest.approx(0.301107, abs=5e-7)
    found = PathStiffness(pair, "iso6336", E, NU, math.inf)
    assert found.peak == pytest.approx(1.31526e8, rel=5e-6)
    middle = 0.5 * (pair.path.start + pair.path.end)
    assert float(found.single(np.array(middle))) == pytest.approx(found.peak, rel=1e-12)
    phases = (np.arange(200_000) + 0.5) / 200_000
    expected = found.peak * mean_factor(pair.contact_ratio)
    assert found.total(phases).mean() == pytest.approx(expected, rel=1e-5)


ENERGY = [
    ((2e-3, 62, 0.0, 0.035, 0.379951), (62, 0.0, 0.035), 1.789780, (20.77797, 19.52353, 21.52303, 12.00120, 12.01779)),
    ((2e-3, 62, 0.0, 0.035, 0.38), (62, 0.0, 0.035), 1.789780, (20.77814, 19.52369, 21.52321, 12.00129, 12.01787)),
    ((4e-3, 20, 0.0, 0.030, 0.38), (60, 0.0, 0.060), 1.670776, (20.90117, 18.46512, 21.52875, 12.17409, 12.22161)),
    ((3e-3, 23, 0.3, 0.025, 0.38), (34, 0.1, 0.030), 1.543753, (22.96906, 18.95523, 23.50923, 13.49968, 13.62255)),
]  # fmt: skip


@pytest.mark.parametrize(("first", "second", "ratio", "values"), ENERGY)
def test_potential_energy(
    first: tuple[float, ...], second: tuple[float, ...], ratio: float, values: tuple[float, ...]
) -> None:
    """Start, mean, double and single zone, peak of one pair [N/(mm um)] at 400 phases from A."""
    m, z_1, x_1, bore_1, radius = first
    z_2, x_2, bore_2 = second
    more = {"facewidth": 0.02, "tip_radius": radius}
    pair = paired(drawn(m, int(z_1), x_1, bore=bore_1, **more), drawn(m, int(z_2), x_2, bore=bore_2, **more))
    assert pair.contact_ratio == pytest.approx(ratio, abs=5e-7)
    found = PathStiffness(pair, "potential-energy", E, NU, math.inf)
    at = np.arange(401) / 400.0
    total = (
        1e-9
        / found.width
        * found.total(
            (pair.path.start - pair.pitch_place) / pair.first.base_pitch + np.minimum(at + 1e-12, 1.0 - 1e-12)
        )
    )
    start, mean, double, single, peak = values
    assert total[0] == pytest.approx(start, abs=6e-6)
    assert total[:-1].mean() == pytest.approx(mean, abs=6e-6)
    assert total[at < ratio - 1.0].mean() == pytest.approx(double, abs=6e-6)
    assert total[at > ratio - 1.0].mean() == pytest.approx(single, abs=6e-6)
    one = float(found.single(np.array([0.5 * (pair.path.start + pair.path.end)]))[0])
    assert 1e-9 * one / found.width == pytest.approx(peak, abs=6e-6)


def test_mean_stiffness__is_near_that_of_the_standard() -> None:
    """The table of docs/teeth.md: iso6336 has c_gamma, potential energy is within 20 % of it."""
    sys.path.insert(0, str(ROOT / "docs"))
    import write_stiffness

    rows = write_stiffness.rows()
    assert len(rows) == 5
    for name, energy, iso, c_gamma in rows:
        assert iso == pytest.approx(c_gamma, rel=2e-4)
        assert energy == pytest.approx(c_gamma, rel=0.2)
        assert f"| {name} | {energy:.1f} | {iso:.1f} | {c_gamma:.1f} |" in write_stiffness.table()
    energies = [row[1] for row in rows]
    assert energies == pytest.approx([19.5, 18.4, 18.9, 20.7, 21.1], abs=0.06)


def test_terms_of_one_tooth() -> None:
    """62 teeth, m 2, bore 35, b 20: bending, shear, compression at 0.349 rad, foundation [1e-9 m/N]."""
    gear = drawn(2e-3, 62, tip_radius=0.379951, bore=0.035)
    terms = tooth_compliance(gear, math.tan(0.349), 0.02, E, NU)
    assert 1e9 * terms.bending == pytest.approx(0.086763, rel=3e-3)
    assert 1e9 * terms.shear == pytest.approx(0.44652, rel=1e-3)
    assert 1e9 * terms.compression == pytest.approx(0.016104, rel=2e-3)
    assert 1e9 * terms.foundation == pytest.approx(1.3894, rel=5e-4)


def test_classes_of_the_standards() -> None:
    """DIN 3967's own example, cd27 at 100 mm: -70/-170 um; DIN 3964 js7: half of IT7, 15 um at 78 mm and 23 um at 190 mm."""
    assert thickness_allowances("cd27", 0.1) == pytest.approx((-70e-6, -170e-6))
    assert thickness_allowances("c25", 0.01) == pytest.approx((-48e-6, -68e-6))
    assert thickness_allowances("c25", 0.0100001) == pytest.approx((-65e-6, -95e-6))
    assert thickness_allowances("h21", 1.0) == pytest.approx((0.0, -12e-6))
    assert thickness_allowances("a30", 1.001) is None
    assert distance_allowance(7, 0.078) == pytest.approx(15e-6)
    assert distance_allowance(7, 0.19) == pytest.approx(23e-6)
    assert distance_allowance(11, 3.2) is None
