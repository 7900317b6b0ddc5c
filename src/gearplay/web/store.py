"""Store of finished results on disk, limited in size, oldest removed first."""

import contextlib
import hashlib
import json
import os
import re
import threading
from pathlib import Path
from typing import Any

from gearplay.files.atomic import LENGTH, MARK, make_folder, with_checksum, write_bytes
from gearplay.web.frames import read_head

KEY = re.compile(r"[0-9a-f]{32}")
PART = re.compile(r"\.[0-9a-f]{32}\.frame\.[0-9a-f]+\.part")
"""A frame that a server was killed over."""


class Store:
    """A folder of result frames, each named by the digest of its request.

    At most ``most`` are kept, and at most ``room`` bytes.
    """

    def __init__(self, folder: Path, *, most: int = 100, room: int = 400 * 1024**2) -> None:
        self.folder, self.most, self.room = folder, most, room
        make_folder(folder)
        for file in folder.glob(".*.frame.*.part"):
            if PART.fullmatch(file.name):
                with contextlib.suppress(OSError):
                    file.unlink()
        self.sizes = {
            file: file.stat().st_size for file in reversed(self._newest_first())
        }  # the oldest first
        self.changing = threading.Lock()
        self.entries: dict[Path, tuple[tuple[int, int], dict[str, Any] | None]] = {}
        """Of each frame that was listed: its time of writing [ns] and size, and its entry, None where it is damaged."""

    @staticmethod
    def key_of(words: dict[str, Any]) -> str:
        """Return the name of the result of a job; 1 and 1.0 are one number.

        >>> Store.key_of({"a": 1}) == Store.key_of({"a": 1.0})
        True
        """
        numbers = json.loads(json.dumps(words), parse_int=float)
        text = json.dumps(numbers, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode("utf-8")).hexdigest()[:32]

    def save(self, key: str, frame: bytes) -> None:
        """Store a frame and remove the oldest; `InputError` where it cannot be written."""
        file = self.folder / f"{key}.frame"
        with self.changing:
            self.sizes.pop(file, None)
            try:
                write_bytes(file, with_checksum(frame))
            finally:  # it may be there although a sync after it failed
                if file.exists():
                    self.sizes[file] = len(frame) + LENGTH
            while len(self.sizes) > 1 and (
                len(self.sizes) > self.most or sum(self.sizes.values()) > self.room
            ):
                oldest = next(iter(self.sizes))
                del self.sizes[oldest]
                oldest.unlink(missing_ok=True)

    def _newest_first(self) -> list[Path]:
        ages = {}
        for file in self.folder.glob("*.frame"):
            with contextlib.suppress(OSError):  # it has just given way to a newer one
                ages[file] = file.stat().st_mtime
        return sorted(ages, key=lambda file: ages[file], reverse=True)

    def load(self, key: str) -> bytes | None:
        """Return the frame of a key; None if it is missing or was changed on disk."""
        if not KEY.fullmatch(key):
            return None
        file = self.folder / f"{key}.frame"
        try:
            whole = file.read_bytes()
        except OSError:
            return None
        frame = whole[:-LENGTH]
        return frame if with_checksum(frame) == whole else None

    def listed(self, count: int = 30) -> list[dict[str, Any]]:
        """Return the stored results, the newest first: key, kind, title, note, time of writing [s]."""
        entries = {}
        for file in self._newest_first()[:count]:
            try:
                now = file.stat()
            except OSError:  # it has just given way to a newer one
                continue
            state, known = (now.st_mtime_ns, now.st_size), self.entries.get(file)
            entries[file] = known if known and known[0] == state else (state, _entry(file, now.st_mtime))
        self.entries = entries
        return [entry for _, entry in entries.values() if entry is not None]


def _entry(file: Path, written: float) -> dict[str, Any] | None:
    """Return the entry of a frame in the list of results, None where it is no complete frame."""
    try:
        with file.open("rb") as source:
            document, _ = read_head(source)
            source.seek(-LENGTH, os.SEEK_END)
            if source.read(len(MARK)) != MARK or not isinstance(document, dict):
                return None
    except (OSError, ValueError):
        return None
    named = {name: document.get(name) for name in ("kind", "title")}
    return {"key": file.stem, **named, "note": document.get("note", ""), "written": written}
