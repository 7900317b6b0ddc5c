"""Finished parts: what was changed after it was stored counts as absent."""

import json
from pathlib import Path

from gearplay.work.pieces import PieceStore


def test_a_part_that_was_changed_is_absent(tmp_path: Path) -> None:
    store = PieceStore(tmp_path)
    part = {"b": [1.5, float("nan")], "a": {"x": 0.1}}
    assert json.dumps(store.keep(["key"], lambda: part)) == json.dumps(part)
    assert json.dumps(store.keep(["key"], dict)) == json.dumps(part)
    (file,) = tmp_path.iterdir()
    file.write_text(file.read_text(encoding="utf-8").replace("1.5", "1.6"), encoding="utf-8")
    assert store.get(file.stem) is None
    assert store.keep(["key"], dict) == {}


def test_a_part_without_a_digest_is_absent(tmp_path: Path) -> None:
    (tmp_path / "key.json").write_text('{"a": 1}', encoding="utf-8")
    assert PieceStore(tmp_path).get("key") is None
    (tmp_path / "key.json").write_text('{"a": 1', encoding="utf-8")
    assert PieceStore(tmp_path).get("key") is None
