"""Faults of gears as drawn: violations of a pair, of a stiffness from the teeth, of a standard's table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from gearplay.parts.mesh.faults import ChipFault, CrackFault, GearFault, SpallFault, WearFault
from gearplay.parts.mesh.stiffness import TeethStiffness
from gearplay.parts.mesh.train import geometry
from gearplay.toothing.allowances import distance_allowance
from gearplay.toothing.cracks import Crack, crack_tip
from gearplay.toothing.gear import DrawnGear, full_tip_radius
from gearplay.toothing.pair import GearPair
from gearplay.vocabulary.errors import NO_VALUE, Fault

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train
    from gearplay.parts.rotor.gear import Toothing

SAME = 1e-9
"""Difference of helix angles [rad] that is rounding."""


def mesh_path(case: Train, j: int, *fields: str) -> str:
    """Return the path of a field of a mesh, which may be one of a planetary set."""
    return case.settable_path(".".join(["meshes", str(j), *fields]))


def drawn_faults(case: Train) -> list[Fault]:
    """Return the faults of the gears of a case whose parts are valid, each once."""
    found = [fault for j in range(len(case.meshes)) for fault in _mesh_faults(case, j)]
    found += _lost_faults(case)
    return list({(fault.path, fault.rule): fault for fault in found}.values())


def gear_path(case: Train, name: str, *fields: str) -> str:
    """Return the path of a field of a gear, which may be one of several of a rotor or a member of a planetary set."""
    rotor = geometry.rotor_of(case, name)
    full = geometry.full_name(case, name)
    return case.field_path(
        rotor, *(["gears", full.removeprefix(f"{rotor}.")] if full != rotor else []), *fields
    )


def _mesh_faults(case: Train, j: int) -> Iterator[Fault]:
    mesh = case.meshes[j]
    given = {name: geometry.gear_of(case, name) for name in (mesh.driver, mesh.driven)}
    is_drawn = mesh.center_distance is not None or any(gear.drawn for gear in given.values())
    if mesh.backlash is None and not is_drawn:
        yield Fault(mesh_path(case, j, "backlash"), NO_VALUE, "is required", "Add it")
        return
    if not is_drawn and not isinstance(mesh.stiffness, TeethStiffness) and mesh.contact == "mesh":
        yield from _tooth_fault_faults(case, j, given)
        return
    if case.formulation == "as_published" and (is_drawn or mesh.contact == "pairs"):
        rule = "must be of full-depth spur teeth without shift, in one contact, as published"
        yield Fault(mesh_path(case, j), mesh.label, rule, 'Take formulation = "geometric"')
        return
    (one, first), (other, second) = given.items()
    if abs(abs(first.helix_angle) - abs(second.helix_angle)) > SAME:
        rule = f"must be that of {one}, {math.degrees(first.helix_angle):.6g} deg, of either hand, since they mesh"
        shown = f"{math.degrees(second.helix_angle):.6g} deg"
        yield Fault(gear_path(case, other, "helix_angle"), shown, rule, "Give both gears the same one")
        return
    faults = [fault for name, gear in given.items() for fault in _gear_faults(case, j, name, gear)]
    faults += [*_stiffness_faults(case, j, given), *_pair_faults(case, j, given)]
    yield from faults or [*_distance_faults(case, j), *_tooth_fault_faults(case, j, given)]


def _gear_faults(case: Train, j: int, name: str, gear: Toothing) -> Iterator[Fault]:
    mesh = case.meshes[j]
    teeth, internal = geometry.teeth_of(case, name), geometry.gear_of(case, name).internal
    if math.isnan(gear.thickness_change(mesh.module, mesh.pressure_angle, teeth, 1.0)[0]):
        rule = "must be given in lengths for a reference diameter over 1000 mm, beyond the table of DIN 3967"
        cure = 'Write { upper = "...", lower = "..." }'
        yield Fault(gear_path(case, name, "allowance"), gear.allowance, rule, cure)
        return
    drawn = gear.drawing(mesh.module, mesh.pressure_angle, teeth, internal=internal)
    roundest = full_tip_radius(mesh.pressure_angle, gear.dedendum)
    if "tip_radius" in gear.drawn and gear.tip_radius > roundest:
        rule = f"must be at most {roundest:.4g} modules, the full round of a rack of this pressure angle and dedendum"
        yield Fault(gear_path(case, name, "tip_radius"), gear.tip_radius, rule, "Lower it or the dedendum")
    elif roundest < 0.0 and "dedendum" in gear.drawn:
        rule = "must leave the rack's teeth a tip: they are pointed before this dedendum"
        yield Fault(gear_path(case, name, "dedendum"), gear.dedendum, rule, "Lower it or the pressure angle")
    yield from _circle_faults(case, name, gear, drawn)
    if not 0.0 < drawn.normal_thickness < math.pi * drawn.module:
        rule = (
            f"must leave a tooth and a space at the reference circle: the tooth is {1e3 * drawn.normal_thickness:.4g} mm thick, "
            f"the pitch is {1e3 * math.pi * drawn.module:.4g} mm"
        )
        field = next((each for each in ("thickness", "allowance") if each in gear.drawn), "profile_shift")
        yield Fault(gear_path(case, name, field), NO_VALUE, rule, "Check the number and its unit")


def _circle_faults(case: Train, name: str, gear: Toothing, drawn: DrawnGear) -> Iterator[Fault]:
    """Refuse tip circles within root circles or, of external gears, within base circles; bores that cut into the teeth."""
    field = "tip_diameter" if gear.tip_diameter is not None else "addendum"
    path = gear_path(case, name, field)
    shown = f"{2e3 * drawn.tip:.6g} mm" if field == "tip_diameter" else f"{gear.addendum:g}"
    cure = "Check the number and its unit, profile_shift and module"
    root, base = 2e3 * drawn.root, 2e3 * drawn.base_radius
    if drawn.sign * (drawn.tip - drawn.root) <= 0.0:
        side = "less" if drawn.internal else "more"
        rule = f"must give a tip diameter of {side} than {root:.6g} mm, that of the root circle"
        yield Fault(path, shown, rule, cure)
    elif not drawn.internal and drawn.tip <= drawn.base_radius:
        rule = f"must give a tip diameter of more than {base:.6g} mm, that of the base circle"
        yield Fault(path, shown, rule, cure)
    if drawn.bore is None:
        return
    if drawn.internal:
        rule = "must not be given for an internal gear, whose rim counts as rigid"
        yield Fault(gear_path(case, name, "bore"), f"{1e3 * drawn.bore:.6g} mm", rule, "Remove it")
    elif drawn.bore >= 2.0 * drawn.root:
        rule = f"must be less than the root diameter, {root:.6g} mm"
        yield Fault(gear_path(case, name, "bore"), f"{1e3 * drawn.bore:.6g} mm", rule, "Check both")


def _stiffness_faults(case: Train, j: int, given: Mapping[str, Toothing]) -> Iterator[Fault]:
    mesh = case.meshes[j]
    if not isinstance(mesh.stiffness, TeethStiffness):
        return
    for name, gear in given.items():
        if gear.facewidth is None:
            rule = 'is required by stiffness kind "teeth"'
            yield Fault(gear_path(case, name, "facewidth"), NO_VALUE, rule, "Give the width of the teeth")
        if mesh.stiffness.method != "potential-energy":
            continue
        internal = geometry.gear_of(case, name).internal
        if gear.helix_angle:
            rule = "must be iso6336 for helical gears"
            path = mesh_path(case, j, "stiffness", "method")
            yield Fault(path, "potential-energy", rule, 'Take method = "iso6336"')
        if gear.bore is None and not internal:
            rule = "is required by potential-energy, for the stiffness of the body under the teeth"
            yield Fault(gear_path(case, name, "bore"), NO_VALUE, rule, 'Give it, or take method = "iso6336"')
        drawn = gear.drawing(
            mesh.module, mesh.pressure_angle, geometry.teeth_of(case, name), internal=internal
        )
        if not internal and drawn.undercut > 0.0:
            rule = f"must be iso6336 for undercut teeth, as those of {name} are"
            cure = f'Take method = "iso6336", or a profile_shift of {drawn.profile_shift + drawn.undercut:.3g} or more'
            yield Fault(mesh_path(case, j, "stiffness", "method"), "potential-energy", rule, cure)


def _pair_faults(case: Train, j: int, given: Mapping[str, Toothing]) -> Iterator[Fault]:
    """Refuse fields that contact by pairs of teeth excludes, and deviations that a mesh cannot follow."""
    mesh = case.meshes[j]
    if mesh.contact == "pairs":
        if not isinstance(mesh.stiffness, TeethStiffness):
            rule = 'must be "teeth" with contact = "pairs", which takes the stiffness of single pairs from the teeth'
            cure = 'Write stiffness = { kind = "teeth", method = "iso6336" } and give both gears a facewidth'
            yield Fault(mesh_path(case, j, "stiffness", "kind"), mesh.stiffness.kind, rule, cure)
        if case.backlash_model != "coupled":
            rule = 'must be mesh with backlash_model = "uncoupled", whose line of action does not follow the centres'
            yield Fault(mesh_path(case, j, "contact"), "pairs", rule, 'Take backlash_model = "coupled"')
    for name, gear in given.items():
        if gear.helix_angle and gear.deviations is not None and any(gear.deviations.form):
            rule = "must not be given for helical gears, along whose oblique lines of contact a sine has no closed form"
            cure = "Remove it; pitch, slope and tip_relief may stay"
            yield Fault(gear_path(case, name, "deviations", "form"), NO_VALUE, rule, cure)
        if gear.helix_angle and gear.facewidth is None and any(_varies(case, each) for each in given):
            rule = "is required by tip relief, profile slopes and wear of helical gears, which vary over it"
            yield Fault(gear_path(case, name, "facewidth"), NO_VALUE, rule, "Give the width of the teeth")
        if gear.deviates and gear.quality is None and not follows_centres(case):
            field = "tip_relief" if gear.tip_relief is not None else "deviations"
            rule = 'must not be given with backlash_model = "uncoupled", whose line of action does not follow the centres'
            yield Fault(gear_path(case, name, field), NO_VALUE, rule, 'Take backlash_model = "coupled"')
        if gear.deviations is None:
            continue
        teeth = geometry.teeth_of(case, name)
        for field in ("pitch", "slope", "form"):
            count = len(getattr(gear.deviations, field))
            if count not in (0, teeth):
                rule = f"must have one item for each of the {teeth} teeth"
                yield Fault(
                    gear_path(case, name, "deviations", field),
                    f"{count} items",
                    rule,
                    "Add or remove items",
                )


def _varies(case: Train, name: str) -> bool:
    """Return whether what is missing on a gear's flanks varies over them: relief, given profile slopes, wear."""
    gear = geometry.gear_of(case, name)
    sloping = gear.deviations is not None and any(gear.deviations.slope)
    worn = any(isinstance(fault, WearFault) for _, fault in tooth_faults(case, name))
    return gear.tip_relief is not None or sloping or worn


def _tooth_fault_faults(case: Train, j: int, given: Mapping[str, Toothing]) -> Iterator[Fault]:
    """Refuse faults of teeth that a mesh cannot follow, and cracks beyond the middle of a tooth."""
    mesh = case.meshes[j]
    for name, gear in given.items():
        for index, fault in tooth_faults(case, name):
            path = f"faults.{index}.kind"
            if not fault.fits_contact(mesh):
                rule = f'must be in meshes with contact = "pairs", as it takes stiffness from single ones; {mesh.label} is not'
                yield Fault(path, fault.kind, rule, 'Write contact = "pairs" in the mesh')
            elif gear.helix_angle and not (fault.along_facewidth or getattr(fault, "depth_alone", False)):
                rule = f"must be of spur gears: along the oblique lines of contact of {mesh.label} it has no closed form"
                cure = 'Take kind = "pitch", "missing-tooth", "eccentricity", or "wear" with a depth'
                yield Fault(path, fault.kind, rule, cure)
            elif not follows_centres(case):
                rule = "must not be given where the line of action does not follow the centres"
                cure = (
                    'Take backlash_model = "coupled" and formulation = "geometric", or kind = "eccentricity"'
                )
                yield Fault(path, fault.kind, rule, cure)
            elif isinstance(fault, CrackFault):
                drawn = gear.drawing(
                    mesh.module, mesh.pressure_angle, geometry.teeth_of(case, name), internal=False
                )
                beyond = -crack_tip(drawn, Crack(fault.depth, fault.angle))[0]
                if beyond > 0.0:
                    deepest = fault.depth - beyond / math.sin(fault.angle)
                    rule = f"must be at most {1e3 * deepest:.4g} mm, where the crack reaches the middle of the tooth"
                    cure = 'Lower it, or take kind = "missing-tooth"'
                    yield Fault(f"faults.{index}.depth", f"{1e3 * fault.depth:.6g} mm", rule, cure)


def gear_faults(case: Train, name: str) -> list[tuple[int, Any]]:
    """Return the faults of a gear with their places in the case."""
    full = geometry.full_name(case, name)
    return [
        (index, fault)
        for index, fault in enumerate(case.faults)
        if isinstance(fault, GearFault) and geometry.full_name(case, fault.at) == full
    ]


def tooth_faults(case: Train, name: str) -> list[tuple[int, Any]]:
    """Return the faults of the teeth of a gear with their places in the case; without eccentricity, which every mesh has."""
    return [(index, fault) for index, fault in gear_faults(case, name) if fault.of_teeth]


def follows_centres(case: Train) -> bool:
    """Return whether lines of action follow the actual centres, as deviations of teeth need."""
    return case.formulation == "geometric" and case.backlash_model == "coupled"


def deviates(case: Train, j: int) -> bool:
    """Return whether teeth of mesh j deviate from involutes in their places, so that its pairs of teeth differ."""
    names = geometry.gears_of_pair(case, j)
    return follows_centres(case) and any(
        geometry.gear_of(case, name).deviates or tooth_faults(case, name) for name in names
    )


def draws_deviations(case: Train) -> bool:
    """Return whether deviations of teeth are drawn, for each member others."""
    gears = (gear for rotor in case.rotors.values() for gear in (rotor, *rotor.gears.values()))
    return bool(follows_centres(case) and case.meshes) and any(gear.quality for gear in gears)


def _lost_faults(case: Train) -> Iterator[Fault]:
    """Refuse faults of gears that would be lost: of a gear in no mesh, of one tooth and flank twice where one is kept."""
    meshed = {geometry.full_name(case, name) for mesh in case.meshes for name in (mesh.driver, mesh.driven)}
    seen: dict[tuple[str, str, int, str], int] = {}
    for index, fault in enumerate(case.faults):
        if not isinstance(fault, GearFault):
            continue
        name = geometry.full_name(case, fault.at)
        if name not in meshed:
            rule, cure = "must be a gear in a mesh", f"Meshes have: {', '.join(sorted(meshed))}"
            yield Fault(f"faults.{index}.at", fault.at, rule, cure if meshed else "Add a mesh")
        elif isinstance(fault, (CrackFault, ChipFault, SpallFault)) or (
            isinstance(fault, WearFault) and fault.profile
        ):
            flank, tooth = getattr(fault, "flank", "both"), getattr(fault, "tooth", -1)
            keys = [(name, fault.kind, tooth, side) for side in ("left", "right") if flank in (side, "both")]
            first = next((seen[key] for key in keys if key in seen), None)
            if first is not None:
                field, shown = (
                    ("profile", f"{len(fault.profile)} points")
                    if isinstance(fault, WearFault)
                    else ("tooth", fault.tooth)
                )
                rule = f"must not be that of faults.{first}, a {fault.kind} of the same gear and flank"
                yield Fault(f"faults.{index}.{field}", shown, rule, "Keep one of the two")
            seen |= dict.fromkeys(keys, index)


def _distance_faults(case: Train, j: int) -> Iterator[Fault]:
    """Refuse working centre distances at which tips strike roots or do not reach, and grades beyond their table."""
    mesh = case.meshes[j]
    pair = geometry.pair_of(case, j)
    if math.isnan(pair.shifted_distance):
        names = " and ".join((mesh.driver, mesh.driven))
        rule = f"must let {names} mesh: the profile shifts leave no centre distance without backlash"
        path = gear_path(case, mesh.driver, "profile_shift")
        yield Fault(path, geometry.gear_of(case, mesh.driver).profile_shift, rule, "Correct the shifts")
        return
    least, most = pair.range_of_distances
    grade = mesh.center_distance_allowance
    if not least < pair.distance < most:
        if mesh.center_distance is None and pair.distance in (pair.reference_distance, pair.shifted_distance):
            yield _tip_fault(case, j, pair)
            return
        path = mesh_path(case, j, "center_distance")
        if mesh.center_distance is None:
            path = case.field_path(mesh.rotors[1], "position")
        rule = (
            f"must be between {1e3 * least:.6g} and {1e3 * most:.6g} mm for these teeth to mesh, and is "
            f"{1e3 * pair.shifted_distance:.6g} mm without backlash"
        )
        shown = f"{1e3 * pair.distance:.6g} mm"
        yield Fault(path, shown, rule, "Check the number, profile shifts and tip diameters")
    elif isinstance(grade, str) and distance_allowance(int(grade[2:]), pair.distance) is None:
        rule = "must be given in lengths for a centre distance over 3150 mm, beyond the grades of ISO 286-1"
        path = mesh_path(case, j, "center_distance_allowance")
        yield Fault(path, grade, rule, 'Write { upper = "...", lower = "..." }')


def _tip_fault(case: Train, j: int, pair: GearPair) -> Fault:
    """Return the fault of tips that strike roots, or do not reach the other gear, at the distance that follows from the gears."""
    names = geometry.gears_of_pair(case, j)
    k = 0 if pair.tip_clearances[0] <= pair.tip_clearances[1] else 1
    gear, gap = (pair.first, pair.second)[k], pair.tip_clearances[k]
    field = "tip_diameter" if gear.tip_diameter is not None else "addendum"
    shown = f"{2e3 * gear.tip:.6g} mm" if gear.tip_diameter is not None else f"{gear.addendum:g}"
    where = f"at their centre distance, {1e3 * pair.distance:.6g} mm"
    rule = f"must let tips reach the teeth of {names[1 - k]} {where}"
    if gap <= 0.0:
        rule = f"must leave the roots of {names[1 - k]} a clearance {where}, where tips reach {-1e3 * gap:.4g} mm into them"
    cure = "Correct tip diameter or addendum, the dedendum of the other gear, or profile shifts"
    return Fault(gear_path(case, names[k], field), shown, rule, cure)
