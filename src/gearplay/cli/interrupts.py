"""Ctrl-C from the first line of a command to its last: one sentence, exit code 130, and what is stored stays."""

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

GRACE = 3.0
"""For so long after a Ctrl-C [s] another one is not heard: what is being kept then must not be destroyed."""


class CommandInterruptedError(GearplayError):
    """Ctrl-C ended a command, which says what it kept."""

    exit_code = INTERRUPTED


SOON = 0.05
"""When an interrupt that cannot be raised yet is tried again [s]."""
LOST_WITHIN = {
    ("gearplay.kernels.compiled_once", "Once._answer"),  # compiled code calls it
    ("scipy.stats._qmc", "Sobol.__init__"),  # it calls Cython that reads a file
}
"""Functions, module and name, that an exception may not pass through: compiled code prints a traceback and goes on."""
SPOILT_BY_IT = ("llvmlite", "numba.core.compiler_lock")
"""Packages or modules that an exception may not come into: LLVM's memory would be freed twice, or a lock held for ever."""


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
    stop, heard, again = threading.Event(), [-GRACE], _Again()
    asked: list[bool] = []

    def interrupt(signum: int, frame: FrameType | None) -> None:
        if not asked:  # an event waits for itself where a second signal comes while it is set
            asked.append(True)
            stop.set()
        if time.monotonic() - heard[0] < GRACE:
            return
        if _would_harm(frame):
            again.soon()
            return
        heard[0] = time.monotonic()
        raise KeyboardInterrupt

    def lost(unraisable: Any) -> None:
        """Take the interrupt that a library could not pass on: it comes again."""
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(unraisable)
            return
        heard[0] = -GRACE
        again.soon()

    def silent(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        """Print no traceback of an interrupt: Cython prints one of what it is about to lose."""
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


class _Again:
    """An interrupt that could not be raised yet, and comes again soon: one at a time, and none after the command."""

    def __init__(self) -> None:
        self.timer: threading.Timer | None = None
        self.due = False

    def soon(self) -> None:
        """Let it come again, if it is not coming already."""
        if not self.due:
            self.due = True  # first: another signal may come on the way
            self.timer = threading.Timer(SOON, self._send)
            self.timer.daemon = True
            self.timer.start()

    def never(self) -> None:
        """Let it come no more: the handler that knows what to do with it is about to go."""
        if self.timer is not None:
            self.timer.cancel()
            self.timer.join()

    def _send(self) -> None:
        """Send Ctrl-C to the main thread, which may be waiting."""
        self.due = False
        if hasattr(signal, "pthread_kill"):
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        else:
            signal.raise_signal(signal.SIGINT)


def _would_harm(frame: FrameType | None) -> bool:
    """Return whether an exception raised at a frame would meet code that can pass none on, or leave things half done."""
    while frame is not None:
        module = str(frame.f_globals.get("__name__"))
        if (module, frame.f_code.co_qualname) in LOST_WITHIN:
            return True
        if any(module == each or module.startswith(f"{each}.") for each in SPOILT_BY_IT):
            return True
        frame = frame.f_back
    return False
