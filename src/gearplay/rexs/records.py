"""A REXS model: components with attributes, relations between them, load cases; access with units."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Final

from gearplay.schema.fields import LARGEST
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError, shorten
from gearplay.vocabulary.quantities import Quantity

VERSIONS: Final = tuple(f"1.{minor}" for minor in range(7))
_UNITS: Final = {
    "°": "deg", "C": "degC", "mum": "um", "1e-6 / C": "um/(m K)", "1 / min": "rpm", "kg / dm^3": "g/cm^3", "N / mm^2": "MPa",
}  # fmt: skip
"""Units of REXS that have another name here."""
_STANDARD: Final = {
    "m": "mm", "rad": "deg", "rad/s": "rpm", "N m": "N m", "N/m": "N/m", "N m/rad": "N mm/rad", "N": "N",
    "kg/m^3": "g/cm^3", "Pa": "MPa", "1/K": "um/(m K)", "W": "kW", "m/s^2": "m/s^2", "kg": "kg", "K": "degC",
}  # fmt: skip
"""Unit of the standard by SI unit, for an attribute that gives none."""
STIFF: Final = (q.STIFFNESS, q.ROTATIONAL_STIFFNESS, q.PRESSURE)
"""Quantities of which programs write 1e20 and more for what is rigid."""
INFINITE: Final = 1e30
MOST_COMPONENTS: Final = 20_000
MOST_RELATIONS: Final = 100_000
MOST_GEARS: Final = 800
POWER: Final = Quantity("power", "P", "W", "kW", 1e-3, "power")


def refused(where: str, rule: str, cure: str = "") -> InputError:
    """Return the error for a file that cannot be read."""
    return InputError.of(where, NO_VALUE, rule, cure)


@dataclass(frozen=True)
class Attribute:
    """A value with its unit: text in XML, typed in JSON, a list for an array."""

    id: str
    unit: str
    value: Any


@dataclass(frozen=True)
class Component:
    """A part of the model."""

    id: int
    type: str
    name: str
    attributes: dict[str, Attribute]

    def __str__(self) -> str:
        called = f' "{shorten(self.name)}"' if self.name else ""
        return f"{shorten(self.type)} {self.id}{called}"


@dataclass(frozen=True)
class Relation:
    """Components by their roles, in the order of the file."""

    type: str
    refs: list[tuple[str, int]]
    order: int = 0

    def role(self, *names: str) -> list[int]:
        """Return the components in one of these roles."""
        return [number for role, number in self.refs if role in names]


@dataclass(frozen=True)
class LoadCase:
    """Attributes of components under one load."""

    id: int
    attributes: dict[int, dict[str, Attribute]]


@dataclass
class Gearbox:
    """A model, with the load case that applies; it counts which attributes were read."""

    version: str
    application: str
    application_version: str
    components: dict[int, Component] = field(default_factory=dict)
    relations: list[Relation] = field(default_factory=list)
    load_cases: list[LoadCase] = field(default_factory=list)
    load_case: LoadCase | None = None
    read: set[tuple[str, str]] = field(default_factory=set)
    lost: dict[str, int] = field(default_factory=dict)
    """Attributes that the writing program left without their value, and in how many components."""
    accumulated: bool = False
    """Whether the file has results over its load cases."""
    _with: dict[int, list[Relation]] = field(default_factory=dict, repr=False)
    """Relations by their components."""

    def add(self, component: Component) -> None:
        """Add a component, whose id must be new."""
        if component.id in self.components:
            raise refused(f"component {component.id}", "must be there once", "Export the model again")
        self.components[component.id] = component

    def check(self) -> None:
        """Refuse an unknown version, references to components that are missing, and assemblies within themselves."""
        if self.version not in VERSIONS:
            rule = f"must be of REXS {VERSIONS[0]} to {VERSIONS[-1]}, not {shorten(self.version, 20)!r}"
            raise refused("model", rule, "Export it in one of these versions")
        for what, count, most in (
            ("components", len(self.components), MOST_COMPONENTS),
            ("relations", len(self.relations), MOST_RELATIONS),
            ("gears", len(self.of_type("cylindrical_gear", "ring_gear")), MOST_GEARS),
        ):
            if count > most:
                raise refused(
                    "model", f"must have at most {most} {what}; it has {count}", "Export a part of it"
                )
        if not self.components:
            raise refused("model", "must have components", "Export the gearbox, not an empty model")
        for relation in self.relations:
            for role, number in relation.refs:
                if number not in self.components:
                    rule = f"refers to component {number} as {shorten(role)}, which is not there"
                    raise refused(f"relation {shorten(relation.type)}", rule, "Export the model again")
        for relation in self.relations:
            for number in {number for _, number in relation.refs}:
                self._with.setdefault(number, []).append(relation)
        for case in self.load_cases:
            for number in case.attributes:
                if number not in self.components:
                    raise refused(
                        f"load_case {case.id}",
                        f"refers to component {number}, which is not there",
                        "Export it again",
                    )
        self._check_assemblies()

    def _check_assemblies(self) -> None:
        above: dict[int, set[int]] = {}
        for relation in self.relations:
            if relation.type in ("assembly", "ordered_assembly"):
                for part in relation.role("part"):
                    above.setdefault(part, set()).update(relation.role("assembly"))
        done: set[int] = set()
        path: dict[int, None] = {}
        for first in above:
            stack = [(first, False)]
            while stack:
                number, leaving = stack.pop()
                if leaving:
                    del path[number]
                    done.add(number)
                elif number in path:
                    raise refused(
                        str(self.components[number]), "must not be a part of itself", "Export the model again"
                    )
                elif number not in done:
                    path[number] = None
                    stack += [(number, True), *((each, False) for each in above.get(number, ()))]

    def of_type(self, *types: str) -> list[Component]:
        """Return the components of some types, by id."""
        return sorted(
            (each for each in self.components.values() if each.type in types), key=lambda each: each.id
        )

    def linked(self, kinds: Iterable[str], role: str, number: int, *others: str) -> list[Component]:
        """Return the components in other roles of relations that have one in a role, by id."""
        kinds = set(kinds)
        found = {
            other
            for relation in self._with.get(number, ())
            if relation.type in kinds and number in relation.role(role)
            for other in relation.role(*others)
        }
        return [self.components[each] for each in sorted(found)]

    def stage_gears(self, stage: Component) -> list[int]:
        """Return the gears of a stage, the first before the second."""
        relations = [
            each
            for each in self._with.get(stage.id, ())
            if each.type == "stage" and stage.id in each.role("stage")
        ]
        numbers = [
            number
            for each in relations
            for role in ("gear_1", "gear_2", "gear")
            for number in each.role(role)
        ]
        return list(dict.fromkeys(numbers))

    def parts(self, number: int, *types: str) -> list[Component]:
        """Return the parts of an assembly of some types."""
        found = self.linked(("assembly", "ordered_assembly"), "assembly", number, "part")
        return [each for each in found if not types or each.type in types]

    def assemblies(self, number: int, *types: str) -> list[Component]:
        """Return the assemblies of some types that have a part."""
        found = self.linked(("assembly", "ordered_assembly"), "part", number, "assembly")
        return [each for each in found if not types or each.type in types]

    def referenced(self, number: int, *types: str) -> list[Component]:
        """Return the components of some types that one refers to: materials, tools."""
        found = self.linked(("reference", "ordered_reference"), "origin", number, "referenced")
        return [each for each in found if each.type in types]

    def attribute(self, component: Component, *names: str) -> Attribute | None:
        """Return the first attribute found of several names, that of the load case before that of the component."""
        loaded: Mapping[str, Attribute] = {}
        if self.load_case is not None:
            loaded = self.load_case.attributes.get(component.id, {})
        for name in names:
            found = loaded.get(name) or component.attributes.get(name)
            if found is not None:
                self.read.add((component.type, name))
                if found.value not in ("", [], None):
                    return found
        return None

    def number(
        self, component: Component, quantity: Quantity | None, *names: str, unit: str = ""
    ) -> float | None:
        """Return a number in SI, or None; `InputError` for text that is no number and for a wrong unit."""
        found = self.attribute(component, *names)
        if found is None or self._is_lost(found):
            return None
        return _number(found.value, found.unit, quantity, f"{component}, {shorten(found.id)}", unit)

    def _is_lost(self, found: Attribute) -> bool:
        if isinstance(found.value, bool):
            self.lost[found.id] = self.lost.get(found.id, 0) + 1
        return isinstance(found.value, bool)

    def text(self, component: Component, *names: str) -> str:
        """Return a text, empty where there is none."""
        found = self.attribute(component, *names)
        if found is None or self._is_lost(found):
            return ""
        value = found.value
        return f"{value:g}" if isinstance(value, float) else str(value)

    def flag(self, component: Component, name: str) -> bool | None:
        """Return a truth value, the one of the current gear where there is one for each; None where there is none."""
        found = self.attribute(component, name)
        if found is None:
            return None
        value = found.value
        if isinstance(value, list):
            at = int(self._shift_index()) - 1
            value = value[at if 0 <= at < len(value) else 0]
        return value if isinstance(value, bool) else str(value).lower() in ("true", "1")

    def _shift_index(self) -> float:
        for unit in self.of_type("gear_unit"):
            return self.number(unit, None, "gear_shift_index") or 1.0
        return 1.0

    def vector(self, component: Component, name: str) -> tuple[float, float, float] | None:
        """Return three numbers in SI, None where there are none."""
        found = self.attribute(component, name)
        if found is None or self._is_lost(found):
            return None
        where = f"{component}, {shorten(name)}"
        if not isinstance(found.value, list) or len(found.value) != 3:
            raise refused(where, "must be three numbers", "Export the model again")
        u, v, w = (_number(each, found.unit, q.LENGTH, where) for each in found.value)
        return u, v, w


def _number(value: Any, unit: str, quantity: Quantity | None, where: str, default: str = "") -> float:
    try:
        number = float(value)
        if isinstance(value, bool) or not math.isfinite(number):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise InputError.of(
            where, value, "must be a finite number", "Correct it, or export the model again"
        ) from None
    unit = " ".join(unit.split())
    if quantity is None:
        if unit not in ("", "none", "-", "1"):
            raise InputError.of(where, f"{number:g} {unit}", "must have no unit", "Correct the unit")
        if abs(number) > INFINITE:
            raise InputError.of(where, f"{number:g}", "must be of the size of a machine", "Correct it")
        return number
    if unit in ("", "none"):
        unit = default or _STANDARD[quantity.unit]
    try:
        if unit == "C" and quantity.unit == "K":
            return number + 273.15
        found = number * _factor(_UNITS.get(unit, unit), quantity)
    except UnitError as error:
        raise InputError.of(where, f"{number:g} {unit}", error.rule, error.cure) from None
    if abs(found) > (INFINITE if quantity in STIFF else LARGEST.get(quantity.name, INFINITE)):
        raise InputError.of(where, f"{number:g} {unit}", "must be of the size of a machine", "Correct it")
    return found


@lru_cache(maxsize=256)
def _factor(unit: str, quantity: Quantity) -> float:
    """Return the factor from a unit to SI."""
    if unit in ("N mm / rad", "N mm/rad") and quantity is q.ROTATIONAL_STIFFNESS:
        return 1e-3  # pint takes long to load for this one alone
    plain = unit.replace("mum", "um").replace("°", "deg").replace(" / ", "/")
    return parse_quantity(f"1 {plain}", quantity)
