"""``gearplay schema``: the JSON schema of case files."""

from __future__ import annotations

from gearplay.cli.output import Json, print_json


def schema(json: Json = False) -> None:
    """Print the JSON schema of case files, for editors.

    It is JSON with --json or without.
    """
    from gearplay.model.schema import json_schema

    print_json(json_schema())
