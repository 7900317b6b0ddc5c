"""Names, units and numbers as text of figures and pages."""

import textwrap

from gearplay.vocabulary.quantities import DIMENSIONS, TEMPERATURE


def plain(text: str) -> str:
    """Return user text escaped for matplotlib: ``$`` starts no formula."""
    return text.replace("$", r"\$")


def short(text: str, most: int = 44) -> str:
    """Return a long name with its middle left out: names that differ often do so at the end.

    >>> short("abcdefghij", 7)
    'abc…hij'
    """
    half = (most - 1) // 2
    kept = text if len(text) <= most else f"{text[: most - 1 - half]}…{text[-half:]}"
    return f" {kept}" if kept.startswith("_") else kept  # matplotlib leaves such labels out of legends


def significant(value: float, digits: int = 3) -> str:
    """Return a number with some significant digits, without exponent between 1e-4 and 1e6.

    >>> significant(1234.5), significant(0.012345), significant(50.0), significant(99.287, 4), significant(2e-7)
    ('1230', '0.0123', '50', '99.29', '2e-07')
    """
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if 1e3 <= abs(rounded) < 1e6 else f"{rounded:.{digits}g}"


def wrapped(text: str, width: int) -> str:
    r"""Return text in lines of at most ``width`` characters, broken at blanks, after underscores, or anywhere.

    >>> wrapped("tooth_error_2 of ring", 8)
    'tooth_\nerror_2\nof ring'
    """
    lines = [""]
    for word in text.replace("_", "_\0").replace(" ", " \0").split("\0"):
        if len((lines[-1] + word).rstrip()) > width and lines[-1]:
            lines.append("")
        lines[-1] += word
    return "\n".join(part for line in lines for part in textwrap.wrap(line.strip(), width))


def shown_unit(unit: str) -> str:
    """Return a unit with typographic characters for pictures.

    >>> shown_unit("(m/s^2)^2/Hz"), shown_unit(""), shown_unit("um")
    ('(m/s²)²/Hz', '1', 'µm')
    """
    text = unit.replace("^2", "²").replace("^3", "³") or "1"
    return plain({"um": "µm", "degC": CELSIUS}.get(text, text))


CELSIUS = "°C"


def offset_in(shown: str) -> float:
    """Return the value of 0 in SI in a display unit, -273.15 for degrees Celsius.

    >>> offset_in("°C"), offset_in("mm")
    (-273.15, 0.0)
    """
    return TEMPERATURE.display_offset if shown == CELSIUS else 0.0


DISPLAY = {q.unit: q for q in DIMENSIONS.values()}


def shown_in(unit: str, largest: float) -> tuple[str, float]:
    """Return the display unit of values up to ``largest`` [unit], and the factor from ``unit`` to it.

    To temperatures, in °C, comes `offset_in`.

    >>> shown_in("m", 3e-4), shown_in("m", 0.08), shown_in("m/s^2", 1.0), shown_in("rad", 1e-4)
    (('µm', 1000000.0), ('mm', 1000.0), ('m/s²', 1.0), ('µrad', 1000000.0))
    >>> shown_in("m", 2e-9)
    ('nm', 1000000000.0)
    """
    if unit == "m" and 0.0 < largest < 2e-8:
        return "nm", 1e9
    if unit == "m" and largest > 1.001e-3:
        return ("mm", 1e3) if largest <= 1.0 else ("m", 1.0)
    if unit == "rad" and 0.0 < largest < 2e-3:
        return "µrad", 1e6
    quantity = DISPLAY.get(unit)
    if quantity is None:
        return shown_unit(unit), 1.0
    return shown_unit(quantity.display_unit).replace("um", "µm"), quantity.display_factor


def axis_label(words: str, unit: str) -> str:
    """Return an axis label with the unit, in lines that fit a panel."""
    return plain("\n".join(textwrap.wrap(words if unit == "1" else f"{words} [{unit}]", 44)))
