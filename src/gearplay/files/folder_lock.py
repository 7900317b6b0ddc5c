"""Exclusive lock of an output folder, released when its process ends."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gearplay.files.atomic import make_folder, shown_path
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.file_lock import try_lock

NAME = ".lock"


@contextmanager
def locked(folder: Path, *, part: str = "") -> Iterator[None]:
    """Lock a folder, or with ``part`` one part of it independently; `InputError` where another process holds the lock.

    The system releases the lock with its process, so a killed process leaves no stale lock.
    """
    make_folder(folder)
    handles: list[int] = []
    try:
        handles.append(_lock(folder, NAME, shared=bool(part)))
        if part:
            handles.append(_lock(folder, f"{NAME}-{part}", shared=False))
        yield
    finally:
        for handle in handles:
            os.close(handle)


def _lock(folder: Path, name: str, *, shared: bool) -> int:
    try:
        handle = try_lock(folder / name, shared=shared)
    except OSError as error:
        rule = f"must be a folder that can be written ({error.strerror})"
        raise InputError(Fault("out", shown_path(folder), rule, "Choose another place")) from None
    if handle is None:
        rule = "must not be in use by another process"
        raise InputError(Fault("out", shown_path(folder), rule, "Wait for it, or choose another folder"))
    return handle
