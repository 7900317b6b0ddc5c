"""A sweep in a folder: claimed by a plan, resumed, assembled into one product."""

import json
import threading
from collections.abc import Generator, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearplay.files.atomic import shown_path, write_text
from gearplay.files.parts import DIGEST, with_digest, without_digest
from gearplay.results.outcomes import Account
from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.engines import Engine
from gearplay.sweeps.running.evaluate import Outcome, Sweep
from gearplay.sweeps.running.product import to_product, write_product
from gearplay.sweeps.running.store import RowStore, StoredRows, forget_failed, read_rows, store_name
from gearplay.sweeps.running.zarr_export import tidy_cube, write_cube
from gearplay.vocabulary.errors import Fault, InputError, TakenError
from gearplay.vocabulary.progress import Progress

if TYPE_CHECKING:
    import xarray as xr

PLAN, PRODUCT, CUBE = "plan.json", "sweep.nc", "sweep.zarr"


def jobs_left(made: Sweep, folder: Path, shard: tuple[int, int] | None, *, retry: bool = False) -> list[int]:
    """Claim a folder, which the caller holds, for a sweep; return the jobs of the shard that it lacks, in order.

    ``retry`` includes failed ones. Raises `TakenError` where the folder belongs to another plan or is damaged.
    """
    claim(made.plan, folder)
    if retry:
        forget_failed(folder, shard)
    known = {address for address, *_ in read_rows(folder, made.reducer.size, shard)}
    return [int(job) for job in _jobs(made, shard) if not known or not _is_done(made, int(job), known)]


def run_in(
    made: Sweep,
    folder: Path,
    engine: Engine,
    left: Sequence[int] | None = None,
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> int:
    """Run what is missing of a sweep in its folder, which the caller holds; return how many cases were run.

    Every finished case is stored at once. ``left`` is the result of `jobs_left`, called here if not given.
    """
    if left is None:
        left = jobs_left(made, folder, engine.shard)
    points = made.template.points
    finished = watched(made, engine, left, len(_jobs(made, engine.shard)) - len(left), progress, stop)
    # Whatever ends the loop ends the workers before the store is closed.
    with closing(RowStore(folder / store_name(engine.shard))) as store, closing(finished):
        for outcomes in finished:
            store.add(outcomes)
    return len(points) // points.jobs * len(left)


def _jobs(made: Sweep, shard: tuple[int, int] | None) -> Sequence[int]:
    """Return the jobs of a shard, all without one, in the order in which they run."""
    wanted = order_of(made.template.points.jobs)
    return wanted if shard is None else wanted[shard[0] - 1 :: shard[1]]


def _is_done(made: Sweep, job: int, known: set[bytes]) -> bool:
    """Return whether every point of a job is stored."""
    return all(made.template.address_of(i) in known for i in made.template.points.job(job))


def watched(
    made: Sweep,
    engine: Engine,
    left: Sequence[int],
    before: int,
    progress: Progress | None,
    stop: threading.Event | None,
) -> Generator[list[Outcome]]:
    """Yield the outcomes of jobs and report progress; raise `KeyboardInterrupt` once stopped."""
    label, total = made.plan.title or "sweep", before + len(left)
    done, together = before, len(made.template.points) // made.template.points.jobs
    with closing(engine.outcomes(made, left, stop)) as finished:
        for outcomes in finished:
            done += len(outcomes) // together
            yield outcomes
            if progress is not None:
                progress(label, done, total)
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
    if done < total and stop is not None and stop.is_set():
        raise KeyboardInterrupt


def claim(plan: SweepPlan, folder: Path) -> None:
    """Note the plan in its folder; `TakenError` where the folder has another plan, by now: shards come there together."""
    document = json.loads(plan.model_dump_json(exclude_none=True))
    path = folder / PLAN
    if not path.exists():
        with suppress(TakenError):
            write_text(path, json.dumps(with_digest(document), indent=1), overwrite=False)
    if _read_plan(path) != document:
        raise _not_ours(folder, "must hold the same plan")


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
    if not isinstance(document, dict) or DIGEST not in document:
        raise _not_ours(path.parent, f"its {path.name} must be a plan that gearplay sweep wrote")
    if (found := without_digest(document)) is None:
        raise _not_ours(path.parent, f"its {path.name} was changed after gearplay sweep wrote it")
    return found


def _not_ours(folder: Path, rule: str) -> TakenError:
    return TakenError(Fault("out", shown_path(folder), rule, "Choose another folder, or overwrite it"))


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


def gather_cube(made: Sweep, folder: Path) -> Account:
    """Write all rows in a folder as a Zarr store there, block by block; return the account of its cases."""
    with closing(StoredRows(folder, made.reducer.size)) as rows:
        return write_cube(made, rows, folder / CUBE)


def _sweep_up(folder: Path) -> None:
    """Remove what a run left that was killed while it wrote."""
    for stale in (*folder.glob(".*.part"), *folder.glob("*/.*.part")):
        if stale.is_file():
            stale.unlink()
    tidy_cube(folder / CUBE)
