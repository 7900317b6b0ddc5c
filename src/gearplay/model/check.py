"""Findings about a valid case: numbers that do not fit each other, and consequences for a simulation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from gearplay.model.case import Case
from gearplay.model.check_elements import element_findings
from gearplay.model.check_run import run_findings
from gearplay.model.check_start import start_findings
from gearplay.model.check_temperature import temperature_findings
from gearplay.model.expansion import thermal_changes
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import Source, load_case
from gearplay.parts.drive.schema import (
    CascadeDrive,
    MotorDrive,
    PositionDrive,
    ServoDrive,
    SpeedDrive,
    TorqueDrive,
)
from gearplay.parts.drive.terms import largest_torque
from gearplay.parts.mesh.check_damping import damping_findings
from gearplay.parts.mesh.check_deviations import deviation_findings
from gearplay.parts.mesh.check_pairs import pair_findings
from gearplay.parts.mesh.check_teeth import teeth_findings
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.massless import UNITS, massless
from gearplay.parts.planetary.frequencies import SetFrequencies, set_frequencies
from gearplay.parts.rotor.schema import Load, Rotor
from gearplay.schema.finding import Finding
from gearplay.toothing.gear import inv

GYRATION: Final = (0.3, 1.5)
"""Usual radii of gyration of gears, in pitch radii: 0.71 is a solid disc, about 1.1 a thin ring gear."""

MISFIT: Final = 1e-6
"""Relative difference of a centre distance from its nominal value that is more than rounding."""


def check_case(case: Source) -> list[Finding]:
    """Return the findings about a valid case, warnings first.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.

    Returns
    -------
    list of Finding
        Each with ``severity``, ``path`` and a message; warnings first.

    Raises
    ------
    InputError
        If the parts are valid but the train is not: contradicting speeds, centres that cannot mesh.

    Examples
    --------
    >>> from gearplay.model.reading import load_case
    >>> for finding in check_case(load_case("han2021"))[:1]:
    ...     print(finding.severity, finding.path)
    note rotors.pinion.inertia

    """
    case = load_case(case)
    light = [*_without_mass(case)]
    packed = pack(case, moves=not light)
    found = [*start_findings(case, packed)]  # raises what only the assembled train can show
    if light:  # nothing starts
        found = light
    speeds = dict(zip(case.rotors, (float(speed) for speed in rolling.nominal_speeds(case)), strict=True))
    found += [*_inertias(case), *_excitation(case), *(() if light else _fixed_step(case, packed))]
    found += element_findings(case)
    found += teeth_findings(case)
    found += deviation_findings(case)
    found += run_findings(case)
    found += damping_findings(case)
    found += pair_findings(case)
    found += temperature_findings(case)
    found += _sets(case)
    for index in range(len(case.meshes)):
        found += [
            *_center_distance(case, index),
            *_wedging(case, index),
            *_errors(case, index),
        ]
    found += _amplitude_bounds(case.operating, speeds)
    found += [Finding("note", path, f"{words}.") for path, words in thermal_changes(case).items()]
    found = _with_accepted(case, found)
    return sorted(found, key=lambda finding: finding.severity != "warning")


def _with_accepted(case: Case, found: list[Finding]) -> list[Finding]:
    """Return findings with the warnings of accepted paths as notes, and a warning for each accepted path without one."""
    warned = {each.path for each in found if each.severity == "warning"}
    accepted = [
        Finding("note", each.path, f"{each.message} Accepted by the case.")
        if each.severity == "warning" and each.path in case.accepted
        else each
        for each in found
    ]
    words = "names a field without a warning. Remove it."
    return accepted + [
        Finding("warning", "accepted", f"{path} {words}") for path in case.accepted if path not in warned
    ]


def _without_mass(case: Case) -> Iterator[Finding]:
    for path, field in {case.field_path(name, field): field for name, field in massless(case)}.items():
        yield Finding(
            "warning",
            path,
            f"the {field} is 0 {UNITS[field]}: modes, Campbell diagrams, frequency responses and load sharing take it so; a "
            "simulation over time refuses it. Give it one to simulate.",
        )


def _inertias(case: Case) -> Iterator[Finding]:
    checked: set[str] = set()
    for mesh in case.meshes:
        for name in (mesh.driver, mesh.driven):
            if name in checked:
                continue
            checked.add(name)
            rotor = case.rotors[geometry.rotor_of(case, name)]
            if len(rotor.gears) > 1 or 0.0 in (
                rotor.mass,
                rotor.inertia,
            ):  # a shaft, whose mass may be anywhere
                continue
            gyration, pitch = math.sqrt(rotor.inertia / rotor.mass), geometry.pitch_radius(case, mesh, name)
            if not GYRATION[0] <= gyration / pitch <= GYRATION[1]:
                yield Finding(
                    "warning",
                    f"rotors.{geometry.rotor_of(case, name)}.inertia",
                    f"the radius of gyration, {gyration:.3g} m, is {gyration / pitch:.2g} times the pitch "
                    f"radius, {pitch:.3g} m; a solid disc has 0.71, a thin ring gear about 1.1. "
                    "Check mass and inertia and their units.",
                )


def _excitation(case: Case) -> Iterator[Finding]:
    if not case.meshes or any(case.gravity) or case.base is not None:
        return
    errors = any(term.amplitude != 0.0 for mesh in case.meshes for term in mesh.transmission_error)
    if not errors and not any(_excites(rotor) for rotor in case.rotors.values()):
        yield Finding(
            "warning",
            "meshes",
            "nothing excites this case: 0 N m of load, 0 um of error of the teeth and of runout, no gravity and no initial "
            "displacement, so rolling without force is an exact solution. "
            "Give a transmission_error, a runout or a load.",
        )
    elif any(rotor.drive for rotor in case.rotors.values()) and not any(map(_resists, case.rotors.values())):
        yield Finding(
            "warning",
            "rotors",
            "no rotor has a load that resists the drive, so the teeth float in their backlash. "
            "Give load.torque, load.drag or load.friction.",
        )


def _resists(rotor: Rotor) -> bool:
    """Return whether something acts against the rotation of a rotor: a load, a torque, a servo."""
    drive = rotor.drive
    return rotor.load != Load() or (drive is not None and drive.kind != "speed")


def _fixed_step(case: Case, packed: Packed) -> Iterator[Finding]:
    step, resolved = case.run.fixed_step, packed.restart_step
    if step is not None and step > 2.0 * resolved:
        yield Finding(
            "warning",
            "run.fixed_step",
            f"{1e6 * step:.4g} us is {step / resolved:.3g} times what resolves the fastest contact, {1e6 * resolved:.3g} us: "
            "contacts are noticed so late that the run may gain energy or leave mesh. Shorten it.",
        )


def _excites(rotor: Rotor) -> bool:
    load, start, drive = rotor.load, rotor.initial, rotor.drive
    ramped = isinstance(drive, (SpeedDrive, ServoDrive)) and drive.ramp > 0.0
    rippling = isinstance(drive, SpeedDrive) and (
        drive.over_time is not None or any(term.amplitude for term in drive.ripple)
    )
    return (
        any((load.drag, load.friction, largest_torque(load.torque, load.terms, load.table)))
        or rotor.unbalance is not None
        or rotor.runout.amplitude != 0.0
        or any(gear.runout.amplitude for gear in rotor.gears.values())
        or any((start.x, start.y, start.vx, start.vy, start.theta, start.omega))
        or ramped
        or rippling
        or (isinstance(drive, TorqueDrive) and drive.largest_torque != 0.0)
        or (isinstance(drive, MotorDrive) and (drive.voltage != 0.0 or drive.over_time is not None))
        or isinstance(drive, (PositionDrive, CascadeDrive))
    )


def _center_distance(case: Case, index: int) -> Iterator[Finding]:
    pair = geometry.pair_of(case, index)
    actual, nominal = geometry.installed_distance(case, index), pair.distance
    if abs(actual - nominal) <= MISFIT * nominal:
        return
    what, shift = "nominal", ""
    if (
        case.meshes[index].center_distance is not None
        or pair.first.profile_shift
        or pair.second.profile_shift
    ):
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


def _wedging(case: Case, index: int) -> Iterator[Finding]:
    ratio = geometry.jam_ratio(case.operating, index)
    if ratio <= 1.0:
        return
    left = geometry.installed_backlash(case.operating, index)
    if left < 0.0:
        text = f"the backlash is {1e6 * left:.4g} um at the distance of the centres, so both flanks are pressed at once"
    elif math.isinf(ratio):
        text = "there is clearance in the sleeves but no backlash"
    else:
        text = f"the jam ratio, 2 sin(alpha) x (sum of radial clearances) / backlash, is {ratio:.2f}"
    yield Finding(
        "warning",
        f"meshes.{index}.backlash",
        f"{text}: both flanks can touch at once and the pair can wedge. Raise the backlash or lower "
        "the clearances, unless that is the case to study.",
    )


def _errors(case: Case, index: int) -> Iterator[Finding]:
    total = sum(abs(term.amplitude) for term in case.meshes[index].transmission_error)
    backlash = geometry.working_backlash(case, index)
    if total > backlash:
        yield Finding(
            "warning",
            f"meshes.{index}.transmission_error",
            f"the amplitudes add up to {1e6 * total:.4g} um, more than the backlash of "
            f"{1e6 * backlash:.4g} um. Check the units.",
        )


def _sets(case: Case) -> Iterator[Finding]:
    for name in case.planetary:
        found = set_frequencies(case, name)
        if found.mesh > 0.0:
            yield Finding(
                "note",
                f"planetary.{name}",
                f"mesh frequency {found.mesh:.6g} Hz; a tooth of the sun meets planets at {found.sun:.6g} Hz, of a planet the "
                f"sun at {found.planet:.6g} Hz, of the ring planets at {found.ring:.6g} Hz; the carrier turns at "
                f"{found.carrier:.6g} Hz{_passing(found)}.",
            )


def _passing(found: SetFrequencies) -> str:
    """Return the text on mesh sidebands that a sensor on the ground records; empty for a carrier that does not turn."""
    if found.carrier_passing == 0.0:
        return ""
    return (
        f", planets pass a place on the ground at {found.carrier_passing:.6g} Hz, sidebands "
        f"{found.mesh:.6g} ± {found.carrier_passing:.6g} Hz"
    )


def _amplitude_bounds(case: Case, speeds: dict[str, float]) -> Iterator[Finding]:
    for name, sleeve in case.sleeves.items():
        if sleeve.on is not None:  # goes round with its carrier
            continue
        mine = [index for index, mesh in enumerate(case.meshes) if name in mesh.rotors]
        for frequency in sorted({float(f"{rolling.mesh_frequency(case, index):.6g}") for index in mine}):
            if sleeve.radial_clearance == 0.0 or frequency == 0.0:
                continue
            bound = geometry.amplitude_bound(sleeve.radial_clearance, frequency)
            yield Finding(
                "note",
                f"sleeves.{name}.radial_clearance",
                f"the acceleration of a motion within the clearance has a line of at most {bound:.3g} m/s^2 at the mesh "
                f"frequency, {frequency:.4g} Hz.",
            )
