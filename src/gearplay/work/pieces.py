"""Finished pieces of long work as JSON files in a folder, under the digest of their identity."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gearplay.files.atomic import make_folder, write_text

LARGEST = 64 * 1024**2
"""Largest document that is read [bytes], far above those that are written."""
DIGEST = "sha256"
"""Key of a stored document: the digest of all others."""


class PieceStore:
    """JSON documents in a folder; damaged and changed ones count as absent."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, key: str) -> dict[str, Any] | None:
        """Return the document stored under a key, or None."""
        stored = read_document(self.folder / f"{key}.json")
        return None if stored is None else without_digest(stored)

    def keep(self, identity: Any, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Return the stored document of a JSON-able identity, or make and store it, atomically."""
        key = digest_of(identity, in_order=False)[:24]
        found = self.get(key)
        if found is None:
            found = json.loads(json.dumps(make()))
            make_folder(self.folder)
            write_text(self.folder / f"{key}.json", json.dumps(with_digest(found)))
        return found


def digest_of(document: Any, *, in_order: bool = True) -> str:
    """Return the digest of a JSON-able object; without ``in_order`` the order of its keys does not matter."""
    return hashlib.sha256(json.dumps(document, sort_keys=not in_order).encode()).hexdigest()


def read_document(path: Path) -> dict[str, Any] | None:
    """Return a stored document with its digest, checked or not; None where the file holds none."""
    try:
        plain = path.is_file() and path.stat().st_size <= LARGEST
        stored = json.loads(path.read_text(encoding="utf-8")) if plain else None
    except (OSError, ValueError, RecursionError):
        return None
    return stored if isinstance(stored, dict) and DIGEST in stored else None


def with_digest(document: dict[str, Any], *, in_order: bool = True) -> dict[str, Any]:
    """Return a document with its digest appended."""
    return {**document, DIGEST: digest_of(document, in_order=in_order)}


def without_digest(stored: dict[str, Any], *, in_order: bool = True) -> dict[str, Any] | None:
    """Return a stored document without its digest; None where the digest is missing or does not match.

    >>> without_digest({**with_digest({"a": 1}), "a": 2}), without_digest({"a": 2})
    (None, None)
    """
    document = {name: value for name, value in stored.items() if name != DIGEST}
    return document if stored.get(DIGEST) == digest_of(document, in_order=in_order) else None
