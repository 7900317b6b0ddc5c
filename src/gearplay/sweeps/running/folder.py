"""A sweep in a folder: claimed by a plan, resumed, assembled into one product."""

import json
import shutil
import threading
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.files.atomic import shown_path
from gearplay.results.outcomes import Account
from gearplay.sweeps.cases.points import order_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.product import to_product, write_product
from gearplay.sweeps.running.zarr_export import temporary_stores, tidy_cube, write_cube
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress
from gearplay.work.claims import PLAN, claim, read_claim
from gearplay.work.engine import Engine
from gearplay.work.folder import OutputFolder
from gearplay.work.rows import PATTERN, RowStore, StoredRows, remove_failed, store_name

if TYPE_CHECKING:
    import xarray as xr

PROGRAM, PRODUCT, CUBE = "gearplay sweep", "sweep.nc", "sweep.zarr"


def output_folder(folder: Path) -> OutputFolder:
    """Return the output folder of a sweep."""
    return OutputFolder(folder, is_complete, remove_sweep)


def is_complete(folder: Path) -> bool:
    """Return whether a folder holds the product of a sweep, in one piece or as Zarr."""
    tidy_cube(folder / CUBE)  # one that was being replaced counts
    return (folder / PRODUCT).exists() or (folder / CUBE).exists()


def remove_sweep(folder: Path) -> None:
    """Delete the plan, product, reports and figures of a sweep from its folder."""
    for name in (PLAN, PRODUCT, "report.html", "tolerance.html", "tolerance.json"):
        (folder / name).unlink(missing_ok=True)
    for path in folder.glob(f"{PATTERN}*"):
        path.unlink()
    for path in (
        *temporary_stores(folder / CUBE),
        *(folder / name for name in ("figures", CUBE, "tolerance")),
    ):
        shutil.rmtree(path, ignore_errors=True)


def jobs_left(made: Sweep, folder: Path, engine: Engine, *, retry: bool = False) -> list[int]:
    """Claim a folder locked by the caller for a sweep; return the missing jobs of the engine's shard, in order.

    ``retry`` includes failed ones. Raises `TakenError` where the folder belongs to another plan or is damaged.
    """
    claim(folder, json.loads(made.plan.model_dump_json(exclude_none=True)), PROGRAM)
    if retry:
        remove_failed(folder, engine.shard)
    with closing(StoredRows(folder, made.reducer.size, engine.shard)) as rows:
        known = set(rows)
    points = made.template.points
    return [
        int(job)
        for job in engine.share(order_of(points.jobs))
        if not known or not all(made.template.address_of(i) in known for i in points.job(int(job)))
    ]


def run_in(
    made: Sweep,
    folder: Path,
    engine: Engine,
    left: Sequence[int] | None = None,
    *,
    label: str | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> int:
    """Run the missing cases of a sweep in its folder, locked by the caller; return their number.

    Every finished case is stored at once. ``left`` is the result of `jobs_left`, called here if not given; ``label`` that of
    the progress, by default the title of the plan.
    """
    if left is None:
        left = jobs_left(made, folder, engine)
    points = made.template.points
    finished = engine.run(
        made,
        left,
        label=label or made.plan.title or "sweep",
        finished=len(engine.share(range(points.jobs))) - len(left),
        pieces=points.job_size,
        progress=progress,
        stop=stop,
    )
    # Whatever ends the loop ends the workers before the store is closed.
    with closing(RowStore(folder / store_name(engine.shard))) as store, closing(finished):
        for outcomes in finished:
            store.add(outcomes)
    return points.job_size * len(left)


def plan_in(folder: Path) -> SweepPlan:
    """Return the plan of a sweep's folder.

    Raises `InputError` where there is none.
    """
    path = folder / PLAN
    if not path.exists():
        rule = f"must be a sweep's folder, with its {PLAN}"
        raise InputError.of("folder", shown_path(folder), rule, "Give the folder that gearplay sweep wrote")
    return load_sweep(read_claim(folder, PROGRAM))


def gather(made: Sweep, folder: Path) -> "xr.Dataset":
    """Return the product of all rows in a folder, and write it there."""
    with closing(StoredRows(folder, made.reducer.size)) as stored:
        rows = dict(stored.items_once())
    product = to_product(made, rows)
    _sweep_up(folder)
    write_product(product, folder / PRODUCT)
    return product


def gather_cube(made: Sweep, folder: Path) -> Account:
    """Write all rows in a folder as a Zarr store there, block by block; return the account of its cases."""
    with closing(StoredRows(folder, made.reducer.size)) as rows:
        return write_cube(made, rows, folder / CUBE)


def _sweep_up(folder: Path) -> None:
    """Remove the temporary files of a run that was killed while writing."""
    for stale in (*folder.glob(".*.part"), *folder.glob("*/.*.part")):
        if stale.is_file():
            stale.unlink()
    tidy_cube(folder / CUBE)
