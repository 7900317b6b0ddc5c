"""Finished parts of long work as JSON files in a folder."""

import hashlib
import json
from pathlib import Path
from typing import Any

from gearplay.files.atomic import make_folder, write_text

DIGEST = "sha256"
"""Key of a stored part: the digest of all others."""


def part_key(identity: Any) -> str:
    """Return the key of a part: the digest of all that decides it, JSON-able."""
    return digest_of(identity, in_order=False)[:24]


class FolderStore:
    """Keeps finished conditions as JSON files in a folder; damaged and changed ones count as absent."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, key: str) -> dict[str, Any] | None:
        """Return a stored part, or None."""
        try:
            part = json.loads((self.folder / f"{key}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return without_digest(part) if isinstance(part, dict) else None

    def put(self, key: str, part: dict[str, Any]) -> None:
        """Store a part, atomically."""
        make_folder(self.folder)
        write_text(self.folder / f"{key}.json", json.dumps(with_digest(part)))


def digest_of(part: Any, *, in_order: bool = True) -> str:
    """Return the digest of a JSON-able object; without ``in_order`` the order of its keys does not matter."""
    return hashlib.sha256(json.dumps(part, sort_keys=not in_order).encode()).hexdigest()


def with_digest(part: dict[str, Any], *, in_order: bool = True) -> dict[str, Any]:
    """Return a part with its digest appended."""
    return {**part, DIGEST: digest_of(part, in_order=in_order)}


def without_digest(stored: dict[str, Any], *, in_order: bool = True) -> dict[str, Any] | None:
    """Return a stored part without its digest; None where the digest is missing or does not match.

    >>> without_digest({**with_digest({"a": 1}), "a": 2}), without_digest({"a": 2})
    (None, None)
    """
    part = {name: value for name, value in stored.items() if name != DIGEST}
    return part if stored.get(DIGEST) == digest_of(part, in_order=in_order) else None
