"""Registry of the kinds of faults that parts of a case may have: the only list of them."""

from typing import Annotated

from pydantic import Tag

from gearplay.parts.bearing.faults import CageFault, ElementDent, InnerDent, OuterDent
from gearplay.parts.mesh.faults import (
    ChipFault,
    CrackFault,
    EccentricityFault,
    MissingToothFault,
    PitchFault,
    SpallFault,
    WearFault,
)
from gearplay.schema.fields import ByKind

AnyFault = Annotated[
    Annotated[InnerDent, Tag("kind:inner")]
    | Annotated[OuterDent, Tag("kind:outer")]
    | Annotated[ElementDent, Tag("kind:element")]
    | Annotated[CageFault, Tag("kind:cage")]
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
        "cage",
        "crack",
        "chip",
        "spall",
        "missing-tooth",
        "pitch",
        "wear",
        "eccentricity",
    ),
]
