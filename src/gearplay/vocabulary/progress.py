"""Progress callbacks: one kind for all public functions, one for parts of a computation."""

from collections.abc import Callable

Progress = Callable[[str, float, float], None]
"""Told what is running, how much of it is done, and of how much, in any unit."""

Tick = Callable[[float, float], None]
"""Told by one piece of work how much of it is done, and of how much."""


def ticking(progress: Progress | None, label: str) -> Tick | None:
    """Return what tells `progress` of one piece of work under its label, or None where nobody listens.

    >>> ticking(lambda what, done, total: print(what, done, total), "orbits")(1, 3)
    orbits 1 3
    """
    if progress is None:
        return None
    return lambda done, total: progress(label, done, total)
