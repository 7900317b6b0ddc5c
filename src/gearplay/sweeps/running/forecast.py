"""Estimate of the duration of a sweep from a few of its cases."""

import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.vocabulary.cores import worker_count
from gearplay.work.engine import run_threads
from gearplay.work.rows import RowStore, store_name


@dataclass(frozen=True)
class Forecast:
    """Estimated cost of a sweep: cases, seconds on ``workers`` cores and stored bytes; number of failed pilots.

    ``overhead`` are the additional seconds for start, gathering and report. ``search`` counts the cases of the search for a
    safe size, which come on top and are in the seconds too.
    """

    cases: int
    search: int
    pilots: int
    seconds: float
    overhead: float
    workers: int
    bytes: float
    failed: int
    reason: str


PILOTS = 1000
"""Points that a forecast runs at most."""

REPORT, PICTURES, GATHERED = 3.0, 1.0, 0.35e-3
"""Approximate times [s] of the report and its imports, of the pictures of each reduction, and of gathering a case."""


def forecast(
    made: Sweep,
    *,
    search: int = 0,
    workers: int | None = None,
    duration: float = 6.0,
    begun: float = 0.0,
) -> Forecast:
    """Run some points of a sweep, spread over it, for about ``duration`` seconds, and estimate the cost of all.

    They are run and stored as in the sweep, on all its workers, whose total time is measured, after a first point that warms up
    the machine. ``search`` cases like these come on top;
    ``begun`` is the time that the process has taken so far [s], as that of the sweep will.
    """
    cores = min(workers or worker_count(), worker_count())
    count, pilots, reasons = len(made.template.points), 0, list[str]()
    jobs = order_of(made.template.points.jobs)[: PILOTS + 1]
    first, *others = jobs
    began = time.monotonic()
    warm = made.evaluate(int(first))
    spent = time.monotonic() - began
    overhead = begun + spent + REPORT + PICTURES * len(made.plan.reduce) + GATHERED * (count + search)
    reasons += [o.reason for o in warm if o.status]
    if others:
        with (
            TemporaryDirectory() as folder,
            closing(RowStore(Path(folder) / store_name(None))) as store,
            closing(run_threads(made, others, workers=cores)) as finished,
        ):
            began = time.monotonic()
            for outcomes in finished:
                store.add(outcomes)
                pilots += len(outcomes)
                reasons += [o.reason for o in outcomes if o.status]
                spent = time.monotonic() - began
                if spent > duration and pilots >= cores:
                    break
    each = spent / pilots if pilots else spent / max(1, len(warm))
    pilots += len(warm)
    return Forecast(
        cases=count,
        search=search,
        pilots=pilots,
        seconds=(count + search) * each,
        overhead=overhead,
        workers=cores,
        bytes=1.1 * made.bytes,
        failed=len(reasons),
        reason=reasons[0] if reasons else "",
    )
