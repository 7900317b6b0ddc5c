"""Parsing of quantities: text with a unit to SI numbers.

``number [space] unit``, at most 64 characters: a plain decimal number (no operators, underscores, inf or nan)
and a product of unit names with bounded exponents. Only text that fits the grammar reaches a conversion, so
``9**9**9 m`` is refused at once. Common units are in an exact table; anything else is converted by pint,
imported only then, in a registry where the radian has a dimension: ``50 Hz`` is no angular speed.
"""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import Quantity

if TYPE_CHECKING:
    import pint

LONGEST: Final = 64
"""Longest text of a quantity [characters]."""

_TEXT: Final = re.compile(
    r"(?P<number>[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?)(?P<gap> *)(?P<unit>.*)"
)
_COMMA: Final = re.compile(r"[+-]?[0-9]*,[0-9]")
COMMA: Final = "has a comma in its number"
_TOKEN: Final = (
    r"(?P<name>[A-Za-zµμ°%]+)|(?P<power>\^-?[0-9]{1,3}(?:\.[0-9]{1,3})?(?![0-9.^]))"
    r"|(?P<one>(?<![0-9A-Za-z])1(?= ?/))|(?P<sign>[*./()])|(?P<space> )"
)
_EXPONENTS: Final = r"\^(-?[0-9]+(?:\.[0-9]+)?)"
"""Patterns that few units need: `re` compiles them when they are used, and keeps them."""

_PI: Final = math.pi
_Factors = Mapping[str, Fraction | float]

# SI unit -> units that mean it -> SI units in one of them; rational factors are exact.
FACTORS: Final[Mapping[str, _Factors]] = MappingProxyType({
    "m": {"m": Fraction(1), "km": Fraction(1000), "cm": Fraction(1, 100), "mm": Fraction(1, 1000),
          "um": Fraction(1, 10**6), "µm": Fraction(1, 10**6), "μm": Fraction(1, 10**6),
          "nm": Fraction(1, 10**9)},
    "kg": {"kg": Fraction(1), "g": Fraction(1, 1000), "mg": Fraction(1, 10**6)},
    "kg m^2": {"kg m^2": Fraction(1), "kg*m^2": Fraction(1), "g m^2": Fraction(1, 1000),
               "kg mm^2": Fraction(1, 10**6), "g mm^2": Fraction(1, 10**9), "kg cm^2": Fraction(1, 10**4)},
    "rad": {"rad": Fraction(1), "mrad": Fraction(1, 1000), "deg": _PI / 180, "°": _PI / 180,
            "arcmin": _PI / 10800, "arcsec": _PI / 648000},
    "rad/s": {"rad/s": Fraction(1), "rpm": _PI / 30, "rev/min": _PI / 30, "rev/s": 2 * _PI,
              "deg/s": _PI / 180},
    "s": {"s": Fraction(1), "ms": Fraction(1, 1000), "us": Fraction(1, 10**6), "µs": Fraction(1, 10**6),
          "min": Fraction(60), "h": Fraction(3600)},
    "Hz": {"Hz": Fraction(1), "kHz": Fraction(1000), "MHz": Fraction(10**6), "1/s": Fraction(1)},
    "m/s": {"m/s": Fraction(1), "mm/s": Fraction(1, 1000), "um/s": Fraction(1, 10**6)},
    "m/s^2": {"m/s^2": Fraction(1), "mm/s^2": Fraction(1, 1000), "g": Fraction(980665, 10**5)},
    "N": {"N": Fraction(1), "mN": Fraction(1, 1000), "kN": Fraction(1000)},
    "N m": {"N m": Fraction(1), "N*m": Fraction(1), "N mm": Fraction(1, 1000), "kN m": Fraction(1000)},
    "N/m": {"N/m": Fraction(1), "N/mm": Fraction(1000), "N/um": Fraction(10**6), "N/µm": Fraction(10**6),
            "kN/mm": Fraction(10**6), "MN/m": Fraction(10**6)},
    "N s/m": {"N s/m": Fraction(1), "N*s/m": Fraction(1), "kN s/m": Fraction(1000)},
    "N m s/rad": {"N m s/rad": Fraction(1), "N m s": Fraction(1)},
    "N m/rad": {"N m/rad": Fraction(1), "N m": Fraction(1)},
    "Pa": {"Pa": Fraction(1), "kPa": Fraction(1000), "MPa": Fraction(10**6), "GPa": Fraction(10**9)},
    "K": {"K": Fraction(1)},
    "1/K": {"1/K": Fraction(1), "um/(m K)": Fraction(1, 10**6)},
    "kg/m^3": {"kg/m^3": Fraction(1), "g/cm^3": Fraction(1000)},
    "N m/(rad s)": {"N m/(rad s)": Fraction(1), "N m/rad/s": Fraction(1)},
    "kg m": {"kg m": Fraction(1), "kg*m": Fraction(1), "kg mm": Fraction(1, 1000), "g m": Fraction(1, 1000),
             "g mm": Fraction(1, 10**6)},
    "(m/s^2)^2/Hz": {"(m/s^2)^2/Hz": Fraction(1), "m^2/s^3": Fraction(1), "g^2/Hz": Fraction(980665, 10**5) ** 2},
    "1": {"%": Fraction(1, 100)},
    "m^2/N": {"m^2/N": Fraction(1), "1/Pa": Fraction(1), "mm^2/N": Fraction(1, 10**6),
              "mm^3/(N m)": Fraction(1, 10**9)},
    "V": {"V": Fraction(1), "mV": Fraction(1, 1000), "uV": Fraction(1, 10**6), "µV": Fraction(1, 10**6)},
    "V/(m/s^2)": {"V/(m/s^2)": Fraction(1), "mV/(m/s^2)": Fraction(1, 1000)},
})  # fmt: skip
"""Exact factors of common units, so that an everyday case never waits for pint."""

USUAL: Final = {"rad": "deg or rad", "rad/s": "rpm, rev/s or rad/s"}
"""Units that messages name where the SI unit is not the usual one."""
CELSIUS: Final = ("degC", "°C", "C")
"""Units of a temperature that count from the melting point of ice."""
ICE: Final = 273.15

_registry_lock: Final = threading.Lock()


class UnitError(ValueError):
    """Raised for text that is no quantity of the requested kind; `rule` and `cure` are for a `Fault`."""

    def __init__(self, rule: str, cure: str) -> None:
        super().__init__(f"{rule}. {cure}.")
        self.rule = rule
        self.cure = cure


def parse_quantity(value: str | float, quantity: Quantity) -> float:
    """Convert a number or a text with a unit into SI.

    Parameters
    ----------
    value
        A plain number, taken as SI, or text such as ``"100 um"``, ``"120 rpm"``, ``"1.52e11 N/m^1.5"``.
    quantity
        What the value has to be; its unit decides the dimension.

    Returns
    -------
    float
        The value in `quantity.unit`, finite.

    Raises
    ------
    UnitError
        If it is not a number, the unit is unknown or of another dimension, or the result is not finite.

    Examples
    --------
    >>> from gearplay.vocabulary.quantities import ANGULAR_SPEED, LENGTH
    >>> parse_quantity("100 um", LENGTH), parse_quantity(0.25, LENGTH)
    (0.0001, 0.25)
    >>> round(parse_quantity("60 rpm", ANGULAR_SPEED), 6)
    6.283185

    """
    example = f"Write a number in {quantity.unit} or text such as {_example(quantity)}"
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise UnitError("must be a number or text with a unit", example)
    if not isinstance(value, str):
        return _finite(value, example)
    if len(value) > LONGEST:
        raise UnitError(f"must have at most {LONGEST} characters", example)
    match = _TEXT.fullmatch(value.strip(" "))
    if cure := comma_cure(value):
        raise UnitError(COMMA, cure)
    if match is None:
        raise UnitError("must start with a plain number, followed by a unit", example)
    number, unit = match["number"], match["unit"]
    if not unit:
        raise UnitError(
            f"has no unit where one for {quantity.unit} is required", _with_unit(number, quantity)
        )
    if unit[0] in "0123456789" and not match["gap"]:
        raise UnitError("must start with a plain number, followed by a unit", example)
    if unit == "1":
        raise UnitError("has no unit", example)
    if quantity.unit == "K" and unit in CELSIUS:
        return _finite(float(number) + ICE, example)
    if quantity.unit == "m" and unit in ("DP", "1/in") and float(number) > 0.0:
        raise UnitError(
            "is a diametral pitch, not a length", f'Write the module: "{25.4 / float(number):.6g} mm"'
        )
    return _scaled(number, _factor(unit, quantity), example)


def comma_cure(text: str) -> str:
    """Return what to write for a number with a comma, "" where there is none.

    Examples
    --------
    >>> comma_cure("0,03 mm"), comma_cure("0,5"), comma_cure("1,000,000 s"), comma_cure("0.5 s")
    ('Write it with a decimal point: "0.03 mm"', 'Write it with a decimal point: 0.5', 'Write it without commas', '')

    """
    plain = text.strip(" ")
    if not _COMMA.match(plain):
        return ""
    if plain.count(",") > 1:
        return "Write it without commas"
    pointed = plain.replace(",", ".")
    bare = re.fullmatch(r"[-+0-9.eE]+", pointed)
    return "Write it with a decimal point: " + (pointed if bare else f'"{pointed}"')


def quantity_of(field: str, value: Any, quantity: Quantity) -> float:
    """Return a quantity in SI, given as a number or as text with a unit; `InputError` of ``field`` for anything else."""
    try:
        return parse_quantity(value, quantity)
    except UnitError as error:
        raise InputError.of(field, value, error.rule, error.cure) from None


def _factor(unit: str, quantity: Quantity) -> Fraction | float:
    """Return the factor from a unit, in any spelling, to SI."""
    factor = _table_factor(unit, quantity.unit)
    if factor is not None:
        return factor
    from gearplay.schema.unit_spellings import as_force, spelled

    plain = spelled(unit, quantity.unit)
    factor = _table_factor(plain, quantity.unit)
    if factor is not None:
        return factor
    plain = _check_unit(plain, quantity)
    try:
        return _pint_factor(plain, quantity.unit, quantity.long_name)
    except UnitError:
        force = as_force(plain, quantity.unit)
        if force == plain:
            raise
    return _pint_factor(force, quantity.unit, quantity.long_name)


def _with_unit(number: str, quantity: Quantity) -> str:
    """Return the cure for a number without a unit: the same number with units that are usual."""
    kelvin = ("degC",) if number.startswith("-") else ("degC", "K")
    units = {"rad/s": ("rpm", "rad/s"), "K": kelvin}.get(
        quantity.unit, (quantity.display_unit, quantity.unit)
    )
    return "Write " + " or ".join(f'"{number} {unit}"' for unit in dict.fromkeys(units) if unit != "1")


def _example(quantity: Quantity) -> str:
    if quantity.unit == "1":
        return '"5 %"'
    return f'"1 {quantity.display_unit}"'


def _finite(value: float, example: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError("must be a finite number", example)
    return number + 0.0  # -0.0 becomes 0.0, so that equal cases have equal digests


def _scaled(number: str, factor: Fraction | float, example: str) -> float:
    """Multiply, rounding once where the factor is exact."""
    plain = _finite(float(number), example)
    if plain == 0.0:
        if any(digit in "123456789" for digit in re.split("[eE]", number)[0]):
            raise UnitError("is too small for a number", example)
        return 0.0
    if isinstance(factor, Fraction):
        try:
            return _finite(float(Fraction(number) * factor), example)
        except OverflowError:
            raise UnitError("must be a finite number", example) from None
    return _finite(plain * factor, example)


def _table_factor(unit: str, si_unit: str) -> Fraction | float | None:
    if unit == si_unit:
        return Fraction(1)
    return FACTORS.get(si_unit, {}).get(unit)


def _check_unit(unit: str, quantity: Quantity) -> str:
    """Return `unit` in pint's spelling if it fits the grammar of units."""
    position, names, token_at = 0, 0, re.compile(_TOKEN).match
    words: list[str] = []
    while position < len(unit):
        match = token_at(unit, position)
        if match is None:
            cure = f"Write it as {_example(quantity)}; powers as in m^2, products with a space"
            raise UnitError("has a unit that cannot be read", cure)
        token = match.group()
        names += match.lastgroup == "name"
        words.append("*" if token == "." else token)
        position = match.end()
    spelled = "".join(words)
    if names == 0 or "**" in spelled or "//" in spelled:
        raise UnitError("has a unit that cannot be read", f"Write it as {_example(quantity)}")
    return spelled


@cache
def _registry() -> pint.UnitRegistry[Any]:
    """Return pint's units with the radian as a dimension of its own."""
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(None, on_redefinition="ignore")
    registry.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    registry.define("radian = [angle] = rad")
    registry.define("@alias revolution = rev")
    return registry


@lru_cache(maxsize=1024)
def _pint_factor(unit: str, si_unit: str, long_name: str) -> float:
    """Return the factor from `unit` to `si_unit` (both in pint's spelling)."""
    foreign = UnitError(
        f"is not {_article(long_name)} {long_name}",
        _usual(si_unit) if si_unit != "1" else "Use %",
    )
    with _registry_lock:
        registry = _registry()
        try:
            one = registry.Quantity(1.0, unit)
            wanted = registry.Quantity(1.0, "" if si_unit == "1" else si_unit)
            if si_unit.endswith("/rad") and "[angle]" not in one.dimensionality:  # N m s for N m s/rad
                one = one / registry.Quantity(1.0, "rad")
            if one.dimensionality != wanted.dimensionality:
                raise foreign
            shifted, factor, double = (
                registry.Quantity(size, one.units).to(wanted.units).magnitude for size in (0.0, 1.0, 2.0)
            )
        except UnitError:
            raise
        except Exception:  # pint raises many kinds: undefined units, overflow, offset units
            raise UnitError(f"has an unknown unit '{unit}'", _usual(si_unit)) from None
    if shifted != 0.0 or not math.isclose(double, 2.0 * factor, rel_tol=1e-12):
        raise UnitError(f"has a unit with an offset or a logarithm, '{unit}'", _usual(si_unit))
    if not (math.isfinite(factor) and factor > 0.0):
        raise foreign
    return float(factor)


def _usual(si_unit: str) -> str:
    """Return the cure that names usual units: of angles and speeds those that engineers write."""
    return f"Use a unit such as {USUAL.get(si_unit, si_unit)}"


def _article(word: str) -> str:
    return "an" if word[0] in "aeiou" else "a"


def unit_exponent(text: str) -> float | None:
    """Return the last exponent in a unit such as ``N/m^1.5``, or None where there is none.

    Examples
    --------
    >>> unit_exponent("1.52e11 N/m^1.5"), unit_exponent("1e8 N/m")
    (1.5, None)

    """
    found = re.findall(_EXPONENTS, text[:LONGEST])
    return float(found[-1]) if found else None
