"""Notes on types of components and attributes that the import does not read."""

from collections import Counter
from typing import Final

from gearplay.parts.environment import REFERENCE
from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Attribute, Gearbox
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import shorten

READ: Final = frozenset({
    "shaft", "shaft_section", "side_plate", "cylindrical_gear", "ring_gear", "cylindrical_stage", "planetary_stage", "material",
    "coupling", "switchable_coupling", "fixed_coupling", "external_load", "gear_unit", "planet_carrier", "additional_mass",
    "flank_geometry", "cylindrical_gear_flank", "concept_bearing", "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry", "slide_bearing", "hydrodynamic_radial_plain_bearing", "gear_casing",
})  # fmt: skip
"""Types of components that are read."""
CONSEQUENCES: Final = {
    "lubricant": "teeth have no friction and bearings no drag; add friction_coefficient and drag",
    "rack_shaped_tool": "roots of the teeth are those of a standard rack",
    "cutter_wheel_tool": "roots of the teeth are those of a standard rack",
    "rolling_bearing_row": "bearings are supports without rolling elements",
    "rolling_element": "bearings are supports without rolling elements",
    "gear_body": "mass and elasticity of gear bodies are missing; import with solid gear bodies adds their mass",
}
"""Consequence of each type of components that is not read."""
PLACES: Final = frozenset({
    "reference_component_for_position", "support_vector", "u_axis_vector", "w_axis_vector", "u_coordinate_on_shaft",
    "u_coordinate_on_shaft_inner_side", "u_coordinate_on_shaft_outer_side", "u_coordinate_on_shaft_side_1",
    "u_coordinate_on_shaft_side_2",
})  # fmt: skip
"""Attributes of places along shafts, about which the import has a note of its own."""


def note_unread(box: Gearbox, notes: Notes) -> None:
    """Note every type of components and every attribute that was not read, and attributes whose value was lost."""
    _note_temperatures(box, notes)
    for name, count in box.lost.items():
        notes.assume(
            f"{shorten(name)} of {count} components is a truth value instead of its value: taken as not given"
        )
    for kind, count in sorted(Counter(each.type for each in box.components.values()).items()):
        if kind not in READ:
            consequence = CONSEQUENCES.get(kind, "it does not act on the case")
            notes.skip(f"{shorten(kind)} ({count}): {consequence}")
    if box.accumulated:
        notes.skip("results over the load cases (accumulation)")
    left: dict[str, set[str]] = {}
    loaded = box.load_case.attributes if box.load_case is not None else {}
    for component in box.components.values():
        if component.type in READ:
            for name, attribute in (component.attributes | loaded.get(component.id, {})).items():
                read = (component.type, name) in box.read or name in PLACES
                if not read and not _is_nothing(attribute):
                    left.setdefault(component.type, set()).add(shorten(name))
    for kind, names in sorted(left.items()):
        notes.skip(f"attributes of {kind}: {', '.join(sorted(names))}")


def _is_nothing(attribute: Attribute) -> bool:
    value = attribute.value
    if isinstance(value, str):
        try:
            return float(value) == 0.0
        except ValueError:
            return value == ""
    return value in (0, None) and not isinstance(value, bool)


def _note_temperatures(box: Gearbox, notes: Notes) -> None:
    found = {
        temperature
        for component in box.components.values()
        for name in ("mean_operating_temperature", "temperature_lubricant")
        if (temperature := box.number(component, q.TEMPERATURE, name)) is not None
        and abs(temperature - REFERENCE) > 0.5
    }
    if found:
        shown = ", ".join(f"{each - 273.15:.4g} degC" for each in sorted(found))
        notes.leave_out(
            f"temperatures of the file ({shown}): lengths and backlash hold at 20 degC; a table [environment] with a "
            "temperature lets them follow"
        )
