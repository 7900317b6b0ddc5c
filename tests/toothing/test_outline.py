"""Outlines of teeth: fillet and involute join, undercut and pointed teeth, rings."""

import math

import numpy as np
import pytest

from gearplay.toothing.gear import DrawnGear, inv
from gearplay.toothing.outline import half_tooth
from gearplay.toothing.potential_energy import fillet


@pytest.mark.parametrize(("teeth", "shift"), [(8, 0.0), (12, 0.0), (16, 0.0), (18, 0.0), (60, 0.5)])
def test_external__fillet_joins_the_involute_without_a_jump(teeth: int, shift: float) -> None:
    gear = DrawnGear(teeth=teeth, module=1e-3, profile_shift=shift)
    radii, half = half_tooth(gear, 400)
    assert [radii[0], radii[-1]] == pytest.approx([gear.root, gear.tip], rel=1e-12)
    assert np.all(np.diff(radii) > 0.0)
    assert np.max(np.abs(np.diff(half) * radii[1:])) < 0.02e-3
    assert half[-1] == pytest.approx(gear.half_angle_at(gear.tip), rel=1e-12)


def test_external__undercut_tooth_is_the_narrower_of_fillet_and_involute() -> None:
    gear = DrawnGear(teeth=8, module=1e-3)
    radii, half = half_tooth(gear, 200)
    x, y = fillet(gear, np.linspace(0.5 * math.pi, gear.pressure_angle, 20_000))
    cut = np.interp(radii, np.hypot(x, y), np.arctan2(x, y), right=np.inf)
    involute = np.array(
        [gear.half_angle_at(radius) if radius > gear.base_radius else np.inf for radius in radii]
    )
    assert half == pytest.approx(np.minimum(cut, involute), abs=1e-6)
    neck = half[(radii > gear.root) & (radii < gear.base_radius)].min()
    assert neck < 0.5 * math.pi / 8 + inv(gear.pressure_angle)  # narrower than the involute's start


def test_external__pointed_tooth_ends_in_its_point() -> None:
    gear = DrawnGear(teeth=12, module=1e-3, profile_shift=1.2)
    assert gear.tip_thickness < 0.0
    radii, half = half_tooth(gear)
    assert half[-1] == pytest.approx(0.0, abs=1e-12)
    assert radii[-1] < gear.tip
    assert half.min() == half[-1]


def test_external__stub_tooth_ends_within_its_fillet() -> None:
    gear = DrawnGear(teeth=60, module=1e-3, addendum=1.0, tip_diameter=2.0 * 29.0e-3)
    radii, half = half_tooth(gear)
    assert radii[-1] == pytest.approx(29.0e-3, rel=1e-12)
    assert np.all(half > gear.half_angle_at(gear.tip) - 1e-12)


def test_ring__reaches_a_tip_within_its_base_circle() -> None:
    gear = DrawnGear(teeth=24, module=1e-3, internal=True)
    assert gear.tip < gear.base_radius
    radii, half = half_tooth(gear)
    assert [radii[0], radii[-1]] == pytest.approx([gear.tip, gear.root], rel=1e-12)
    assert half[0] == half[1] == pytest.approx(gear.half_angle, rel=1e-12)


def test_ring__pointed_space_ends_in_its_point() -> None:
    gear = DrawnGear(teeth=40, module=1e-3, internal=True, dedendum=3.0)
    assert gear.half_angle_at(gear.root) < 0.0
    radii, half = half_tooth(gear)
    assert half[-1] == pytest.approx(0.0, abs=1e-12)
    assert radii[-1] < gear.root
