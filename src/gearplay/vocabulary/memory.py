"""Errors of refused memory as one sentence."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from gearplay.vocabulary.errors import ResourceError

_THREAD: Final = "can't start new thread"


def is_too_little_memory(error: BaseException) -> bool:
    """Return whether an error is due to a refused memory allocation.

    >>> is_too_little_memory(MemoryError()), is_too_little_memory(OSError(errno.ENOMEM, "")), is_too_little_memory(OSError())
    (True, True, False)
    """
    if isinstance(error, OSError):
        return error.errno == errno.ENOMEM
    return isinstance(error, MemoryError) or (isinstance(error, RuntimeError) and str(error) == _THREAD)


def too_little_memory(error: BaseException) -> ResourceError:
    """Return the message for an error of `is_too_little_memory`, with the size in NumPy's text if it has one.

    >>> print(too_little_memory(MemoryError("Unable to allocate 5.51 GiB for an array with shape (37, 20) and data type x")))
    memory: this process may not have 5.51 GiB more. Lower the sampling, the duration, the members or the number of signals.
    """
    size = str(error).removeprefix("Unable to allocate ").partition(" for an array")[0]
    wanted = f"{size} more" if isinstance(error, MemoryError) and size != str(error) else "more"
    return ResourceError(
        f"memory: this process may not have {wanted}. Lower the sampling, the duration, the members or the number of signals."
    )


@contextmanager
def enough_memory() -> Iterator[None]:
    """Raise `ResourceError` in place of a `MemoryError` within the block."""
    try:
        yield
    except MemoryError as error:
        raise too_little_memory(error) from None
