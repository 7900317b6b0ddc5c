import tomllib
from typing import Any

import pytest

from gearplay.model.toml_files import write_toml

DOCUMENTS: list[dict[str, Any]] = [
    {"conditions": [{"name": "a", "set": {"x.y": 1}, "measured": {"line": {"amplitude": 2.0}}}]},
    {"rotors": {"pinion": {"mass": 1.0, "drive": {"kind": "speed", "speed": 2.0}}, "ring": {}}},
    {"a": {"b": {"c": {"d": 1}}, "e": [1, 2]}, "f": []},
]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_written_file__reads_back(document: dict[str, Any]) -> None:
    assert tomllib.loads(write_toml(document)) == document
