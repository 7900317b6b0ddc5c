"""One process a folder: a lock that ends with the process that holds it, however it ends."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gearplay.files.atomic import make_folder, shown_path
from gearplay.vocabulary.errors import Fault, InputError

NAME = ".lock"


@contextmanager
def locked(folder: Path, *, part: str = "") -> Iterator[None]:
    """Hold a folder, or with ``part`` one part of it beside others; `InputError` where another process does.

    The system drops the lock with its process, so a killed one leaves nothing behind that hinders.
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
        handle = os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        rule = f"must be a folder that can be written ({error.strerror})"
        raise InputError(Fault("out", shown_path(folder), rule, "Choose another place")) from None
    try:
        if os.name == "nt":
            import msvcrt

            if not shared:
                msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            import fcntl

            fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        rule = "must not be in use by another process"
        raise InputError(
            Fault("out", shown_path(folder), rule, "Wait for it, or choose another folder")
        ) from None
    return handle
