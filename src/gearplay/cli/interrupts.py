"""Ctrl-C from the first line of a command to its last: one sentence, exit code 130, and what is stored stays."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.exit_codes import INTERRUPTED

GRACE = 3.0
"""For so long after a Ctrl-C [s] another one is not heard: what is being kept then must not be destroyed."""


class CommandInterruptedError(GearplayError):
    """Ctrl-C ended a command, which says what it kept."""

    exit_code = INTERRUPTED


SOON = 0.05
"""When an interrupt that cannot be raised yet is tried again [s]."""
ASKED_BY_COMPILED_CODE = ("gearplay.kernels.compiled_once", "_answer")
"""The function that compiled code calls: an exception that leaves it is lost, with a traceback."""


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
    stop, heard = threading.Event(), [-GRACE]

    def interrupt(signum: int, frame: FrameType | None) -> None:
        stop.set()
        if time.monotonic() - heard[0] < GRACE:
            return
        if _in_compiled_code(frame):
            _again()
            return
        heard[0] = time.monotonic()
        raise KeyboardInterrupt

    def lost(unraisable: Any) -> None:
        """Take the interrupt that a library could not pass on: it comes again."""
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(unraisable)
            return
        heard[0] = -GRACE
        _again()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before, hook = signal.signal(signal.SIGINT, interrupt), sys.unraisablehook
    sys.unraisablehook = lost
    _running.append(stop)
    try:
        yield stop
    finally:
        _running.pop()
        sys.unraisablehook = hook
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)


def _again() -> None:
    """Let an interrupt that could not be raised come again soon."""
    timer = threading.Timer(SOON, _send)
    timer.daemon = True
    timer.start()


def _send() -> None:
    """Send Ctrl-C to the main thread, which may be waiting."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


def _in_compiled_code(frame: FrameType | None) -> bool:
    """Return whether a frame was called from compiled code, which can take no exception."""
    while frame is not None:
        if (frame.f_globals.get("__name__"), frame.f_code.co_name) == ASKED_BY_COMPILED_CODE:
            return True
        frame = frame.f_back
    return False
