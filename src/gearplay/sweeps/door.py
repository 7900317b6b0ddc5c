"""`sweep`: many cases from one plan, in memory or in a folder that survives any interruption."""

import json
import os
import threading
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearplay.files.atomic import shown_path, write_text
from gearplay.files.folder_lock import locked
from gearplay.files.plan_files import Source
from gearplay.model.case import Case
from gearplay.model.reading import bundled_names, load_case
from gearplay.solver.simulate import worker_count
from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep, make_plan
from gearplay.sweeps.running.engines import run_dask, run_processes, run_threads
from gearplay.sweeps.running.evaluate import Outcome, Sweep
from gearplay.sweeps.running.product import check_size, product_bytes, to_product, write_product
from gearplay.sweeps.running.store import RowStore, StoredRows, forget_failed, read_rows, store_name
from gearplay.sweeps.running.zarr_export import write_cube
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr

PLAN, PRODUCT, CUBE = "plan.json", "sweep.nc", "sweep.zarr"
Report = Callable[[str, float, float], None]
Rows = dict[bytes, tuple[int, str, bytes]]


@dataclass(frozen=True)
class Policy:
    """How to run a sweep; none of it changes the result.

    ``engine`` is "threads" or "processes", with ``workers`` of them (the cores if not given); ``scheduler`` is the address of an
    existing Dask cluster, with ``security`` its TLS files. ``shard`` (i, n) runs the i-th of n parts.
    """

    engine: str = "threads"
    workers: int | None = None
    scheduler: str | None = None
    security: Mapping[str, Path] | None = None
    shard: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.engine not in ("threads", "processes"):
            raise InputError(Fault("engine", self.engine, "must be threads or processes", "Choose one"))

    def outcomes(
        self, made: Sweep, jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Outcome]]:
        """Yield the outcomes of jobs as they are done; threads end their cases early once stopped."""
        if self.scheduler is not None:
            return run_dask(made, jobs, address=self.scheduler, security=dict(self.security or {}))
        if self.engine == "processes":
            return run_processes(made, jobs, workers=self.workers)
        return run_threads(made, jobs, workers=self.workers, stop=stop)


def sweep(
    case: Source | Case | SweepPlan,
    axes: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]] | None = None,
    *,
    reduce: Sequence[Mapping[str, Any]] | None = None,
    folder: str | os.PathLike[str] | None = None,
    policy: Policy | None = None,
    progress: Report | None = None,
    stop: threading.Event | None = None,
    **more: Any,
) -> "xr.Dataset":
    """Simulate every combination of the axes and return what was kept, a dimension per axis.

    Either ``case`` is a case, ``axes`` the values by path (or tables as in a plan file) and ``reduce`` what to keep, with
    ``members``, ``design`` and ``set`` as in a plan file; or ``case`` alone is a plan: a `SweepPlan`, a bundled name, a path
    or a mapping. With a ``folder`` finished cases are kept there and the same call goes on after an interruption; without,
    all is in memory.
    Failed cases are rows with ``status`` and ``reason``.

    Raises `InputError` for a plan that does not fit, `ResourceError` for one that is too large or a full disk.

    >>> found = sweep("han2021", {"meshes.0.backlash": ["50 um", "100 um"]}, set={"run.duration": 0.01, "run.transient": 0.0},
    ...     reduce=[{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}])
    >>> dict(found.sizes), found.rms.attrs["units"], found.status.values.tolist()
    ({'backlash': 2}, 'm/s^2', [0, 0])
    """
    _check_kinds(axes, reduce)
    if isinstance(case, SweepPlan):
        plan = case
    elif axes is None and reduce is None:
        plan = load_sweep(case.resolved() if isinstance(case, Case) else case)
    else:
        source = os.fspath(case) if isinstance(case, os.PathLike) else case
        plan = make_plan(source, axes or {}, reduce or (), **more)
    made, chosen = Sweep(freeze(plan)), policy or Policy()
    check_size(made)
    if folder is None:
        rows: Rows = {}
        with closing(
            _watched(made, chosen, order_of(made.template.points.jobs), 0, progress, stop)
        ) as finished:
            for outcome in (each for outcomes in finished for each in outcomes):
                rows[outcome.address] = (outcome.status, outcome.reason, outcome.row.tobytes())
        return to_product(made, rows)
    place = Path(folder)
    with locked(place):
        run_in(made, place, chosen, progress=progress, stop=stop)
        return gather(made, place)


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


def run_in(
    made: Sweep,
    folder: Path,
    policy: Policy,
    *,
    retry: bool = False,
    progress: Report | None = None,
    stop: threading.Event | None = None,
) -> int:
    """Run what is missing of a sweep in its folder, which the caller holds; return how many cases were run.

    Every finished case is stored at once. ``retry`` runs those again that failed.
    """
    claim(made.plan, folder)
    if retry:
        forget_failed(folder, policy.shard)
    points = made.template.points
    known = {address for address, *_ in read_rows(folder, made.reducer.size, policy.shard)}
    wanted, each = order_of(points.jobs), len(points) // points.jobs
    if policy.shard is not None:
        wanted = wanted[policy.shard[0] - 1 :: policy.shard[1]]
    left = [int(job) for job in wanted if not known or not _is_done(made, int(job), known)]
    finished = _watched(made, policy, left, len(wanted) - len(left), progress, stop)
    # Whatever ends the loop ends the workers before the store is closed.
    with closing(RowStore(folder / store_name(policy.shard))) as store, closing(finished):
        for outcomes in finished:
            store.add(outcomes)
    return each * len(left)


def _is_done(made: Sweep, job: int, known: set[bytes]) -> bool:
    """Return whether every point of a job is stored."""
    return all(made.template.address_of(i) in known for i in made.template.points.job(job))


def _watched(
    made: Sweep,
    policy: Policy,
    left: Sequence[int],
    before: int,
    progress: Report | None,
    stop: threading.Event | None,
) -> Generator[list[Outcome]]:
    """Yield the outcomes of jobs and tell of progress; `KeyboardInterrupt` once stopped."""
    label, total = made.plan.title or "sweep", before + len(left)
    done = before
    with closing(policy.outcomes(made, left, stop)) as finished:
        for outcomes in finished:
            done += 1
            yield outcomes
            if progress is not None:
                progress(label, done, total)
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
    if done < total and stop is not None and stop.is_set():
        raise KeyboardInterrupt


def freeze(plan: SweepPlan) -> SweepPlan:
    """Return a plan with its case file in it: what goes on later, or elsewhere, must not depend on where the file lies."""
    if not isinstance(plan.case, str) or plan.case in bundled_names():
        return plan
    return plan.model_copy(update={"case": load_case(plan.case).resolved()})


def claim(plan: SweepPlan, folder: Path) -> None:
    """Note the plan in its folder; `InputError` where the folder has another plan."""
    text = plan.model_dump_json(exclude_none=True, indent=1)
    path = folder / PLAN
    if not path.exists():
        write_text(path, text)
    elif _read_plan(path) != json.loads(text):
        rule = "must hold the same plan"
        raise InputError(Fault("out", shown_path(folder), rule, "Choose another folder, or say --overwrite"))


def plan_in(folder: Path) -> SweepPlan:
    """Return the plan of a sweep's folder.

    Raises `InputError` where there is none.
    """
    path = folder / PLAN
    if not path.exists():
        rule = f"must be a sweep's folder, with its {PLAN}"
        raise InputError(
            Fault("folder", shown_path(folder), rule, "Give the folder that gearplay sweep wrote")
        )
    return load_sweep(_read_plan(path))


def _read_plan(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        document = None
    if not isinstance(document, dict):
        rule = f"its {path.name} must be a plan that gearplay sweep wrote"
        cure = "Choose another folder with --out, or say --overwrite"
        raise InputError(Fault("out", shown_path(path.parent), rule, cure))
    return document


def gather(made: Sweep, folder: Path) -> "xr.Dataset":
    """Return the product of all rows in a folder, and write it there."""
    rows = {
        address: (status, reason, row)
        for address, status, reason, _, row in read_rows(folder, made.reducer.size)
    }
    product = to_product(made, rows)
    _sweep_up(folder)
    write_product(product, folder / PRODUCT)
    return product


def gather_cube(made: Sweep, folder: Path) -> dict[str, Any]:
    """Write all rows in a folder as a Zarr store there, block by block; return its path, failed cases and their reasons."""
    with closing(StoredRows(folder, made.reducer.size)) as rows:
        failed, reasons = write_cube(made, rows, folder / CUBE)
    return {"cube": str(folder / CUBE), "failed": failed, "reasons": reasons}


def _sweep_up(folder: Path) -> None:
    for stale in (*folder.glob(".*.part"), *folder.glob("*/.*.part")):
        if stale.is_file():  # a run was killed while it wrote
            stale.unlink()


@dataclass(frozen=True)
class Forecast:
    """What a sweep will take: cases, seconds on ``workers`` cores and the bytes that it keeps; how many of the pilots failed."""

    cases: int
    pilots: int
    seconds: float
    workers: int
    bytes: float
    failed: int
    reason: str


def forecast(made: Sweep, *, workers: int | None = None, patience: float = 8.0) -> Forecast:
    """Run up to 12 points of a sweep, spread over it, for at most ``patience`` seconds, and say what all will take."""
    count, spent, pilots, reasons = len(made.template.points), 0.0, 0, list[str]()
    with closing(run_threads(made, order_of(made.template.points.jobs)[:12], workers=1)) as finished:
        for outcomes in finished:
            spent, pilots = spent + sum(o.seconds for o in outcomes), pilots + len(outcomes)
            reasons += [o.reason for o in outcomes if o.status]
            if spent > patience:
                break
    cores = min(workers or worker_count(), worker_count())
    seconds = count * spent / pilots / cores
    return Forecast(
        count, pilots, seconds, cores, 1.1 * product_bytes(made), len(reasons), reasons[0] if reasons else ""
    )
