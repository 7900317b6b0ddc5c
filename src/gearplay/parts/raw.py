"""Fields of parts that are valid, or still raw tables of a file since they are at fault on their own."""

from collections.abc import Iterable, Mapping
from typing import Any

from gearplay.vocabulary.errors import Fault
from gearplay.vocabulary.suggestions import did_you_mean

Raw = Mapping[str, Any]


def read(part: object, name: str) -> Any:
    """Return a field of a part; None where a raw table has it not."""
    return part.get(name) if isinstance(part, Mapping) else getattr(part, name, None)


def text(part: object, name: str) -> str | None:
    """Return a field that is a text, else None."""
    value = read(part, name)
    return value if isinstance(value, str) else None


def unknown_rotor(path: str, name: str, names: Iterable[str]) -> Fault:
    """Return the fault of a name that is none of the rotors' ``names``."""
    return Fault(path, name, "must be the name of a rotor", did_you_mean(name, names, "Rotors"))
