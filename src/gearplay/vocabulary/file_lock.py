"""Operating-system lock on a file, released when its process ends."""

import errno
import os
from pathlib import Path


def try_lock(file: Path, *, shared: bool = False) -> int | None:
    """Take the lock of a file, which is created if missing; return a handle to close, None if another process holds it.

    Raises ``OSError`` where the file cannot be made, or its file system has no locks.
    """
    handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        if os.name == "nt":
            import msvcrt

            if not shared:
                msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            import fcntl

            fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError as error:
        os.close(handle)
        if error.errno in (errno.EAGAIN, errno.EACCES):
            return None
        raise
    return handle
