"""Estimate of the compile time, from the last measured speed and the present load of the machine."""

import math
import os
from contextlib import suppress
from pathlib import Path

USUAL = 9e-4
"""Core seconds for a unit of a kernel's length where nothing has been compiled yet."""
SLOWEST = 20.0
"""Times the usual that a pace is believed to be, either way."""
FILE = "pace"


def share_of_cores(processes: int, cores: int) -> float:
    """Return how many cores so many busy processes get, with those that are busy on this machine already.

    >>> share_of_cores(2, 1000)
    2.0
    """
    busy = 0.0
    with suppress(OSError, AttributeError):  # not on every system
        busy = os.getloadavg()[0]
    return processes * min(1.0, cores / (processes + busy))


def seconds_for(length: int, processes: int, cores: int, folder: Path | None) -> float:
    """Return how long [s] kernels of a length take, by the pace that is noted in a folder, where there is one."""
    return length * (USUAL if folder is None else pace_in(folder)) / share_of_cores(processes, cores)


def pace_in(folder: Path) -> float:
    """Return the core seconds for a unit of length that a folder notes, the usual ones where it does not."""
    with suppress(OSError, ValueError):
        found = float((folder / FILE).read_text(encoding="ascii"))
        if USUAL / SLOWEST <= found <= USUAL * SLOWEST:
            return found
    return USUAL


def note_pace(folder: Path, length: int, seconds: float, shared: float) -> None:
    """Note the pace at which kernels of a length were compiled in so many seconds on that many cores."""
    if length > 0 and math.isfinite(seconds):
        with suppress(OSError):  # a folder that cannot be written to holds no compiled code either
            (folder / FILE).write_text(f"{seconds * shared / length:.4g}", encoding="ascii")


def duration_words(seconds: float) -> str:
    """Return an approximate time as text, to one digit.

    >>> duration_words(0.4), duration_words(26.0), duration_words(75.0), duration_words(214.0)
    ('a second', '30 s', 'a minute', '4 min')
    """
    if seconds < 1.5:
        return "a second"
    if seconds < 55.0:
        step = 1.0 if seconds < 9.5 else 10.0
        return f"{step * math.ceil(seconds / step - 0.3):.0f} s"
    return "a minute" if seconds < 90.0 else f"{math.ceil(seconds / 60.0 - 0.3):.0f} min"
