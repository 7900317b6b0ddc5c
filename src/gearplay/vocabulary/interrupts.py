"""Deferral of Ctrl-C in critical sections."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SOON = 0.05
"""Time after which a deferred interrupt is tried again [s]."""
LOST_WITHIN = {("scipy.stats._qmc", "Sobol.__init__")}  # it calls Cython that reads a file
"""Functions, module and name, that an exception may not pass through: compiled code prints a traceback and continues."""


def would_harm(frame: FrameType | None) -> bool:
    """Return whether an exception at a frame would reach code that cannot propagate it."""
    while frame is not None:
        if (str(frame.f_globals.get("__name__")), frame.f_code.co_qualname) in LOST_WITHIN:
            return True
        frame = frame.f_back
    return False


class Again:
    """Repetition of a deferred interrupt: one at a time, and none after the work."""

    def __init__(self) -> None:
        self.timer: threading.Timer | None = None
        self.due = False

    def soon(self) -> None:
        """Schedule it again, unless it is scheduled already."""
        if not self.due:
            self.due = True  # first: another signal may come on the way
            self.timer = threading.Timer(SOON, self._send)
            self.timer.daemon = True
            self.timer.start()

    def never(self) -> None:
        """Cancel it: its handler is about to be removed."""
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


@contextmanager
def raised_without_harm() -> Iterator[None]:
    """Defer Ctrl-C within the block to a safe point, if Python's own handler is installed.

    Another handler is kept, such as that of the command line.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield
        return
    again = Again()

    def interrupt(signum: int, frame: FrameType | None) -> None:
        if not would_harm(frame):
            raise KeyboardInterrupt
        again.soon()

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        again.never()
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if again.due:
        raise KeyboardInterrupt
