"""What a sweep will take, from a few of its cases."""

from contextlib import closing
from dataclasses import dataclass

from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.running.engines import run_threads
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.vocabulary.cores import worker_count


@dataclass(frozen=True)
class Forecast:
    """What a sweep will take: cases, seconds on ``workers`` cores and the bytes that it keeps; how many of the pilots failed.

    ``search`` counts the cases of the search for a safe size, which come on top and are in the seconds too.
    """

    cases: int
    search: int
    pilots: int
    seconds: float
    workers: int
    bytes: float
    failed: int
    reason: str


def forecast(made: Sweep, *, search: int = 0, workers: int | None = None, patience: float = 8.0) -> Forecast:
    """Run up to 12 points of a sweep, spread over it, for at most ``patience`` seconds, and say what all will take.

    ``search`` cases like these come on top.
    """
    count, spent, pilots, reasons = len(made.template.points), 0.0, 0, list[str]()
    with closing(run_threads(made, order_of(made.template.points.jobs)[:12], workers=1)) as finished:
        for outcomes in finished:
            spent, pilots = spent + sum(o.seconds for o in outcomes), pilots + len(outcomes)
            reasons += [o.reason for o in outcomes if o.status]
            if spent > patience:
                break
    cores = min(workers or worker_count(), worker_count())
    seconds = (count + search) * spent / pilots / cores
    return Forecast(
        count, search, pilots, seconds, cores, 1.1 * made.bytes, len(reasons), reasons[0] if reasons else ""
    )
