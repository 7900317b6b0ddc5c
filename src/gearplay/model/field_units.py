"""Unit of a field, by its path in a case."""

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel

from gearplay.model.case import Case
from gearplay.model.item_names import numbered
from gearplay.model.wording import parts_in
from gearplay.schema.fields import HertzStiffness, Measure
from gearplay.vocabulary.quantities import hertz_stiffness


def unit_at(case: Case, path: str) -> str:
    """Return the SI unit of the field at a dotted path, "1" where it has none.

    >>> from gearplay.model.reading import load_case
    >>> unit_at(load_case("han2021"), "rotors.ring.load.drag"), unit_at(load_case("han2021"), "sleeves.ring.restitution")
    ('N m s/rad', '1')
    >>> unit_at(load_case("han2021"), "environment.temperature")
    'K'
    """
    place: Any = case
    info, holder = None, None
    for part in numbered(case, path).split("."):
        if isinstance(place, BaseModel) or (isinstance(place, type) and issubclass(place, BaseModel)):
            holder, info = place, (place if isinstance(place, type) else type(place)).model_fields.get(part)
            place = None if isinstance(place, type) else getattr(place, part, None)
            if place is None and info is not None:  # a table that the case does not have
                place = next(iter(parts_in(info.annotation)), None)
        elif isinstance(place, (list, tuple)):
            place = place[int(part)]
        else:
            place = place[part]
    measure = None if info is None else measure_in((*info.metadata, info.annotation))
    if isinstance(measure, HertzStiffness):
        return hertz_stiffness(getattr(holder, "exponent", 1.5)).unit
    return measure.quantity.unit if measure is not None and measure.quantity is not None else "1"


def measure_in(annotations: Sequence[Any]) -> Measure | None:
    """Return the first `Measure` of a type, at any depth: in a tuple, or in a union with None."""
    for each in annotations:
        found = each if isinstance(each, Measure) else measure_in(get_args(each))
        if found is not None:
            return found
    return None
