"""Names of rotors and gears from those of the file."""

import re
import unicodedata
from collections.abc import Container
from typing import Final

LONGEST: Final = 24
_SUFFIX: Final = re.compile(r"\s*@.*$|\[[^\]]*\]|\([^)]*\)")


def plain_name(text: str, fallback: str) -> str:
    """Return a name of lower-case letters, digits and underscores, without numbers in brackets and angles of planets.

    >>> plain_name("Sonnenwelle [34]", "shaft"), plain_name("Zahnräder @ 0.0°", "gear"), plain_name("[7]", "shaft")
    ('sonnenwelle', 'zahnrader', 'shaft')
    """
    ascii_text = unicodedata.normalize("NFKD", _SUFFIX.sub("", text)).encode("ascii", "ignore").decode()
    name = re.sub(r"[^a-z0-9]+", "_", ascii_text.lower()).strip("_")
    return (name if name[:1].isalpha() else f"{fallback}_{name}".strip("_"))[:LONGEST].rstrip("_")


def new_name(text: str, fallback: str, number: int, repeated: Container[str], taken: set[str]) -> str:
    """Return a name that is not taken, and take it; one that several components have gets the component's number."""
    name = plain_name(text, fallback)
    if name in repeated or name in taken:
        name = f"{name}_{number}"
    while name in taken:
        name += "_b"
    taken.add(name)
    return name
