"""Values in plans: validated in the case that they change, and converted to SI."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic_core import to_jsonable_python

from gearplay.model.case import Case
from gearplay.model.item_names import numbered
from gearplay.model.reading import replace
from gearplay.model.tables import brings_file
from gearplay.schema.fields import Part
from gearplay.vocabulary.errors import Fault, InputError


def changed(base: Case, changes: Mapping[str, Any], where: str) -> Case:
    """Return a changed case; `InputError` gives the path in the plan, ``where``, before the path in the case."""
    try:
        return replace(base, changes)
    except InputError as error:
        raise InputError(
            [Fault(f"{where}: {f.path}", f.value, f.rule, f.cure) for f in error.faults]
        ) from None


def value_at(case: Case, path: str) -> Any:
    """Return the value at a dotted path of a case [SI], JSON-able, defaults included; `InputError` where there is no field."""
    value: Any = case
    for part in numbered(case, path).split("."):
        try:
            if isinstance(value, Part):
                if part not in type(value).model_fields:
                    raise KeyError(part)
                value = getattr(value, part)
            else:
                value = value[int(part)] if isinstance(value, (list, tuple)) else value[part]
        except (KeyError, IndexError, ValueError, TypeError):
            rule = "must lead to a field of the case"
            raise InputError.of("path", path, rule, "See gearplay schema") from None
    return to_jsonable_python(value)


def value_in_si(base: Case, paths: Sequence[str], raw: Any, where: str) -> Any:
    """Return a value, with or without a unit, in SI as a field at the first of ``paths``; it is validated at all of them.

    The name of a table's file stays: a resolved case holds the values of the file.
    """
    made = changed(base, dict.fromkeys(paths, raw), where)
    return raw if brings_file(paths[0], raw) else value_at(made, paths[0])


def number_in_si(base: Case, paths: Sequence[str], raw: Any, where: str) -> float:
    """Return `value_in_si` where it is a number.

    Raises `InputError` for a path to something else.
    """
    value = value_in_si(base, paths, raw, where)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError.of(f"{where}: {paths[0]}", value, "must be a number there", "Correct the path")
    return float(value)


def factor(raw: Any, where: str) -> float:
    """Return a factor on a value of the case; `InputError` for one that is no plain number."""
    if isinstance(raw, bool) or not isinstance(raw, (int, float)):
        raise InputError.of(where, raw, "must be a plain number, as a factor", "Write it without quotes")
    return float(raw)
