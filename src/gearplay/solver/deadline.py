"""Deadline of a request: one limit on wall time for all the runs that it makes."""

import functools
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Final, TypeVar

Made = TypeVar("Made")

clock: Callable[[], float] = time.monotonic
"""Clock of all deadlines [s]."""


class Deadline:
    """End of the time that a request may take, ``limit`` [s] after its first run began; None for no limit.

    ``has_stopped`` is whether it ended a run.
    """

    def __init__(self, limit: float | None) -> None:
        self.limit = math.inf if limit is None else limit
        self.has_stopped = False
        self._end: float | None = None

    def left(self) -> float:
        """Return the time left [s], from the first call on."""
        if self.limit == math.inf:
            return math.inf
        if self._end is None:
            self._end = clock() + self.limit
        return self._end - clock()

    def is_over(self) -> bool:
        """Return whether no time is left; the caller then ends its run."""
        over = self.left() < 0.0
        self.has_stopped |= over
        return over


_CURRENT: Final[ContextVar[Deadline | None]] = ContextVar("deadline", default=None)


@contextmanager
def limited(limit: float | None) -> Iterator[Deadline]:
    """Give all runs within the block one deadline; the enclosing request's, where there is one.

    >>> with limited(2.0) as outer, limited(10.0) as inner:
    ...     inner is outer, deadline_of(None) is outer
    (True, True)
    """
    outer = _CURRENT.get()
    if outer is not None:
        yield outer
        return
    deadline = Deadline(limit)
    token = _CURRENT.set(deadline)
    try:
        yield deadline
    finally:
        _CURRENT.reset(token)


def deadline_of(limit: float | None) -> Deadline:
    """Return the deadline of the request that is running, or a new one of ``limit`` [s]."""
    return _CURRENT.get() or Deadline(limit)


def in_request(call: Callable[[], Made]) -> Callable[[], Made]:
    """Return a call to make on another thread, with the deadline of this one."""
    return functools.partial(copy_context().run, call)
