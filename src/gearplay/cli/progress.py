"""A progress bar with an estimate, only where somebody can see it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from gearplay.vocabulary.progress import Progress as Told

if TYPE_CHECKING:
    from gearplay.model.case import Case


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


def compile_kernels(case: Case, *, quiet: bool, derivative: bool = False) -> None:
    """Compile what a case needs, with progress: a bar on a terminal, else one line."""
    from gearplay.solver.compiling import prepare

    with progress_bar(quiet=quiet) as bar:
        prepare(case, derivative=derivative, progress=bar)
