"""Gears as the file has them, and the pairs of gears of its stages."""

import math
import re
from dataclasses import dataclass, field
from typing import Any, Final

from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Component, Gearbox, refused
from gearplay.rexs.text import quantity
from gearplay.toothing.gear import DrawnGear, inv
from gearplay.toothing.pair import GearPair
from gearplay.vocabulary import quantities as q

SPUR: Final = math.radians(1e-6)
SHIFTS: Final = (
    "addendum_modification_coefficient", "addendum_modification_coefficient_after_finishing", "profile_shift_coefficient",
)  # fmt: skip
SERIES: Final = re.compile(r"(?:a|ab|b|bc|c|cd|d|e|f|g|h)(?:2[1-9]|30)")
SERIES_NAMES: Final = (
    "tooth_thickness_deviation_tolerance_series_din_3967_1978", "din_3967_deviation_tolerance_series",
)  # fmt: skip
FIELDS_3964: Final = (
    "center_distance_tolerance_field_din_3964_1980",
    "din_3964_center_distance_tolerance_field",
)
QUALITIES: Final = (
    "tolerance_class_according_to_iso_1328_2013", "accuracy_grade_iso_1328", "quality_din_3961", "gear_quality",
)  # fmt: skip


@dataclass
class Gear:
    """A gear: numbers in SI; ``shift`` is positive where material moves away from the gear's axis, for a ring too."""

    component: Component
    teeth: int
    internal: bool
    module: float
    pressure_angle: float
    helix: float
    shift: float | None
    fields: dict[str, Any] = field(default_factory=dict)
    """Further fields of a case, by name."""
    facewidth: float | None = None

    @property
    def reference_diameter(self) -> float:
        """Diameter of the reference circle [m]."""
        return self.module * self.teeth / math.cos(self.helix)


def gear_of(box: Gearbox, component: Component, notes: Notes) -> Gear:
    """Return a gear of the file; `InputError` where module or number of teeth are missing."""
    flanks = box.linked(("flank",), "gear", component.id, "left", "right")
    places = [component, *flanks]
    teeth = box.number(component, None, "number_of_teeth")
    module = box.number(component, q.LENGTH, "normal_module")
    transverse = box.number(component, q.LENGTH, "transverse_module")
    helix = box.number(component, q.ANGLE, "helix_angle_reference_diameter", "helix_angle") or 0.0
    if module is None and transverse is not None:
        module = transverse * math.cos(helix)
    if teeth is None or module is None or teeth == 0.0 or teeth != int(teeth) or module <= 0.0:
        raise refused(
            str(component),
            "must have a whole number of teeth and a normal module",
            "Add them and export it again",
        )
    internal = component.type == "ring_gear" or teeth < 0
    angle = _first(box, places, q.ANGLE, "normal_pressure_angle", "pressure_angle")
    if angle is None:
        notes.assume("no pressure angle in the file: 20 deg", component)
        angle = math.radians(20.0)
    shift = _first(box, places, None, *SHIFTS)
    length = _first(box, places, q.LENGTH, "addendum_modification")
    shift = length / module if shift is None and length is not None else shift
    # Internal gears count negative teeth in ISO 21771, and so their shift the other way.
    shift = -shift if shift is not None and internal else shift
    gear = Gear(component, abs(int(teeth)), internal, module, angle, helix, shift)
    _check_flanks(box, component, flanks, notes)
    gear.facewidth = box.number(component, q.LENGTH, "face_width")
    _tip(box, gear, notes)
    _tolerances(box, gear, places, notes)
    return gear


def _first(box: Gearbox, places: list[Component], of: Any, *names: str, unit: str = "") -> float | None:
    for place in places:
        found = box.number(place, of, *names, unit=unit)
        if found is not None:
            return found
    return None


def _check_flanks(box: Gearbox, component: Component, flanks: list[Component], notes: Notes) -> None:
    for names, of in ((SHIFTS, None), (("normal_pressure_angle",), q.ANGLE)):
        values = {box.number(flank, of, *names) for flank in flanks} - {None}
        if len(values) > 1:
            notes.leave_out(
                f"the two flanks of {component} differ in {names[0]}: both are as the left one; its back flank is off"
            )
    kinds = (
        "tip_relief",
        "root_relief",
        "profile_crowning",
        "profile_slope",
        "helix_crowning",
        "helix_slope",
    )
    for flank in flanks:
        for each in box.referenced(flank.id, *kinds, "topographical_modification", "triangular_tip_relief"):
            text = f"{each.type.replace('_', ' ')} of {component}: its flanks are unmodified involutes"
            notes.leave_out(
                f"{text}; add tip_relief by hand, the transmission error under load is too large without"
            )


def _tip(box: Gearbox, gear: Gear, notes: Notes) -> None:
    diameter = box.number(gear.component, q.LENGTH, "tip_diameter")
    if diameter is None:
        return
    size, least = abs(diameter), gear.reference_diameter - (4.0 if gear.internal else 2.0) * gear.module
    most = gear.reference_diameter + (2.0 if gear.internal else 6.0) * gear.module
    if least <= size <= most:
        gear.fields["tip_diameter"] = quantity(size, "mm")
    else:
        notes.assume(
            f"tip diameter of {gear.component} is {1e3 * size:g} mm, reference diameter {1e3 * gear.reference_diameter:.6g} mm: "
            "ignored, its addendum is 1.0 modules"
        )


def _tolerances(box: Gearbox, gear: Gear, places: list[Component], notes: Notes) -> None:
    for place in places:
        series = box.text(place, *SERIES_NAMES).strip().lower()
        if series and not gear.fields.get("allowance"):
            if SERIES.fullmatch(series):
                gear.fields["allowance"] = series
            else:
                notes.leave_out(
                    f"tooth thickness series {series[:20]!r} of {gear.component}: no series of DIN 3967"
                )
    span = [
        _first(box, places, q.LENGTH, f"{end}_backlash_allowance_referenced_to_span", unit="um")
        for end in ("upper", "lower")
    ]
    if span[0] is not None and span[1] is not None and "allowance" not in gear.fields:
        upper, lower = (each / math.cos(gear.pressure_angle) for each in span if each is not None)
        gear.fields["allowance"] = {"upper": quantity(upper, "um"), "lower": quantity(lower, "um")}
    for place in places:
        quality = box.number(place, None, *QUALITIES)
        if quality is not None and 1 <= quality <= 11:
            gear.fields["quality"] = int(quality)


@dataclass
class Pair:
    """Two gears of a stage."""

    stage: Component
    first: Gear
    second: Gear
    distance: float
    common: float | None
    """Common facewidth [m] where the file has one."""
    fields: dict[str, Any] = field(default_factory=dict)

    @property
    def facewidth(self) -> float | None:
        """Common facewidth [m]."""
        widths = [each.facewidth for each in (self.first, self.second) if each.facewidth]
        return self.common or (min(widths) if widths else None)


def pair_of(
    box: Gearbox, stage: Component, gears: dict[int, Gear], placed: float | None, notes: Notes
) -> Pair:
    """Return the pair of a stage; ``placed`` is the distance of the axes by their positions [m].

    Raises `InputError` where a gear is missing, or modules, pressure angles or helix angles do not match.
    """
    numbers = box.stage_gears(stage)
    if len(numbers) != 2 or not all(number in gears for number in numbers):
        raise refused(
            str(stage), "must have two cylindrical gears, as gear_1 and gear_2", "Export the model again"
        )
    first, second = (gears[number] for number in numbers)
    for what, a, b in (
        ("normal module", first.module, second.module),
        ("pressure angle", first.pressure_angle, second.pressure_angle),
    ):
        if not math.isclose(a, b, rel_tol=1e-6):
            raise refused(
                str(stage),
                f"must have two gears of one {what}",
                "Correct it in the program that wrote the file",
            )
    inside = first.internal or second.internal
    if first.internal and second.internal:
        raise refused(
            str(stage),
            "must have one external gear at least",
            "Correct it in the program that wrote the file",
        )
    if abs(abs(first.helix) - abs(second.helix)) > 1e-6:
        raise refused(
            str(stage), "must have two gears of one helix angle: gearplay has no crossed axes", "Correct it"
        )
    if abs(first.helix) > SPUR and (first.helix * second.helix > 0.0) != inside:
        notes.assume(f"{stage}: hands of the helices do not match; the angle is taken without its sign")
    distance = box.number(stage, q.LENGTH, "center_distance")
    if distance == 0.0:
        raise refused(str(stage), "must have a centre distance that is not 0", "Correct it, or remove it")
    if distance is None:
        distance = placed if placed else abs(_drawn(first, second).reference_distance)
        notes.assume(
            f"{stage} has no centre distance in the file: {1e3 * distance:.7g} mm, from {'positions' if placed else 'teeth'}"
        )
    elif placed is not None and abs(abs(distance) - placed) > 1e-6:
        notes.assume(
            f"{stage}: centre distance {1e3 * abs(distance):.7g} mm; its axes are {1e3 * placed:.7g} mm apart: the former holds"
        )
    pair = Pair(stage, first, second, abs(distance), box.number(stage, q.LENGTH, "common_face_width"))
    _shifts(pair, notes)
    _allowance(box, pair)
    return pair


def _drawn(*gears: Gear) -> GearPair:
    """Return a pair by its shifts, of which missing ones count 0, a ring second; its distance is not set."""
    first, second = (
        DrawnGear(
            teeth=each.teeth,
            module=each.module,
            pressure_angle=each.pressure_angle,
            helix_angle=abs(each.helix),
            internal=each.internal,
            profile_shift=each.shift or 0.0,
        )
        for each in sorted(gears, key=lambda each: each.internal)
    )
    return GearPair(first, second, math.nan)


def zero_backlash_distance(first: Gear, second: Gear) -> float:
    """Return the centre distance [m] at which a pair has no backlash, nan where there is none; missing shifts count 0."""
    return _drawn(first, second).shifted_distance


def _shifts(pair: Pair, notes: Notes) -> None:
    """Find shifts that are not in the file from the centre distance, and the sign of a ring's shift that fits it."""
    first, second = pair.first, pair.second
    missing = [each for each in (first, second) if each.shift is None]
    for ring in (first, second):
        if ring.internal and ring.shift and not missing:
            off = abs(zero_backlash_distance(first, second) - pair.distance)
            ring.shift = -ring.shift
            if not abs(zero_backlash_distance(first, second) - pair.distance) < off:
                ring.shift = -ring.shift
            else:
                notes.assume(
                    f"shift of {ring.component} counted away from its axis in the file, as the centre distance says"
                )
    if missing:
        total = _sum_of_shifts(pair)
        rest = total - sum(_signed(each) for each in (first, second) if each.shift is not None)
        rest = 0.0 if abs(rest) < 1e-6 else rest
        for each in missing:
            each.shift = (-1.0 if each.internal else 1.0) * rest / len(missing) + 0.0
        if rest:
            named = " and ".join(f"{each.component} ({each.shift:.6g})" for each in missing)
            notes.assume(
                f"profile shift of {named}: not in the file, from the centre distance of {pair.stage}"
            )


def _signed(gear: Gear) -> float:
    return (-1.0 if gear.internal else 1.0) * (gear.shift or 0.0)


def _sum_of_shifts(pair: Pair) -> float:
    """Return the sum of shifts at which the pair has no backlash at its centre distance, a ring's negative (ISO 21771)."""
    drawn = _drawn(pair.first, pair.second)
    cosine = drawn.least_distance / pair.distance
    if not 0.0 < cosine < 1.0:
        rule = f"has a centre distance, {1e3 * pair.distance:.6g} mm, at which its involutes cannot touch"
        raise refused(str(pair.stage), rule, "Correct it in the program that wrote the file")
    teeth = sum(each.sign * each.teeth for each in (drawn.first, drawn.second))
    opened = inv(math.acos(cosine)) - inv(drawn.first.transverse_angle)
    return opened * teeth / (2.0 * math.tan(drawn.first.pressure_angle))


def _allowance(box: Gearbox, pair: Pair) -> None:
    upper, lower = (
        box.number(pair.stage, q.LENGTH, f"{end}_center_distance_allowance", unit="um")
        for end in ("upper", "lower")
    )
    if upper is not None and lower is not None:
        pair.fields["center_distance_allowance"] = {
            "upper": quantity(upper, "um"),
            "lower": quantity(lower, "um"),
        }
        return
    found = box.text(pair.stage, *FIELDS_3964).strip().lower()
    grade = re.fullmatch(r"(?:js)?(\d{1,2})(?:\.0)?", found)
    if grade:
        pair.fields["center_distance_allowance"] = f"js{grade[1]}"
