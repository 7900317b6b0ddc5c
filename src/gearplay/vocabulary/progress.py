"""Progress callbacks: one kind for all public functions, one for parts of a computation."""

import inspect
import warnings
from collections.abc import Callable
from typing import Any

Progress = Callable[[str, float, float], None]
"""Told what is running, how much of it is done, and of how much, in any unit."""

Tick = Callable[[float, float], None]
"""Told by one piece of work how much of it is done, and of how much."""


def ticking(progress: Callable[..., Any] | None, label: str) -> Tick | None:
    """Return what tells `progress` of one piece of work under its label, or None where nobody listens.

    A function of two numbers, as older versions of some verbs took, is still told these, with a `DeprecationWarning`.

    >>> ticking(lambda what, done, total: print(what, done, total), "orbits")(1, 3)
    orbits 1 3
    """
    if progress is None:
        return None
    told = listening(progress)
    return lambda done, total: told(label, done, total)


def listening(progress: Callable[..., Any]) -> Progress:
    """Return a callback that takes label, done and total, whatever the user's takes; see `ticking`."""
    try:
        inspect.signature(progress).bind("", 0.0, 1.0)
    except TypeError:
        words = (
            "progress: takes what is running as well now, (what, done, total); two numbers are the old way"
        )
        warnings.warn(words, DeprecationWarning, stacklevel=4)
        return lambda _, done, total: progress(done, total)
    except ValueError:  # a builtin that does not say what it takes
        pass
    return progress
