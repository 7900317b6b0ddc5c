"""Findings about inertias of gears, centre distances of positions, wedging, and errors of teeth beyond the backlash."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from gearplay.parts.mesh.runout import runout_loss
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding
from gearplay.toothing.gear import inv

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

GYRATION: Final = (0.3, 1.5)
"""Usual radii of gyration of gears, in pitch radii: 0.71 is a solid disc, about 1.1 a thin ring gear."""

MISFIT: Final = 1e-6
"""Relative difference of a centre distance from its nominal value that is more than rounding."""


def gyration_findings(case: Train) -> Iterator[Finding]:
    """Yield findings about inertias that do not suit the sizes of the gears."""
    first = {name: mesh for mesh in reversed(case.meshes) for name in (mesh.driven, mesh.driver)}
    for name in dict.fromkeys(name for mesh in case.meshes for name in (mesh.driver, mesh.driven)):
        rotor = case.rotors[geometry.rotor_of(case, name)]
        if len(rotor.gears) > 1 or rotor.mass == 0.0 or rotor.inertia == 0.0:  # of a shaft it may be anywhere
            continue
        gyration, pitch = (
            math.sqrt(rotor.inertia / rotor.mass),
            geometry.pitch_radius(case, first[name], name),
        )
        if not GYRATION[0] <= gyration / pitch <= GYRATION[1]:
            yield Finding(
                "warning",
                f"rotors.{geometry.rotor_of(case, name)}.inertia",
                f"the radius of gyration, {gyration:.3g} m, is {gyration / pitch:.2g} times the pitch "
                f"radius, {pitch:.3g} m; a solid disc has 0.71, a thin ring gear about 1.1. "
                "Check mass and inertia and their units.",
            )


def backlash_findings(case: Train) -> Iterator[Finding]:
    """Yield findings about what makes and takes the backlash of every mesh."""
    for index in range(len(case.meshes)):
        yield from _center_distance(case, index)
        yield from _wedging(case, index)
        yield from _errors(case, index)


def _center_distance(case: Train, index: int) -> Iterator[Finding]:
    pair = geometry.pair_of(case, index)
    actual, nominal = geometry.installed_distance(case, index), pair.distance
    if abs(actual - nominal) <= MISFIT * nominal:
        return
    what, shift = "nominal", ""
    if case.meshes[index].center_distance is not None or pair.is_shifted:
        what = "working"
    elif abs(actual - nominal) > 0.05 * pair.first.module and actual > pair.least_distance:
        rise = inv(pair.at(actual).working_angle) - inv(pair.first.transverse_angle)
        teeth = pair.second.teeth + pair.second.sign * pair.first.teeth
        total = 0.5 * rise * teeth / math.tan(pair.first.pressure_angle)
        names = "x of the ring less that of the pinion" if pair.internal else "the sum of both"
        shift = f" Gears made for this distance have profile shifts, {names} {total:.4g}: give them as profile_shift."
    yield Finding(
        "warning",
        f"meshes.{index}.backlash",
        f"the positions are {actual:.6g} m apart, the {what} centre distance is {nominal:.6g} m. The "
        f"backlash is defined at the {what} distance; do not count the play of the installed "
        f"distance twice.{shift}",
    )


def _wedging(case: Train, index: int) -> Iterator[Finding]:
    hot = case.operating
    ratio = geometry.jam_ratio(hot, index)
    left = geometry.installed_normal_backlash(hot, index)
    lost = runout_loss(hot, index) * math.cos(geometry.pair_of(hot, index).first.base_helix)
    if ratio <= 1.0 and not left < lost:
        return
    if left < 0.0:
        text = f"the normal backlash is {1e6 * left:.4g} um at the distance of the centres, so both flanks are pressed at once"
    elif math.isinf(ratio):
        text = "there is clearance in the sleeves but no backlash"
    elif left < lost:
        text = f"the runouts of its gears take up to {1e6 * lost:.4g} um of its normal backlash of {1e6 * left:.4g} um"
    else:
        text = f"the jam ratio, 2 sin(alpha) x (sum of radial clearances) / backlash, is {ratio:.2f}"
    yield Finding(
        "warning",
        f"meshes.{index}.backlash",
        f"{text}: both flanks can touch at once and the pair can wedge. Raise the backlash or lower "
        "the clearances, unless that is the case to study.",
    )


def _errors(case: Train, index: int) -> Iterator[Finding]:
    total = sum(abs(term.amplitude) for term in case.meshes[index].transmission_error)
    backlash = geometry.working_backlash(case, index)
    if total > max(backlash, 0.0):
        yield Finding(
            "warning",
            f"meshes.{index}.transmission_error",
            f"the amplitudes add up to {1e6 * total:.4g} um, more than the backlash of "
            f"{1e6 * backlash:.4g} um. Check the units.",
        )
