"""Validation errors as sentences: field, value, rule, cure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from gearplay.schema.fields import KIND, Later, Problem
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, join_path
from gearplay.vocabulary.suggestions import did_you_mean

Path = tuple[str | int, ...]
Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], document: Mapping[str, Any]) -> Model:
    """Return the model of a document; `InputError` with every fault found."""
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise InputError(translate(error, document, model)) from None


def translate(error: ValidationError, document: Mapping[str, Any], model: type[BaseModel]) -> list[Fault]:
    """Return the faults of a validation.

    Parameters
    ----------
    error
        What validating `document` raised.
    document
        The raw case, to find the value at fault.
    model
        Type of the whole, to name the fields that exist.

    """
    faults: list[Fault] = []
    for detail in error.errors(include_url=False):
        faults.extend(_faults_of(detail, document, model))
    return faults


def _faults_of(detail: ErrorDetails, document: Mapping[str, Any], model: type[BaseModel]) -> list[Fault]:
    path = _plain_path(detail["loc"], document)
    context = detail.get("ctx", {})
    kind = detail["type"]
    if kind == "gearplay":
        problems: list[Problem] = context["problems"]
        return [_fault(path + problem.at, document, problem.rule, problem.cure) for problem in problems]
    if kind == "gearplay_kind":
        return [_kind_fault(path, document, context["kinds"])]
    if kind == "extra_forbidden":
        known = known_fields(model, path[:-1], document)
        cure = _own_table(model, path) or did_you_mean(str(path[-1]), known, "Fields")
        return [Fault(join_path(path), NO_VALUE, "unknown field", cure)]
    if kind == "missing":
        return [Fault(join_path(path), NO_VALUE, "is required", _addition(model, path))]
    rule, cure = _words(kind, context)
    if detail["loc"] and detail["loc"][-1] == "[key]":
        return [Fault(join_path(path), NO_VALUE, f"the name {rule}", cure)]
    return [_fault(path, document, rule, cure)]


def _own_table(model: type[BaseModel], path: Path) -> str:
    """Return the cure for a part written into a rotor that has a table at the top of the file, else an empty text."""
    table = next(
        (name for name in (f"{path[-1]}s", f"{path[-1]}es", str(path[-1])) if name in model.model_fields),
        None,
    )
    if table is None or len(path) != 3 or path[0] != "rotors":
        return ""
    several = get_origin(model.model_fields[table].annotation) in (tuple, list)
    return f"Write it as a table: {f'[[{table}]]' if several else f'[{join_path((table, path[1]))}]'}"


def _addition(model: type[BaseModel], path: Path) -> str:
    """Return the cure for a missing field: of a table, the fields that it requires."""
    annotation = model.model_fields[str(path[0])].annotation if len(path) == 1 else None
    parts = [] if annotation is None else parts_in(annotation)
    required = [
        name for part in parts[:1] for name, field in part.model_fields.items() if field.is_required()
    ]
    if not required:
        return "Add it"
    kind = get_origin(annotation)
    heading = (
        f"[[{path[0]}]]"
        if kind in (tuple, list)
        else f"[{path[0]}.NAME]"
        if kind in (dict, Mapping)
        else f"[{path[0]}]"
    )
    return f"Add a table {heading} with {', '.join(required)}"


def _fault(path: Path, document: Mapping[str, Any], rule: str, cure: str) -> Fault:
    return Fault(join_path(path) or "case", value_at(document, path), rule, cure)


def _kind_fault(path: Path, document: Mapping[str, Any], kinds: str) -> Fault:
    value = value_at(document, path)
    if not isinstance(value, Mapping):
        return Fault(join_path(path), value, "must be a table with a kind", f"Kinds: {kinds}")
    given = value.get("kind", NO_VALUE)
    cure = did_you_mean(given, kinds.split(", "), "Kinds") if isinstance(given, str) else f"Kinds: {kinds}"
    return Fault(f"{join_path(path)}.kind", given, f"must be one of {kinds}", cure)


def _words(kind: str, context: Mapping[str, Any]) -> tuple[str, str]:
    """Return rule and cure for the library's own kinds of error."""
    match kind:
        case "int_type" | "int_from_float" | "int_parsing" | "int_parsing_size":
            return "must be a whole number", "Write it without quotes, point and unit"
        case "greater_than_equal":
            return f"must be {context['ge']} or more", "Choose a value in this range"
        case "less_than_equal":
            return f"must be at most {context['le']}", "Choose a value in this range"
        case "bool_type":
            return "must be true or false", "Write it without quotes"
        case "string_type":
            return "must be text", "Put it in quotes"
        case "string_too_long":
            return f"must have at most {context['max_length']} characters", "Shorten it"
        case "string_pattern_mismatch" if "planet" in str(context.get("pattern")):
            rule = "must be the name of a rotor, a letter followed by at most 31 letters, digits or _"
            return rule, "Members of a planetary set are set.sun, set.ring, set.carrier, set.planet1 ..."
        case "string_pattern_mismatch" if r"\." in str(context.get("pattern")):
            return "must be a rotor, or rotor.gear", "Write the name of a rotor, a dot, the name of its gear"
        case "string_pattern_mismatch" if "A-Za-z" in str(context.get("pattern")):
            return "must be a letter followed by at most 31 letters, digits or _", "Choose another name"
        case "string_pattern_mismatch":
            return "must not contain control characters", "Remove them"
        case "string_unicode":
            return "must be valid Unicode text", "Save the file as UTF-8"
        case "literal_error":
            return f"must be one of {context['expected']}".replace(" or ", ", "), "Choose one of these"
        case "too_short":
            return f"must have at least {context['min_length']} entry", "Add one"
        case "too_long":
            return f"must have at most {context['max_length']} entries", "Remove some"
        case "model_type" | "model_attributes_type" | "dict_type" | "mapping_type":
            return "must be a table", "Write it as a [table] or in braces"
    return "does not fit this field", "See gearplay schema"


def _plain_path(location: Sequence[str | int], document: Mapping[str, Any]) -> Path:
    """Return an error's location without the tags of unions and the marks of keys, which the document does not have."""
    path: Path = ()
    for part in location:
        tagged = isinstance(part, str) and part.startswith(KIND)
        if part != "[key]" and not (tagged and value_at(document, (*path, part)) is NO_VALUE):
            path = (*path, part)
    return path


def value_at(document: object, path: Path) -> object:
    """Return the raw value at a path, or `NO_VALUE` where there is none."""
    value: Any = document
    for part in path:
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            return NO_VALUE
    return value if path else NO_VALUE


def known_fields(model: type[BaseModel], path: Path, document: Mapping[str, Any]) -> list[str]:
    """Return the names of the fields that exist in the part of a case at `path`."""
    types: list[type[BaseModel]] = [model]
    value: object = document
    for index, part in enumerate(path):
        value = value_at(document, path[: index + 1])
        deeper: list[type[BaseModel]] = []
        for each in types:
            if isinstance(part, str) and part in each.model_fields:
                deeper.extend(parts_in(each.model_fields[part].annotation))
        types = deeper or types  # a name or an index: its part is of the table's type
    kind = value.get("kind") if isinstance(value, Mapping) else None
    fitting = [
        each for each in types if "kind" in each.model_fields and each.model_fields["kind"].default == kind
    ]
    return list(dict.fromkeys(name for each in fitting or types for name in each.model_fields))


def parts_in(annotation: Any) -> list[type[BaseModel]]:
    """Return the kinds of parts that a field may hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if isinstance(annotation, Later):
        return [annotation.find()]
    inside = (*getattr(annotation, "__args__", ()), *getattr(annotation, "__metadata__", ()))
    return [found for inner in inside for found in parts_in(inner)]
