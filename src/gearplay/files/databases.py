"""Messages for causes of SQLite errors: disk, lock of another process, damaged content."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gearplay.files.atomic import shown_path
from gearplay.vocabulary.errors import InputError, ResourceError, TakenError


@contextmanager
def sqlite_errors(path: Path, rule: str, cure: str, *, foreign: bool = False) -> Iterator[None]:
    """Translate an SQLite error raised in the block, also one wrapped by a library.

    ``rule`` is what the file must do or hold, ``cure`` for where it does not. With ``foreign`` any other error means that too.

    Raises `ResourceError` where the disk is full or fails, `InputError` where another process holds the file, else `TakenError`.
    """
    try:
        yield
    except Exception as error:
        cause = _cause(error)
        if cause is None and not foreign:
            raise
        words = type(error).__name__ if cause is None else str(cause)
        if "full" in words or "disk I/O" in words:
            raise ResourceError(
                f"out = {path}: the disk is full or cannot be written ({words}). "
                "What is stored stays valid: free some space, then the same command goes on."
            ) from None
        place = shown_path(path.parent)
        if "locked" in words:
            busy = f"its {path.name} must not be in use by another process"
            raise InputError.of("out", place, busy, "Wait for it, or choose another folder") from None
        raise TakenError.of("out", place, f"its {path.name} must {rule} ({words})", cure) from None


def _cause(error: BaseException | None) -> sqlite3.Error | None:
    """Return the SQLite error among the causes of another one."""
    while error is not None and not isinstance(error, sqlite3.Error):
        error = error.__cause__ or error.__context__
    return error
