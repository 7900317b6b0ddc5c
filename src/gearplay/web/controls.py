"""Controls of the page: every field of a case with label, unit, bounds and slider range."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from gearplay.model.case import Case
from gearplay.model.field_units import measure_in
from gearplay.model.torsional_pair import PARTS
from gearplay.parts.environment import Material
from gearplay.parts.mesh.schema import PlanetMesh
from gearplay.parts.mesh.train.geometry import is_held
from gearplay.parts.rotor.gear import Toothing
from gearplay.schema.fields import HertzStiffness, Measure
from gearplay.vocabulary import quantities as q

GROUPS: Mapping[str, str] = {
    "planetary": "Planetary sets",
    "torsional_pair": "Torsional pair",
    "sleeves": "Sleeves",
    "bearings": "Rolling bearings",
    "supports": "Supports",
    "faults": "Faults",
    "meshes": "Mesh",
    "couplings": "Couplings",
    "rotors.drive": "Drive and load",
    "rotors": "Gears",
    "base": "Housing",
    "environment": "Temperature",
    "": "Model",
    "run": "Run",
}
"""Groups of controls, in order, by the first part of a field's path."""
SKIPPED = frozenset(
    [
        "title",
        "position",
        "on",
        "gravity",
        "driver",
        "driven",
        "floating",
        "internal",
        "max_wall_time",
        "max_steps",
        "reference_temperature",
        "temperature_range",
        "center_distance",
        "helix_angle",
        "thickness",
        "tip_diameter",
    ]
)
"""Fields that a slider cannot change without changing the mechanism, and limits that the server sets."""

SPANS: Mapping[str, tuple[float, float]] = {
    q.LENGTH.name: (0.0, 200e-6),
    q.ANGLE.name: (-math.pi, math.pi),
    q.ROTATIONAL_DRAG.name: (0.0, 1e-2),
    q.TORQUE.name: (0.0, 1.0),
    q.TIME.name: (0.0, 1.0),
    q.DAMPING.name: (0.0, 100.0),
    q.SPEED.name: (-1e-2, 1e-2),
    q.ANGULAR_SPEED.name: (-10.0, 10.0),
    q.RATIO.name: (0.0, 1.0),
    q.STIFFNESS.name: (0.0, 1e8),
    q.ROTATIONAL_STIFFNESS.name: (0.0, 1e4),
}
"""Sliders of fields that are 0 now, by quantity [SI]."""
WARMER = 150.0
"""Half of the range of a temperature slider [K]."""
BASIC = frozenset(
    [
        "amplitude",
        "backlash",
        "backlash_model",
        "internal_clearance",
        "drag",
        "duration",
        "ensemble",
        "friction",
        "friction_coefficient",
        "mean",
        "play",
        "radial_clearance",
        "ratio",
        "restitution",
        "speed",
        "stiffness",
        "temperature",
        "torque",
        "torsional_stiffness",
        "transient",
    ]
)
"""Fields that are shown first; the others of a part are folded."""
OF_CENTRE = (".vx", ".vy")
"""Velocities that must be 0 where a centre is held."""
OF_MATERIAL = ("modulus", "poisson", "density")


@dataclass(frozen=True)
class Control:
    """One field of a case as a page shows it; numbers are in its display unit, ``factor`` of SI and ``offset``."""

    path: str
    group: str
    owner: str
    label: str
    about: str
    kind: str  # number, integer, choice or switch
    value: float | int | str | bool | None
    unit: str = ""
    factor: float = 1.0
    offset: float = 0.0
    least: float | None = None
    most: float | None = None
    low: float | None = None
    high: float | None = None
    logarithmic: bool = False
    choices: tuple[str, ...] = ()
    basic: bool = False


def controls(case: Case) -> list[dict[str, Any]]:
    """Return the controls of a case, grouped, in the order of its fields.

    >>> from gearplay.model.reading import load_case
    >>> by_path = {each["path"]: each for each in controls(load_case("han2021"))}
    >>> each = by_path["meshes.0.backlash"]
    >>> each["group"], each["owner"], each["unit"], round(each["value"], 6), each["least"]
    ('Mesh', 'pinion-ring', 'um', 100.0, 0.0)
    """
    order = list(GROUPS.values())
    held = tuple(f"rotors.{name}.initial." for name in case.rotors if is_held(case, name))
    shown = (
        each
        for each in _walk(case, "", "")
        if not (each.path.startswith(held) and each.path.endswith(OF_CENTRE))
    )
    found = sorted(shown, key=lambda control: order.index(control.group))
    return [asdict(replace(each, basic=each.path.rpartition(".")[2] in BASIC)) for each in found]


def _walk(part: Any, path: str, owner: str) -> Iterator[Control]:
    if isinstance(part, BaseModel):
        for name, info in type(part).model_fields.items():
            if isinstance(part, Case) and part.torsional_pair is not None and name in PARTS:
                continue  # they follow from the pair
            if name in SKIPPED or (name == "angle" and path.startswith("meshes")):
                continue
            if isinstance(part, Material) and name in OF_MATERIAL:  # they do not act
                continue
            if isinstance(part, Toothing) and name in Toothing.model_fields and name not in part.drawn:
                continue
            here, value = f"{path}.{name}".lstrip("."), getattr(part, name)
            about = info.description or ""
            annotations = (*info.metadata, info.annotation)
            if _is_vector(value):
                yield from _components(part, name, here, owner, value, info.annotation)
            elif isinstance(value, (BaseModel, Mapping, tuple)):
                yield from _walk(value, here, owner)
            else:
                control = _control(part, name, here, owner, value, annotations, about)
                if control is not None:
                    yield control
    elif isinstance(part, Mapping):
        for name, value in part.items():
            if "." in name:  # a member of a planetary set, whose table has its fields
                continue
            yield from _walk(value, f"{path}.{name}", f"{owner}.{name}".lstrip("."))
    elif isinstance(part, tuple):
        for at, value in enumerate(part):
            if isinstance(value, BaseModel) and not isinstance(value, PlanetMesh):
                yield from _walk(value, f"{path}.{at}", getattr(value, "label", owner))


def _is_vector(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and all(isinstance(each, float) for each in value)


def _components(
    part: BaseModel, name: str, path: str, owner: str, value: tuple[float, ...], annotation: Any
) -> Iterator[Control]:
    """Yield a control for each of two components along x and y."""
    items = _items_of(annotation)
    for at, (each, axis) in enumerate(zip(value, "xy", strict=True)):
        control = _control(part, name, f"{path}.{at}", owner, each, get_args(items[at])[1:], "")
        if control is not None:
            yield replace(control, label=f"{_label(path, name)} along {axis}")


def _items_of(annotation: Any) -> tuple[Any, ...]:
    """Return the annotation of a tuple's items; the tuple may be optional or annotated itself."""
    if get_origin(annotation) is tuple:
        return get_args(annotation)
    return next((items for inner in get_args(annotation) if (items := _items_of(inner))), ())


def _control(
    part: BaseModel, name: str, path: str, owner: str, value: Any, annotations: tuple[Any, ...], about: str
) -> Control | None:
    group, label = _group(path), _label(path, name)
    choices = _choices(annotations)
    if choices:
        if len(choices) == 1 or value is None:  # the kind of a union: another one has other fields
            return None
        return Control(path, group, owner, label, about, "choice", value, choices=choices)
    if isinstance(value, bool):
        return Control(path, group, owner, label, about, "switch", value)
    if isinstance(value, int):
        least, most = _bounds(annotations)
        return Control(
            path, group, owner, label, about, "integer", value, least=least, most=most, low=least,
            high=min(most if most is not None else math.inf, max(10.0 * value, 10.0)),
        )  # fmt: skip
    if not isinstance(value, float):
        return None
    measure = measure_in(annotations)
    if measure is None:
        return None
    unit, factor = _shown(part, path, measure)
    least, most = (_either(measure.ge, measure.gt), _either(measure.le, measure.lt))
    low, high, logarithmic = slider(value, measure)
    offset = measure.quantity.display_offset if measure.quantity is not None else 0.0
    return Control(
        path, group, owner, label, measure.about, "number", value * factor + offset, unit, factor, offset,
        None if least is None else least * factor + offset, None if most is None else most * factor + offset,
        low * factor + offset, high * factor + offset, logarithmic,
    )  # fmt: skip


def slider(value: float, measure: Measure) -> tuple[float, float, bool]:
    """Return a slider's ends [SI] for a number and whether it should run in logarithms.

    >>> slider(1e-4, Measure(q.LENGTH, "clearance", ge=0.0, le=0.1)), slider(1e8, Measure(q.STIFFNESS, "mean", gt=0.0))
    ((0.0, 0.0004, False), (10000000.0, 1000000000.0, True))
    >>> slider(0.9, Measure(None, "restitution", gt=0.0, le=1.0)), slider(1e-9, Measure(None, "tolerance", ge=1e-13, le=1e-2))
    ((0.01, 1.0, False), (1e-13, 0.01, True))
    """
    least, most = _either(measure.ge, measure.gt), _either(measure.le, measure.lt)
    low, high = -math.inf if least is None else least, math.inf if most is None else most
    if measure.quantity in (None, q.RATIO) and high - low <= 10.0:
        if low > 0.0 and high / low > 1e3:
            return low, high, True
        edge = 0.01 * (high - low)
        return (
            low if measure.ge is not None else low + edge,
            high if measure.le is not None else high - edge,
            False,
        )
    if measure.quantity is q.TEMPERATURE:
        return max(low, value - WARMER), min(high, value + WARMER), False
    if measure.quantity is q.ANGLE and low == 0.0:  # of a play
        return 0.0, min(high, max(4.0 * value, 0.01)), False
    if measure.quantity is q.ANGLE:  # of more than half a turn too
        return max(low, min(value, -math.pi)), min(high, max(value, math.pi)), False
    if value == 0.0:
        name = measure.quantity.name if measure.quantity is not None else q.RATIO.name
        first, last = SPANS.get(name, (0.0, 1.0))
        return max(low, first), min(high, last), False
    if measure.ge == 0.0:
        return 0.0, min(high, 4.0 * value), False
    ends = sorted((0.1 * value, 10.0 * value))
    return max(low, ends[0]), min(high, ends[1]), value > 0.0


def _either(one: float | None, other: float | None) -> float | None:
    return one if one is not None else other


def _shown(part: BaseModel, path: str, measure: Measure) -> tuple[str, float]:
    """Return the display unit of a field and the factor from SI to it."""
    if isinstance(measure, HertzStiffness):
        return q.hertz_stiffness(getattr(part, "exponent", 1.5)).unit, 1.0
    if measure.quantity is None:
        return "", 1.0
    if path.endswith((".module", "radius", "facewidth")):  # sizes, not clearances
        return "mm", 1e3
    unit = "" if measure.quantity.display_unit == "1" else measure.quantity.display_unit
    return unit, measure.quantity.display_factor


def _choices(annotations: tuple[Any, ...]) -> tuple[str, ...]:
    for each in annotations:
        if get_origin(each) is Literal:
            return tuple(str(choice) for choice in get_args(each))
    return ()


def _bounds(annotations: tuple[Any, ...]) -> tuple[float | None, float | None]:
    """Return the least and the largest value that annotations allow, those within a union too."""
    least: Any = None
    most: Any = None
    for each in annotations:
        inner = tuple(each.metadata) if isinstance(each, FieldInfo) else get_args(each)
        below, above = _bounds(inner) if inner else (None, None)
        least = (
            each.ge if isinstance(each, Ge) else each.gt if isinstance(each, Gt) else _either(below, least)
        )
        most = each.le if isinstance(each, Le) else each.lt if isinstance(each, Lt) else _either(above, most)
    return least, most


def _group(path: str) -> str:
    head, *parts = path.split(".")
    if head == "rotors" and parts[1:2] in (["material"], ["temperature"]):
        head = "environment"
    elif head == "rotors" and len(parts) > 2 and parts[1] in ("drive", "load"):
        head = "rotors.drive"
    return GROUPS.get(head, GROUPS[""])


def _label(path: str, name: str) -> str:
    """Return the label of a field, with the part it belongs to where its own name is ambiguous.

    >>> _label("meshes.0.transmission_error.0.amplitude", "amplitude"), _label("rotors.ring.load.drag", "drag")
    ('transmission error 1: amplitude', 'load: drag')
    """
    parts = path.split(".")
    inner = parts[1:-1] if parts[0] == "run" or len(parts) < 3 else parts[2:-1]
    words = [str(int(part) + 1) if part.isdigit() else part.replace("_", " ") for part in inner]
    own = name.replace("_", " ")
    return f"{' '.join(words)}: {own}" if words else own
