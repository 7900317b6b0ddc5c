"""Registry of the kinds of faults that parts of a case may have: the only list of them."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Tag

from gearplay.parts.bearing.faults import NO_CAGE, ElementDent, InnerDent, OuterDent
from gearplay.parts.mesh.faults import (
    ChipFault,
    CrackFault,
    EccentricityFault,
    MissingToothFault,
    PitchFault,
    SpallFault,
    WearFault,
)
from gearplay.schema.fields import ByKind, Problem, refuse


def _without_cage(value: Any) -> Any:
    if isinstance(value, Mapping) and value.get("kind") == "cage":
        refuse([Problem(("kind",), NO_CAGE, "Choose one of these")])
    return value


AnyFault = Annotated[
    Annotated[InnerDent, Tag("kind:inner")]
    | Annotated[OuterDent, Tag("kind:outer")]
    | Annotated[ElementDent, Tag("kind:element")]
    | Annotated[CrackFault, Tag("kind:crack")]
    | Annotated[ChipFault, Tag("kind:chip")]
    | Annotated[SpallFault, Tag("kind:spall")]
    | Annotated[MissingToothFault, Tag("kind:missing-tooth")]
    | Annotated[PitchFault, Tag("kind:pitch")]
    | Annotated[WearFault, Tag("kind:wear")]
    | Annotated[EccentricityFault, Tag("kind:eccentricity")],
    ByKind(
        "inner",
        "outer",
        "element",
        "crack",
        "chip",
        "spall",
        "missing-tooth",
        "pitch",
        "wear",
        "eccentricity",
    ),
    BeforeValidator(_without_cage),
]
