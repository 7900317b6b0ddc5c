"""Old names of arguments: they go on working and say the new one."""

import functools
import warnings
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError

Verb = TypeVar("Verb", bound=Callable[..., Any])


def renamed(**names: str) -> Callable[[Verb], Verb]:
    """Return what lets a function take old argument names: ``renamed(time="duration")``.

    Raises `InputError` where both the old and the new name are given.

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
            return verb(*given, **with_new_names(verb.__name__, names, named))

        called.old_names = names  # type: ignore[attr-defined]
        return cast(Verb, called)

    return wrap


def with_new_names(
    verb: str, names: Mapping[str, str], named: Mapping[str, Any], *, depth: int = 3
) -> dict[str, Any]:
    """Return arguments under their new names, each old one with a warning at the caller, ``depth`` calls up.

    Raises `InputError` where both the old and the new name are given.
    """
    found = dict(named)
    for old, new in names.items():
        if old not in found:
            continue
        if new in found:
            raise InputError(Fault(old, NO_VALUE, f"is the old name of {new}", "Give one of them"))
        words = f"{verb}({old}=...): the argument is called {new} now"
        warnings.warn(words, DeprecationWarning, stacklevel=depth)
        found[new] = found.pop(old)
    return found
