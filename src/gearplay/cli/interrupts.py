"""Ctrl-C from the first line of a command to its last: one sentence, exit code 130, and what is stored stays."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.exit_codes import INTERRUPTED

GRACE = 3.0
"""For so long after a Ctrl-C [s] another one is not heard: what is being kept then must not be destroyed."""


class CommandInterruptedError(GearplayError):
    """Ctrl-C ended a command, which says what it kept."""

    exit_code = INTERRUPTED


_running: list[threading.Event] = []


def leave_at_once(code: int = INTERRUPTED) -> None:
    """Let Ctrl-C end the process here and now, with its sentence: before a command begins there is nothing to keep.

    With another ``code``, after a command: its answer is out, and that is what it leaves with.
    """

    def leave(signum: int, frame: FrameType | None) -> None:
        if code == INTERRUPTED:
            os.write(2, b"Interrupted.\n")
        os._exit(code)

    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, leave)


@contextmanager
def interruptible() -> Iterator[threading.Event]:
    """Yield an event that Ctrl-C sets before it raises: libraries may swallow the exception, not the event.

    Within another one it is the same event.
    """
    if _running:
        yield _running[-1]
        return
    stop, heard = threading.Event(), [0.0]

    def interrupt(signum: int, frame: FrameType | None) -> None:
        if stop.is_set() and time.monotonic() - heard[0] < GRACE:
            return
        heard[0] = time.monotonic()
        stop.set()
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = signal.signal(signal.SIGINT, interrupt)
    _running.append(stop)
    try:
        yield stop
    finally:
        _running.pop()
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)
