"""Finished parts of long work, kept as JSON files in a folder."""

import hashlib
import json
from pathlib import Path
from typing import Any

from gearplay.files.atomic import make_folder, write_text


def part_key(identity: Any) -> str:
    """Return the key of a part: the digest of all that decides it, JSON-able."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:24]


class FolderStore:
    """Keeps finished conditions as JSON files in a folder; damaged ones count as absent."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, key: str) -> dict[str, Any] | None:
        """Return a stored part, or None."""
        try:
            part = json.loads((self.folder / f"{key}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return part if isinstance(part, dict) else None

    def put(self, key: str, part: dict[str, Any]) -> None:
        """Store a part, atomically."""
        make_folder(self.folder)
        write_text(self.folder / f"{key}.json", json.dumps(part))
