"""`sweep`: many cases of one plan, in memory or in a resumable folder."""

import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from gearplay.files.folder_lock import locked
from gearplay.files.plan_files import Source
from gearplay.model.case import Case
from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep, make_plan
from gearplay.sweeps.result import SweepResult
from gearplay.sweeps.running.engines import Engine
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.folder import gather, run_in, watched
from gearplay.sweeps.running.product import to_product
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.progress import Progress


def sweep(
    case: Source | Case | SweepPlan,
    axes: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]] | None = None,
    *,
    reduce: Sequence[Mapping[str, Any]] | None = None,
    ensemble: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    engine: Engine | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    **more: Any,
) -> SweepResult:
    """Simulate every combination of the axes and return what was kept, a dimension per axis.

    Parameters
    ----------
    case
        With ``axes`` a case; alone a plan: a `SweepPlan`, a bundled name, a path or a mapping.
    axes
        Values by path, in SI or with a unit; or tables as in a plan file.
    reduce
        What to keep of each case: tables as in a plan file, docs/sweeps.
    ensemble
        Members of each case; 1 if not given.
    folder
        Where finished cases are stored, so that the same call resumes after an interruption; in memory if not given.
    threads
        Threads; the cores by default. It changes nothing in the result.
    engine
        Where to run, for more than threads: processes, a cluster, one part of several.
    progress
        Called with what is running, cases done, and of how many.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.
    more
        ``design``, ``carry``, ``set`` and ``title`` as in a plan file.

    Returns
    -------
    SweepResult
        ``ds`` has a variable for each reduction; failed cases are rows with ``status`` and ``reason``.

    Raises
    ------
    InputError
        For a plan that does not fit.
    ResourceError
        For one that is too large, or a full disk.

    Examples
    --------
    >>> found = sweep("han2021", {"meshes.0.backlash": ["50 um", "100 um"]}, set={"run.duration": 0.01, "run.transient": 0.0},
    ...     reduce=[{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}])
    >>> dict(found.ds.sizes), found.ds.rms.attrs["units"], found.message
    ({'backlash': 2}, 'm/s^2', '2 cases: 2 finished, 0 failed')

    """
    _check_kinds(axes, reduce)
    if isinstance(case, SweepPlan):
        plan = case
    elif axes is None and reduce is None:
        plan = load_sweep(case.resolved() if isinstance(case, Case) else case)
    else:
        source = os.fspath(case) if isinstance(case, os.PathLike) else case
        more |= {} if ensemble is None else {"members": ensemble}
        plan = make_plan(source, axes or {}, reduce or (), **more)
    made, chosen = Sweep(plan.frozen()), engine or Engine(workers=threads)
    made.check_size()
    if folder is None:
        rows: dict[bytes, tuple[int, str, bytes]] = {}
        with closing(
            watched(made, chosen, order_of(made.template.points.jobs), 0, progress, stop)
        ) as finished:
            for outcome in (each for outcomes in finished for each in outcomes):
                rows[outcome.address] = (outcome.status, outcome.reason, outcome.row.tobytes())
        return SweepResult(to_product(made, rows))
    place = Path(folder)
    with locked(place):
        run_in(made, place, chosen, progress=progress, stop=stop)
        return SweepResult(gather(made, place))


def _check_kinds(axes: Any, reduce: Any) -> None:
    """Refuse a single value or table where a list is meant: Python would take it apart."""
    if isinstance(axes, Mapping):
        for path, values in axes.items():
            if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
                rule = "must be a list of values"
                raise InputError(
                    Fault(f"axes.{path}", values, rule, "Write it in brackets, like ['50 um', '100 um']")
                )
    for name, given in (("axes", axes), ("reduce", reduce)):
        listed = isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping))
        if given is not None and not listed and not (name == "axes" and isinstance(given, Mapping)):
            raise InputError(Fault(name, given, "must be a list of tables", "Put it in brackets"))
