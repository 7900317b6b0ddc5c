"""Registry of the kinds of faults that parts of a case may have: the only list of them."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Tag

from gearplay.parts.bearing.faults import NO_CAGE, ElementDent, InnerDent, OuterDent
from gearplay.schema.fields import ByKind, Problem, refuse


def _without_cage(value: Any) -> Any:
    if isinstance(value, Mapping) and value.get("kind") == "cage":
        refuse([Problem(("kind",), NO_CAGE, "Choose one of these")])
    return value


AnyFault = Annotated[
    Annotated[InnerDent, Tag("kind:inner")]
    | Annotated[OuterDent, Tag("kind:outer")]
    | Annotated[ElementDent, Tag("kind:element")],
    ByKind("inner", "outer", "element"),
    BeforeValidator(_without_cage),
]
