"""Deferral of Ctrl-C in critical sections."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SOON = 0.05
"""When an interrupt that cannot be raised yet is tried again [s]."""
LOST_WITHIN = {
    ("gearplay.kernels.compiled_once", "Once._answer"),  # compiled code calls it
    ("scipy.stats._qmc", "Sobol.__init__"),  # it calls Cython that reads a file
    ("numba.core.base", "BaseContext.refresh"),  # half of its registrations would be made twice, or never
    ("numba.core.typing.context", "BaseContext.refresh"),
    *(
        ("numba.core.compiler_lock", f"_CompilerLock.{each}")
        for each in ("acquire", "release", "__enter__", "__exit__")
    ),
}
"""Functions, module and name, that an exception may not pass through: compiled code prints a traceback and continues, or
a lock stays taken."""
SPOILT_BY_IT = "llvmlite"
"""A package that an exception may not come into: LLVM's memory would be freed twice, or its lock held for ever."""


def would_harm(frame: FrameType | None) -> bool:
    """Return whether an exception at a frame would reach code that cannot propagate it, or leave a state half changed.

    So would a partial import of a numba module: imported again, it finds its types registered and fails.
    """
    found: set[str] = set()
    while frame is not None:
        module = str(frame.f_globals.get("__name__"))
        if (module, frame.f_code.co_qualname) in LOST_WITHIN:
            return True
        found.add(module.partition(".")[0])
        frame = frame.f_back
    return SPOILT_BY_IT in found or {"importlib", "numba"} <= found


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

    Another handler stays: the command line has its own, which does the same and more.
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
