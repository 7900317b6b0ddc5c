"""A progress bar with an estimate, only where somebody can see it."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from gearplay.cli.output import say
from gearplay.vocabulary.progress import Progress as Told


@contextmanager
def interruptible() -> Iterator[threading.Event]:
    """Yield an event that Ctrl-C sets before it raises: libraries may swallow the exception, not the event."""
    stop = threading.Event()

    def interrupt(signum: int, frame: object) -> None:
        stop.set()
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def compiling_notice() -> Iterator[None]:
    """Say on standard error what takes so long, if the block is not done within two seconds."""
    words = "Compiling the kernels: once after an installation, about a minute."
    timer = threading.Timer(2.0, say, args=[words])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@contextmanager
def progress_bar(*, quiet: bool) -> Iterator[Told | None]:
    """Yield a function that shows progress on standard error, or None off a terminal or when ``quiet``."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("of which left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)

        def report(label: str, done: float, total: float) -> None:
            bar.update(task, description=label, completed=done, total=total)

        yield report
