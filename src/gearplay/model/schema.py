"""JSON schema of case files, for editors."""

from __future__ import annotations

import json
from typing import Any, Final

from gearplay.model.case import Case

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> dict[str, Any]:
    """Return the JSON schema of a case file: every field with description, SI unit and bounds.

    Examples
    --------
    >>> json_schema()["$defs"]["Rotor"]["properties"]["mass"]["x-unit"]
    'kg'

    """
    schema = _named(Case.model_json_schema(mode="validation"))
    return {"$schema": DIALECT, **schema, "title": "gearplay case"}


def _named(schema: dict[str, Any]) -> dict[str, Any]:
    """Return a schema in which definitions of parts for a quantity are named by their titles."""
    text = json.dumps(schema)
    for key, each in schema["$defs"].items():
        if "_Annotated_" in key:
            text = text.replace(f'"{key}"', f'"{each["title"]}"')
            text = text.replace(f'"#/$defs/{key}"', f'"#/$defs/{each["title"]}"')
    renamed: dict[str, Any] = json.loads(text)
    return renamed
