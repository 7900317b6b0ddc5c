"""JSON schema of case files, for editors."""

from __future__ import annotations

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
    schema = Case.model_json_schema(mode="validation")
    return {"$schema": DIALECT, **schema, "title": "gearplay case"}
