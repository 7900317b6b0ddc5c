"""Field types of case files: quantities, names, lists, unions by kind.

A `Measure` takes a number in SI or text with a unit and holds its bounds, its description and its part of the
JSON schema together. Nothing in this module depends on rotors or meshes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, Any, Final, NamedTuple, NoReturn, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from gearplay.schema.units import COMMA, ICE, LONGEST, UnitError, comma_cure, parse_quantity, unit_exponent
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import Quantity

KIND: Final = "kind:"
"""Prefix that marks the tag of a union in an error's location."""

SMALLEST: Final = 1e-24
"""Smallest number taken where a positive one is required [SI]."""

LARGEST: Final[Mapping[str, float]] = MappingProxyType({
    q.LENGTH.name: 1e3, q.MASS.name: 1e9, q.INERTIA.name: 1e12, q.ANGLE.name: 1e6,
    q.ANGULAR_SPEED.name: 1e6, q.TIME.name: 1e6, q.FREQUENCY.name: 1e7, q.SPEED.name: 1e5,
    q.ACCELERATION.name: 1e6, q.FORCE.name: 1e12, q.TORQUE.name: 1e12, q.STIFFNESS.name: 1e16,
    q.DAMPING.name: 1e12, q.ROTATIONAL_DRAG.name: 1e12, q.ROTATIONAL_STIFFNESS.name: 1e15,
    q.PRESSURE.name: 1e14, q.RATIO.name: 1e6, q.HERTZ_STIFFNESS.name: 1e24,
    q.TEMPERATURE.name: 1e4, q.EXPANSION.name: 1.0, q.MASS_DENSITY.name: 1e6,
    q.INTEGRAL_GAIN.name: 1e15, q.UNBALANCE.name: 1e9, q.SPECTRAL_DENSITY.name: 1e12,
    q.RESISTANCE.name: 1e9, q.INDUCTANCE.name: 1e6, q.TORQUE_CONSTANT.name: 1e6,
    q.VOLTAGE.name: 1e4, q.SENSITIVITY.name: 1e3, q.ACCELERATION_DENSITY.name: 1e3,
    q.WEAR_COEFFICIENT.name: 1e-6,
})  # fmt: skip
"""Largest magnitude of each dimension [SI]: far above any machine, far below where arithmetic breaks."""


class Problem(NamedTuple):
    """A fault at `at`, a path below the part that is being checked."""

    at: tuple[str | int, ...]
    rule: str
    cure: str = ""


def refuse(problems: Iterable[Problem]) -> None:
    """Raise all `problems` as one validation error; return if there is none."""
    found = list(problems)
    if found:
        raise PydanticCustomError("gearplay", "input refused", {"problems": found})


def _refuse_here(rule: str, cure: str) -> NoReturn:
    raise PydanticCustomError("gearplay", "input refused", {"problems": [Problem((), rule, cure)]})


class Part(BaseModel):
    """Base of every part of a case: frozen, no unknown fields, finite numbers, no silent conversions.

    A part's validator is built with that of the whole that it belongs to, or when the part is first used on its own. Defaults
    that are parts are therefore made without it, by ``model_construct``.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        strict=True,
        validate_default=False,
        hide_input_in_errors=True,
        defer_build=True,
    )

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a private attribute; `InputError` for a field, which is constant."""
        if name in type(self).model_fields:
            cure = 'Make a changed copy, for example gearplay.replace(case, {"meshes.0.backlash": 1e-4})'
            raise InputError.of(name, value, "must not be assigned: fields are constant", cure)
        super().__setattr__(name, value)


@dataclass(frozen=True)
class Measure:
    """A number in SI or text with a unit, within bounds.

    Parameters
    ----------
    quantity
        Dimension; None for a plain number without a unit. One that is not in `LARGEST`, as a quantity that only one part has,
        requires `lt` or `le`.
    about
        Description, one line.
    gt, ge, lt, le
        Bounds [SI].

    Examples
    --------
    >>> Measure(q.LENGTH, "radial clearance", ge=0.0).read("100 um")
    0.0001

    """

    quantity: Quantity | None
    about: str
    gt: float | None = field(default=None, kw_only=True)
    ge: float | None = field(default=None, kw_only=True)
    lt: float | None = field(default=None, kw_only=True)
    le: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Raise `TypeError` for a quantity without a largest magnitude."""
        if (
            self.quantity is None
            or self.quantity.name in LARGEST
            or self.lt is not None
            or self.le is not None
        ):
            return
        raise TypeError(f"{self.about}: {self.quantity.name} needs lt or le, since LARGEST does not have it")

    def read(self, value: Any) -> float:
        """Return the value in SI, or refuse it."""
        if self.quantity is None:
            return self._within(_plain_number(value))
        try:
            return self._within(parse_quantity(value, self.quantity), text=isinstance(value, str))
        except UnitError as error:
            _refuse_here(error.rule, error.cure)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.json_schema(None if self.quantity is None else self.quantity.unit)

    def json_schema(self, unit: str | None) -> dict[str, Any]:
        """Return the JSON schema: a bounded number, or text when there is a unit."""
        words = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
        bounds = {words[key]: getattr(self, key) for key in words if getattr(self, key) is not None}
        number: dict[str, Any] = {"type": "number", **bounds}
        if unit is None:
            return {**number, "description": self.about}
        text = {"type": "string", "maxLength": LONGEST, "description": "number and unit"}
        return {"anyOf": [number, text], "description": f"{self.about} [{unit}]", "x-unit": unit}

    def _holds(self, value: float) -> bool:
        """Return whether a value [SI] keeps to all bounds."""
        low_ok = (self.gt is None or value > self.gt) and (self.ge is None or value >= self.ge)
        high_ok = (self.lt is None or value < self.lt) and (self.le is None or value <= self.le)
        return low_ok and high_ok

    def _within(self, value: float, *, text: bool = False) -> float:
        if not self._holds(value):
            _refuse_here(f"must be {self._range()}", self._advice(value, text=text))
        largest = math.inf if self.quantity is None else LARGEST.get(self.quantity.name, math.inf)
        if abs(value) > largest:
            _refuse_here(
                f"must be at most {self._show(largest)} in magnitude", "Check the number and its unit"
            )
        if self.gt == 0.0 and value < SMALLEST:
            _refuse_here(f"must be at least {self._show(SMALLEST)}", "Check the number and its unit")
        return value

    def _show(self, bound: float) -> str:
        if self.quantity is None or self.quantity.unit == "1":
            return f"{bound:g}"
        if self.quantity is q.ANGLE:
            return f"{bound * q.ANGLE.display_factor:g} deg"
        return f"{bound:g} {self.quantity.unit}"

    def _range(self) -> str:
        bounds = {
            "greater than {}": self.gt,
            "{} or more": self.ge,
            "less than {}": self.lt,
            "at most {}": self.le,
        }
        return " and ".join(words.format(self._show(b)) for words, b in bounds.items() if b is not None)

    def _advice(self, value: float, *, text: bool) -> str:
        if value < 0.0 and self.quantity is q.TEMPERATURE:
            celsius = (
                "" if text or value <= -ICE else f'Write "{value:g} degC" if these are degrees Celsius; '
            )
            return f"{celsius or 'Correct it; '}absolute zero is {-ICE:g} degC"
        if value < 0.0 and (self.gt == 0.0 or self.ge == 0.0):
            return "Remove the minus sign or check what the field means"
        if self.quantity is q.ANGLE and not text and self._holds(math.radians(value)):
            return f'A plain number is in rad: write "{value:g} deg" if these are degrees'
        return "Choose a value in this range"


@dataclass(frozen=True)
class HertzStiffness(Measure):
    """A contact stiffness [N/m^exponent] whose unit follows the field `exponent` of the same table."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read_beside)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.json_schema("N/m^exponent")

    def read_beside(self, value: Any, info: core_schema.ValidationInfo) -> float:
        """Return the stiffness in SI; its unit must contain the sleeve's exponent."""
        exponent = info.data.get("exponent")
        if exponent is None:  # the exponent itself is at fault and is reported on its own
            exponent = (unit_exponent(value) or 1.0) if isinstance(value, str) else 1.0
        quantity = q.hertz_stiffness(exponent)
        try:
            return self._within(parse_quantity(value, quantity))
        except UnitError as error:
            if error.rule == COMMA:
                _refuse_here(error.rule, error.cure)
            _refuse_here(
                f"{error.rule} for exponent {exponent:g}",
                f"Write a number in {quantity.unit}, or give the exponent that belongs to the unit",
            )


def _plain_number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        if isinstance(value, str) and (cure := comma_cure(value)):
            _refuse_here(COMMA, cure)
        _refuse_here("must be a plain number", "Write it without quotes and without a unit")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        _refuse_here("must be a finite number", "Write a plain decimal number")
    return number + 0.0


class Listed(NamedTuple):
    """Validator that takes a TOML list as a tuple and checks its length.

    Parameters
    ----------
    shortest, longest
        Bounds on the number of items.
    about
        Description, one line.

    """

    shortest: int
    longest: int
    about: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {
            **handler(schema),
            "minItems": self.shortest,
            "maxItems": self.longest,
            "description": self.about,
        }

    def read(self, value: Any) -> tuple[Any, ...]:
        """Return the items, or refuse the list as a whole."""
        size = f"{self.shortest}" if self.shortest == self.longest else f"{self.shortest} to {self.longest}"
        if not isinstance(value, (list, tuple)):
            _refuse_here(f"must be a list of {size} items", "Write it in square brackets")
        if not self.shortest <= len(value) <= self.longest:
            _refuse_here(f"must have {size} items", "Add or remove items")
        return tuple(value)


class Counted(NamedTuple):
    """Validator that checks the size of a table of names before any entry is validated.

    Parameters
    ----------
    shortest, longest
        Bounds on the number of entries.

    """

    shortest: int
    longest: int

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "minProperties": self.shortest, "maxProperties": self.longest}

    def read(self, value: Any) -> Any:
        """Return the table, or refuse it as a whole."""
        if isinstance(value, dict) and not self.shortest <= len(value) <= self.longest:
            _refuse_here(f"must have {self.shortest} to {self.longest} entries", "Add or remove entries")
        return value


Value = TypeVar("Value")


class FrozenTable(dict[str, Value]):
    """Immutable dictionary; it pickles and compares as a dictionary."""

    def _locked(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise TypeError("a case cannot be changed: use gearplay.replace(case, {...}) for a changed copy")

    __setitem__ = __delitem__ = update = setdefault = pop = popitem = clear = __ior__ = _locked

    def __reduce__(self) -> tuple[type[FrozenTable[Value]], tuple[dict[str, Value]]]:
        return type(self), (dict(self),)


@dataclass(frozen=True)
class Later:
    """Type of a part that few cases have: `find` imports it, when the first such part is read.

    >>> Later(lambda: Part).read({})
    Part()
    """

    find: Callable[[], type[Part]]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        # within definitions, so that the part is one of them
        return handler(core_schema.definitions_schema(self.find().__pydantic_core_schema__, []))

    def read(self, value: Any) -> Part:
        """Return the part, or raise its ``ValidationError``."""
        return self.find().model_validate(value)


def by_kind(*kinds: str) -> Callable[[Any], str | None]:
    """Return a discriminator that reads the field `kind` of a table; its tags start with `KIND`."""

    def discriminate(value: Any) -> str | None:
        kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
        return KIND + kind if isinstance(kind, str) and kind in kinds else None

    return discriminate


class ByKind(Discriminator):
    """Choose the member of a union by its field `kind`; hashable, so that `ByKind | None` may be written."""

    def __init__(self, *kinds: str) -> None:
        super().__init__(
            by_kind(*kinds),
            custom_error_type="gearplay_kind",
            custom_error_message="unknown kind",
            custom_error_context={"kinds": ", ".join(kinds)},
        )

    def __hash__(self) -> int:
        return id(self)


def is_absent(value: object) -> bool:
    """Return whether a field is not given, empty or 0; such a newer field is left out of files, so that digests do not change."""
    return not value


NAME: Final = r"[A-Za-z][A-Za-z0-9_]{0,31}"
"""Pattern of a name."""
Name = Annotated[
    str,
    Field(
        pattern=f"^{NAME}$",
        description="name: a letter, then at most 31 letters, digits or _",
    ),
]
Offset = Annotated[
    tuple[
        Annotated[float, Measure(q.LENGTH, "distance along this axis", ge=-0.1, le=0.1)],
        Annotated[float, Measure(q.LENGTH, "distance along this axis", ge=-0.1, le=0.1)],
    ],
    Listed(2, 2, "where it is off the rotor's nominal centre, along x and y; on a carrier at its rotation 0"),
    Field(exclude_if=lambda offset: offset == (0.0, 0.0)),
]
"""Error of place of a bush or a support."""
MEMBER: Final = r"(sun|ring|carrier|planet[1-9][0-9]?)"
"""Pattern of a member of a planetary set, whose rotor is called ``set.member``."""
RotorName = Annotated[
    str,
    Field(
        pattern=rf"^{NAME}(\.{MEMBER})?$",
        description="rotor, or set.sun, set.ring, set.carrier, set.planet1 ... of a planetary set",
    ),
]
Order = Annotated[int, Field(ge=1, le=64, description="order: multiples of the mesh phase psi")]
