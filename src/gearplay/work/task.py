"""A task of independent jobs, as threads, processes and clusters run it."""

import math
import threading
import time
from collections.abc import Callable
from typing import Protocol, TypeVar

Piece = TypeVar("Piece")

RETRIES = 3
"""Number of times that jobs are submitted again after their process died."""
PAUSE = 0.1
"""Interval [s] at which a wait for results checks for cancellation."""


class Jobs(Protocol[Piece]):
    """Jobs by number, each with the pieces of result that it gives."""

    def evaluate(self, job: int, stop: threading.Event | None = None) -> list[Piece]:
        """Return the pieces of a job; none once stopped."""


class Task(Jobs[Piece], Protocol[Piece]):
    """Jobs that another process can run."""

    @property
    def remake(self) -> "tuple[Callable[[str], Task[Piece]], str]":
        """A function of a module and its argument, with which another process makes the same task."""


def run_batch(
    make: Callable[[str], Task[Piece]], text: str, jobs: list[int], longest: float = math.inf
) -> tuple[int, list[Piece], float]:
    """Run jobs of the task ``make(text)`` in another process until ``longest`` [s] have passed, one at least.

    Returns the number of finished jobs, their pieces, and the seconds that they took.
    """
    task, begin = make(text), time.monotonic()
    done, pieces = 0, list[Piece]()
    for job in jobs:
        pieces += task.evaluate(job)
        done += 1
        if time.monotonic() > begin + longest:
            break
    return done, pieces, time.monotonic() - begin
