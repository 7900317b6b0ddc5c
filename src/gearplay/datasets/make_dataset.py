"""`make_dataset`: labelled records of a plan in a resumable folder."""

import os
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from gearplay.datasets.evaluate import Dataset
from gearplay.datasets.folder import gather, jobs_left, output_folder, run_in
from gearplay.datasets.reading import load_dataset_plan
from gearplay.datasets.result import DatasetResult, result_of
from gearplay.files.plan_files import Source
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress
from gearplay.work.engine import Engine
from gearplay.work.folder import locked

Watch = Callable[[], AbstractContextManager[tuple[Progress | None, threading.Event | None]]]


def make_dataset(
    plan: Source,
    folder: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    retry: bool = False,
    threads: int | None = None,
    engine: Engine | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> DatasetResult:
    """Simulate labelled records and write them, their labels and a data sheet into a folder; see docs/datasets.

    Parameters
    ----------
    plan
        A bundled name, the path of a TOML file, or a table laid out as one.
    folder
        Where the records are stored, one file each, ``labels.csv`` and ``README.md``. The same call resumes after an
        interruption, with the same bytes in the end.
    overwrite
        Whether the data set of the folder is replaced; the old one stays until the new one is complete.
    retry
        Whether failed records are simulated again when a folder is resumed.
    threads
        Threads; the cores by default. It changes nothing in the result.
    engine
        Where to run, for more than threads: processes, a cluster, one part of several.
    progress
        Called with what is running, records done, and of how many.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    DatasetResult
        ``ds`` is the table of labels: a variable over ``record`` for each column. Failed records are rows with ``status`` 1
        and a ``reason``.

    Raises
    ------
    InputError
        For a plan that does not fit, or a folder of another plan.
    ResourceError
        For too many records, or a full disk.

    Examples
    --------
    >>> import tempfile
    >>> plan = {"case": "han2021", "set": {"run.duration": 0.02, "run.transient": 0.0},
    ...     "rig": {"collector": {"sampling": "20 kHz"}}, "split": {"train": 0.5, "validation": 0.0, "test": 0.5},
    ...     "axes": [{"name": "backlash", "path": "meshes.0.backlash", "values": ["80 um", "120 um"]}],
    ...     "classes": [{"label": "normal"}, {"label": "worn", "set": {"sleeves.ring.radial_clearance": "150 um"}}]}
    >>> made = make_dataset(plan, tempfile.mkdtemp() + "/records")
    >>> made.message, made.ds["label"].values.tolist()
    ('Data set: 4 records: 4 finished, 0 failed; train 2, validation 0, test 2', ['normal', 'normal', 'worn', 'worn'])

    """
    chosen = engine or Engine(workers=threads)
    made = Dataset(load_dataset_plan(plan).frozen())
    _, found = dataset_in(
        made,
        Path(folder),
        chosen,
        overwrite=overwrite,
        retry=retry,
        watch=lambda: nullcontext((progress, stop)),
    )
    if found is not None:
        return found
    with locked(Path(folder)):  # after a shard: all that is there
        return result_of(made, gather(made, Path(folder)), str(folder))


def dataset_in(
    made: Dataset, folder: Path, engine: Engine, *, overwrite: bool = False, retry: bool = False, watch: Watch
) -> tuple[int, DatasetResult | None]:
    """Run, or resume, a data set in a folder; return the number of records simulated now, and the result, None for a shard.

    A shard only simulates its records. ``watch()`` is a context manager that yields the progress callback and the stop
    event.
    """
    if overwrite and engine.shard is not None:
        rule = "must not be given for one shard: it would remove the results of the others"
        raise InputError.of("overwrite", overwrite, rule, "Remove it, or choose another folder")

    def work(place: Path) -> tuple[int, DatasetResult | None]:
        left = jobs_left(made, place, engine, retry=retry)
        with watch() as (progress, stop), engine.lasting() as lasting:
            run_in(made, place, lasting, left, progress=progress, stop=stop)
        if engine.shard is not None:
            return len(left), None
        return len(left), result_of(made, gather(made, place), str(folder))

    part = "" if engine.shard is None else f"{engine.shard[0]}-of-{engine.shard[1]}"
    identity = made.plan.model_dump_json(exclude_none=True)
    return output_folder(folder).run(work, identity=identity, overwrite=overwrite, part=part)
