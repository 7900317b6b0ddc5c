"""Ctrl-C in commands: one sentence, exit code 130, stored results kept."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any

from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.exit_codes import INTERRUPTED
from gearplay.vocabulary.interrupts import Again, would_harm

GRACE = 3.0
"""Time after a Ctrl-C [s] in which another one is ignored, so that results being stored are not destroyed."""


class CommandInterruptedError(GearplayError):
    """Ctrl-C ended a command; the message names the stored results."""

    exit_code = INTERRUPTED


_running: list[threading.Event] = []


def leave_at_once(code: int = INTERRUPTED) -> None:
    """End the process at once on Ctrl-C: before a command begins there is nothing to keep.

    With another ``code``, after a command, whose output is complete: the exit code is that of the command.
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
    stop, last, again = threading.Event(), [-GRACE], Again()
    stopping: list[bool] = []

    def interrupt(signum: int, frame: FrameType | None) -> None:
        if not stopping:  # an event waits for itself where a second signal comes while it is set
            stopping.append(True)
            stop.set()
        if time.monotonic() - last[0] < GRACE:
            return
        if would_harm(frame):
            again.soon()
            return
        last[0] = time.monotonic()
        raise KeyboardInterrupt

    def lost(unraisable: Any) -> None:
        """Schedule again an interrupt that a library could not propagate."""
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(unraisable)
            return
        last[0] = -GRACE
        again.soon()

    def silent(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        """Suppress the traceback of a `KeyboardInterrupt`: Cython prints one before it discards the exception."""
        if not issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before, hooks = signal.signal(signal.SIGINT, interrupt), (sys.unraisablehook, sys.excepthook)
    sys.unraisablehook, sys.excepthook = lost, silent
    _running.append(stop)
    try:
        yield stop
    finally:
        _running.pop()
        again.never()
        sys.unraisablehook, sys.excepthook = hooks
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)
