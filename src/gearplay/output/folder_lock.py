"""One process a folder: a lock that ends with the process that holds it, however it ends."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gearplay.output.files import make_folder
from gearplay.vocabulary.errors import Fault, InputError

NAME = ".lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder; `InputError` where another process does.

    The system drops the lock with its process, so a killed one leaves nothing behind that hinders.
    """
    make_folder(folder)
    handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        _lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _lock(handle: int, folder: Path) -> None:
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        rule = "must not be in use by another process"
        raise InputError(Fault("out", str(folder), rule, "Wait for it, or choose another folder")) from None
