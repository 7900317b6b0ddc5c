"""The unit of a field, found from its place in a case."""

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel

from gearplay.model.case import Case
from gearplay.model.fields import HertzStiffness, Measure
from gearplay.model.item_names import numbered
from gearplay.vocabulary.quantities import hertz_stiffness


def unit_at(case: Case, path: str) -> str:
    """Return the SI unit of the field at a dotted path, "1" where it has none.

    >>> from gearplay.model.reading import load_case
    >>> unit_at(load_case("han2021"), "rotors.ring.load.drag"), unit_at(load_case("han2021"), "sleeves.ring.restitution")
    ('N m s/rad', '1')
    """
    place: Any = case
    holder, field = case, ""
    for part in numbered(case, path).split("."):
        if isinstance(place, BaseModel):
            holder, field = place, part  # type: ignore[assignment]
            place = getattr(place, part, None)
        elif isinstance(place, (list, tuple)):
            place = place[int(part)]
        else:
            place = place[part]
    info = type(holder).model_fields[field]
    measure = measure_in((*info.metadata, info.annotation))
    if isinstance(measure, HertzStiffness):
        return hertz_stiffness(getattr(holder, "exponent", 1.5)).unit
    return measure.quantity.unit if measure is not None and measure.quantity is not None else "1"


def measure_in(annotations: Sequence[Any]) -> Measure | None:
    """Return the first `Measure` of a type, however deep: in a tuple, or beside None."""
    for each in annotations:
        found = each if isinstance(each, Measure) else measure_in(get_args(each))
        if found is not None:
            return found
    return None
