"""Units as powers of the base units of SI, as the model description of an FMU states them."""

from collections import Counter
from typing import Final

_DERIVED: Final = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    **{each: {each: 1} for each in ("kg", "m", "s", "A", "K", "mol", "cd", "rad")},
}


def base_powers(unit: str) -> dict[str, int] | None:
    """Return the powers of base units in a unit of SI; None where one is not whole, or no unit of SI.

    >>> base_powers("N m s/rad"), base_powers("N/m^1.5")
    ({'kg': 1, 'm': 2, 's': -1, 'rad': -1}, None)
    """
    found: Counter[str] = Counter()
    for sign, part in zip((1, *[-1] * unit.count("/")), unit.split("/"), strict=True):
        for token in part.strip("() ").split():
            name, _, power = token.partition("^")
            if name == "1":
                continue
            if name not in _DERIVED or not (power or "1").lstrip("-").isdigit():
                return None
            for base, exponent in _DERIVED[name].items():
                found[base] += sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in found.items() if exponent}
