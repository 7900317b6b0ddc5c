"""Common spellings of units, mapped to those of the unit tables and of pint."""

import re
from typing import Final

_SUPERSCRIPTS: Final = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_RAISED: Final = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+")
_DOTS: Final = re.compile(" *[·⋅∙•×] *")
_HYPHEN: Final = re.compile(r"(?<=[A-Za-zµμ])-(?=[A-Za-zµμ])")
_WORD: Final = re.compile(r"([A-Za-zµμ]+)([2-4](?![0-9.]))?")
_JOINED: Final = re.compile(r"([kMGm]?N)(mm|cm|um|µm|μm|m)?(s)?|(kg)(mm|cm|m)")
_WORDS: Final = {
    "lbm": "lb", "lbs": "lb", "mil": "thou", "mils": "thou", "micron": "um", "microns": "um", "RPM": "rpm", "Rpm": "rpm",
    "sec": "s", "secs": "s", "Kg": "kg", "KG": "kg", "Deg": "deg",
}  # fmt: skip
_TURNS_A_MINUTE: Final = ("r/min", "tr/min", "u/min", "1/min", "min^-1", "upm", "rot/min")
_FORCES: Final = {"lb": "lbf", "oz": "ozf"}


def spelled(unit: str, si_unit: str) -> str:
    """Return a unit in the plain spelling: powers with ``^``, products with a space, one name for each unit.

    Parameters
    ----------
    unit
        The unit as written in the input.
    si_unit
        SI unit of the expected quantity: some spellings of revolutions per minute have another meaning for other quantities.

    Examples
    --------
    >>> spelled("kg·m²", "kg m^2"), spelled("Nm/rad", "N m/rad"), spelled("1/min", "rad/s"), spelled("in-lb", "N m")
    ('kg m^2', 'N m/rad', 'rpm', 'in lb')

    """
    if unit in ('"', "″"):
        return "in"
    unit = _RAISED.sub(lambda found: "^" + found.group().translate(_SUPERSCRIPTS), unit)
    unit = _HYPHEN.sub(" ", _DOTS.sub(" ", unit))
    if si_unit == "rad/s" and unit.lower() in _TURNS_A_MINUTE:
        return "rpm"
    return _WORD.sub(lambda found: _word(found[1]) + (f"^{found[2]}" if found[2] else ""), unit)


def _word(name: str) -> str:
    joined = _JOINED.fullmatch(name)
    return " ".join(filter(None, joined.groups())) if joined else _WORDS.get(name, name)


def as_force(unit: str, si_unit: str) -> str:
    """Return a unit whose pounds and ounces, and the kilograms of a torque, are forces, as in ``in lb`` of a torque.

    >>> as_force("in lb", "N m"), as_force("kg cm", "N m")
    ('in lbf', 'kgf cm')
    """
    forces = _FORCES | ({"kg": "kgf"} if si_unit == "N m" else {})
    return re.sub("[A-Za-z]+", lambda found: forces.get(found.group(), found.group()), unit)
