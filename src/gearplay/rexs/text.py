"""Text of numbers in a case file."""

from typing import Final

SIZES: Final = {
    "mm": 1e-3, "um": 1e-6, "m": 1.0, "deg": 0.017453292519943295, "rpm": 0.10471975511965977, "N m": 1.0, "N/m": 1.0,
    "N m/rad": 1.0, "kg": 1.0, "kg m^2": 1.0, "N s/m": 1.0, "GPa": 1e9, "kg/m^3": 1.0, "1/K": 1.0, "m/s^2": 1.0, "s": 1.0,
    "degC": 1.0, "N m s/rad": 1.0,
}  # fmt: skip
"""SI units in one of each unit."""


def number(value: float) -> str:
    """Return a number with at most twelve digits, trailing zeros left out.

    >>> number(0.1 + 0.2), number(190.0), number(2e8), number(1.1e-5)
    ('0.3', '190', '2e8', '1.1e-5')
    """
    plain = f"{value + 0.0:.12g}"
    digits, _, power = f"{value + 0.0:.11e}".partition("e")
    short = f"{digits.rstrip('0').rstrip('.')}e{int(power)}"
    return short if len(short) + 2 < len(plain) or "e" in plain else plain


def quantity(value: float, unit: str) -> str:
    """Return a value in SI as text in a unit.

    >>> quantity(0.19, "mm"), quantity(-8.5e-5, "um")
    ('190 mm', '-85 um')
    """
    return f"{number(value / SIZES[unit])} {unit}"
