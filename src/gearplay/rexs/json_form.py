"""REXS in JSON (.rexsj)."""

import json
from collections.abc import Mapping
from typing import Any, Final

from gearplay.rexs.records import Attribute, Component, Gearbox, LoadCase, Relation, refused
from gearplay.rexs.values import Budget, decoded, whole
from gearplay.vocabulary.errors import shorten

CODED: Final = ("floating_point_array_coded", "integer_array_coded", "floating_point_matrix_coded")


def _no_constant(name: str) -> Any:
    raise refused("file", f"must have finite numbers, not {name}", "Correct it")


def read_json(content: bytes) -> Gearbox:
    """Return the model of a JSON document; `InputError` where it is damaged or no REXS model."""
    try:
        document = json.loads(content.decode("utf-8-sig"), parse_constant=_no_constant)
    except RecursionError:
        raise refused("file", "is nested too deep", "Export it again") from None
    except ValueError as error:  # JSONDecodeError, UnicodeDecodeError, an integer too long to read
        raise refused("file", f"is not valid JSON: {shorten(str(error), 80)}", "Export it again") from None
    model = _table(document, "file").get("model")
    if not isinstance(model, Mapping):
        raise refused(
            "file", "must be a REXS model, whose first entry is 'model'", "Export the gearbox as REXS"
        )
    budget = Budget()
    texts = [str(model.get(key, "")) for key in ("version", "applicationId", "applicationVersion")]
    box = Gearbox(texts[0], texts[1], texts[2])
    for entry in _list(model, "relations"):
        refs = [
            (str(_table(ref, "ref").get("role", "")), whole(ref.get("id"), "relation, ref"))
            for ref in _list(entry, "refs")
        ]
        budget.take(1 + len(refs))
        box.relations.append(
            Relation(str(entry.get("type", "")), refs, whole(entry.get("order"), "relation, order", 0))
        )
    for entry in _list(model, "components"):
        component = _component(entry, budget)
        box.add(component)
    spectra = model.get("load_spectrum") or []
    for spectrum in spectra if isinstance(spectra, list) else [spectra]:
        box.accumulated = box.accumulated or "accumulation" in _table(spectrum, "load_spectrum")
        for case in _list(_table(spectrum, "load_spectrum"), "load_cases"):
            found = LoadCase(whole(case.get("id"), "load_case"), {})
            for entry in _list(case, "components"):
                component = _component(entry, budget)
                found.attributes[component.id] = component.attributes
            box.load_cases.append(found)
    box.check()
    return box


def _component(entry: Mapping[str, Any], budget: Budget) -> Component:
    attributes = {}
    for each in _list(entry, "attributes"):
        key = str(each.get("id", ""))
        values = [(kind, value) for kind, value in each.items() if kind not in ("id", "unit", "origin")]
        budget.take()
        if len(values) > 1:
            raise refused(f"attribute {shorten(key)}", "must have one value", "Export it again")
        for kind, value in values:
            if kind in CODED:
                coded = _table(value, f"attribute {shorten(key)}")
                value = decoded(str(coded.get("value", "")), str(coded.get("code", "")), key, budget)
            elif isinstance(value, list):
                budget.take(len(value))
            attributes[key] = Attribute(key, str(each.get("unit") or ""), value)
    number = whole(entry.get("id"), "component")
    return Component(number, str(entry.get("type", "")), str(entry.get("name") or ""), attributes)


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise refused(where, "must be a JSON object", "Export it again")
    return value


def _list(table: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    found = table.get(key) or []
    if not isinstance(found, list):
        raise refused(key, "must be a JSON array", "Export it again")
    return [_table(each, key) for each in found]
