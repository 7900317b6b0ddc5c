"""Gearboxes in the REXS format for tests: built from numbers, written as XML, JSON or zip."""

import io
import json
import math
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

DOCS = Path(__file__).resolve().parents[2] / "docs" / "gearboxes"
TWO_STAGES, PLANETARY, WORM = (
    DOCS / f"{name}.rexsz" for name in ("FVA_two_stages_1.4", "FVA_planetary_stage_1.1", "FVA_worm_stage_1.4")
)
RIGID: dict[str, Any] = {"rotational_stiffness": (1e20, "N mm / rad")}
Value = tuple[Any, str] | str | bool | int | float
KINDS = {bool: "boolean", str: "string", int: "integer", float: "floating_point"}


def unpacked(path: Path) -> str:
    """Return the text of the only member of an archive."""
    with zipfile.ZipFile(path) as archive:
        return archive.read(archive.namelist()[0]).decode("utf-8-sig")


def packed(text: str | bytes, name: str = "model.rexs") -> bytes:
    """Return an archive with one member."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, text)
    return content.getvalue()


@dataclass
class Box:
    """A model: components by number, relations, load cases."""

    version: str = "1.4"
    components: dict[int, tuple[str, str, dict[str, Value]]] = field(default_factory=dict)
    relations: list[tuple[str, dict[str, int]]] = field(default_factory=list)
    cases: dict[int, dict[int, dict[str, Value]]] = field(default_factory=dict)

    def add(self, type: str, name: str = "", parent: int | None = None, **attributes: Value) -> int:
        """Add a component, as a part of a parent, and return its number."""
        number = len(self.components) + 1
        self.components[number] = (type, name, attributes)
        if parent is not None:
            self.relate("assembly", assembly=parent, part=number)
        return number

    def relate(self, kind: str, **roles: int) -> None:
        """Add a relation."""
        self.relations.append((kind, roles))

    def shaft(
        self, name: str, at: tuple[float, float], sections: Any = ((100.0, 40.0, 0.0),), **more: Value
    ) -> int:
        """Add a shaft at a place [mm] with sections of length, outer and inner diameter [mm], held by rigid bearings."""
        number = self.add("shaft", name, **place(at), **more)
        for length, outer, inner in sections:
            self.add(
                "shaft_section", "", number, length=(length, "mm"), outer_diameter_begin=(outer, "mm"),
                outer_diameter_end=(outer, "mm"), inner_diameter_begin=(inner, "mm"), inner_diameter_end=(inner, "mm"),
            )  # fmt: skip
        return number

    def gear(
        self, shaft: int, teeth: int, module: float = 2.0, type: str = "cylindrical_gear", **more: Value
    ) -> int:
        """Add a gear to a shaft."""
        shift = more.pop("shift", None)
        number = self.add(
            type,
            f"gear {teeth}",
            shaft,
            number_of_teeth=teeth,
            normal_module=(module, "mm"),
            face_width=(20.0, "mm"),
            **more,
        )
        if shift is not None:
            flank = self.add("cylindrical_gear_flank", "", addendum_modification_coefficient=(shift, "none"))
            self.relate("flank", gear=number, left=flank)
        return number

    def stage(self, first: int, second: int, distance: float | None, **more: Value) -> int:
        """Add a stage of two gears."""
        if distance is not None:
            more["center_distance"] = (distance, "mm")
        number = self.add("cylindrical_stage", "stage", **more)
        self.relate("stage", stage=number, gear_1=first, gear_2=second)
        return number

    def hold(self, inner: int, outer: int, type: str = "concept_bearing", **more: Value) -> int:
        """Add a bearing or a coupling between two parts."""
        number = self.add(type, "", **more)
        self.relate("side", assembly=number, inner_part=inner, outer_part=outer)
        return number

    def xml(self) -> str:
        """Return the model as XML."""
        lines = [
            f'<?xml version="1.0" encoding="UTF-8"?>\n<model version="{self.version}" applicationId="t" applicationVersion="1">'
        ]
        lines.append("<relations>")
        for number, (kind, roles) in enumerate(self.relations, start=1):
            refs = "".join(f'<ref id="{each}" role="{role}"/>' for role, each in roles.items())
            lines.append(f'<relation id="{number}" type="{kind}">{refs}</relation>')
        lines.append("</relations><components>")
        lines += [_xml(number, *component) for number, component in self.components.items()]
        lines.append("</components>")
        if self.cases:
            lines.append('<load_spectrum id="1">')
            for number, parts in self.cases.items():
                inner = "".join(
                    _xml(each, self.components[each][0], "", values) for each, values in parts.items()
                )
                lines.append(f'<load_case id="{number}">{inner}</load_case>')
            lines.append("</load_spectrum>")
        return "\n".join([*lines, "</model>"])

    def json(self) -> str:
        """Return the model as JSON."""
        relations = [
            {"id": k, "type": kind, "refs": [{"id": each, "role": role} for role, each in roles.items()]}
            for k, (kind, roles) in enumerate(self.relations, start=1)
        ]
        components = [_json(number, *component) for number, component in self.components.items()]
        model: dict[str, Any] = {"version": self.version, "relations": relations, "components": components}
        if self.cases:
            cases = [
                {
                    "id": number,
                    "components": [
                        _json(each, self.components[each][0], "", values) for each, values in parts.items()
                    ],
                }
                for number, parts in self.cases.items()
            ]
            model["load_spectrum"] = {"id": 1, "load_cases": cases}
        return json.dumps({"model": model})

    def write(self, folder: Path, name: str = "box.rexs") -> Path:
        """Write the model as XML and return its path."""
        path = folder / name
        path.write_text(self.xml(), encoding="utf-8")
        return path


def place(at: tuple[float, float]) -> dict[str, Value]:
    """Return the attributes of an axis along u at a place in the plane of v and w [mm]."""
    return {
        "support_vector": ([0.0, *at], "mm"),
        "u_axis_vector": ([1.0, 0.0, 0.0], "mm"),
        "w_axis_vector": ([0.0, 0.0, 1.0], "mm"),
    }


def _xml(number: int, type: str, name: str, attributes: dict[str, Value]) -> str:
    inner = ""
    for key, given in attributes.items():
        value, unit = given if isinstance(given, tuple) else (given, "none")
        if isinstance(value, list):
            text = f"<array>{''.join(f'<c>{each}</c>' for each in value)}</array>"
        else:
            text = escape(str(value).lower() if isinstance(value, bool) else str(value))
        inner += f'<attribute id="{key}" unit="{unit}">{text}</attribute>'
    return f'<component id="{number}" type="{type}" name={quoteattr(name)}>{inner}</component>'


def _json(number: int, type: str, name: str, attributes: dict[str, Value]) -> dict[str, Any]:
    found = []
    for key, given in attributes.items():
        value, unit = given if isinstance(given, tuple) else (given, "none")
        kind = (
            "floating_point_array"
            if isinstance(value, list)
            else KINDS[bool if isinstance(value, bool) else type_of(value)]
        )
        found.append({"id": key, "unit": unit, kind: value})
    return {"id": number, "type": type, "name": name, "attributes": found}


def type_of(value: Any) -> type:
    """Return the type of a plain value."""
    return next(each for each in (str, int, float) if isinstance(value, each))


def pair(teeth: tuple[int, int] = (20, 40), module: float = 2.0, **more: Any) -> Box:
    """Return a gearbox of one pair, driven at 1000 rpm with 50 N m."""
    box = Box(**more)
    distance = 0.5 * module * sum(teeth)
    casing = box.add("gear_casing", "casing")
    first = box.shaft("Input [1]", (0.0, 0.0), rotational_speed=(1000.0, "1 / min"), defines_speed=True)
    second = box.shaft("Output [2]", (distance, 0.0))
    box.stage(box.gear(first, teeth[0], module), box.gear(second, teeth[1], module), distance)
    for shaft in (first, second):
        box.hold(shaft, casing, radial_stiffness=(1e20, "N / m"))
    box.add("external_load", "", first, torque_around_u_axis=(50.0, "N m"), transmits_torque=True)
    box.add("external_load", "", second, transmits_torque=True)
    return box


def planetary(
    box: Box, casing: int, *, sun: int | None = None, planets: int = 3, **more: Any
) -> tuple[int, int, int]:
    """Add a planetary stage 18/21/60 of module 3 mm with a fixed ring; return shafts of sun, ring and carrier."""
    a, stage = 58.5, box.add("planetary_stage", "Planets")
    sun = sun or box.shaft("Sun", (0, 0), rotational_speed=(1000.0, "1 / min"), defines_speed=True)
    ring, carrier = box.shaft("Ring", (0, 0), ((20.0, 260.0, 230.0),)), box.shaft("Carrier", (0, 0))
    gears = box.gear(sun, 18, 3.0), box.gear(ring, 60, 3.0, "ring_gear")
    for k in range(planets):
        at = (a * math.cos(2 * math.pi * k / planets), a * math.sin(2 * math.pi * k / planets))
        planet, pin = (
            box.shaft("Planet", at, ((20.0, 50.0, 30.0),)),
            box.shaft("Pin", at, ((30.0, 30.0, 0.0),)),
        )
        own = box.gear(planet, 21, 3.0, **more)
        for first, second in ((gears[0], own), (own, gears[1])):
            box.relate("assembly", assembly=stage, part=box.stage(first, second, a))
        box.hold(pin, planet, radial_stiffness=(5e8, "N / m"))
        box.hold(pin, carrier, "coupling", **RIGID)
        box.relate("planet_shaft", planetary_stage=stage, shaft=planet)
        box.relate("planet_pin", planetary_stage=stage, shaft=pin)
    box.relate("planet_carrier_shaft", planetary_stage=stage, shaft=carrier)
    box.hold(ring, casing, "coupling", **RIGID)
    box.hold(carrier, casing, radial_stiffness=(1e9, "N / m"))
    return sun, ring, carrier
