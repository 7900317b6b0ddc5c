"""Old names of arguments: they go on working and say the new one."""

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeVar, cast

Verb = TypeVar("Verb", bound=Callable[..., Any])


def renamed(**names: str) -> Callable[[Verb], Verb]:
    """Return what lets a function take old argument names: ``renamed(time="duration")``.

    Raises `TypeError` where both the old and the new name are given.

    >>> @renamed(time="duration")
    ... def wait(*, duration: float) -> float:
    ...     return duration
    >>> with warnings.catch_warnings(record=True) as said:
    ...     warnings.simplefilter("always")
    ...     wait(time=2.0), str(said[0].message)
    (2.0, 'wait(time=...): the argument is called duration now')
    """

    def wrap(verb: Verb) -> Verb:
        @functools.wraps(verb)
        def called(*given: Any, **named: Any) -> Any:
            for old, new in names.items():
                if old not in named:
                    continue
                if new in named:
                    raise TypeError(f"{verb.__name__}(): {old} is the old name of {new}; give one of them")
                words = f"{verb.__name__}({old}=...): the argument is called {new} now"
                warnings.warn(words, DeprecationWarning, stacklevel=2)
                named[new] = named.pop(old)
            return verb(*given, **named)

        return cast(Verb, called)

    return wrap
