"""Gears of rotors, and their names in meshes."""

from collections.abc import Container
from typing import Annotated, Final

from pydantic import Field

from gearplay.schema.fields import NAME, Measure, Part
from gearplay.vocabulary import quantities as q

ADDENDUM: Final = 1.0
"""In modules: full-depth teeth, ISO 53."""
DEDENDUM: Final = 1.25

GearName = Annotated[
    str,
    Field(
        pattern=rf"^{NAME}(\.{NAME})?$",
        description="rotor, or rotor.gear: names of a letter, then at most 31 letters, digits or _",
    ),
]
Teeth = Annotated[int, Field(ge=6, le=10_000, description="number of teeth; required in a mesh")]
Internal = Annotated[bool, Field(description="true for a ring gear")]


class Runout(Part):
    """Eccentricity of the toothing (half the indicator reading) and where it points at ``theta = 0``."""

    amplitude: Annotated[
        float, Measure(q.LENGTH, "eccentricity (half the indicator reading)", ge=0.0, le=0.1)
    ] = 0.0
    phase: Annotated[float, Measure(q.ANGLE, "direction of the eccentricity at theta = 0")] = 0.0


class Gear(Part):
    """One of several gears that a rotor carries."""

    teeth: Teeth
    internal: Internal = False
    runout: Runout = Runout()


def split_name(name: str, rotors: Container[str]) -> tuple[str, str]:
    """Return rotor and gear of a gear called as meshes call it, "" for the only gear of a rotor.

    >>> split_name("layshaft.wheel", ["layshaft"]), split_name("stage.sun", ["stage.sun"])
    (('layshaft', 'wheel'), ('stage.sun', ''))
    """
    if name in rotors:
        return name, ""
    rotor, _, gear = name.partition(".")
    return rotor, gear
