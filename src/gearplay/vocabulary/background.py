"""Uninterruptible library calls on a daemon thread, so that Ctrl-C returns at once."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

Made = TypeVar("Made")


def begin(work: Callable[[], Made]) -> Future[Made]:
    """Call ``work()`` on a daemon thread; return its future."""
    made: Future[Made] = Future()

    def do() -> None:
        try:
            made.set_result(work())
        except BaseException as error:  # the caller's to judge
            made.set_exception(error)

    threading.Thread(target=do, daemon=True).start()
    return made


def on_daemon_thread(work: Callable[[], Made]) -> Made:
    """Return the result of ``work()``, called on a daemon thread, so that Ctrl-C is not delayed by a library.

    `KeyboardInterrupt` is raised in the caller at once; the thread continues and ends with the process at the latest.

    >>> on_daemon_thread(lambda: 2 + 2)
    4
    """
    return begin(work).result()
