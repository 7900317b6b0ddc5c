"""Progress on standard error: a bar with an estimate on a terminal, else an occasional line."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final

from gearplay.cli.interrupts import interruptible
from gearplay.vocabulary.errors import escape_controls
from gearplay.vocabulary.progress import Progress as Callback

INTERVAL: Final = 10.0
"""Time [s] between two lines of progress; short work writes none."""


class Lines:
    """Progress as lines of text, ``section: 40 %``, one every `INTERVAL`; none once standard error is closed."""

    def __init__(self) -> None:
        self._next = time.monotonic() + INTERVAL

    def __call__(self, label: str, done: float, total: float) -> None:
        """Write a line if the last one, or the start, is long enough ago."""
        if time.monotonic() < self._next:
            return
        self._next = time.monotonic() + INTERVAL
        share = 100.0 * done / total if total > 0.0 else 0.0
        with suppress(OSError, ValueError):
            sys.stderr.write(f"{escape_controls(label)}: {share:.0f} %\n")
            sys.stderr.flush()


@contextmanager
def progress_bar(*, quiet: bool) -> Iterator[Callback | None]:
    """Yield a function that shows progress on standard error, None when ``quiet``: a bar, or lines where that is no terminal."""
    if quiet or sys.stderr is None:
        yield None
        return
    if not sys.stderr.isatty():
        yield Lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)

        def report(label: str, done: float, total: float) -> None:
            bar.update(task, description=label, completed=done, total=total)

        yield report


@contextmanager
def watched(*, quiet: bool) -> Iterator[tuple[Callback | None, threading.Event]]:
    """Yield the function that shows progress, as `progress_bar` does, and the event that Ctrl-C sets."""
    with interruptible() as stop, progress_bar(quiet=quiet) as report:
        yield report, stop
