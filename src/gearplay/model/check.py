"""Findings about a valid case: numbers that do not fit each other, and consequences for a simulation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gearplay.model.case import Case
from gearplay.model.check_run import run_findings
from gearplay.model.check_start import start_findings
from gearplay.model.expansion import thermal_changes
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import Source, load_case
from gearplay.parts.drive.schema import SpeedDrive
from gearplay.parts.mesh.check_backlash import backlash_findings, gyration_findings
from gearplay.parts.mesh.check_damping import damping_findings
from gearplay.parts.mesh.check_deviations import deviation_findings
from gearplay.parts.mesh.check_pairs import pair_findings
from gearplay.parts.mesh.check_teeth import teeth_findings
from gearplay.parts.mesh.temperature import temperature_findings
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.massless import UNITS, massless
from gearplay.parts.planetary.frequencies import set_findings
from gearplay.parts.protocol import Actuator
from gearplay.parts.rotor.schema import Initial, Load, Rotor
from gearplay.parts.sleeve.amplitude import amplitude_findings
from gearplay.schema.finding import Finding


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
    return findings_of(case, pack(case, moves=not any(_without_mass(case))))


def findings_of(case: Case, packed: Packed) -> list[Finding]:
    """Return the findings about a case that is packed already, as `check_case` does."""
    light = [*_without_mass(case)]
    found = [*start_findings(case, packed)]  # raises what only the assembled train can show
    if light:  # nothing starts
        found = light
    found += [*gyration_findings(case), *_excitation(case), *(() if light else _fixed_step(case, packed))]
    found += _elements(case)
    found += teeth_findings(case)
    found += deviation_findings(case)
    found += run_findings(case)
    found += damping_findings(case)
    found += pair_findings(case)
    found += set_findings(case)
    found += backlash_findings(case)
    found += amplitude_findings(case.operating)
    found += [Finding("note", path, f"{words}.") for path, words in thermal_changes(case).items()]
    found += temperature_findings(case)  # the verdict is the last
    found = _with_accepted(case, [each._replace(path=case.settable_path(each.path)) for each in found])
    return sorted(dict.fromkeys(found), key=lambda finding: finding.severity != "warning")


def _with_accepted(case: Case, found: list[Finding]) -> list[Finding]:
    """Return findings with the warnings of accepted paths as notes, and a warning for each accepted path without one."""
    fields = {case.settable_path(path): path for path in case.accepted}
    warned = {each.path for each in found if each.severity == "warning"}
    accepted = [
        Finding("note", each.path, f"{each.message} Accepted by the case.")
        if each.severity == "warning" and each.path in fields
        else each
        for each in found
    ]
    words = "names a field without a warning. Remove it."
    return accepted + [
        Finding("warning", "accepted", f"{path} {words}")
        for field, path in fields.items()
        if field not in warned
    ]


def _without_mass(case: Case) -> Iterator[Finding]:
    for path, field in {case.field_path(name, field): field for name, field in massless(case)}.items():
        yield Finding(
            "warning",
            path,
            f"the {field} is 0 {UNITS[field]}: modes, Campbell diagrams, frequency responses and load sharing take it so; a "
            "simulation over time refuses it. Give it one to simulate.",
        )


def _elements(case: Case) -> Iterator[Finding]:
    """Yield the findings of parts that hold and connect rotors, of faults, rotors and the housing."""
    for table, name, part in case.every_holder():
        held, alone = geometry.is_held(case, name), len(case.holders(name)) == 1
        yield from part.findings(f"{table}.{name}", held=held, alone=alone)
    for path, _, joint in case.named_joints():
        held = all(geometry.is_held(case, name) for name in joint.named_rotors().values())
        yield from joint.findings(path, held=held)
    speeds = dict(zip(case.rotors, rolling.nominal_speeds(case).tolist(), strict=True))
    for index, fault in enumerate(case.faults):
        part = fault.part(getattr(case, fault.table))
        carrier = getattr(part, "on", None)
        speed = speeds.get(fault.at, 0.0) - (0.0 if carrier is None else speeds[carrier])
        yield from fault.findings(f"faults.{index}", part, speed)
    span = case.run.transient + case.run.duration
    for name, rotor in case.rotors.items():
        yield from rotor.findings(f"rotors.{name}", span, held=geometry.is_held(case, name))
    if case.base is not None:
        yield from case.base.findings(span)


def _excitation(case: Case) -> Iterator[Finding]:
    if _rests(case):
        name = next(name for name, rotor in case.rotors.items() if rotor.is_prescribed)
        settle = ", so that gravity only settles what has play" if any(case.gravity) else ""
        yield Finding(
            "warning",
            case.field_path(name, "drive", "speed"),
            "nothing excites this case: every prescribed speed is 0, and no torque, no motion of the housing and no initial "
            f"state moves a rotor{settle}. Give a speed.",
        )
        return
    if not case.meshes or any(case.gravity) or case.base is not None:
        return
    errors = any(term.amplitude != 0.0 for mesh in case.meshes for term in mesh.transmission_error)
    if not errors and not any(rotor.excites() for rotor in case.rotors.values()):
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


def _rests(case: Case) -> bool:
    """Return whether all prescribed speeds of a case are 0 at all times and nothing else moves its rotors."""
    rotors = case.rotors.values()
    drives = [rotor.drive for rotor in rotors if rotor.drive is not None]
    if case.base is not None or not drives or not all(map(_stops, drives)):
        return False
    moved = any(rotor.load.largest_torque() or rotor.initial != Initial() for rotor in rotors)
    return not (moved or np.any(rolling.nominal_speeds(case)))


def _stops(drive: Actuator) -> bool:
    return (
        isinstance(drive, SpeedDrive) and drive.speed == 0.0 and drive.ramp == 0.0 and drive.over_time is None
    )


def _resists(rotor: Rotor) -> bool:
    """Return whether something acts against the rotation of a rotor: a load, a torque, a servo."""
    return rotor.load != Load() or (rotor.drive is not None and not rotor.drive.prescribes)


def _fixed_step(case: Case, packed: Packed) -> Iterator[Finding]:
    step, resolved = case.run.fixed_step, packed.restart_step
    if step is not None and step > 2.0 * resolved:
        yield Finding(
            "warning",
            "run.fixed_step",
            f"{1e6 * step:.4g} us is {step / resolved:.3g} times what resolves the fastest contact, {1e6 * resolved:.3g} us: "
            "contacts are noticed so late that the run may gain energy or leave mesh. Shorten it.",
        )
