"""`sweep`: many cases of one plan, in memory or in a resumable folder."""

import os
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearplay.files.plan_files import Source
from gearplay.model.case import Case
from gearplay.results.outcomes import Account
from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep, make_plan
from gearplay.sweeps.result import SweepResult
from gearplay.sweeps.running import folder as folders
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.product import to_product
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional
from gearplay.vocabulary.progress import Progress
from gearplay.work.engine import Engine
from gearplay.work.folder import locked

if TYPE_CHECKING:
    import xarray as xr


def sweep(
    case: Source | Case | SweepPlan,
    axes: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]] | None = None,
    *,
    reduce: Sequence[Mapping[str, Any]] | None = None,
    ensemble: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    report: bool = False,
    retry: bool = False,
    zarr: bool = False,
    threads: int | None = None,
    engine: Engine | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    **more: Any,
) -> SweepResult:
    """Simulate every combination of the axes and return the kept numbers, a dimension per axis.

    Parameters
    ----------
    case
        With ``axes`` a case; alone a plan: a `SweepPlan`, a bundled name, a path or a mapping.
    axes
        Values by path, in SI or with a unit; or tables as in a plan file.
    reduce
        Numbers to keep of each case: tables as in a plan file, docs/sweeps.
    ensemble
        Members of each case; 1 if not given.
    folder
        Where finished cases are stored, so that the same call resumes after an interruption; in memory if not given.
    overwrite
        Whether the result of the folder is replaced; the old one stays until the new one is complete.
    report
        Whether ``report.html``, its figures and the tolerance page are written into the folder too.
    retry
        Whether failed cases are run again when a folder is resumed.
    zarr
        Whether ``sweep.zarr`` is written into the folder too.
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
    if overwrite and chosen.shard is not None:
        rule = "must not be given for one shard: it would remove the results of the others"
        raise InputError.of("overwrite", overwrite, rule, "Remove it, or choose another folder")
    if folder is not None:
        finished = sweep_in(
            made, Path(folder), chosen,
            overwrite=overwrite, report=report, retry=retry, zarr=zarr,
            watch=lambda: nullcontext((progress, stop)),
        )  # fmt: skip
        if finished.product is not None:
            return SweepResult(finished.product)
        with locked(Path(folder)):  # after a shard: all that is there
            return SweepResult(folders.gather(made, Path(folder)))
    rows: dict[bytes, tuple[int, str, bytes]] = {}
    points = made.template.points
    running = chosen.run(
        made, order_of(points.jobs),
        label=plan.title or "sweep", pieces=points.job_size, progress=progress, stop=stop,
    )  # fmt: skip
    with closing(running):
        for outcome in (each for outcomes in running for each in outcomes):
            rows[outcome.address] = (outcome.status, outcome.reason, outcome.row.tobytes())
    return SweepResult(to_product(made, rows))


@dataclass(frozen=True)
class Finished:
    """Outcome of `sweep_in`: cases ``ran``, the product, the account of all cases, the document of the tolerance page."""

    ran: int
    product: "xr.Dataset | None" = None
    account: Account | None = None
    tolerance: dict[str, Any] | None = None


def sweep_in(
    made: Sweep,
    folder: Path,
    engine: Engine,
    *,
    overwrite: bool = False,
    report: bool = False,
    retry: bool = False,
    zarr: bool = False,
    watch: Callable[[], AbstractContextManager[tuple[Progress | None, threading.Event | None]]],
) -> Finished:
    """Run, or resume, a sweep in a folder and assemble its product; the options are those of `sweep`.

    A shard only runs its cases. A product too large for one piece is written as Zarr alone. The work is done within ``watch()``,
    which yields the progress callback and the event that ends it.
    """
    from gearplay.sweeps.report.page import write_sweep_report
    from gearplay.sweeps.tolerances.page import write_tolerances

    tolerance = report and made.plan.tolerance is not None
    only_zarr = zarr and made.is_large
    if zarr:
        load_optional("zarr", "cluster")
    if not only_zarr or tolerance:
        made.check_size()

    def work(place: Path) -> Finished:
        left = folders.jobs_left(made, place, engine, retry=retry)
        with watch() as (progress, stop), engine.lasting() as lasting:
            ran = folders.run_in(made, place, lasting, left, progress=progress, stop=stop)
            if engine.shard is not None:
                return Finished(ran)
            account = folders.gather_cube(made, place) if zarr else None
            if only_zarr:
                return Finished(ran, account=account)
            product = folders.gather(made, place)
            account = Account.of(product["status"].values, product["reason"].values)
            if report:
                write_sweep_report(made, product, place)
            found = None
            if tolerance:
                found = write_tolerances(made, product, place, lasting, progress=progress, stop=stop)
            return Finished(ran, product, account, found)

    part = "" if engine.shard is None else f"{engine.shard[0]}-of-{engine.shard[1]}"
    identity = made.plan.model_dump_json(exclude_none=True)
    return folders.output_folder(folder).run(work, identity=identity, overwrite=overwrite, part=part)


def _check_kinds(axes: Any, reduce: Any) -> None:
    """Refuse a single value or table where a list is meant: Python would take it apart."""
    if isinstance(axes, Mapping):
        for path, values in axes.items():
            if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
                rule = "must be a list of values"
                raise InputError.of(
                    f"axes.{path}", values, rule, "Write it in brackets, like ['50 um', '100 um']"
                )
    for name, given in (("axes", axes), ("reduce", reduce)):
        listed = isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping))
        if given is not None and not listed and not (name == "axes" and isinstance(given, Mapping)):
            raise InputError.of(name, given, "must be a list of tables", "Put it in brackets")
