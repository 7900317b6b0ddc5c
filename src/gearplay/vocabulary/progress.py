"""Progress callbacks: one kind for all public functions, one for parts of a computation."""

from collections.abc import Callable

Progress = Callable[[str, float, float], None]
"""Callback with the label of the running work, the amount done and the total, in any unit."""

Tick = Callable[[float, float], None]
"""Callback of one piece of work with the amount done and the total."""


def ticking(progress: Progress | None, label: str) -> Tick | None:
    """Return a `Tick` that reports one piece of work to ``progress`` under its label, or None without ``progress``.

    >>> ticking(lambda what, done, total: print(what, done, total), "orbits")(1, 3)
    orbits 1 3
    """
    if progress is None:
        return None
    return lambda done, total: progress(label, done, total)
